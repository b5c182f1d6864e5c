"""Boxes of mass and inertia that represent rigid bodies without other geometry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.results.body_shape import BodyShape
from kanefe.results.surface_outline import SurfaceOutline
from kanefe.views.cuboids import CORNERS, equivalent_cuboid

SMALLEST = 0.012
"""Side of the box that represents a point, relative to the scene's size."""

COVERED = 0.5
"""Size of a body's surfaces, relative to that of its box, above which they represent the body."""

_FACES = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
TRIANGLES = np.concatenate((_FACES[:, [0, 1, 2]], _FACES[:, [0, 2, 3]]))
"""Triangles of a box with the corners `kanefe.views.cuboids.CORNERS`."""


def box_of(shape: BodyShape, surfaces: Sequence[SurfaceOutline], smallest: float = 0.0) -> np.ndarray | None:
    """Return the corners (8, 3) of the box of a rigid body in its frame; None if its surfaces represent it.

    Parameters
    ----------
    shape : BodyShape
        A body with mass.
    surfaces : sequence of SurfaceOutline
        Surfaces of the body. A plane represents a driven body such as a deck.
    smallest : float
        Smallest side, m.
    """
    sides, axes = equivalent_cuboid(shape.mass, shape.inertia)
    if shape.is_driven and any(surface.is_endless for surface in surfaces):
        return None
    for surface in surfaces:
        extent = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
        if not surface.is_endless and extent >= COVERED * float(np.linalg.norm(sides)):
            return None
    return np.asarray(shape.com + 0.5 * (CORNERS * np.maximum(sides, smallest)) @ axes.T)


def is_inside(corners: np.ndarray, points: np.ndarray) -> bool:
    """Return whether one of the points (p, 3) is well inside a box (8, 3)."""
    middle, edges = corners.mean(axis=0), corners[[1, 3, 4]] - corners[0]
    squares = np.maximum((edges**2).sum(axis=1), 1e-300)
    shares = np.abs((points - middle) @ edges.T) / squares
    return bool((shares < 0.45).all(axis=1).any())
