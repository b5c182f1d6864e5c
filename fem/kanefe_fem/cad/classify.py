"""Planes and cylinders among the faces of solids, by their normals: exporters write cylinders as splines."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.frames import turn_to
from kanefe_fem import _gmsh

GRID = 5
"""Points on a face along each of its two parameters."""

ON_EDGES = 17
"""Points on each edge."""

FLAT = 1e-6
"""Largest difference of the normals of a plane: some exporters write seven digits."""

ROUND = 1e-5
"""Largest distance of points from a cylinder, relative to its radius."""


class Samples(NamedTuple):
    """Points on a face in mm, with the outward normals of those on the grid of its parameters; (e, k, 3) on edges."""

    inside: np.ndarray
    edges: np.ndarray
    grid: np.ndarray
    normals: np.ndarray


def samples(gmsh: Any, tag: int) -> Samples:
    """Return points on a face: of a grid over its parameters, those of it within the face, and points on its edges."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    fractions = (np.arange(GRID) + 0.5) / GRID
    u, v = np.meshgrid(*(a + (b - a) * fractions for a, b in zip(low, high, strict=True)))
    places = np.column_stack([u.ravel(), v.ravel()]).ravel()
    grid = np.reshape(gmsh.model.getValue(2, tag, places), (-1, 3))
    normals = np.reshape(gmsh.model.getNormal(tag, places), (-1, 3))
    # before 4.9 the coordinates are always parameters, and nothing says so
    how = () if _gmsh.is_before(gmsh, 4, 9) else (True,)
    within = [gmsh.model.isInside(2, tag, place, *how) > 0 for place in np.reshape(places, (-1, 2)).tolist()]
    edges = []
    for _, edge in gmsh.model.getBoundary([(2, tag)], combined=False, oriented=False):
        start, end = (float(one[0]) for one in gmsh.model.getParametrizationBounds(1, edge))
        edges.append(np.reshape(gmsh.model.getValue(1, edge, np.linspace(start, end, ON_EDGES)), (-1, 3)))
    return Samples(grid[within], np.reshape(edges, (-1, ON_EDGES, 3)), grid, normals)


def kind_of_face(found: Samples, area: float, size: float) -> dict[str, Any]:
    """Return the kind of a face with its plane or cylinder as fields of `kanefe_fem.cad.shapes.Face`, lengths in mm.

    Parameters
    ----------
    found : Samples
    area : float
        mm^2.
    size : float
        Of the whole, mm: cylinders of ten times this radius count as planes that are not flat.
    """
    points, normals = found.grid, found.normals
    if not np.isfinite(normals).all():
        return {"kind": "other"}
    if np.abs(normals - normals[0]).max() < FLAT:
        normal = normals.mean(axis=0)
        return {"kind": "plane", "normal": normal / np.linalg.norm(normal), "point": points.mean(axis=0)}
    spread, directions = np.linalg.eigh(normals.T @ normals)
    if spread[0] > 1e-9 * spread[-1]:
        return {"kind": "other"}
    axis = directions[:, 0]  # all normals are across it
    across = turn_to(axis).T[:2]
    plane = points @ across.T
    middle = plane.mean(axis=0)
    local = plane - middle  # far from the origin, squares lose digits
    rows = np.column_stack([2.0 * local, np.ones(len(local))])
    (x, y, rest), *_ = np.linalg.lstsq(rows, (local**2).sum(axis=1), rcond=None)
    radius = float(np.sqrt(max(rest + x * x + y * y, 0.0)))
    centre = np.array([x, y])
    misfit = np.abs(np.linalg.norm(local - centre, axis=1) - radius).max()
    if not 0.0 < radius < 10.0 * size or misfit > ROUND * radius:
        return {"kind": "other"}
    along = (found.edges.reshape(-1, 3) if len(found.edges) else points) @ axis
    length = float(np.ptp(along))
    if length <= 0.0:
        return {"kind": "other"}
    point = (centre + middle) @ across + axis * (along.max() + along.min()) / 2.0
    radial = points[0] - point
    return {
        "kind": "cylinder",
        "normal": axis,
        "point": point,
        "radius": radius,
        "length": length,
        "angle": area / (radius * length),
        "is_hole": bool(normals[0] @ (radial - axis * (axis @ radial)) < 0.0),
    }
