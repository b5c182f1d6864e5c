"""Event values of loads in states of a run: values of functions of loads between frames."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.arrays import Integers, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.contact.broad_phase import BALL
from kanefe.kernels.force_elements.places import END_NUMBERS
from kanefe.kernels.loads.loads_between import evaluate_load
from kanefe.kernels.loads.loads_layout import (
    CHANGES,
    COORDINATE,
    END_COUNT,
    FIRST_NUMBER,
    TEAM,
    place_of_load,
    span_of_load,
)
from kanefe.kernels.loads.points import gather_points
from kanefe.kernels.loads.reach import FIRST_SWEPT, SWEPT_BALLS, find_near, find_swept, nearness_at
from kanefe.kernels.scene import Scene, state_in, work_in
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tables import LoadsBetween

NEAR, ALL = -1, -2
"""Values for the loads that are looked at: those that come near, and all."""

PATH = 2.0
"""Distance, in multiples of the longest distance between two positions in a step, within which a contact may be missed.
"""

PATH_NUMBERS = 10
"""Number of values of a ball swept in a step: a box about its centres, the last centre, and the longest displacement
along an axis."""


@entry()
def watch_states(
    scene: Scene,
    counts: Integers,
    far: RealRows,
    times: Reals,
    drives: RealBlocks,
    inputs: RealRows,
    states: RealRows,
    found: RealRows,
    memory: Reals,
    changing: Integers,
    only: Integers,
    near: Reals,
) -> None:
    """Write the event values of loads in some states, or change a state by an event.

    Of several states, those of a step, it is told of loads that come nowhere near how far away they are, at least. Of
    one state all are looked at.

    Parameters
    ----------
    scene : Scene
        With these loads alone between frames, and the addresses of what they are watched by.
    counts : ndarray of int, shape (loads,)
        How many values each has.
    far : ndarray, shape (values, 2)
        What is written of a load that cannot act: so much of how far it is from acting, and so much where that is not
        known.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, values)
    memory : ndarray
        For `Work`, and `path_size` numbers behind it.
    changing : ndarray of int, shape (4,)
        Number of a load whose states an event changes (below zero: none does), number of the event, first and number of
        the states: these are written to the first state, and to `found` by how much the potential energy grows, J.
    only : ndarray of int, shape (1,)
        Number of the load that alone is looked at; the number of loads: none; NEAR: those that come near in a step,
        and all of one state; ALL: all.
    near : ndarray, shape (loads,)
        Written: above zero for loads that were looked at, whose values are no estimates.
    """
    between, work = scene.between, work_in(scene, memory)
    loads, acting, paths = len(between.loads), work.acting, memory[work.size :]
    least, last, change = paths[:loads], paths[loads : 2 * loads], paths[2 * loads :]
    near[:] = 1.0
    has_frames = False  # along joint coordinates alone nothing else has to be known of the scene
    for end in range(len(between.rows)):
        has_frames = has_frames or between.rows[end] != COORDINATE
    if changing[0] >= 0:
        of, y, first, count = changing[0], states[0], changing[2], changing[3]
        state = state_in(scene.tables, times[0], y, drives[0], inputs[0])
        if has_frames:
            sweep_outward(scene, state, work, False)
        gather_points(scene, work, between.loads[of, TEAM], of, of + 1)
        evaluate_load(scene, state, work, of, of)
        out, z = acting[span_of_load(between, of)], y[first : first + count]
        out[0], least[0] = 0.0, float(changing[1])
        for i in range(count):
            out[1 + i] = z[i]
        own, ends = between.numbers[between.loads[of, FIRST_NUMBER] :], acting[place_of_load(between) :]
        call_address(between.addresses[of, CHANGES], (times[0], own, least, ends, z, out))
        for i in range(count):
            z[i] = out[1 + i]
        found[0, 0] = out[0]
        return
    if only[0] >= 0:
        near[:] = 0.0
        if only[0] < loads:
            near[only[0]] = 1.0
    elif only[0] == NEAR and len(states) > 1 and len(between.reach.balls) > 0:
        near[:] = change[:loads] = 0.0
        for row in range(len(states)):
            sweep_outward(scene, state_in(scene.tables, times[row], states[row], drives[row], inputs[row]), work, False)
            find_near(scene, work)
            enclose_balls(between, acting, row == 0, change[loads:])
            nearness, at = acting[nearness_at(between.reach) :], 0
            for load in range(loads):
                gap = -min(nearness[load], 0.0)
                least[load] = gap if row == 0 else min(least[load], gap)
                if row > 0:
                    change[load] = max(change[load], abs(gap - last[load]))
                last[load] = gap
                for i in range(counts[load]):
                    found[row, at + i] = far[at + i, 0] * gap + (far[at + i, 1] if gap == 0.0 else 0.0)
                at += counts[load]
        put_enclosing(between, change[loads:], acting)
        find_swept(between.reach, acting)
        nearness = acting[nearness_at(between.reach) :]
        for load in range(loads):
            is_swept = load >= between.reach.sizes[FIRST_SWEPT]
            if (is_swept and nearness[load] > 0.0) or (not is_swept and least[load] <= PATH * change[load]):
                near[load] = 1.0
    if not is_any(near):
        return
    for row in range(len(states)):
        here, at = state_in(scene.tables, times[row], states[row], drives[row], inputs[row]), 0
        if has_frames:
            sweep_outward(scene, here, work, False)
        for load in range(loads):
            if near[load] > 0.0:
                gather_points(scene, work, between.loads[load, TEAM], load, load + 1)
                evaluate_load(scene, here, work, load, load)
                written = place_of_load(between) + END_NUMBERS * between.loads[load, END_COUNT]
                for i in range(counts[load]):
                    found[row, at + i] = acting[written + i]
            at += counts[load]


@inlined
def is_any(near: np.ndarray) -> bool:
    """Return whether any load is looked at."""
    total = 0.0
    for load in range(len(near)):
        total += near[load]
    return total > 0.0


@inlined
def enclose_balls(between: LoadsBetween, acting: np.ndarray, is_first: bool, boxes: np.ndarray) -> None:
    """Take in where the centres of swept balls are: a box about all places of each, and its longest way."""
    for b in range(between.reach.sizes[SWEPT_BALLS]):
        box, way = boxes[PATH_NUMBERS * b :], 0.0
        for c in range(3):
            x = acting[BALL * b + c]
            if not is_first:
                way = max(way, abs(x - box[6 + c]))
            box[c], box[3 + c] = (x, x) if is_first else (min(box[c], x), max(box[3 + c], x))
            box[6 + c] = x
        box[9] = way if is_first else max(box[9], way)


@inlined
def put_enclosing(between: LoadsBetween, boxes: np.ndarray, acting: np.ndarray) -> None:
    """Write balls about all that swept balls were in, and may have been between, in their place."""
    for b in range(between.reach.sizes[SWEPT_BALLS]):
        box, square = boxes[PATH_NUMBERS * b :], 0.0
        for c in range(3):
            acting[BALL * b + c] = 0.5 * (box[c] + box[3 + c])
            square += (box[3 + c] - box[c]) ** 2
        acting[BALL * b + 3] += 0.5 * np.sqrt(square) + PATH * box[9]


@inlined
def path_size(between: LoadsBetween) -> int:
    """Return how many numbers are kept of a step: of each load and of each swept ball."""
    return 3 * len(between.loads) + PATH_NUMBERS * between.reach.sizes[SWEPT_BALLS]
