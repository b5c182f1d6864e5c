"""Projection of displacement or velocity fields over a flexible body on its modes, weighted by mass.

    eta = (Psi^T M Psi)^-1 Psi^T M f,     error^2 = (f - Psi eta)^T M (f - Psi eta) / f^T M f

For a velocity field the error is the fraction of the kinetic energy that the modes cannot represent.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.model import TRANSLATIONS
from kanefe.frames import Vector, numbers
from kanefe.storage.scipy_later import sp, spla

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody

Field = Callable[[np.ndarray], Any] | Sequence[Sequence[float]] | np.ndarray
"""Function of positions (P, 3) in G that returns vectors (P, 3), or one vector per node (n, 3)."""

REPORTED = 1e-2
"""Relative error from which a warning is issued."""


def projected(body: FlexibleBody, field: Field, label: str) -> Vector:
    """Return the modal coordinates of a field, (k,), and warn of the fraction of it that the modes cannot represent.

    A function is evaluated at the mass points: the nodes of solids, points within the elements of beams. A table for
    the nodes of a body of beams is fitted at the nodes with equal weights.

    Raises
    ------
    ModelError
        If the field has another shape or is not finite; the message names it by the label.
    """
    if body.bends_far:
        raise ModelError(
            f"{label}: an exact beam does not move linearly in its coordinates, so that no field is projected on them. "
            "Remedy: modal_coordinates= and modal_speeds=, or the start= of a run from kanefe.equilibrium under loads "
            "that bend it"
        )
    points, nodes = body.inertia_points, body.nodes
    is_by_mass = len(points) > 0 and (callable(field) or points.shape == nodes.shape)
    places = points if is_by_mass else nodes
    given = numbers(field(places.copy())) if callable(field) else numbers(field)
    if given.shape != (len(places), 3) or not np.all(np.isfinite(given)):
        where = "at each position for which the function is called" if callable(field) else "of each node"
        raise ModelError(
            f"{label} must be finite and of shape ({len(places)}, 3), a vector in G {where}, not {given.shape}"
        )
    f = given.astype(float).ravel()
    weights, basis = _mass(body, is_by_mass)
    weighted = weights @ basis
    gram, right = basis.T @ weighted, weighted.T @ f
    is_sparse = sp.issparse(gram)
    eta = spla.spsolve(sp.csc_matrix(gram), right) if is_sparse else np.linalg.lstsq(gram, right, rcond=1e-13)[0]
    left = f - basis @ eta
    whole = float(f @ (weights @ f))
    error = float(np.sqrt(max(left @ (weights @ left), 0.0) / whole)) if whole > 0.0 else 0.0
    if error > REPORTED:
        warnings.warn(
            f"{label}: the modes of the body show it but for {100.0 * error:.2g} % (root mean square "
            f"{'by mass' if is_by_mass else 'over the nodes'}). Remedy: more modes; rigid motion belongs to the "
            "joint",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return np.asarray(eta)


def _mass(body: FlexibleBody, is_by_mass: bool) -> tuple[sp.csr_matrix, Any]:
    """Return weights (3 P, 3 P) and motion (3 P, k) of the points: of the mass, or of the nodes with equal weights."""
    k, components = body.free_count, body.components
    if is_by_mass and body.is_exact:
        return sp.kron(body.inertia_mass, sp.identity(3), format="csr"), body.inertia_basis[:, :k]
    rows = body.inertia_basis if is_by_mass else body.basis
    weights = body.inertia_mass if is_by_mass else sp.identity(len(body.nodes) * len(components), format="csr")
    if not all(c in components for c in TRANSLATIONS):
        raise ModelError(
            "a field over nodes that do not move along x, y and z is not supported. Remedy: modal coordinates"
        )
    where = [components.index(c) for c in TRANSLATIONS]
    chosen = (np.arange(len(body.nodes))[:, None] * len(components) + where).ravel()
    return weights[chosen][:, chosen].tocsr(), rows[chosen, :k]
