"""From step to step, with the outputs passed: states within a step, in which stiff modes are settled.

Within the tolerance of a state a stiff mode has any force: ``K e`` is large however small its error e. What the mode
does is known all the same: over a step it follows the rest, with the accelerations a of the polynomial of the step. A
step of Euler's implicit method for the difference to these, with an h of some steps of the run, leaves slow motions as
they are and divides the errors of stiff modes by ``1 + (omega h)^2``:

    (M + h^2 K) x = F + h^2 K a,    elastic coordinates moved by h^2 (x - a).

Then the accelerations of the state are x, and all that is computed from it has the forces that belong to them. This is
one linearly implicit evaluation. Only elastic coordinates move; joints close the loops behind them.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.language import copy, entry, kernel
from kanefe.kernels.steppers.breakpoints import stay_on_side
from kanefe.kernels.steppers.force_scales import put_force_scales
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.steppers.step_commands import Command, Run, await_output, step_of, watch_steps
from kanefe.kernels.steppers.step_times import AT, look_at_clock


class Settling(IntEnum):
    """How far an output is settled."""

    NOT = 0  # outputs stay as they are
    SOME = 1  # they are settled
    ASKED = 2  # one has been evaluated for it
    MOVED = 3  # and has been moved


class Limits(NamedTuple):
    """How outputs are settled."""

    promised: float = 10.0
    """Error of a state that a run promises, relative to what its tolerance allows a step. Fixed steps have no
    tolerance."""
    settled_over: float = 3.0
    """Length h of Euler's step, in steps of the run: between the nodes of a step its polynomial misses modes of a
    radian a step by more than its accelerations are wrong; a longer one takes from slow vibrations what the state
    knows."""
    difference: float = 1e-3
    """Time over which the polynomial is differentiated, in steps: truncation is then its square, and round-off over
    it."""


LIMITS = Limits()


@kernel
def go_on(run: Run) -> int:
    """Return the next command of a method that is not an accepted step with more to come; write the outputs passed.

    Of a method whose outputs are to be settled, SETTLE and IMPLICIT come in between.
    """
    step, clock = step_of(run), run.clock
    if clock[AT.clock] != 0 and clock[AT.last_look] == 0:
        look_at_clock(clock, False)
    while True:
        if step.waiting > 0:
            command = _settle(run)
        else:
            command = run.advance(run.integers, run.reals, run.vectors, run.table)
            if command != Command.ACCEPTED:
                stay_on_side(step)
                return command
            command = _take_step(run)
        if command != Command.ACCEPTED:
            return command
        is_done = step.stored == len(run.times) or step.steps >= run.most_steps
        if is_done and step.waiting == 0:
            return command


@kernel
def _settle(run: Run) -> int:
    """Return what is wanted to settle the outputs that wait; ACCEPTED when all are."""
    step = step_of(run)
    if step.settles == Settling.ASKED:
        _take_settled(run)
        if step.has_loops:
            return Command.SETTLE.value
    if step.settles == Settling.MOVED:
        step.waiting -= 1
        step.settles = Settling.SOME
    return _ask_settled(run) if step.waiting > 0 else Command.ACCEPTED.value


@kernel
def _take_step(run: Run) -> int:
    """Watch a step that has been accepted, and write its outputs; return SETTLE where their loops are to be closed."""
    step, clock = step_of(run), run.clock
    if clock[AT.clock] != 0:
        look_at_clock(clock, True)
    if step.bend_count > 0:  # where the step began: what it went past an event with has not been
        watch_bends(step.bends, run.reals, step.time_old, step.state_old)
    if step.of_forces > 0.0:
        put_force_scales(step)
    if step.looks_for_jumps:
        watch_steps(step)
    first = stored = step.stored
    while stored < len(run.times) and run.times[stored] <= step.time:
        run.interpolate(run.integers, run.reals, run.vectors, run.table, run.times[stored], run.states[stored])
        stored += 1
    step.stored = stored
    await_output(run)
    if step.settles != Settling.NOT and stored > first:
        step.waiting, step.share_stiffness = stored - first, (LIMITS.settled_over * step.h) ** 2
        if step.has_loops:
            return Command.SETTLE.value
    return Command.ACCEPTED.value


@kernel
def _ask_settled(run: Run) -> int:
    """Ask for the evaluation of the first output that waits, its loops closed, with pushes by its accelerations."""
    step = step_of(run)
    number, before, behind = step.stored - step.waiting, step.at, step.slope
    t, h, n, square = run.times[number], step.h, step.coordinates, step.share_stiffness
    run.interpolate(run.integers, run.reals, run.vectors, run.table, t - LIMITS.difference * h, before)
    run.interpolate(run.integers, run.reals, run.vectors, run.table, t + LIMITS.difference * h, behind)
    by_damping, by_stiffness = step.damping_direction, step.stiffness_direction
    for i in range(n, n + step.speeds):
        by_damping[i], by_stiffness[i] = 0.0, square / h * ((behind[i] - before[i]) / (2.0 * LIMITS.difference))
    copy(run.states[number], before)
    step.time_at, step.share_damping, step.settles = t, 0.0, Settling.ASKED
    step.evaluations += 1
    return Command.IMPLICIT.value


@kernel
def _take_settled(run: Run) -> None:
    """Move the elastic coordinates of the output that was evaluated.

    It stays as it is where one would move by more than the error that is promised: then a force jumps there, or there
    are no numbers.
    """
    step = step_of(run)
    n, state, moves, elastic = step.coordinates, run.states[step.stored - step.waiting], step.moves, step.elastic
    pushed, slope, large, square, farthest = (
        step.stiffness_direction, step.slope, step.large, step.share_stiffness, 0.0
    )  # fmt: skip
    for is_moved in range(2):
        for row in range(len(moves)):
            at, i = moves[row, 1], n + moves[row, 2]
            if moves[row, 0] == STRAIGHT and elastic[i] != 0.0:
                change = square * slope[i] - pushed[i]
                if is_moved == 1:
                    state[at] += change
                    continue
                allowed = LIMITS.promised * (large[at] + step.relative * abs(state[at]))
                farthest = max(farthest, abs(change) / allowed if abs(change) < np.inf else np.inf)
        if farthest > 1.0 and not (step.is_fixed and farthest < np.inf):
            break
    step.settles = Settling.MOVED


@entry()
def next_command(run: Run) -> int:
    """Return the next command of a method, for a loop in Python: see `go_on`."""
    return go_on(run)
