"""The relief of height fields: low places are drawn darker than high ones."""

from __future__ import annotations

import numpy as np

from kanefe.results.surface_outline import SurfaceOutline

SHALLOW = 0.005
"""Depth relative to the root of the area below which low places are not fully dark, so that flat ground is light."""

DARK = 0.5
"""Brightness of the lowest place in small pictures, relative to that of the highest."""


def relief(surface: SurfaceOutline) -> np.ndarray:
    """Return the brightness (n,) of the vertices of a height field by height above its mean slope; 1 for the highest.

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
    normal = np.cross(b - a, c - a).sum(axis=0)
    heights = surface.vertices @ normal
    area = np.linalg.norm(normal)
    below = (heights.max() - heights) / area
    return np.asarray(1.0 - below / max(below.max(), SHALLOW * np.sqrt(area)))
