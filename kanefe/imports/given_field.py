"""Mass field and added mass that a user gives beside his matrices, checked against nodes and mass matrix."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.damping import real_matrix
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import MassField, rigid_motion
from kanefe.frames import numbers

DENSE = 2000
"""Number of rows of an added mass up to which its eigenvalues are computed."""

EXACT = 1e-9
"""Error of the shape functions in a rigid motion, relative to it, that counts as round-off."""


def checked_field(field: MassField, nodes: np.ndarray, components: tuple[str, ...], size: int) -> MassField:
    """Return a given mass field with sparse matrices.

    Parameters
    ----------
    field : MassField
        Its mass may be a vector of the masses of the points, kg.
    nodes : ndarray, shape (n, 3)
    components : tuple of str
    size : int
        Number of degrees of freedom, n times components: superelements have none.

    Raises
    ------
    ModelError
        If shapes disagree, a mass is negative, or the shape functions do not carry the rigid motions of the nodes.
    """
    if not isinstance(field, MassField):
        raise ModelError(f"mass_field={field!r}. Remedy: kanefe.MassField(points, mass, interpolation)")
    points, given = numbers(field.points), field.mass
    count = len(points) if points.ndim == 2 else 0
    mass = sp.diags(numbers(given)).tocsr() if np.ndim(given) == 1 else real_matrix(given)
    N = real_matrix(field.interpolation)
    if points.shape != (count, 3) or not count or mass.shape != (count, count) or N.shape != (3 * count, size):
        raise ModelError(
            f"the mass field has points of shape {points.shape}, masses of {mass.shape} and shape functions of "
            f"{N.shape}. Remedy: (P, 3), (P,) or (P, P), and (3 P, {size})"
        )
    if not all(np.all(np.isfinite(part)) for part in (points, mass.data, N.data)):
        raise ModelError("the mass field has numbers that are not finite. Remedy: check the shape functions")
    if abs(mass - mass.T).max() > EXACT * abs(mass).max() or mass.diagonal().min() < 0.0:
        raise ModelError("the masses of the mass field are not symmetric, or one is negative. Remedy: kg, from rho N N")
    middle = nodes.mean(axis=0)
    expected = rigid_motion(points, middle)
    error = np.abs(N @ rigid_motion(nodes, middle, components) - expected)
    error[~np.isfinite(error)] = np.inf
    moves = [c for c in range(3) if "xyz"[c] in components]
    rows = (3 * np.arange(count)[:, None] + moves).ravel()
    turns = [3 + c for c in range(3) if {0, 1, 2} - {c} <= set(moves)]
    worst = error[rows][:, [*moves, *turns]].max(initial=0.0)
    reach = max(float(np.ptp(nodes, axis=0).max()), 1.0)
    if worst > EXACT * reach:
        raise ModelError(
            f"the shape functions of the mass field do not move its points with a rigid motion of the nodes (by "
            f"{worst:.2g} of a unit motion). Remedy: check the order of nodes and components, and "
            "slopes as rotations: rz = dv/dx, ry = -dw/dx"
        )
    return replace(field, points=points.astype(float), mass=mass, interpolation=N)


def check_field_mass(field: MassField, M: sp.csr_matrix) -> None:
    """Raise a ModelError if a mass matrix is not that of the mass field."""
    own = field.mass_matrix()
    scale = np.sqrt(np.maximum(np.maximum(M.diagonal(), own.diagonal()), 0.0))
    entries = abs(own - M).tocoo()
    sizes = scale[entries.row] * scale[entries.col]
    share = float((entries.data[sizes > 0.0] / sizes[sizes > 0.0]).max(initial=0.0))
    if share > ROUND_OFF:
        at = int(np.argmax(np.where(sizes > 0.0, entries.data / np.where(sizes > 0.0, sizes, 1.0), 0.0)))
        raise ModelError(
            f"the mass matrix is not that of the mass field: between rows {entries.row[at]} and {entries.col[at]} they "
            f"differ by {share:.2g} of the masses there. Remedy: leave the mass out, and it follows from the field; a "
            "lumped matrix has none"
        )


def check_added_mass(A: sp.csr_matrix) -> None:
    """Raise a ModelError if an added mass is negative in some motion; of more than `DENSE` rows only at single ones."""
    diagonal = A.diagonal()
    rows = np.flatnonzero(diagonal)
    lowest = float(diagonal.min(initial=0.0))
    if lowest >= 0.0 and 0 < len(rows) <= DENSE:
        lowest = float(np.linalg.eigvalsh(A[rows][:, rows].toarray())[0])
    if lowest < -ROUND_OFF * diagonal.max(initial=0.0):
        raise ModelError(
            f"the added mass is negative in a motion: it has the eigenvalue {lowest:.3g} kg beside "
            f"{diagonal.max():.3g} kg at a node. Remedy: check signs and the order of rows"
        )
