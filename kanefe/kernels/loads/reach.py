"""Which loads can act at a state: balls about what touches, against boxes and balls about what is touched.

A load whose balls are all out of the bounds of its first end does nothing, and its ends are not looked at. What is
found is exact: it depends on the state alone, whatever the speeds are. What touches but for round-off is in reach. A
ball on a flexible body grows by a bound on how far its points are displaced, ``sum_j w_j |eta_j|``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, rotated, rotated_back, vector
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.contact.broad_phase import BALL, overlap, sort_along_widest
from kanefe.kernels.layout import COUNT, POSITION, WORK_ETA, R
from kanefe.kernels.scene import Scene, Work
from kanefe.kernels.sweeps.elastic import span
from kanefe.kernels.tables import Reach

# Columns of the integers of a ball
BALL_ROW, SWELL = range(2)
BALL_INTEGERS = 2
# Columns of bounds, in the row of the first end of a load
ORIGIN, AXES, LOWER, UPPER, ROUNDING, STRETCH, IS_ROOM = 0, 3, 12, 15, 18, 19, 20
BOUNDS_NUMBERS = 21
# Columns of the integers of a team
(
    FIRST_LOAD,
    LOADS,
    BALL_OF_TEAM,
    FIRST_STATE_OF_TEAM,
    STATES_OF_TEAM,
    BODY,
    POINTS,
    POOL,
    TURNS,
    IS_PLAIN,
) = range(10)
TEAM_INTEGERS = 10
# Of a load in `Reach.loads`
BOUNDS_ROW, FIRST_BALL, BALL_COUNT = range(3)
# Sizes
FIRST_SWEPT, SWEPT_BALLS, HAS_SWEPT_STATES = range(3)

WIDER = 1e-12
"""Size that balls have more, relative to the coordinates of their places: far more than round-off of a touch."""


def no_reach() -> Reach:
    """Return the tables of a scene without loads."""
    none, two = np.zeros(0), np.zeros((0, 2), dtype=np.int64)
    return Reach(
        np.zeros((0, TEAM_INTEGERS), dtype=np.int64),
        np.zeros((0, 3), dtype=np.int64),
        two,
        np.zeros((0, BALL)),
        two,
        none,
        np.zeros(0, dtype=np.int64),
        np.zeros((0, BOUNDS_NUMBERS)),
        two,
        none,
        np.zeros(3, dtype=np.int64),
    )


def reach_size(reach: Reach) -> int:
    """Return how many numbers `find_near` writes."""
    return int(_near_at(reach)) + 2 * len(reach.loads) - int(reach.sizes[FIRST_SWEPT])


@inlined
def nearness_at(reach: Reach) -> int:
    """Return where it is written of each load whether it is near: above zero; else minus the gap, as far as known."""
    return BALL * len(reach.balls) + len(reach.swells) + 2 * reach.sizes[SWEPT_BALLS]


@inlined
def _near_at(reach: Reach) -> int:
    """Return where the numbers of the swept loads that are near begin."""
    return nearness_at(reach) + len(reach.loads)


@inlined
def near_load(reach: Reach, i: int, out: np.ndarray) -> int:
    """Return the number of one of the swept loads that are near."""
    return int(out[_near_at(reach) + i].real)


@inlined
def find_near(scene: Scene, work: Work) -> int:
    """Write how near all loads are, and in rising order the swept ones that are; return how many these are."""
    reach, rows, out = scene.between.reach, work.frames.numbers, work.acting
    place_balls(scene, work)
    nearness = out[nearness_at(reach) : _near_at(reach)]
    for n in range(len(reach.teams)):
        first, ball = reach.teams[n, FIRST_LOAD], reach.teams[n, BALL_OF_TEAM]
        last = first + reach.teams[n, LOADS]
        if ball >= 0:
            gap = gap_of(reach, first, ball, rows, out)
            if gap > 0.0:
                for load in range(first, last):
                    nearness[load] = -gap
                continue
        for load in range(first, last):
            gap, at = 0.0, reach.loads[load, FIRST_BALL]
            for m in range(reach.loads[load, BALL_COUNT]):
                to_ball = gap_of(reach, load, reach.members[at + m], rows, out)
                gap = to_ball if m == 0 else min(gap, to_ball)
            nearness[load] = -gap if gap > 0.0 else 1.0
    return find_swept(reach, out)


@inlined
def find_swept(reach: Reach, out: np.ndarray) -> int:
    """Write which swept loads are near, of balls that are placed; return how many."""
    if reach.sizes[SWEPT_BALLS] == 0:
        return 0
    return sweep_over_balls(reach.pairs, len(reach.balls), reach.sizes, nearness_at(reach), len(reach.loads), out)


@kernel
def sweep_over_balls(
    pairs: np.ndarray, balls: int, sizes: np.ndarray, nearness_begins: int, loads: int, out: np.ndarray
) -> int:
    """Write which swept loads are near, and their numbers in rising order; return how many these are."""
    count, first = sizes[SWEPT_BALLS], sizes[FIRST_SWEPT]
    begin = nearness_begins - 2 * count
    keys, order = out[begin : begin + count], out[begin + count : nearness_begins]
    nearness, near = out[nearness_begins : nearness_begins + loads], out[nearness_begins + loads :]
    nearness[first:] = 0.0
    axis, found = sort_along_widest(out, count, keys, order), 0
    for i in range(count):
        a = int(order[i].real)
        end = out[BALL * a + axis].real + out[BALL * a + 3].real
        for j in range(i + 1, count):
            b = int(order[j].real)
            if keys[b].real > end:
                break
            if not overlap(out, a, b):
                continue
            pair = min(a, b) * balls + max(a, b)
            for place in range(place_of_pair(pairs, pair), len(pairs)):
                if pairs[place, 0] != pair:
                    break
                near[found] = pairs[place, 1]
                nearness[pairs[place, 1]] = 1.0
                found += 1
    for i in range(1, found):  # in rising order: sums do not depend on where the balls are
        moved, j = near[i], i
        while j > 0 and near[j - 1].real > moved.real:
            near[j] = near[j - 1]
            j -= 1
        near[j] = moved
    return found


@inlined
def place_of_pair(pairs: np.ndarray, pair: int) -> int:
    """Return the first place of a pair in a list in rising order, or that of the next."""
    low, high = 0, len(pairs)
    while low < high:
        middle = (low + high) // 2
        if pairs[middle, 0] < pair:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def place_balls(scene: Scene, work: Work) -> None:
    """Write centres in N and radii of all balls, grown by what their bodies are displaced."""
    reach, flexible, modal, rows, out = (
        scene.between.reach,
        scene.flexible,
        work.modal,
        work.frames.numbers,
        work.acting,
    )
    grown = BALL * len(reach.balls)
    for s in range(len(reach.swells)):
        body, at = flexible.bodies[reach.swells[s, 0]], reach.swells[s, 1]
        eta = modal[span(body, WORK_ETA)]
        out[grown + s] = weighed_sizes(reach.weights[at : at + body[COUNT]], eta)
    for b in range(len(reach.balls)):
        row, swell = reach.balls[b, BALL_ROW], reach.balls[b, SWELL]
        centre, radius = vector(reach.centres, b, 0), reach.centres[b, 3]
        if row >= 0:
            turned = rotated(real_matrix(rows, row, R), centre)
            centre = (
                rows[row, POSITION].real + turned[0],
                rows[row, POSITION + 1].real + turned[1],
                rows[row, POSITION + 2].real + turned[2],
            )
        if swell >= 0:
            radius += out[grown + swell].real
        radius += WIDER * (radius + size_of(centre))
        out[BALL * b], out[BALL * b + 1], out[BALL * b + 2], out[BALL * b + 3] = centre[0], centre[1], centre[2], radius


@vector_kernel
def weighed_sizes(weights: np.ndarray, x: np.ndarray) -> float:
    """Return the sum of the sizes of numbers times their weights."""
    s = 0.0
    for i in range(len(x)):
        s += weights[i] * abs(x[i].real)
    return s


@inlined
def gap_of(reach: Reach, n: int, ball: int, work: np.ndarray, out: np.ndarray) -> Any:
    """Return how far a ball is from the bounds of a load, m, at least; up to zero: the load may act."""
    row, b = reach.loads[n, BOUNDS_ROW], BALL * ball
    x, radius = (out[b].real, out[b + 1].real, out[b + 2].real), out[b + 3].real
    if row >= 0:
        place = (work[row, POSITION].real, work[row, POSITION + 1].real, work[row, POSITION + 2].real)
        x, radius = rotated_back(real_matrix(work, row, R), minus(x, place)), radius + WIDER * size_of(place)
    x = rotated_back(real_matrix(reach.bounds, n, AXES), minus(x, vector(reach.bounds, n, ORIGIN)))
    return gap_to(reach.bounds, n, x, radius)


@inlined
def size_of(place: Numbers) -> Any:
    """Return the largest of the coordinates of a place."""
    return max(abs(place[0]), abs(place[1]), abs(place[2]))


@inlined
def gap_to(bounds: np.ndarray, n: int, x: Numbers, radius: float) -> Any:
    """Return how far a ball is from bounds, seen in their axes."""
    lower, upper = vector(bounds, n, LOWER), vector(bounds, n, UPPER)
    below, above = minus(lower, x), minus(x, upper)
    if bounds[n, IS_ROOM] > 0.0:
        return -max(below[0], above[0], below[1], above[1], below[2], above[2]) - radius
    out = (max(below[0], above[0], 0.0), max(below[1], above[1], 0.0), max(below[2], above[2], 0.0))
    return np.sqrt(dot(out, out)) - bounds[n, ROUNDING] - bounds[n, STRETCH] * radius


@inlined
def real_matrix(array: np.ndarray, i: int, at: int) -> Numbers:
    """Read the real part of a matrix in row i of an array."""
    return (
        array[i, at].real,
        array[i, at + 1].real,
        array[i, at + 2].real,
        array[i, at + 3].real,
        array[i, at + 4].real,
        array[i, at + 5].real,
        array[i, at + 6].real,
        array[i, at + 7].real,
        array[i, at + 8].real,
    )
