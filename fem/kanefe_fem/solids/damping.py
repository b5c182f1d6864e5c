"""Damping of a solid, assembled by the forms of its stiffness and mass with the damping of each group in the moduli."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import ViscoelasticPart
from kanefe_fem import _fenicsx
from kanefe_fem.materials.of_groups import CellMaterials

if TYPE_CHECKING:
    from kanefe_fem.solids.problem import Assembly
    from kanefe_fem.solids.quadrature_assembly import QuadratureAssembly


def damping_of_solid(assembly: Assembly | QuadratureAssembly, cells: CellMaterials, dimension: int) -> dict[str, Any]:
    """Return C, H and the viscoelastic parts of a solid, as fields of a `FiniteElementModel`; of none nothing.

    ``C = sum of mass_g M_g + stiffness_g K_g`` and ``H = sum of eta_g K_g`` over the groups g, with their moduli as
    given; those that relax alike are one part.
    """
    found: dict[str, Any] = {}

    def stiffness(shares: np.ndarray) -> sp.csr_matrix:
        with _fenicsx.quiet():
            return assembly.stiffness_with(cells.moduli.times(shares))

    shares = cells.of_each(lambda own: own.damping.stiffness if own.damping else 0.0)
    rates = cells.of_each(lambda own: own.damping.mass if own.damping else 0.0)
    if shares.any():
        found["damping"] = stiffness(shares)
    if rates.any():
        of_mass = sp.kron(assembly.mass_with(rates * cells.density), sp.identity(dimension), format="csr")
        found["damping"] = found["damping"] + of_mass if "damping" in found else of_mass
    losses = cells.of_each(lambda own: own.loss_factor)
    if losses.any():
        found["structural"] = stiffness(losses)
    parts = []
    for arms in dict.fromkeys(own.prony for own in cells.losses if own.prony):
        is_part = np.repeat([float(own.prony == arms) for own in cells.losses], cells.counts)
        parts.append(ViscoelasticPart(stiffness(is_part), *zip(*arms, strict=True)))
    found["viscoelastic"] = tuple(parts)
    return found
