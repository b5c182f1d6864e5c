"""Thin solids: which of their faces lie opposite of each other at one distance, and which are rims between them.

Two faces are a pair if they are parallel planes or cylinders on one axis with the solid between them, and nothing else
is nearer. Thin pairs come first; a face with both faces of a pair beside it is a rim. The pairs of a sheet have one
side each, from face to neighbour, as the metal has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kanefe.errors import MeshError
from kanefe_fem.cad.shapes import Face, Solid

EVEN = 0.01
"""Largest change of the distance between two faces, relative to it, that counts as one thickness."""

WIDE = 2.0
"""Width of a rim, relative to the thickness, above which it is more than a rim: 1.4 is an edge at 45 degrees."""

THICK = 0.25
"""Thickness, relative to the root of the middle area, above which a solid is not thin."""

FULL = 0.05
"""Largest volume that the pairs may miss, relative to that of the solid."""

REMEDY = "Remedy: mesh it as a solid, or draw its middle surface (gmsh, .geo) for shell_body"

Borders = Mapping[int, Mapping[int, float]]
"""Lengths of the edges that each face shares with others, by their numbers, m."""


class Probe(NamedTuple):
    """What is asked of the geometry: points within a face (k, 3), and which of some points on a face are within it."""

    points: Callable[[Face], np.ndarray]
    covers: Callable[[Face, np.ndarray], np.ndarray]


class Pair(NamedTuple):
    """Two faces opposite of each other, and their distance in m."""

    one: Face
    other: Face
    thickness: float

    @property
    def area(self) -> float:
        """Area half-way between the two faces, m^2."""
        return 0.5 * (self.one.area + self.other.area)


class Sheet(NamedTuple):
    """A thin solid.

    Attributes
    ----------
    thickness : dict of int to float
        Of the faces of one side by their numbers, m.
    across : dict of int to tuple of int
        For each face of either side the faces of the one side there.
    """

    thickness: Mapping[int, float]
    across: Mapping[int, tuple[int, ...]]


def depth(face: Face, points: np.ndarray) -> np.ndarray:
    """Return how deep points (k, 3) are in the solid under a plane or a cylinder, m, shape (k,); negative outside."""
    if face.kind == "plane":
        return np.asarray((face.point - points) @ face.normal)
    beside = np.linalg.norm(_radial(face, points), axis=1)
    return (beside - face.radius) * (1.0 if face.is_hole else -1.0)


def outward(face: Face, points: np.ndarray) -> np.ndarray:
    """Return the unit normals out of the solid of a plane or a cylinder at points (k, 3), shape (k, 3)."""
    if face.kind == "plane":
        return np.broadcast_to(face.normal, points.shape)
    radial = _radial(face, points)
    return np.asarray(radial / np.linalg.norm(radial, axis=1)[:, None] * (-1.0 if face.is_hole else 1.0))


def _radial(face: Face, points: np.ndarray) -> np.ndarray:
    away = points - face.point
    return np.asarray(away - np.outer(away @ face.normal, face.normal))


def sheet_of(solid: Solid, borders: Borders, probe: Probe, file: str) -> Sheet:
    """Return the two sides of a thin solid.

    Parameters
    ----------
    solid : Solid
    borders : Borders
    probe : Probe
    file : str
        For messages.

    Raises
    ------
    MeshError
        If the solid is no sheet of one thickness for each pair of faces; the message has the face and the reason.
    """
    label = f"{file}: no middle surface of {solid.name!r}"
    pairs = _thin_pairs(solid, borders, probe)
    if not pairs:
        largest = max(solid.faces, key=lambda face: face.area)
        raise MeshError(f"{label}: {_why_alone(largest, solid.faces, probe)}. {REMEDY}")
    for reason in _reasons(solid, pairs, borders, probe):
        raise MeshError(f"{label}: {reason}. {REMEDY}")
    side = _sides(pairs, borders)
    area = {sign: sum(face.area for face in _faces(pairs) if side[face.tag] == sign) for sign in (1, -1)}
    kept = 1 if area[1] >= area[-1] else -1
    across: dict[int, tuple[int, ...]] = {}
    thickness: dict[int, float] = {}
    for pair in pairs:
        own, far = (pair.one, pair.other) if side[pair.one.tag] == kept else (pair.other, pair.one)
        thickness[own.tag] = pair.thickness
        across[own.tag] = (own.tag,)
        across[far.tag] = (*across.get(far.tag, ()), own.tag)
    return Sheet(thickness, across)


def _faces(pairs: Sequence[Pair]) -> list[Face]:
    return list({face.tag: face for pair in pairs for face in (pair.one, pair.other)}.values())


def _thin_pairs(solid: Solid, borders: Borders, probe: Probe) -> list[Pair]:
    """Return the pairs of faces that are sides of a sheet: thin ones first, without what is a rim of others."""
    found: list[Pair] = []
    for pair in sorted(_pairs(solid.faces, probe), key=lambda pair: pair.thickness**2 / pair.area):
        is_rim = any(
            of.one.tag in borders[face.tag] and of.other.tag in borders[face.tag] for of in found for face in pair[:2]
        )
        if pair.thickness**2 < pair.area and not is_rim:
            found.append(pair)
    return found


def _pairs(faces: Sequence[Face], probe: Probe) -> list[Pair]:
    """Return all pairs of faces of which one is the nearest opposite of at least half of the other."""
    made: dict[frozenset[int], Pair] = {}
    regular = [face for face in faces if face.kind != "other"]
    for one in regular:
        others = [other for other in regular if other is not one]  # a face is under itself by round-off
        facing = [(float(t.mean()), other) for other in others for t in (depth(other, one.points),) if _is_even(t)]
        points = probe.points(one)
        is_free = np.ones(len(points), dtype=bool)
        for thickness, other in sorted(facing, key=lambda each: each[0]):
            foot = points + depth(other, points)[:, None] * outward(other, points)
            is_near = is_free & (depth(other, points) > 0.0) & probe.covers(other, foot)
            is_free &= ~is_near
            if is_near.sum() >= 0.5 * len(points):
                made.setdefault(frozenset((one.tag, other.tag)), Pair(one, other, thickness))
    return list(made.values())


def _is_even(depths: np.ndarray) -> bool:
    mean = float(depths.mean())
    return mean > 0.0 and float(np.ptp(depths)) <= EVEN * mean


def _sides(pairs: Sequence[Pair], borders: Borders) -> dict[int, int]:
    """Return the side, 1 or -1, of each face that is reached from the first; neighbours are on one side."""
    faces = {face.tag for face in _faces(pairs)}
    links = [(pair.one.tag, pair.other.tag, -1) for pair in pairs]
    links += [(tag, other, 1) for tag in faces for other in borders[tag] if other in faces]
    of: dict[int, list[tuple[int, int]]] = {tag: [] for tag in faces}
    for one, other, sign in links:
        of[one].append((other, sign))
        of[other].append((one, sign))
    start = pairs[0].one.tag
    side, open_ends = {start: 1}, [start]
    while open_ends:
        tag = open_ends.pop()
        for other, sign in of[tag]:
            if other not in side:
                side[other] = side[tag] * sign
                open_ends.append(other)
            elif side[other] != side[tag] * sign:
                side[other] = 0  # on both sides
    return side


def _reasons(solid: Solid, pairs: Sequence[Pair], borders: Borders, probe: Probe) -> Iterator[str]:
    """Yield why a solid of these pairs is no sheet."""
    first: dict[int, float] = {}
    for pair in pairs:
        for face in (pair.one, pair.other):
            t = first.setdefault(face.tag, pair.thickness)
            if abs(t - pair.thickness) > EVEN * t:
                low, high = sorted((t, pair.thickness))
                yield f"the thickness under {_named(face)} is {_mm(low)} at one place and {_mm(high)} at another"
    side = _sides(pairs, borders)
    for face in _faces(pairs):
        if side.get(face.tag) == 0:
            yield f"it branches, as a T does: {_named(face)} would be on both of its sides"
        if face.tag not in side:
            yield f"it is several sheets: {_named(face)} is not connected with {_named(pairs[0].one)}"
    yield from _odd_rims(solid, first, side, borders, probe)
    volume, area = sum(pair.thickness * pair.area for pair in pairs), sum(pair.area for pair in pairs)
    if abs(volume / solid.volume - 1.0) > FULL:
        yield f"its pairs of faces have {100.0 * volume / solid.volume:.3g} % of its volume"
    if volume > THICK * area**1.5:
        yield f"it is not thin: {_mm(volume / area)} thick, with a middle surface of {1e6 * area:.4g} mm2"


def _odd_rims(
    solid: Solid, thickness: Mapping[int, float], side: Mapping[int, int], borders: Borders, probe: Probe
) -> Iterator[str]:
    """Yield what faces without a partner are more than rims: connected ones are to have both sides beside them."""
    alone = {face.tag: face for face in solid.faces if face.tag not in thickness}
    while alone:
        cluster, ends = {}, [next(iter(alone))]
        while ends:
            tag = ends.pop()
            if tag in alone:
                cluster[tag] = alone.pop(tag)
                ends += borders[tag]
        lengths = {1: 0.0, -1: 0.0}
        thickest = 0.0
        for tag in cluster:
            for other, length in borders[tag].items():
                if other in thickness:
                    lengths[side[other]] += length
                    thickest = max(thickest, thickness[other])
        largest = max(cluster.values(), key=lambda face: face.area)
        area = sum(face.area for face in cluster.values())
        if min(lengths.values()) <= 0.0:
            yield f"{_why_alone(largest, solid.faces, probe)}, and it is on one side of the sheet only"
        if area > WIDE * thickest * min(lengths.values()):
            yield f"{_why_alone(largest, solid.faces, probe)}, and it is too wide for a rim"


def _why_alone(face: Face, faces: Sequence[Face], probe: Probe) -> str:
    """Return why a face has no partner."""
    if face.kind == "other":
        return f"{_named(face)} is neither a plane nor a cylinder"
    points = probe.points(face)
    normals = outward(face, points)
    below: list[float] = []
    for other in (one for one in faces if one.kind == "plane" and one is not face):
        slope = normals @ other.normal
        ahead = slope < -0.5  # within 60 degrees of parallel
        way = np.where(ahead, depth(other, points) / np.where(ahead, -slope, 1.0), -1.0)
        below += way[(way > 0.0) & probe.covers(other, points - way[:, None] * normals)].tolist()
    if below and max(below) - min(below) > EVEN * max(below):
        return f"the thickness under {_named(face)} varies from {_mm(min(below))} to {_mm(max(below))}"
    return f"{_named(face)} has no partner: no other lies opposite of it at one distance, with nothing nearer"


def _named(face: Face) -> str:
    at = ", ".join(f"{round(float(one), 9) + 0.0:.4g}" for one in face.centre)
    kind = {"plane": "plane face", "cylinder": f"cylinder of radius {_mm(face.radius)}"}.get(face.kind, "face")
    return f"the {kind} at ({at}) m"


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
