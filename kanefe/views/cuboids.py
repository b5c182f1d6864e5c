"""Boxes that represent rigid bodies."""

from __future__ import annotations

import numpy as np

CORNERS = np.array(
    [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], dtype=float
)
"""Corners of a cube, in VTK's order for a hexahedron."""


def equivalent_cuboid(mass: float, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return sides (3,) in m and axes (3, 3, columns) of the homogeneous box with a given mass and inertia.

    From ``I_1 = m (b^2 + c^2) / 12`` and the same for the other principal axes.

    Parameters
    ----------
    mass : float
        kg.
    inertia : ndarray, shape (3, 3)
        About the centre of mass, kg m2.

    Examples
    --------
    >>> equivalent_cuboid(12.0, np.diag([13.0, 10.0, 5.0]))[0].round(12).tolist()
    [1.0, 2.0, 3.0]
    """
    moments, axes = np.linalg.eigh(inertia)
    order = np.argsort(np.argmax(abs(axes), axis=0), kind="stable")  # keeps the box's axes near the body's own
    moments, axes = moments[order], axes[:, order]
    squares = 6.0 / mass * (moments.sum() - 2.0 * moments)
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1.0
    return np.sqrt(np.maximum(squares, 0.0)), axes
