"""Where the parts of an assembly meet: shafts in holes, and planes face to face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from kanefe.frames import turn_to
from kanefe_fem.cad.shapes import Face, Solid

COAXIAL = 1e-5
"""Largest distance of two axes relative to the size of the assembly, and largest angle between them, rad."""

PLAY = 0.05
"""Largest difference of the radii of shaft and hole relative to the larger."""

COVERED = 0.6
"""Least fraction of a full turn that the faces of a shaft or a hole have together: fillets have less."""

ALONG = 0.01
"""Least length that shaft and hole have in common, relative to the radius."""


@dataclass(frozen=True, eq=False)
class Barrel:
    """A shaft or a hole of a solid: its cylinders on one axis with one radius.

    Attributes
    ----------
    solid : Solid
    faces : tuple of Face
    axis, point : ndarray, shape (3,)
        Direction, and a point on the axis, m.
    radius : float
        m.
    spans : tuple of (float, float)
        Where its faces begin and end along the axis from the point, m.
    is_hole : bool
    """

    solid: Solid
    faces: tuple[Face, ...]
    axis: np.ndarray
    point: np.ndarray
    radius: float
    spans: tuple[tuple[float, float], ...]
    is_hole: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """A shaft in a hole.

    Attributes
    ----------
    shaft, hole : Barrel
    point, axis : ndarray, shape (3,)
        Middle of what they have in common, m, and direction.
    length : float
        Of what they have in common, m.
    """

    shaft: Barrel
    hole: Barrel
    point: np.ndarray
    axis: np.ndarray
    length: float

    @property
    def play(self) -> float:
        """Difference of the radii, m."""
        return self.hole.radius - self.shaft.radius


@dataclass(frozen=True, eq=False)
class Contact:
    """Two planes face to face.

    Attributes
    ----------
    solids : (Solid, Solid)
    faces : (Face, Face)
    normal : ndarray, shape (3,)
        Out of the first.
    point : ndarray, shape (3,)
        m.
    """

    solids: tuple[Solid, Solid]
    faces: tuple[Face, Face]
    normal: np.ndarray
    point: np.ndarray


def barrels(solid: Solid, size: float) -> list[Barrel]:
    """Return the shafts and holes of a solid, cylinders that are cut into several faces as one."""
    left = [face for face in solid.faces if face.kind == "cylinder"]
    found = []
    while left:
        first = left[0]
        same = [face for face in left if _is_same(first, face, size)]
        left = [face for face in left if all(face is not one for one in same)]
        spans = [_span(first, face) for face in same]
        turns = [sum(f.angle for f, (a, b) in zip(same, spans, strict=True) if a < (c + d) / 2 < b) for c, d in spans]
        if max(turns) >= COVERED * 2.0 * np.pi:
            found.append(
                Barrel(solid, tuple(same), first.normal, first.point, first.radius, tuple(spans), first.is_hole)
            )
    return found


def _is_same(a: Face, b: Face, size: float) -> bool:
    close = abs(a.radius - b.radius) < 0.1 * COAXIAL * size and a.is_hole == b.is_hole
    return close and _are_coaxial(a.normal, a.point, b.normal, b.point, size)


def _are_coaxial(axis: np.ndarray, point: np.ndarray, other: np.ndarray, there: np.ndarray, size: float) -> bool:
    if float(np.linalg.norm(np.cross(axis, other))) > COAXIAL:
        return False
    # at the middle of both, so that the angle between them does not count twice
    return float(np.linalg.norm(np.cross(there - point, axis))) <= COAXIAL * size


def _span(first: Face, face: Face) -> tuple[float, float]:
    middle = float((face.point - first.point) @ first.normal)
    return middle - face.length / 2.0, middle + face.length / 2.0


def fits(solids: Sequence[Solid], size: float) -> list[Fit]:
    """Return each shaft of a solid in a hole of another, on one axis, with about its radius."""
    every = [one for solid in solids for one in barrels(solid, size)]
    shafts, holes = ([one for one in every if one.is_hole == kind] for kind in (False, True))
    found = []
    for shaft, hole in product(shafts, holes):
        play = hole.radius - shaft.radius
        if shaft.solid is hole.solid or not -0.1 * COAXIAL * size < play < PLAY * hole.radius:
            continue
        if not _are_coaxial(hole.axis, hole.point, shaft.axis, shaft.point, size):
            continue
        offset = float((shaft.point - hole.point) @ hole.axis)
        sign = float(np.sign(shaft.axis @ hole.axis))
        own = [tuple(sorted((offset + sign * a, offset + sign * b))) for a, b in shaft.spans]
        common = [(max(a, c), min(b, d)) for (a, b), (c, d) in product(hole.spans, own)]
        common = [(a, b) for a, b in common if b - a > ALONG * hole.radius]
        if common:
            low, high = min(a for a, _ in common), max(b for _, b in common)
            point = hole.point + hole.axis * (low + high) / 2.0
            found.append(Fit(shaft, hole, point, hole.axis, _covered(common)))
    return found


def _covered(spans: list[tuple[float, float]]) -> float:
    """Return the length that spans cover together."""
    length, end = 0.0, -np.inf
    for a, b in sorted(spans):
        length += max(0.0, b - max(a, end))
        end = max(end, b)
    return length


def facing_planes(solids: Sequence[Solid], size: float) -> list[Contact]:
    """Return planes of two solids that lie on each other."""
    near = 0.1 * COAXIAL * size
    found = []
    for one, other in combinations(solids, 2):
        if not may_touch(one, other, near):
            continue
        planes = ([face for face in solid.faces if face.kind == "plane"] for solid in (one, other))
        for a, b in product(*planes):
            is_opposite = float(np.linalg.norm(a.normal + b.normal)) < COAXIAL
            if is_opposite and abs((b.point - a.point) @ a.normal) < near and _meet(a, b):
                smaller = min((a, b), key=lambda face: face.area)
                found.append(Contact((one, other), (a, b), a.normal, smaller.centre))
    return found


def _meet(one: Face, other: Face) -> bool:
    """Return whether two faces in one plane have points in common: those inside the one that lie inside the other."""
    across = turn_to(one.normal)[:, :2]
    return any(_is_any_inside(a.inside @ across, b.edges @ across) for a, b in ((one, other), (other, one)))


def _is_any_inside(points: np.ndarray, edges: np.ndarray) -> bool:
    """Return whether a point (p, 2) lies inside the edges (e, k, 2) of a face: a ray from it meets an odd number."""
    start, end = edges[:, :-1].reshape(-1, 2), edges[:, 1:].reshape(-1, 2)
    y = points[:, None, 1]
    meets = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    where = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / rise
    return bool((np.count_nonzero(meets & (where > points[:, None, 0]), axis=1) % 2 == 1).any())


def may_touch(one: Solid, other: Solid, slack: float) -> bool:
    """Return whether the boxes around two solids meet."""
    return bool((one.low <= other.high + slack).all() and (other.low <= one.high + slack).all())
