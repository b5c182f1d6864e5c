"""Where steps end: at the end of the run, at breakpoints, or where a function of time jumps.

A `Step` has the breakpoints in ascending order. `next_breakpoint` is the place of the next one, `last_kept` that of the
last at which steps have to end, `kept_at_once` how many these are at a time, `rejected_before` the rejected steps at
the last look. `left_sides` are, if there are any, as many times: the last ones before each at which functions of time
have their values from before it (where none jumps, itself).
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import copy, inlined, kernel
from kanefe.kernels.steppers.step_commands import Command, Reason, Step


class Limits(NamedTuple):
    """How many breakpoints are kept and passed over."""

    fewest_kept: int = 8
    most_kept: int = 1024
    epsilon: float = 2.220446049250313e-16  # of numbers
    pieces_of_free_step: float = 4.0  # steps that want more pieces of a table than these pass over its knots


LIMITS = Limits()


@inlined
def next_breakpoint(step: Step) -> int:
    """Return the place of the first breakpoint after the time, and keep it; one there but for round-off is met."""
    knots, t, i = step.breakpoints, step.time, step.next_breakpoint
    while i < len(knots) and knots[i] <= t + 1e-9 * (knots[i] - knots[i - 1]):
        i += 1
    while i > 1 and knots[i - 1] > t + 1e-9 * (knots[i - 1] - knots[i - 2]):
        i -= 1
    step.next_breakpoint = i
    return i


@kernel
def has_jumped(step: Step) -> bool:
    """Return whether a function of time jumps where the last step has ended, so that its last rates are not the next.

    A method asks this after each step, and then begins anew with its step and what it knows of the scene.
    """
    if step.side_count == 0 or step.is_fixed:
        return False
    i, knots = next_breakpoint(step) - 1, step.breakpoints
    return bool(step.time_old < knots[i] and step.left_sides[i] < knots[i])


@kernel
def stay_on_side(step: Step) -> None:
    """Bring the time to evaluate at between the breakpoints about the step, to the sides on which the step is.

    A step that ends where a function of time jumps is with the value from before, the one that begins there with that
    from then on.
    """
    if step.side_count > 0:
        i = next_breakpoint(step)
        step.time_at = max(step.time_at, step.breakpoints[i - 1])
        if i < step.side_count:
            step.time_at = min(step.time_at, step.left_sides[i])


@kernel
def accept(step: Step, new: np.ndarray, stage: int) -> int:
    """Make `new` the state at the end of the step, and say so; a step to what is no number fails."""
    step.stage, step.command = stage, Command.ACCEPTED
    for i in range(len(new)):
        if not abs(new[i]) < np.inf:
            step.reason, step.worst, step.command = Reason.NO_NUMBERS, i, Command.FAILED
            return step.command
    copy(step.state, step.state_old)
    copy(new, step.state)
    step.time_old = step.time
    if step.is_last:
        step.time = step.stop
    elif not step.is_fixed:
        step.time += step.h
        _meet_breakpoint(step)
    else:  # Kahan's sum: a million rounded steps would end beside the outputs, and what is kept is so at their ends
        h = step.h - step.time_excess
        step.time += h
        step.time_excess = (step.time - step.time_old) - h
    step.steps += 1
    return step.command


@inlined
def _meet_breakpoint(step: Step) -> None:
    """Let a step that has come to a breakpoint but for the round-off of its length end there."""
    i = step.next_breakpoint
    if i < step.breakpoint_count:
        knot = step.breakpoints[i]
        if abs(step.time - knot) <= 4.0 * LIMITS.epsilon * abs(knot):
            step.time = knot


@kernel
def breakpoint_ahead(step: Step, wanted: float) -> float:
    """Return the breakpoint of a table at which the step must end, s; infinity if steps may pass over breakpoints.

    No method is of its order across a kink. Where a step that passes over knots is rejected until few are left, the
    next steps end at them: `LIMITS.fewest_kept` at first, twice as many each time that a longer step fails at once.
    """
    i, knots, last = next_breakpoint(step), step.breakpoints, step.last_kept
    is_rejected = step.rejected > step.rejected_before
    step.rejected_before = step.rejected
    if i == len(knots):
        return np.inf
    free = LIMITS.pieces_of_free_step * (knots[i] - knots[i - 1])
    if i > last:
        if not (is_rejected and step.time + step.h > knots[i] and wanted < free):
            return np.inf
        is_same = i <= last + 2.0 * LIMITS.pieces_of_free_step
        step.kept_at_once = min(2 * step.kept_at_once, LIMITS.most_kept) if is_same else LIMITS.fewest_kept
        step.last_kept = i + step.kept_at_once
    step.next_step = min(step.next_step, free)  # steps that end at knots have errors so small that they say nothing
    return float(knots[i])


@inlined
def even_part(wanted: float, rest: float) -> float:
    """Return the step wanted, or all that is left, or half of it: two even steps are better than one and a sliver."""
    if wanted >= rest * (1.0 - 1e-9):
        return rest
    return wanted if wanted <= 0.5 * rest else 0.5 * rest


@inlined
def clip(step: Step, wanted: float) -> None:
    """Set the step: the one wanted, or an even part of what is left; fixed ones are cut at the end alone."""
    rest, next_break = step.stop - step.time, np.inf
    if not step.is_fixed:
        wanted = min(wanted, step.largest, step.largest_of_drives, step.to_event)
        if step.breakpoint_count > 0:
            next_break = breakpoint_ahead(step, wanted) - step.time
    step.is_last = min(wanted, next_break) >= rest * (1.0 - 1e-9)
    rest = min(rest, next_break)
    is_whole = step.is_fixed and wanted < rest * (1.0 - 1e-9)
    step.h = wanted if is_whole else even_part(wanted, rest)


@inlined
def end_of(step: Step) -> float:
    """Return when the step ends, s."""
    return step.stop if step.is_last else step.time + step.h
