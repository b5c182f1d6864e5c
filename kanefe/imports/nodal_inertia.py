"""The mass field of matrices whose nodes rotate: exact where K and M tell how points move, else the rest estimated."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import outside
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import ROTATIONS, TRANSLATIONS, MassField, fields_together, rigid_motion
from kanefe.imports.rest_of_mass import share_of_rest, with_rest
from kanefe.imports.rigid_parts import RigidParts, is_round_off, rigid_parts, six_components
from kanefe.imports.slender_elements import slender_elements


class NodalFormWarning(UserWarning):
    """The inertia of a deformed body is estimated: shape functions are not known, or it is a superelement."""


class NodalInertia(NamedTuple):
    """The mass field of matrices.

    Attributes
    ----------
    field : MassField
        With the mass matrix M.
    share : float
        The part of M that is estimated, 0 if none is: see `kanefe.imports.rest_of_mass.share_of_rest`.
    """

    field: MassField
    share: float = 0.0


def inertia_of_nodes(
    K: sp.csr_matrix, M: sp.csr_matrix, points: np.ndarray, components: tuple[str, ...]
) -> NodalInertia:
    """Return the mass field of a model.

    Parameters
    ----------
    K, M : csr_matrix, shape (N, N)
    points : ndarray, shape (n, 3)
        m.
    components : tuple of str
        Of every node, N = n times their number.
    """
    lagrange = _lagrange_field(M, points, components)
    if lagrange is not None:
        return NodalInertia(lagrange)
    motions = six_components(components, len(points))
    in_six = (motions @ M @ motions.T).tocsr()
    found = rigid_parts(in_six, points, motions, components)
    if is_round_off(in_six - found.mass, in_six):
        return NodalInertia(found.field)
    share = _share(found, M, motions, points, components)
    if set(components) & set(ROTATIONS):
        in_beams = slender_elements((motions @ K @ motions.T).tocsr(), in_six, points, motions, components)
        if in_beams is not None:
            others = rigid_parts(in_six - in_beams.mass, points, motions, components)
            both = RigidParts(
                fields_together((in_beams.field, _heavy(others.field, in_beams.field))), in_beams.mass + others.mass
            )
            if is_round_off(in_six - both.mass, in_six):
                return NodalInertia(both.field)
            lower = _share(both, M, motions, points, components)
            found, share = (both, lower) if lower < share else (found, share)
    return NodalInertia(with_rest(found.field, M, rigid_motion(points, np.zeros(3), components)), share)


def _lagrange_field(M: sp.csr_matrix, points: np.ndarray, components: tuple[str, ...]) -> MassField | None:
    """Return the mass field if M is one scalar matrix for every translation and nothing for rotations, else None."""
    width = len(components)
    places = [i for i, c in enumerate(components) if c in TRANSLATIONS]
    if not places:
        return None
    scalar = sum((M[a::width][:, a::width] for a in places[1:]), M[places[0] :: width][:, places[0] :: width])
    scalar = scalar / len(places)
    selected = sp.diags([float(c in TRANSLATIONS) for c in components])
    size = float(np.ptp(points, axis=0).max()) or 1.0
    per_length = sp.diags(np.tile([1.0 if c in TRANSLATIONS else 1.0 / size for c in components], len(points)))
    others = per_length @ (M - sp.kron(scalar, selected, format="csr")) @ per_length
    if abs(others).max() > ROUND_OFF * abs(scalar).max():
        return None
    chosen = sp.csr_matrix([[float(c == axis) for c in components] for axis in TRANSLATIONS])
    interpolation = sp.kron(sp.identity(len(points)), chosen, format="csr")
    return MassField(points, scalar.tocsr(), interpolation)


def _share(
    found: RigidParts, M: sp.csr_matrix, motions: sp.csr_matrix, points: np.ndarray, components: tuple[str, ...]
) -> float:
    return share_of_rest(M, (motions.T @ found.mass @ motions).tocsr(), points, components)


def tell_share(share: float, source: str) -> None:
    """Warn that the inertia of a moving body is estimated in part."""
    if share:
        warnings.warn(
            f"{source} has a mass matrix whose shape functions are not known: mass, frequencies, momenta and energy "
            f"are exact, and of the change of inertia with deformation {share:.2g} is estimated, of an even strain, "
            "bending or twist of the body at most. Remedy: a finer mesh, or mass_field= with the shape functions",
            NodalFormWarning,
            stacklevel=outside(),
        )


def _heavy(field: MassField, beside: MassField) -> MassField:
    """Return the points of a field that have mass, relative to another field of the same model."""
    heavy = np.flatnonzero(np.asarray(np.abs(field.mass).sum(axis=1)).ravel() > 1e-12 * abs(beside.mass).max())
    rows = (3 * heavy[:, None] + np.arange(3)).ravel()
    return MassField(
        points=field.points[heavy],
        mass=field.mass[heavy][:, heavy],
        interpolation=field.interpolation[rows],
        turns=sp.csr_matrix(field.turns)[rows],
        arms=np.asarray(field.arms)[heavy],
    )
