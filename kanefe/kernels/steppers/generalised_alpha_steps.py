"""A step of the generalised-alpha method from its beginning to its end, but for what an iteration does.

See `kanefe.kernels.steppers.generalised_alpha`.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import copy, inlined, kernel
from kanefe.kernels.steppers.breakpoints import accept, clip, even_part
from kanefe.kernels.steppers.generalised_alpha_state import (
    AlphaStep,
    answer_of_arms,
    know_step,
    move_arms,
    push_by,
    put_ahead,
    put_end,
    reach,
    span_of,
)
from kanefe.kernels.steppers.generalised_alpha_systems import are_factored, factorise_newton, solve_newton
from kanefe.kernels.steppers.step_commands import Command, Reason, ask, fail, largest_share, wish


class StepLimits(NamedTuple):
    """How far steps are corrected and kept."""

    largest_iterations: int = 8
    largest_if_fixed: int = 20
    """Largest number of iterations of a step, which is then shortened, and of a fixed step."""
    near: float = 1e4
    """Largest correction, relative to the same, with which a fixed step is left: a thousandth of the bodies' size."""
    kept: float = 1.2
    """Growth of the step up to which the step and the factors are kept."""


STEP_LIMITS = StepLimits()


class Stage(IntEnum):
    """Where to go on."""

    BEGIN = 0
    FIRST = 1
    AHEAD = 2
    OF_JERK = 3
    JERK_FILTERED = 4
    ITERATED = 5
    DIFFERENTIATED = 6
    FILTERED = 7
    AFTER = 8
    PROJECTED = 9


@inlined
def _has_dense_matrix(step: AlphaStep) -> bool:
    """Return whether the Newton matrix is that of all unknowns, which knows all, so that rates are enough."""
    return step.takes_jacobian and step.most_directions == 0


@kernel
def ask_end(step: AlphaStep) -> int:
    """Ask for the accelerations at the end of the step."""
    put_end(step)
    return ask(step, Command.RATES if _has_dense_matrix(step) else Command.IMPLICIT, Stage.ITERATED)


@inlined
def _up_to_output(step: AlphaStep) -> float:
    """Return the step that is wanted, or a shorter one, so that free steps end at outputs.

    Within a step, modes that it does not resolve are not known: their energy there would be that of the interpolation.
    """
    wanted, rest = step.next_step, step.next_output - step.time
    return wanted if step.is_fixed or not step.smallest < rest < np.inf else even_part(wanted, rest)


@inlined
def _iterate_anew(step: AlphaStep) -> None:
    know_step(step)
    step.iteration = step.mixed_from = step.halvings = 0


@kernel
def begin_step(step: AlphaStep) -> int:
    """Begin a step, or the same step again with another length; first see to the rate of change of a."""
    clip(step, _up_to_output(step))
    _iterate_anew(step)
    step.is_fresh = False
    if not step.has_jerk and step.speeds > 0:
        put_ahead(step)
        return ask(step, Command.RATES, Stage.AHEAD)
    return ask_end(step)


@kernel
def ask_jacobian(step: AlphaStep, stage: int) -> int:
    """Ask for the Jacobian, or the directions, of the state that was evaluated last."""
    step.jacobians += 1
    if step.most_directions == 0:
        return ask(step, Command.JACOBIAN, stage)
    step.evaluations += 1
    return ask(step, Command.DIRECTIONS, stage)


@kernel
def filter_row(step: AlphaStep, row: np.ndarray, stage: int) -> int:
    """Take from a row of accelerations what the step does not resolve; what it asks for to do so, START if it is done.

    The state `at` has the accelerations du: with pushes by du - x a linearly implicit evaluation gives
    ``du - x + (M + s C + r K)^-1 M x``.
    """
    n, moving, _ = span_of(step)
    if _has_dense_matrix(step):
        _solve_filter(step, row)
    elif step.takes_jacobian or step.has_stiffness:
        change, found = step.change, step.found
        for i in range(n, moving):
            change[i] = found[i] - row[i]
        push_by(step, change)
        move_arms(step, row)
        return ask(step, Command.IMPLICIT, stage)
    return Command.START.value


@kernel
def _solve_filter(step: AlphaStep, row: np.ndarray) -> None:
    if are_factored(step) or factorise_newton(step):
        solve_newton(step, row)


@kernel
def take_filtered(step: AlphaStep, row: np.ndarray) -> None:
    """Write to a row of accelerations what the evaluation has left of it."""
    (n, moving, _), slope, change = span_of(step), step.slope, step.change
    for i in range(n, moving):
        row[i] = slope[i] - change[i]
    if step.takes_jacobian:
        _solve_filter(step, row)
    else:
        answer_of_arms(step, row)


