"""The space that a run takes, which determines the first view of it.

It contains the moving bodies, and the fixed parts if they are not much larger: not all of a road. If the moving bodies
travel together over several times their size, the view moves with them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kanefe.frames import rotation_matrix
from kanefe.results.body_shape import BodyShape
from kanefe.results.load_lines import LoadLine
from kanefe.results.reader import Reader
from kanefe.views.cuboids import CORNERS
from kanefe.views.player.boxes import box_of
from kanefe.views.player.skins import Skin
from kanefe.views.player.tracks import GROUND, Tracks

LOOKED_AT = 100
"""Number of instants at which the extents are evaluated."""

TRAVELS = 3.0
"""Size of the traversed space, relative to that occupied at an instant, above which the view travels."""

ALONG = 0.5
"""Displacement along an axis, relative to the size of the moving bodies, above which the view travels along that axis.
"""

WIDE = 3.0
"""Size of the whole scene, relative to the space of the moving bodies, up to which all of it is in view."""

STILL = 1e-6
"""Motion relative to the size of the body that counts as zero."""

LEAST = 1e-4
"""Smallest space of moving bodies, relative to the whole scene, that determines the view."""


class Extent(NamedTuple):
    """Lowest and highest corner, (3,) each, m."""

    low: np.ndarray
    high: np.ndarray

    @property
    def size(self) -> float:
        """Its diagonal, m."""
        return float(np.linalg.norm(self.high - self.low))

    @property
    def corners(self) -> np.ndarray:
        """Its corners, (8, 3), m."""
        return np.asarray(0.5 * (self.low + self.high) + 0.5 * CORNERS * (self.high - self.low))


class Room(NamedTuple):
    """The space in view.

    Attributes
    ----------
    box : Extent
        Extent in N of the whole scene at all times shown, or of the moving bodies if that is much smaller.
    is_whole : bool
        Whether it is that of the whole scene.
    path : ndarray, shape (S, 3), or None
        Centre of the moving bodies in N at the times shown; None if they do not travel together.
    about : Extent or None
        Extent of the travelling bodies about the path, at all times.
    """

    box: Extent
    is_whole: bool
    path: np.ndarray | None = None
    about: Extent | None = None

    @property
    def size(self) -> float:
        """Diagonal of the space in view at one time, m; 1 for a single point."""
        return (self.about or self.box).size or 1.0

    def around(self, row: int) -> np.ndarray:
        """Return the corners of the space in view at one of the times shown, (8, 3), in N, m."""
        if self.path is None or self.about is None:
            return self.box.corners
        return self.path[row] + self.about.corners


def room_of(result: Reader, tracks: Tracks, skins: Mapping[str, Skin], lines: Sequence[LoadLine]) -> Room:
    """Return the space of all bodies, of finite surfaces, and of the lines of loads."""
    count = len(tracks.frames)
    seen = _Seen(np.unique(np.linspace(0, count - 1, LOOKED_AT).round().astype(int)))
    mass, middle = 0.0, np.zeros((count, 3))
    for name in result.bodies:
        shape = result.body(name)
        if shape.line is not None:  # bent far, it is not where it was at rest
            moves = seen.see(result.nodal_positions(name, frames=tracks.frames[seen.rows]), moves=True)
        else:
            points = _points_of(result, shape, skins)
            moves = seen.see(_placed(tracks, tracks.number(name), points, seen.rows), moves=shape.is_flexible)
        if moves and shape.mass > 0.0:
            if shape.line is not None:
                centre = result.center_of_mass(name)[tracks.frames]
            else:
                centre = tracks.tracked(tracks.number(name), shape.com)
            mass, middle = mass + shape.mass, middle + shape.mass * centre
    for surface in result.surfaces:
        if not surface.is_endless:
            seen.see(_placed(tracks, tracks.number(surface.body, surface.interface), surface.vertices, seen.rows))
    for line in lines:
        seen.see(line.points[seen.rows])
    return seen.room(middle / mass if mass else None)


class _Seen:
    """Boxes of what was looked at, at some of the times shown.

    Parameters
    ----------
    rows : ndarray of int
        Their numbers.
    """

    def __init__(self, rows: np.ndarray) -> None:
        self.rows = rows
        self._boxes: list[tuple[np.ndarray, np.ndarray, bool]] = []

    def see(self, places: np.ndarray, moves: bool = False) -> bool:
        """Add points (rows, p, 3); return whether they move."""
        low, high = places.min(axis=1), places.max(axis=1)
        size = np.linalg.norm(high.max(axis=0) - low.min(axis=0))
        moves = moves or bool(np.ptp(places, axis=0).max() > STILL * size)
        self._boxes.append((low, high, moves))
        return moves

    def room(self, middle: np.ndarray | None) -> Room:
        """Return the space of all points; `middle` is the centre of the mass that moves, at all times, if any does."""
        whole, moving = _boxes(self._boxes), _boxes([one for one in self._boxes if one[2]])
        everything, moved = _joined(*whole), _joined(*moving)
        if moved.size <= LEAST * everything.size:
            return Room(everything, is_whole=True)
        is_whole = everything.size <= WIDE * moved.size
        box, size = everything if is_whole else moved, float(np.linalg.norm(moving[1] - moving[0], axis=1).max())
        if middle is None or not moved.size > TRAVELS * size > 0.0:
            return Room(box, is_whole)
        path = np.where(np.ptp(middle, axis=0) > ALONG * size, middle, middle[0])
        about = _joined(moving[0] - path[self.rows], moving[1] - path[self.rows])
        return Room(box, is_whole, path, about)


def _points_of(result: Reader, shape: BodyShape, skins: Mapping[str, Skin]) -> np.ndarray:
    """Return points of a body in its frame that span the room it takes, (p, 3)."""
    points = [np.zeros((1, 3))]
    if shape.is_flexible:
        points.append(skins[shape.name].points)
    if shape.mass > 0.0:
        points.append(shape.com[None])
        own = [surface for surface in result.surfaces if surface.body == shape.name]
        if not shape.is_flexible and (sides := box_of(shape, own)) is not None:
            points.append(sides)
    return np.vstack(points)


def _placed(tracks: Tracks, frame: int, points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the corners (rows, 8, 3) in N of the box around points (p, 3) of a frame, at some of the times shown."""
    corners = Extent(points.min(axis=0), points.max(axis=0)).corners
    if frame == GROUND:
        return np.broadcast_to(corners, (len(rows), *corners.shape))
    place, turn = tracks.poses[frame]
    axes = np.array([rotation_matrix(turn[row]) for row in rows])
    return np.asarray(place[rows, None] + corners @ np.swapaxes(axes, 1, 2))


def _boxes(seen: Sequence[tuple[np.ndarray, np.ndarray, bool]]) -> tuple[np.ndarray, np.ndarray]:
    """Return lowest and highest corner of all points at each instant, (rows, 3) each; zeros if there are none."""
    if not seen:
        return np.zeros((1, 3)), np.zeros((1, 3))
    return np.min([low for low, _, _ in seen], axis=0), np.max([high for _, high, _ in seen], axis=0)


def _joined(low: np.ndarray, high: np.ndarray) -> Extent:
    return Extent(low.min(axis=0), high.max(axis=0))
