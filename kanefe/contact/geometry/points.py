"""Points and balls that touch other surfaces, and those that stand for other shapes on ground that is not flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import positive
from kanefe.contact.geometry.shape import Probe, SurfaceShape, length_and_direction
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers

MOST_POINTS = 4000
"""Largest number of points that represent a shape: each has its own friction states."""

SAME_PLACE = 1e-9
"""Distance relative to the spacing below which two points are the same."""

FEWEST_AROUND = 24
"""Least number of points around a round shape: it sinks by 1 - cos(pi / 24), 0.9 % of its radius, between two points.
"""


@dataclass(frozen=True, eq=False)
class Points(SurfaceShape):
    """Balls or points that touch other surfaces: an edge, a skid, the feet of a table.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Centres, m.
    radius : float
        Of each, m; 0: points.
    share : float, optional
        Of each, of the stiffness of the contact; default 1/n: all of them together have it.
    """

    points: Any
    radius: float = 0.0
    share: float | None = None
    kind = 6

    def __post_init__(self) -> None:
        places = numbers(self.points)
        if places.ndim != 2 or places.shape[1:] != (3,) or not len(places) or not np.all(np.isfinite(places)):
            raise ModelError(f"points of a surface must be finite, shape (n, 3), m, not {self.points!r}")
        if numbers(self.radius).shape or numbers(self.radius) != 0.0:
            positive(self.radius, "radius of points")
        if self.share is not None and positive(self.share, "share of points") > 1.0:
            raise ModelError(
                f"share of points is that of each of the whole stiffness, and must be 1 at most, not {self.share!r}"
            )
        object.__setattr__(self, "points", places)

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from the nearest, m, and the normal of its ball."""
        offsets = np.asarray(x, dtype=float) - self.points
        length, normal = length_and_direction(offsets[int(np.argmin(np.linalg.norm(offsets, axis=1)))])
        return length - self.radius, normal

    @property
    def numbers(self) -> Vector:
        """Nothing: others do not touch it."""
        return np.zeros(0)

    def probes(self) -> tuple[Probe, ...]:
        """Return each, with its share."""
        share = 1.0 / len(self.points) if self.share is None else self.share
        return tuple(Probe(point, self.radius, share) for point in self.points)


def on_line(start: Vector, end: Vector, spacing: float) -> Matrix:
    """Return places from one to another, at most a spacing apart, (n, 3)."""
    count = _counted(float(np.linalg.norm(end - start)) / spacing * (1.0 - SAME_PLACE)) + 1
    return np.linspace(start, end, max(count, 2))


def on_circle(radius: float, axes: Matrix, spacing: float) -> Matrix:
    """Return places of a circle about the third of some axes (3, 3, columns), (n, 3); of no radius its middle."""
    count = max(_counted(2.0 * math.pi * radius / spacing), FEWEST_AROUND) if radius > 0.0 else 1
    angles = np.arange(count) * (2.0 * math.pi / count)
    return np.asarray(radius * (np.cos(angles)[:, None] * axes[:, 0] + np.sin(angles)[:, None] * axes[:, 1]))


def on_box(size: Vector, spacing: float) -> tuple[Matrix, int]:
    """Return places of the faces of a box about its middle, and how many the face has that has most."""
    along = np.maximum(np.asarray(size, dtype=float) / spacing, 1.0) + 1.0
    _refuse_many(float(np.prod(along) - np.prod(along - 2.0)), "box")
    lines = [on_line(np.array([-0.5 * side]), np.array([0.5 * side]), spacing)[:, 0] for side in size]
    places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    outside = np.any(np.abs(places) >= 0.5 * size * (1.0 - SAME_PLACE), axis=1)
    counts = sorted(len(line) for line in lines)
    return places[outside], counts[1] * counts[2]


def on_cylinder(radius: float, length: float, axes: Matrix, spacing: float) -> tuple[Matrix, int]:
    """Return places of a cylinder along the third of some axes, and how many one of its ends has."""
    heights = on_line(np.array([-0.5 * length]), np.array([0.5 * length]), spacing)
    _refuse_many(len(heights) * len(on_circle(radius, axes, spacing)), "cylinder")
    side = (heights[:, :, None] * axes[:, 2] + on_circle(radius, axes, spacing)).reshape(-1, 3)
    rings = max(math.ceil(radius / spacing), 1)
    disc = np.vstack([on_circle(radius * i / rings, axes, spacing) for i in range(rings)])
    ends = [end * 0.5 * length * axes[:, 2] + disc for end in (-1.0, 1.0)]
    return np.vstack((side, *ends)), len(disc) + len(side) // len(heights)


def on_triangles(vertices: Matrix, triangles: np.ndarray, spacing: float) -> tuple[Matrix, int]:
    """Return places of triangles, and how many the flat face has that has most."""
    found, faces = [], []
    for corners in vertices[triangles]:
        a, b, c = corners
        sides = np.linalg.norm((b - a, c - b, a - c), axis=1)
        parts = max(_counted(float(sides.max()) / spacing * (1.0 - SAME_PLACE)), 1)
        _refuse_many((parts + 1) * (parts + 2) // 2)
        i, j = np.nonzero(np.add.outer(np.arange(parts + 1), np.arange(parts + 1)) <= parts)
        found.append(a + np.outer(i / parts, b - a) + np.outer(j / parts, c - a))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        faces.append(np.tile((*normal, normal @ a / spacing), (len(i), 1)))
    places = np.vstack(found)
    _, first, same = np.unique(
        np.round(places / (SAME_PLACE * spacing)), axis=0, return_index=True, return_inverse=True
    )
    _, face = np.unique(np.round(np.vstack(faces) / SAME_PLACE), axis=0, return_inverse=True)
    in_faces = np.unique(np.column_stack((face.ravel(), same.ravel())), axis=0)[:, 0]
    return places[first], int(np.bincount(in_faces).max())


def _counted(spaces: float) -> int:
    """Return how many spaces of a line are needed; a ModelError, before they are made, if too many."""
    _refuse_many(spaces)
    return math.ceil(spaces)


def _refuse_many(count: float, title: str = "shape") -> None:
    if count > MOST_POINTS:
        raise ModelError(
            f"{count:.4g} points would represent a {title}, and {MOST_POINTS} are permitted. Remedy: a larger spacing, "
            "or a simpler shape instead"
        )


def standing_for(title: str, places: Matrix, at_once: int, radius: float = 0.0) -> Points:
    """Return points that stand for a shape, of which so many lie on flat ground at once; a ModelError if too many."""
    _refuse_many(len(places), title)
    return Points(places, radius, 1.0 / at_once)
