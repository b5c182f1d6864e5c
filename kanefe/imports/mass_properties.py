"""Mass, centre and inertia of a body by its matrix, and whether the matrix agrees with itself in all directions."""

from __future__ import annotations

import warnings

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel

FEW = 4
"""Number of entries of M that differ between directions, as one of the file that is wrong or two that are swapped."""


def mass_properties(model: FiniteElementModel) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass (kg), centre of mass (3,) and inertia (3, 3) about G's origin, from M and the rigid motions.

    For a planar model only the entries of its components are meaningful (Eq. 45-48 in general form).
    """
    R = model.rigid_modes()
    generalised = R.T @ (model.mass @ R)
    present = [COMPONENTS.index(c) for c in model.components if c in TRANSLATIONS]
    mass = float(np.mean(np.diag(generalised)[present])) if present else 0.0
    c = generalised[3:, :3]  # the first moment as m c~
    first = np.array((c[2, 1] or -c[1, 2], c[0, 2] or -c[2, 0], c[1, 0] or -c[0, 1]))
    return mass, first / mass if mass else first, generalised[3:, 3:]


def check_moments(model: FiniteElementModel) -> None:
    """Check that M gives one first moment for all axes; warn if only few of its entries differ between directions."""
    if not set(TRANSLATIONS) <= set(model.components):
        return
    R = model.rigid_modes()
    first = (R.T @ (model.mass @ R))[:3, 3:]
    mass, _, _ = mass_properties(model)
    reach = float(np.linalg.norm(model.nodes, axis=1).max()) or 1.0
    uneven = abs(first + first.T)
    if uneven.max() > ROUND_OFF * mass * reach:
        a, b = np.unravel_index(uneven.argmax(), (3, 3))
        raise ModelError(
            "the body's first moment by its matrix differs between axes: translation along "
            f"{TRANSLATIONS[a]} and rotation about {TRANSLATIONS[b]} give {first[a, b]:.6g} kg m, the other way "
            f"{-first[b, a]:.6g}. Remedy: check that no entry of the mass matrix is missing"
        )
    width = len(model.components)
    places = [model.components.index(c) for c in TRANSLATIONS]
    blocks = [model.mass[: model.nodal_size][p::width][:, p : model.nodal_size : width] for p in places]
    largest = max(abs(block).max() for block in blocks)
    for axis in (1, 2):
        other = (blocks[axis] - blocks[0]).tocoo()
        odd = np.flatnonzero(abs(other.data) > ROUND_OFF * largest)
        if 0 < len(odd) <= FEW < blocks[0].nnz / 10 and not model.generalised:
            i, j = other.row[odd[0]], other.col[odd[0]]
            warnings.warn(
                f"the mass between nodes {i} and {j} (from 0) differs between x and {TRANSLATIONS[axis]}, and that of "
                "nearly all others does not. Remedy: check that no entry of the mass matrix is missing or wrong",
                AccuracyWarning,
                stacklevel=outside(),
            )
