"""Tables that determine which loads can act at a state: balls about their ends, and bounds of their opposite sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.loads.reach import Bound, Pair, ReachSizes, RowBall, Swell, Team
from kanefe.kernels.tables import Reach
from kanefe.kernels.values.records import allocate, filled_rows
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.load_points import point_numbers

if TYPE_CHECKING:
    from kanefe.loads.reach import Bounds

SWEEP_FROM = 4
"""Number of loads per ball from which a sweep over the balls replaces separate tests of the loads: to sort and compare
a ball takes about as many products as that many tests of its place in the axes of what is touched."""

NO_POINTS = {"body": -1, "point_count": 0, "turns": 0, "is_plain": 0, "mode_count": 0, "column_count": 0}
"""What a team has of points whose loads have none on a flexible body."""

EVERYWHERE = {"row": -1, "origin": np.zeros(3), "axes": np.eye(3), "lower": np.zeros(3), "upper": np.zeros(3)} | {
    "rounding": 0.0,
    "stretch": 0.0,
    "is_room": 0.0,
}
"""Bounds of a load that acts everywhere: without balls nobody looks at them."""

SLACK = 1.01
"""Factor on the radii of balls in a sweep: events see contacts approach before they touch."""


def sweeps(builder: FrameOffsets, chosen: Sequence[int]) -> list[int]:
    """Return those of some loads that are found by a sweep over balls."""
    found, balls = [], set[tuple[object, ...]]()
    for number in chosen:
        reach = builder.reaches[number]
        if reach is None or not reach.bounds.is_bounded or builder.point_bodies[number] >= 0:
            continue
        of_load = _balls_of(builder, number)
        if len(of_load) == 1:
            found.append(number)
            balls |= {of_load[0].key, _ball_of_bounds(builder, number, reach.bounds).key}
    return found if len(found) > SWEEP_FROM * len(balls) else []


@dataclass
class _Ball:
    """A ball in a row, or in the frame of a flexible body (kernel's number) with the weights of its modes."""

    row: int
    centre: Vector
    radius: float
    flexible: int = -1
    weights: Vector = field(default_factory=lambda: np.zeros(0))

    @property
    def key(self) -> tuple[object, ...]:
        return self.row, *self.centre.tolist(), self.radius, self.flexible


def _balls_of(builder: FrameOffsets, number: int) -> list[_Ball]:
    """Return balls about all points of a load, one for each link or flexible body; none if it always acts."""
    load, reach, body = builder.model.loads[number], builder.reaches[number], builder.point_bodies[number]
    if reach is None:
        return []
    places: dict[tuple[int, int], list[tuple[Vector, float, Vector]]] = {}
    for end, point, radius in reach.probes:
        marker = load.ends[end]
        if body >= 0:
            motion = builder.modes[body].of_interface(marker.interface.motion[:3, : builder.modes[body].count])
            key = builder.frame_offsets[body].row, builder.flexible_numbers[body]
            place = marker.interface.position
            arm = float(np.linalg.norm(marker.point + marker.axes @ point))
            of_ball = place, radius + arm, np.linalg.norm(motion, axis=0)
        else:
            frame_offset = builder.frame_offset(marker.body, marker.interface)
            place = frame_offset.place + frame_offset.axes @ (marker.point + marker.axes @ point)
            key, of_ball = (frame_offset.row, -1), (place, radius, np.zeros(0))
        places.setdefault(key, []).append(of_ball)
    found = []
    for (row, flexible), of_row in places.items():
        centres = np.array([place for place, _, _ in of_row])
        centre = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
        radius = max(float(np.linalg.norm(place - centre)) + radius for place, radius, _ in of_row)
        weights = np.max([weights for _, _, weights in of_row], axis=0) if flexible >= 0 else np.zeros(0)
        found.append(_Ball(row, centre, radius, flexible, weights))
    return found


def _ball_of_bounds(builder: FrameOffsets, number: int, bounds: Bounds) -> _Ball:
    """Return the ball about bounds that end somewhere."""
    marker = builder.model.loads[number].ends[0]
    frame_offset = builder.frame_offset(marker.body, marker.interface)
    middle = marker.axes @ bounds.axes @ (0.5 * (bounds.lower + bounds.upper))
    centre = frame_offset.place + frame_offset.axes @ (marker.point + middle)
    return _Ball(frame_offset.row, centre, bounds.size)


def in_teams(builder: FrameOffsets, numbers: Sequence[int]) -> list[list[int]]:
    """Return loads that are not swept in teams: those of the points of one body, or of one row, on one surface."""
    teams: dict[object, list[int]] = {}
    for number in numbers:
        key: object = None
        reach = builder.reaches[number]
        if reach is not None:
            bounds = (np.asarray(value, dtype=float).tobytes() for value in _bounds(builder, number).values())
            carriers = tuple((ball.row, ball.flexible) for ball in _balls_of(builder, number))
            key = carriers, builder.point_bodies[number], *bounds
        teams.setdefault(key, []).append(number)
    return list(teams.values())


class _Numbered:
    """Balls, each once, in the order in which they are asked for."""

    def __init__(self) -> None:
        self.balls: list[_Ball] = []
        self._numbers: dict[tuple[object, ...], int] = {}

    def number(self, ball: _Ball) -> int:
        """Return the number of a ball."""
        if ball.key not in self._numbers:
            self._numbers[ball.key] = len(self.balls)
            self.balls.append(ball)
        return self._numbers[ball.key]


def reach_tables(builder: FrameOffsets, teams: Sequence[Sequence[int]], swept: Sequence[int]) -> Reach:
    """Return the tables of the reach of loads: those of all teams one by one, and then those that are swept."""
    numbered, in_teams = _Numbered(), [number for team in teams for number in team]
    pairs = _pairs(builder, swept, len(in_teams), numbered)
    swept_balls = len(numbered.balls)
    own = [_balls_of(builder, number) for number in in_teams] + [[]] * len(swept)
    members = [numbered.number(ball) for of_load in own for ball in of_load]
    of_teams, points = _teams(builder, teams, own, numbered)
    (of_loads, bounds), (rows, centres) = (
        _all_bounds(builder, [*in_teams, *swept], own),
        _rows_of(numbered, swept_balls),
    )
    keyed = sorted((a * len(numbered.balls) + b, load) for a, b, load in pairs)
    swells, weights = _swells(numbered.balls)
    has_states = any(len(builder.model.loads[number].initial_states) > 0 for number in swept)
    return Reach(
        teams=of_teams,
        loads=of_loads,
        bounds=bounds,
        balls=rows,
        centres=centres,
        swells=filled_rows(Swell, swells)[0],
        weights=np.concatenate((*weights, np.zeros(0))),
        members=np.array(members, dtype=np.int64),
        pairs=filled_rows(Pair, [{"balls": pair, "load": load} for pair, load in keyed])[0],
        points=points,
        sizes=allocate(ReachSizes, first_swept=len(in_teams), swept_balls=swept_balls, has_swept_states=has_states)[0],
    )


def _pairs(builder: FrameOffsets, swept: Sequence[int], first: int, numbered: _Numbered) -> list[tuple[int, int, int]]:
    """Return the two balls of each swept load, the lower number first, and the load; the first load has a number."""
    found = []
    for load, number in enumerate(swept, first):
        reach = builder.reaches[number]
        if reach is not None:
            ends = _balls_of(builder, number)[0], _ball_of_bounds(builder, number, reach.bounds)
            a, b = sorted(map(numbered.number, ends))
            found.append((a, b, load))
    return found


def _all_bounds(builder: FrameOffsets, order: Sequence[int], own: Sequence[Sequence[_Ball]]) -> tuple[np.ndarray, ...]:
    """Return integers and numbers of the bounds of all loads, which have these balls."""
    found, first = [], 0
    for number, balls in zip(order, own, strict=True):
        found.append(_bounds(builder, number) | {"first_ball": first, "ball_count": len(balls)})
        first += len(balls)
    return filled_rows(Bound, found)


def _rows_of(numbered: _Numbered, swept_balls: int) -> tuple[np.ndarray, ...]:
    """Return integers and numbers of all balls, of which the first ones are swept."""
    bodies, found = _swelling(numbered.balls), []
    for i, ball in enumerate(numbered.balls):
        swell = bodies.index(ball.flexible) if ball.flexible >= 0 else -1
        radius = ball.radius * (SLACK if i < swept_balls else 1.0)
        found.append({"row": ball.row, "swell": swell, "centre": ball.centre, "radius": radius})
    return filled_rows(RowBall, found)


def _teams(
    builder: FrameOffsets, teams: Sequence[Sequence[int]], own: Sequence[Sequence[_Ball]], numbered: _Numbered
) -> tuple[np.ndarray, np.ndarray]:
    """Return the integers of teams, with the balls about all that their loads have, and the numbers of their points."""
    found, first, pool, size = [], 0, [np.zeros(0)], 0
    for team in teams:
        loads, states = [builder.model.loads[n] for n in team], [builder.model.load_states[n] for n in team]
        balls = [ball for of_load in own[first : first + len(team)] for ball in of_load]
        beside = all(one.stop == other.start for one, other in pairwise(states))
        of_team = {
            "first_load": first,
            "load_count": len(team),
            "ball": numbered.number(_about(balls)) if len(team) > 1 and len(balls) == len(team) else -1,
            "first_state": states[0].start if beside else -1,
            "state_count": states[-1].stop - states[0].start if beside else 0,
            "constants": size,
        }
        body = builder.point_bodies[team[0]]
        if body >= 0:
            points, numbers = point_numbers(loads, builder.modes[body])
            pool.append(numbers)
            size += len(numbers)
            found.append(of_team | points | {"body": builder.flexible_numbers[body]})
        else:
            found.append(of_team | NO_POINTS)
        first += len(team)
    return filled_rows(Team, found)[0], np.concatenate(pool)


def _about(balls: Sequence[_Ball]) -> _Ball:
    """Return the ball about balls in one frame."""
    centre = np.mean([ball.centre for ball in balls], axis=0)
    radius = max(float(np.linalg.norm(ball.centre - centre)) + ball.radius for ball in balls)
    return _Ball(balls[0].row, centre, radius, balls[0].flexible, np.max([ball.weights for ball in balls], axis=0))


def _bounds(builder: FrameOffsets, number: int) -> dict[str, Any]:
    """Return the bounds of a load in the row of its first end; of one that acts everywhere none."""
    reach, marker = builder.reaches[number], builder.model.loads[number].ends[0]
    if reach is None:
        return EVERYWHERE
    frame_offset, bounds = builder.frame_offset(marker.body, marker.interface), reach.bounds
    return {
        "row": frame_offset.row,
        "origin": frame_offset.place + frame_offset.axes @ marker.point,
        "axes": frame_offset.axes @ marker.axes @ bounds.axes,
        **{name: getattr(bounds, name) for name in ("lower", "upper", "rounding", "stretch", "is_room")},
    }


def _swelling(balls: Sequence[_Ball]) -> list[int]:
    """Return the flexible bodies that balls are on, in the order of these."""
    return list(dict.fromkeys(ball.flexible for ball in balls if ball.flexible >= 0))


def _swells(balls: Sequence[_Ball]) -> tuple[list[dict[str, int]], list[Vector]]:
    """Return what balls grow by, and the weights: of a body the largest of all its balls."""
    swells, all_weights, first = [], list[Vector](), 0
    for body in _swelling(balls):
        weights = np.max([ball.weights for ball in balls if ball.flexible == body], axis=0)
        swells.append({"body": body, "mode_count": len(weights), "first": first})
        all_weights.append(weights)
        first += len(weights)
    return swells, all_weights


def far_values(builder: FrameOffsets, number: int) -> np.ndarray:
    """Return what the events of a load see where it cannot act, (events, 2): see `kanefe.kernels.loads.watching`."""
    reach = builder.reaches[number]
    if reach is None:
        return np.zeros((len(builder.model.loads[number].events), 2))
    size = reach.bounds.size + max(radius for _, _, radius in reach.probes)
    return np.array([(factor, factor * size) for factor in reach.watched]).reshape(-1, 2)
