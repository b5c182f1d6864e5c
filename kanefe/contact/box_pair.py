"""A box on a box: along one axis, of least overlap, their faces meet in a polygon, or two edges cross.

The axis is found among those of the faces and the products of edges (the separating axis theorem; Gottschalk, Lin and
Manocha 1996). Where a face leads, what touches are corners of both faces that lie over the other face, and the places
where their edges cross: corners of the polygon that they share. Each is a slot, so that friction knows it again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.contact.geometry.shape import Probe
from kanefe.frames import Matrix, Vector, cross
from kanefe.loads.base import End

OWN_CORNERS, OTHER_CORNERS, CROSSINGS, EDGES, SLOTS = 0, 4, 8, 16, 17
"""First slots of corners of the box that touches, of that which is touched, and of crossings of edges of their faces;
then one for edges that cross in space."""

CORNER_SHARE, EDGE_SHARE = 0.25, 0.5

SIDES = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
"""Corners of a face, round it."""

PARALLEL = 1e-6
"""Sine of the angle between edges below which their product is not an axis."""

PREFERRED = 1e-6
"""Of the size of the boxes: by so much less must edges overlap than faces, to lead."""

ON_EDGE = 1e-6
"""Of the size of the boxes: corners this near to a face's edge are over the face."""


def box_probes(half: Vector) -> tuple[Probe, ...]:
    """Return the slots of a box of given half sizes that touches a box."""
    return tuple(
        Probe(np.zeros(3), 0.0, EDGE_SHARE if slot == EDGES else CORNER_SHARE, -1.0 - slot, half)
        for slot in range(SLOTS)
    )


class BoxPair(NamedTuple):
    """How two boxes meet.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        From the box that is touched, in N.
    overlap : float
        Along it, m; below 0: they are apart.
    edges : (int, int) or None
        Axes of the edges that cross; None: a face leads.
    """

    normal: Vector
    overlap: float
    edges: tuple[int, int] | None


def meeting(surface: End, other: Vector, end: End, own: Vector) -> BoxPair:
    """Return how a box of half sizes `own` at an end meets one of half sizes `other` at a surface."""
    between, size = end.p - surface.p, float(np.sum(own + other))
    faces = [*surface.A.T, *end.A.T]
    best = min((_along(axis, between, surface.A, other, end.A, own) for axis in faces), key=lambda met: met.overlap)
    least = best.overlap - PREFERRED * size
    for i in range(3):
        for j in range(3):
            axis = cross(end.A[:, i], surface.A[:, j])
            length = float(np.linalg.norm(axis))
            if length > PARALLEL:
                found = _along(axis / length, between, surface.A, other, end.A, own)
                if found.overlap < least:
                    best, least = found._replace(edges=(i, j)), found.overlap
    return best


def _along(axis: Vector, between: Vector, A: Matrix, other: Vector, B: Matrix, own: Vector) -> BoxPair:
    away = float(axis @ between)
    reach = float(other @ np.abs(A.T @ axis) + own @ np.abs(B.T @ axis))
    return BoxPair(axis if away >= 0.0 else -axis, reach - abs(away), None)


def slot_of(
    met: BoxPair, slot: int, surface: End, other: Vector, end: End, own: Vector
) -> tuple[float, Vector, Vector]:
    """Return depth (m), normal, and place in N of a slot."""
    n = met.normal
    if met.edges is not None or slot == EDGES:
        if met.edges is None or slot != EDGES:
            return -abs(met.overlap), n, end.p
        i, j = met.edges
        a, b = end.A[:, i], surface.A[:, j]
        p = end.p - end.A @ (own * np.where(end.A.T @ n >= 0.0, 1.0, -1.0) * (np.arange(3) != i))
        q = surface.p + surface.A @ (other * np.where(surface.A.T @ n >= 0.0, 1.0, -1.0) * (np.arange(3) != j))
        d, c = q - p, float(a @ b)
        return met.overlap, n, p + (float(d @ a) - c * float(d @ b)) / (1.0 - c * c) * a
    margin = ON_EDGE * float(np.sum(own + other))
    own_face, other_face = _Face(end, own, -n), _Face(surface, other, n)
    if slot < OTHER_CORNERS:
        return _over(own_face.corner(slot), other_face, n, margin), n, own_face.corner(slot)
    if slot < CROSSINGS:
        corner = other_face.corner(slot - OTHER_CORNERS)
        return _over(corner, own_face, -n, margin), n, corner
    side, is_end = divmod(slot - CROSSINGS, 2)
    start, stop = own_face.corner(side), own_face.corner((side + 1) % 4)
    depths = [other_face.below(p, n) for p in (start, stop)]
    flat = [other_face.flat(p + depth * n) for p, depth in zip((start, stop), depths, strict=True)]
    low, high = 0.0, 1.0
    for along, half in enumerate(other_face.half):
        x, way = flat[0][along], flat[1][along] - flat[0][along]
        if abs(way) <= margin:
            if abs(x) > half + margin:
                return -abs(abs(x) - half), n, start
            continue
        ends = sorted(((-half - x) / way, (half - x) / way))
        low, high = max(low, ends[0]), min(high, ends[1])
    share = high if is_end else low
    length = float(np.linalg.norm(stop - start))
    away = min((high - low) * length - margin, ((1.0 - share) if is_end else share) * length - margin)
    depth = depths[0] + share * (depths[1] - depths[0])
    return (depth if away > 0.0 else min(depth, away)), n, start + share * (stop - start)


class _Face:
    """A face of a box: that which looks most along a direction."""

    def __init__(self, end: End, half: Vector, direction: Vector) -> None:
        along = end.A.T @ direction
        axis = int(np.argmax(np.abs(along)))
        first, second = (axis + 1) % 3, (axis + 2) % 3
        self.normal = end.A[:, axis] * (1.0 if along[axis] >= 0.0 else -1.0)
        self.middle = end.p + half[axis] * self.normal
        self._sides = end.A[:, first], end.A[:, second]
        self.half = half[first], half[second]

    def corner(self, i: int) -> Vector:
        """Return a corner."""
        x, y = SIDES[i]
        return self.middle + x * self.half[0] * self._sides[0] + y * self.half[1] * self._sides[1]

    def below(self, p: Vector, n: Vector) -> float:
        """Return how far below the face a place is, along n."""
        return float(self.normal @ (self.middle - p)) / float(self.normal @ n)

    def flat(self, p: Vector) -> tuple[float, float]:
        """Return the place on the face."""
        return float(self._sides[0] @ (p - self.middle)), float(self._sides[1] @ (p - self.middle))


def _over(p: Vector, face: _Face, n: Vector, margin: float) -> float:
    """Return how far below a face a place is, along n; of a place beside the face how far beside, below 0."""
    depth = face.below(p, n)
    x, y = face.flat(p + depth * n)
    beside = min(face.half[0] - abs(x), face.half[1] - abs(y)) + margin
    return depth if beside >= 0.0 else min(depth, beside)
