"""From step to step, with the outputs passed: states within a step, in which stiff modes are settled.

Within the tolerance of a state a stiff mode has any force: ``K e`` is large however small its error e. What the mode
does is known all the same: over a step it follows the rest, with the accelerations a of the polynomial of the step. A
step of Euler's implicit method for the difference to these, with an h of some steps of the run, leaves slow motions as
they are and divides the errors of stiff modes by ``1 + (omega h)^2``:

    (M + h^2 K) x = F + h^2 K a,    elastic coordinates moved by h^2 (x - a).

Then the accelerations of the state are x, and all that is computed from it has the forces that belong to them. This is
one linearly implicit evaluation. Only elastic coordinates move; joints close the loops behind them.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import RealRows
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.steppers.force_scales import put_force_scales
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    BENDS,
    BREAKPOINTS,
    COORDINATES,
    DAMPING_DIRECTION,
    ELASTIC,
    EVALUATIONS,
    HAS_LOOPS,
    IMPLICIT,
    IS_FIXED,
    LARGE,
    LOOKS_FOR_JUMPS,
    MAP,
    MAP_SIZE,
    OF_FORCES,
    RELATIVE,
    SETTLE,
    SETTLES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SPEEDS,
    STATE_OLD,
    STEP,
    STEPS,
    STIFFNESS_DIRECTION,
    STORED,
    STRAIGHT,
    TIME,
    TIME_AT,
    TIME_OLD,
    WAITING,
    Run,
    await_output,
    stay_on_side,
    watch_steps,
)
from kanefe.kernels.steppers.step_times import CLOCK, LAST_LOOK, look_at_clock

NOT_SETTLED, IS_SETTLING, IS_ASKED, IS_MOVED = range(4)
"""Values of SETTLES: outputs stay as they are; they are settled; one has been evaluated for it; and has been moved."""

PROMISED = 10.0
"""Error of a state that a run promises, relative to what its tolerance allows a step. Fixed steps have no tolerance."""

SETTLED_OVER = 3.0
"""Length h of Euler's step, in steps of the run: between the nodes of a step its polynomial misses modes of a radian a
step by more than its accelerations are wrong; a longer one takes from slow vibrations what the state knows."""

DIFFERENCE = 1e-3
"""Time over which the polynomial is differentiated, in steps: truncation is then its square, and round-off over it."""


@kernel
def go_on(run: Run, vectors: np.ndarray) -> int:
    """Return the next command of a method that is not an accepted step with more to come; write the outputs passed.

    Of a method whose outputs are to be settled, SETTLE and IMPLICIT come in between.
    """
    integers, reals, clock = run.integers, run.reals, run.clock
    if clock[CLOCK] != 0 and clock[LAST_LOOK] == 0:
        look_at_clock(clock, False)
    while True:
        if integers[WAITING] > 0:
            if integers[SETTLES] == IS_ASKED:
                _take_settled(run, vectors)
                if integers[HAS_LOOPS]:
                    return SETTLE
            if integers[SETTLES] == IS_MOVED:
                integers[WAITING] -= 1
                integers[SETTLES] = IS_SETTLING
            if integers[WAITING] > 0:
                return _ask_settled(run, vectors)
        else:
            command = run.advance(integers, reals, vectors, run.table)
            if command != ACCEPTED:
                if integers[BREAKPOINTS] > 0:
                    stay_on_side(integers, reals)
                return command
            if clock[CLOCK] != 0:
                look_at_clock(clock, True)
            if integers[BENDS] > 0:  # where the step began: what it went past an event with has not been
                watch_bends(integers[integers[BENDS] :], reals, reals[TIME_OLD], vectors[STATE_OLD])
            if reals[OF_FORCES] > 0.0:
                put_force_scales(integers, reals, vectors)
            if integers[LOOKS_FOR_JUMPS] > 0:
                watch_steps(integers, reals, vectors)
            first = stored = integers[STORED]
            while stored < len(run.times) and run.times[stored] <= reals[TIME]:
                run.interpolate(integers, reals, vectors, run.table, run.times[stored], run.states[stored])
                stored += 1
            integers[STORED] = stored
            await_output(run)
            if integers[SETTLES] != NOT_SETTLED and stored > first:
                integers[WAITING], reals[SHARE_STIFFNESS] = stored - first, (SETTLED_OVER * reals[STEP]) ** 2
                if integers[HAS_LOOPS]:
                    return SETTLE
                continue
        if integers[STORED] == len(run.times) or integers[STEPS] >= run.most_steps:
            return ACCEPTED


@kernel
def _ask_settled(run: Run, vectors: np.ndarray) -> int:
    """Ask for the evaluation of the first output that waits, its loops closed, with pushes by its accelerations."""
    integers, reals, number = run.integers, run.reals, run.integers[STORED] - run.integers[WAITING]
    t, h, n, square = run.times[number], reals[STEP], integers[COORDINATES], reals[SHARE_STIFFNESS]
    before, behind = vectors[AT], vectors[SLOPE]
    run.interpolate(integers, reals, vectors, run.table, t - DIFFERENCE * h, before)
    run.interpolate(integers, reals, vectors, run.table, t + DIFFERENCE * h, behind)
    for i in range(n, n + integers[SPEEDS]):
        change = (behind[i] - before[i]) / (2.0 * DIFFERENCE)
        vectors[DAMPING_DIRECTION, i], vectors[STIFFNESS_DIRECTION, i] = 0.0, square / h * change
    copy(run.states[number], vectors[AT])
    reals[TIME_AT], reals[SHARE_DAMPING] = t, 0.0
    integers[SETTLES] = IS_ASKED
    integers[EVALUATIONS] += 1
    return IMPLICIT


@kernel
def _take_settled(run: Run, vectors: np.ndarray) -> None:
    """Move the elastic coordinates of the output that was evaluated.

    It stays as it is where one would move by more than the error that is promised: then a force jumps there, or there
    are no numbers.
    """
    integers, reals, n = run.integers, run.reals, run.integers[COORDINATES]
    state = run.states[integers[STORED] - integers[WAITING]]
    pushed, square, farthest = vectors[STIFFNESS_DIRECTION], reals[SHARE_STIFFNESS], 0.0
    for is_moved in range(2):
        for row in range(integers[MAP_SIZE]):
            kind, at, i = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], n + integers[MAP + 3 * row + 2]
            if kind == STRAIGHT and vectors[ELASTIC, i] != 0.0:
                change = square * vectors[SLOPE, i] - pushed[i]
                if is_moved == 1:
                    state[at] += change
                    continue
                allowed = PROMISED * (vectors[LARGE, at] + reals[RELATIVE] * abs(state[at]))
                farthest = max(farthest, abs(change) / allowed if abs(change) < np.inf else np.inf)
        if farthest > 1.0 and not (integers[IS_FIXED] and farthest < np.inf):
            break
    integers[SETTLES] = IS_MOVED


@entry()
def next_command(run: Run, vectors: RealRows) -> int:
    """Return the next command of a method, for a loop in Python: see `go_on`."""
    return go_on(run, vectors)