@kernel
def size_of(step: AlphaStep, change: np.ndarray) -> float:
    """Write a change of the unknowns, of what is allowed of their displacement; return the largest part."""
    (n, moving, end), residual, allowed = span_of(step), step.residual, step.allowed
    weight = step.share_stiffness
    for i in range(n, end):
        residual[i] = (weight if i < moving else 1.0) * change[i] / allowed[i]
    return largest_share(step, residual, n, end)


@kernel
def shorten(step: AlphaStep, h: float) -> int:
    """Try a shorter step; fixed ones are not."""
    step.is_wanted = True
    if step.is_fixed:
        if not step.takes_jacobian or step.is_fresh:
            return fail(step, Reason.NO_CONVERGENCE, Stage.AFTER)
        _iterate_anew(step)  # the Jacobian of an earlier state may be what is wrong
        return ask_end(step)
    step.rejected += 1
    step.next_step = h
    if h < step.smallest:
        return fail(step, Reason.TOO_SMALL, Stage.AFTER)
    return begin_step(step)


@kernel
def go_on_or_leave(step: AlphaStep, size: float) -> int:
    """Ask for another iteration, accept a fixed step that is near enough, or have it shorter."""
    step.iteration += 1
    most = STEP_LIMITS.largest_if_fixed if step.is_fixed else STEP_LIMITS.largest_iterations
    if not step.is_fixed and step.iteration > 2 and size > step.correction:
        most = 0
    if step.iteration < most:
        step.correction = size
        return ask_end(step)
    if not step.is_fixed or size > STEP_LIMITS.near:
        return shorten(step, 0.25 * step.h)
    if step.unconverged == 0:
        step.first_unconverged = step.time_at
    step.unconverged += 1
    step.last_unconverged = step.time_at
    step.largest_left = max(step.largest_left, size)
    return finish(step)


@kernel
def finish(step: AlphaStep) -> int:
    """Write the end of the step, and find its error where it is not fixed."""
    (n, moving, end), h, new, slope, found, known = (
        span_of(step), step.h, step.new, step.slope, step.found, step.known
    )  # fmt: skip
    reach(step, new)
    for i in range(len(new) - 2, len(new)):
        new[i] = step.state[i] + 0.5 * h * (known[i] + slope[i])
        found[i] = slope[i]
    if step.is_fixed:
        return _accept(step)
    third = (step.beta - 1.0 / 6.0) * h * h / step.share_stiffness
    tried, ends, begun = step.tried, step.ends, step.begun
    for i in range(n, moving):
        tried[i] = third * (ends[i] - begun[i])
    left, at_start, change = step.left, step.at_start, step.change
    for i in range(moving, end):
        rates = left[i] + (found[i] - known[i]) / step.share_of_rates
        tried[i] = found[i] - at_start[i] - 0.5 * h * rates
        change[i] = np.sqrt(step.relative) * tried[i]
    asked = filter_row(step, tried, Stage.FILTERED)
    return asked if asked != Command.START else judge(step)


@kernel
def judge(step: AlphaStep) -> int:
    """Accept or reject a step by its error, and choose the next one.

    The error is the third-order part of the move, with what the move has from the errors of internal states, their
    difference to the trapezoidal rule: both have passed the matrix. States themselves are kept to the root of the
    tolerance, for those that are of interest and move nothing.
    """
    (_, moving, end), h, tried = span_of(step), step.h, step.tried
    copy(step.change[moving:end], tried[moving:end])
    step.error = size_of(step, tried)
    if not step.error <= 1.0:
        return shorten(step, h * max(0.2, 0.9 * step.error ** (-1.0 / 3.0)))
    grown = h * min(2.0, 0.9 * max(step.error, 1e-6) ** (-1.0 / 3.0))
    wish(step, h if step.takes_jacobian and h <= grown <= STEP_LIMITS.kept * h else grown)
    return _accept(step)


@kernel
def _accept(step: AlphaStep) -> int:
    """Accept the step; what the next one begins with stays."""
    (n, moving, end), h, left, ends, begun = span_of(step), step.h, step.left, step.ends, step.begun
    jerk, found, known, before, at_start = step.jerk, step.found, step.known, step.before, step.at_start
    for i in range(n, moving):
        jerk[i] = (ends[i] - begun[i]) / h
        left[i] = ends[i]
    step.has_jerk, step.step_of_a, step.step_before = True, h, h
    for i in range(moving, end):
        left[i] = (found[i] - known[i]) / step.share_of_rates
    copy(at_start[n:end], before[n:end])
    copy(found[n:end], at_start[n:end])
    powers = len(found) - 2
    copy(known[powers:], before[powers:])
    copy(found[powers:], known[powers:])
    return accept(step, step.new, Stage.AFTER)
