"""Damping of a frame of beams, from that of the materials of its elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import ViscoelasticPart
from kanefe_fem.materials.damping import Losses


def damping_of_beams(
    losses: Sequence[Losses], mass: sp.csr_matrix, stiffness: Callable[[np.ndarray], sp.csr_matrix]
) -> dict[str, Any]:
    """Return C, H and the viscoelastic parts of a frame, as fields of a `FiniteElementModel`; of none nothing.

    Parameters
    ----------
    losses : sequence of Losses
        Of each element.
    mass : csr_matrix, shape (N, N)
    stiffness : callable
        Returns the sum of the instantaneous stiffnesses of elements times shares (m,).

    Raises
    ------
    ModelError
        If elements have different damping proportional to mass.
    """
    found: dict[str, Any] = {}
    viscous = [own.damping for own in losses]
    shares = np.array([0.0 if own is None else own.stiffness for own in viscous])
    rates = {0.0 if own is None else own.mass for own in viscous}
    if len(rates) > 1:
        raise ModelError(
            "elements of a frame have different damping proportional to mass. Remedy: the same mass= in all of their "
            "materials, or damping= of the body, a matrix"
        )
    rate = rates.pop() if rates else 0.0
    if shares.any() or rate > 0.0:
        found["damping"] = rate * mass + (stiffness(shares) if shares.any() else 0.0 * mass)
    etas = np.array([own.loss_factor for own in losses])
    if etas.any():
        found["structural"] = stiffness(etas)
    parts = []
    for arms in dict.fromkeys(own.prony for own in losses if own.prony):
        of_part = stiffness(np.array([float(own.prony == arms) for own in losses]))
        parts.append(ViscoelasticPart(of_part, *zip(*arms, strict=True)))
    return found | {"viscoelastic": tuple(parts)}
