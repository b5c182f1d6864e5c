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
from kanefe.kernels.values.filled import allocate, filled_rows
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.load_points import point_numbers

if TYPE_CHECKING:
    from kanefe.loads.reach import Bounds

SWEEP_FROM = 4
"""Number of loads per ball from which a sweep over the balls replaces separate tests of the loads: to sort and compare
a ball takes about as many products as that many tests of its place in the axes of what is touched."""

NO_POINTS = {"body": -1, "point_count": 0, "turns": 0, "is_plain": 0, "mode_count": 0, "column_count": 0}
"""Fields of a team whose loads have no points on a flexible body."""

EVERYWHERE = {"row": -1, "axes": np.eye(3), "rounding": 0.0, "stretch": 0.0, "is_room": 0.0}
EVERYWHERE |= dict.fromkeys(("origin", "lower", "upper"), np.zeros(3))
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


_Known = dict[tuple[object, ...], tuple[int, _Ball]]
"""Balls by their keys, each with its number."""


def _number(known: _Known, ball: _Ball) -> int:
    """Return the number of a ball, the next one if it is new."""
    return known.setdefault(ball.key, (len(known), ball))[0]


def reach_tables(builder: FrameOffsets, teams: Sequence[Sequence[int]], swept: Sequence[int]) -> Reach:
    """Return the tables of the reach of loads: those of all teams one by one, and then those that are swept."""
    known, teamed, pairs = _Known(), [number for team in teams for number in team], list[tuple[int, int, int]]()
    for load, number in enumerate(swept, len(teamed)):
        reach = builder.reaches[number]
        if reach is not None:
            ends = _balls_of(builder, number)[0], _ball_of_bounds(builder, number, reach.bounds)
            a, b = sorted(_number(known, ball) for ball in ends)
            pairs.append((a, b, load))
    swept_balls, bounds, members = len(known), [], list[int]()
    own = [_balls_of(builder, number) for number in teamed] + [[]] * len(swept)
    for number, balls in zip([*teamed, *swept], own, strict=True):
        bounds.append(_bounds(builder, number) | {"first_ball": len(members), "ball_count": len(balls)})
        members += [_number(known, ball) for ball in balls]
    of_teams, points = _teams(builder, teams, own, known)
    all_balls = [ball for _, ball in known.values()]
    bodies, rows, swells, weights = list[int](), [], [], np.zeros(0)
    for body in dict.fromkeys(ball.flexible for ball in all_balls if ball.flexible >= 0):
        largest = np.max([ball.weights for ball in all_balls if ball.flexible == body], axis=0)
        swells.append({"body": body, "mode_count": len(largest), "first": len(weights)})
        bodies.append(body)
        weights = np.concatenate((weights, largest))
    for i, ball in enumerate(all_balls):
        swell, wider = bodies.index(ball.flexible) if ball.flexible >= 0 else -1, SLACK if i < swept_balls else 1.0
        rows.append({"row": ball.row, "swell": swell, "centre": ball.centre, "radius": ball.radius * wider})
    keyed = sorted((a * len(all_balls) + b, load) for a, b, load in pairs)
    by_key = filled_rows(Pair, [{"balls": pair, "load": load} for pair, load in keyed])[0]
    has_states = any(len(builder.model.loads[number].initial_states) > 0 for number in swept)
    own_sizes = allocate(ReachSizes, first_swept=len(teamed), swept_balls=swept_balls, has_swept_states=has_states)[0]
    (loads, limits), (of_balls, centres) = filled_rows(Bound, bounds), filled_rows(RowBall, rows)
    grow, touching = filled_rows(Swell, swells)[0], np.array(members, np.int64)
    return Reach(of_teams, loads, limits, of_balls, centres, grow, weights, touching, by_key, points, own_sizes)


def _teams(
    builder: FrameOffsets, teams: Sequence[Sequence[int]], own: Sequence[Sequence[_Ball]], known: _Known
) -> tuple[np.ndarray, np.ndarray]:
    """Return the integers of teams, with the balls about all that their loads have, and the numbers of their points."""
    found, first, pool, size = [], 0, [np.zeros(0)], 0
    for team in teams:
        loads, states = [builder.model.loads[n] for n in team], [builder.model.load_states[n] for n in team]
        balls = [ball for of_load in own[first : first + len(team)] for ball in of_load]
        beside = all(one.stop == other.start for one, other in pairwise(states))
        ball = _number(known, _about(balls)) if len(team) > 1 and len(balls) == len(team) else -1
        count, begin = (states[-1].stop - states[0].start, states[0].start) if beside else (0, -1)
        of_team = {"first_load": first, "load_count": len(team), "ball": ball, "constants": size}
        of_team |= {"first_state": begin, "state_count": count}
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


def far_values(builder: FrameOffsets, number: int) -> np.ndarray:
    """Return what the events of a load see where it cannot act, (events, 2): see `kanefe.kernels.loads.watching`."""
    reach = builder.reaches[number]
    if reach is None:
        return np.zeros((len(builder.model.loads[number].events), 2))
    size = reach.bounds.size + max(radius for _, _, radius in reach.probes)
    return np.array([(factor, factor * size) for factor in reach.watched]).reshape(-1, 2)
