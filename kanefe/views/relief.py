"""The relief of fields of heights: low places are drawn darker than high ones."""

from __future__ import annotations

import numpy as np

from kanefe.results.surface_outline import SurfaceOutline


def relief(surface: SurfaceOutline) -> np.ndarray:
    """Return how high the vertices of a field of heights are above its mean slope, (n,), of 0 to 1.

    Examples
    --------
    >>> import kanefe as kf
    >>> x, scene = [0.0, 1.0, 2.0], kf.System()
    >>> ground = scene.add_surface("road", scene.ground, kf.shapes.HeightField(x, x, [[0, 0, 0], [0, 1, 0], [0, 0, 0]]))
    >>> ball = scene.add_point("ball", 1.0)
    >>> float(relief(scene.simulate((0.0, 0.1)).surfaces[0]).max())
    1.0
    """
    a, b, c = (surface.vertices[surface.triangles[:, i]] for i in range(3))
    heights = surface.vertices @ np.cross(b - a, c - a).sum(axis=0)
    return np.asarray((heights - heights.min()) / (np.ptp(heights) or 1.0))
