"""Tables that determine which loads can act at a state: balls about their ends, and bounds of their opposite sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.contact.broad_phase import BALL
from kanefe.kernels.loads.reach import BALL_INTEGERS, BOUNDS_NUMBERS, TEAM_INTEGERS
from kanefe.kernels.tables import Reach
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.load_points import point_numbers

if TYPE_CHECKING:
    from kanefe.loads.reach import Bounds

SWEEP_FROM = 4
"""Number of loads per ball from which a sweep over the balls replaces separate tests of the loads: to sort and compare
a ball takes about as many products as that many tests of its place in the axes of what is touched."""

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
            row, numbers_of = _bounds(builder, number, reach.bounds)
            carriers = tuple((ball.row, ball.flexible) for ball in _balls_of(builder, number))
            key = row, carriers, builder.point_bodies[number], numbers_of.tobytes()
        teams.setdefault(key, []).append(number)
    return list(teams.values())


def reach_tables(builder: FrameOffsets, teams: Sequence[Sequence[int]], swept: Sequence[int]) -> Reach:
    """Return the tables of the reach of loads: those of all teams one by one, and then those that are swept."""
    numbers: dict[tuple[object, ...], int] = {}
    balls: list[_Ball] = []

    def number_of(ball: _Ball) -> int:
        if ball.key not in numbers:
            numbers[ball.key] = len(balls)
            balls.append(ball)
        return numbers[ball.key]

    order = [*(number for team in teams for number in team), *swept]
    first_swept = len(order) - len(swept)
    pairs = []
    for place, number in enumerate(swept):
        reach = builder.reaches[number]
        if reach is not None:
            ends = _balls_of(builder, number)[0], _ball_of_bounds(builder, number, reach.bounds)
            pairs.append((*sorted(map(number_of, ends)), first_swept + place))
    swept_balls = len(balls)
    members: list[int] = []
    of_loads, bounds = [], []
    for place, number in enumerate(order):
        reach, first = builder.reaches[number], len(members)
        if place < first_swept:
            members += [number_of(ball) for ball in _balls_of(builder, number)]
        row, of_load = (-1, np.zeros(BOUNDS_NUMBERS)) if reach is None else _bounds(builder, number, reach.bounds)
        of_loads.append((row, first, len(members) - first))
        bounds.append(of_load)
    of_teams, points = _teams(
        builder, teams, [[balls[m] for m in members[f : f + n]] for _, f, n in of_loads], number_of
    )
    keyed = sorted((a * len(balls) + b, load) for a, b, load in pairs)
    swells, weights, of_balls = _swells(balls)
    centres = [(*ball.centre, ball.radius * (SLACK if i < swept_balls else 1.0)) for i, ball in enumerate(balls)]
    has_states = any(len(builder.model.loads[number].initial_states) > 0 for number in swept)
    return Reach(
        np.array(of_teams, dtype=np.int64).reshape(-1, TEAM_INTEGERS),
        np.array(of_loads, dtype=np.int64).reshape(-1, 3),
        np.array(of_balls, dtype=np.int64).reshape(-1, BALL_INTEGERS),
        np.array(centres).reshape(-1, BALL),
        np.array(swells, dtype=np.int64).reshape(-1, 2),
        np.concatenate((*weights, np.zeros(0))),
        np.array(members, dtype=np.int64),
        np.array(bounds).reshape(-1, BOUNDS_NUMBERS),
        np.array(keyed, dtype=np.int64).reshape(-1, 2),
        points,
        np.array((first_swept, swept_balls, int(has_states))),
    )


def _teams(
    builder: FrameOffsets,
    teams: Sequence[Sequence[int]],
    balls_of: Sequence[Sequence[_Ball]],
    number_of: Callable[[_Ball], int],
) -> tuple[list[tuple[int, ...]], np.ndarray]:
    """Return the integers of teams, and the numbers of their points."""
    model, found, first, pool, size = builder.model, [], 0, [np.zeros(0)], 0
    for team in teams:
        loads, states = [model.loads[number] for number in team], [model.load_states[number] for number in team]
        balls = [ball for of_load in balls_of[first : first + len(team)] for ball in of_load]
        ball = number_of(_about(balls)) if len(team) > 1 and len(balls) == len(team) else -1
        beside = all(one.stop == other.start for one, other in pairwise(states))
        of_states = (states[0].start, states[-1].stop - states[0].start) if beside else (-1, 0)
        body, of_points = builder.point_bodies[team[0]], (-1, 0, 0, 0, 0)
        if body >= 0:
            numbers, turns, is_plain = point_numbers(loads, builder.modes[body])
            count = sum(len(load.ends) - 1 for load in loads)
            of_points = builder.flexible_numbers[body], count, size, int(turns), int(is_plain)
            pool.append(numbers)
            size += len(numbers)
        found.append((first, len(team), ball, *of_states, *of_points))
        first += len(team)
    return found, np.concatenate(pool)


def _about(balls: Sequence[_Ball]) -> _Ball:
    """Return the ball about balls in one frame."""
    centre = np.mean([ball.centre for ball in balls], axis=0)
    radius = max(float(np.linalg.norm(ball.centre - centre)) + ball.radius for ball in balls)
    return _Ball(balls[0].row, centre, radius, balls[0].flexible, np.max([ball.weights for ball in balls], axis=0))


def _bounds(builder: FrameOffsets, number: int, bounds: Bounds) -> tuple[int, np.ndarray]:
    """Return the row of the first end of a load, and its bounds there, as the kernels have them."""
    marker = builder.model.loads[number].ends[0]
    frame_offset = builder.frame_offset(marker.body, marker.interface)
    axes = frame_offset.axes @ marker.axes
    origin = frame_offset.place + frame_offset.axes @ marker.point
    numbers = bounds.rounding, bounds.stretch, float(bounds.is_room)
    return frame_offset.row, np.concatenate((origin, (axes @ bounds.axes).ravel(), bounds.lower, bounds.upper, numbers))


def _swells(balls: Sequence[_Ball]) -> tuple[list[tuple[int, int]], list[Vector], list[tuple[int, int]]]:
    """Return what balls grow by: of a body the largest weights of all its balls, and each ball's row and swell."""
    largest: dict[int, Vector] = {}
    for ball in balls:
        if ball.flexible >= 0:
            known = largest.get(ball.flexible, np.zeros_like(ball.weights))
            largest[ball.flexible] = np.maximum(known, ball.weights)
    swells, place = [], 0
    for flexible, weights in largest.items():
        swells.append((flexible, place))
        place += len(weights)
    order = list(largest)
    of_balls = [(ball.row, order.index(ball.flexible) if ball.flexible >= 0 else -1) for ball in balls]
    return swells, list(largest.values()), of_balls


def far_values(builder: FrameOffsets, number: int) -> np.ndarray:
    """Return what the events of a load see where it cannot act, (events, 2): see `kanefe.kernels.loads.watching`."""
    reach = builder.reaches[number]
    if reach is None:
        return np.zeros((len(builder.model.loads[number].events), 2))
    size = reach.bounds.size + max(radius for _, _, radius in reach.probes)
    return np.array([(factor, factor * size) for factor in reach.watched]).reshape(-1, 2)
