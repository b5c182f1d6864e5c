"""Explicit Runge-Kutta methods with dense output: one function for all, a table of coefficients for each.

Rows of the table: ``c_i, a_i0, a_i1, ...`` for the stages, the row after the last of which is the step itself, with its
own rate (first same as last); further stages of the dense output; then the weights of the error estimates and of the
dense output, again from the second column on.
"""

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.language import ADVANCE, INTERPOLATE, Array, copy, inlined, kernel, pointer, vector_kernel
from kanefe.kernels.steppers.breakpoints import accept, clip, end_of, has_jumped
from kanefe.kernels.steppers.step_commands import (
    Command,
    Reason,
    Row,
    Step,
    ask,
    ask_rates,
    fail,
    first_step,
    scaled_size,
    wish,
)


class Limits(NamedTuple):
    """From where on numbers count in a step."""

    # By which the first step may grow, which is a guess far on the safe side: as in CVODE (Hindmarsh et al., ACM Trans.
    # Math. Software 31 (2005) 363-396)
    largest_growth: float = 1e4
    # Error, relative to the tolerance, below which it is round-off: a first step must not depend on units
    round_off: float = 1e-10
    # Share of the usual pivot below which a step that falls to a tenth creeps up to a singular position
    singular: float = 1e-3
    # Share of the usual step below which a mechanism is held for good: at a dead centre its speeds grow without bound
    smallest_creep: float = 1e-5
    # To which the relative tolerance may grow there: the error of one step
    largest_relative: float = 1e-6


LIMITS = Limits()


class Stage(IntEnum):
    """Where to go on, besides the number of a stage of the method."""

    BEGIN = 0
    FIRST = -1
    AFTER = -2
    PROJECTED = -3
    CLOSED = -4
    NEXT = -5


class ExplicitStep(Step):
    """A step of an explicit method."""

    stages: int  # of `kanefe.integrate.methods.explicit.Tableau`
    extra: int
    estimates: int
    dense: int
    order: int
    rate_count: int
    is_guess: bool  # the step is the first one, of which nothing was known
    usual_step: float
    usual_weakest: float  # pivot of the constraints
    looser: float  # by how much the tolerance has grown
    too_long: float  # the length that was rejected before this step, or zero
    new: Row
    difference: Row  # the error
    rates: Annotated[np.ndarray, Array("rate_count", "size")]  # of stages, at the end, and of the dense output


@inlined
def _weigh(rates: np.ndarray, weights: np.ndarray, count: int, h: float, out: np.ndarray) -> None:
    """Add h times a weighted sum of rates to `out`."""
    for j in range(count):
        weight = h * weights[1 + j]
        if weight != 0.0:
            _add(rates[j], weight, out)


@vector_kernel
def _add(rate: np.ndarray, weight: float, out: np.ndarray) -> None:
    """Add so many times a rate."""
    for i in range(len(out)):
        out[i] += weight * rate[i]


@vector_kernel
def _go_from(old: np.ndarray, new: np.ndarray, share: float, out: np.ndarray) -> None:
    """Write what is a share of the way from one state to another."""
    for i in range(len(out)):
        out[i] = old[i] + share * (new[i] - old[i])


@kernel
def _ask_stage(step: ExplicitStep, table: np.ndarray, stage: int) -> int:
    """Ask for the rates of a stage."""
    at = step.at
    copy(step.state, at)
    _weigh(step.rates, table[stage], stage, step.h, at)
    step.time_at = step.time + table[stage, 0] * step.h
    return ask(step, Command.RATES, stage)


@kernel
def _size(step: ExplicitStep, weights: np.ndarray) -> float:
    """Return the size of an estimate of the error."""
    error = step.difference
    error[:] = 0.0
    _weigh(step.rates, weights, step.stages + 1, step.h, error)
    return scaled_size(step, error, step.state, step.new) / max(1.0, step.looser)


@kernel
def _error(step: ExplicitStep, table: np.ndarray) -> float:
    """Return the size of the error of a step; of the method of order 8, of its estimates of order 5 and 3."""
    first = step.stages + 1 + step.extra
    size = _size(step, table[first])
    if step.estimates < 2 or size == 0.0 or not size < np.inf:
        return size
    worst = step.worst  # the component that counts is that of the first estimate
    ratio = 0.1 * _size(step, table[first + 1]) / size  # of squares, those of small errors would vanish
    step.worst = worst
    return size / np.sqrt(1.0 + ratio * ratio)


@inlined
def _is_near_singular(step: ExplicitStep) -> bool:
    return step.weakest < LIMITS.singular * step.usual_weakest


@kernel
def _passes_singular_position(step: ExplicitStep) -> bool:
    """Let the error grow tenfold with every step that creeps up to a singular position, and take it back behind.

    Beside such a position the rates have an error of round-off divided by the square of the distance, which no step is
    small enough for. The position itself is passed by the momentum of the step. False: the mechanism is held there.
    """
    h = step.time - step.time_old
    if _is_near_singular(step) and h <= LIMITS.smallest_creep * step.usual_step:
        return False
    step.usual_weakest = max(step.usual_weakest, step.weakest)
    if not _is_near_singular(step):
        step.usual_step = h
    if _is_near_singular(step) and h < 0.1 * step.usual_step:
        step.looser = min(10.0 * max(1.0, step.looser), LIMITS.largest_relative / step.relative)
    else:
        step.looser = 1.0
    return True


@kernel
def _begin_step(step: ExplicitStep, table: np.ndarray) -> int:
    if step.time >= step.stop:
        return ask(step, Command.DONE, Stage.NEXT)
    clip(step, step.next_step)
    return _ask_stage(step, table, 1)


@kernel
def _take_first(step: ExplicitStep, table: np.ndarray) -> int:
    """Begin with the rates at the start, or anew with those behind a jump or with loops that are closed."""
    rates = step.rates[0]
    copy(step.slope, rates)
    if step.stage == Stage.CLOSED:
        if not step.is_fixed and not _passes_singular_position(step):
            return fail(step, Reason.HELD, Stage.CLOSED)
    elif step.next_step <= 0.0:
        step.next_step, step.is_guess = first_step(step, rates), True
    return _begin_step(step, table)


@kernel
def _go_on(step: ExplicitStep, table: np.ndarray) -> int:
    """Go on behind an accepted step."""
    if step.has_loops:
        return ask(step, Command.PROJECT, Stage.PROJECTED)
    if has_jumped(step):
        return ask_rates(step, Stage.FIRST)
    copy(step.rates[step.stages], step.rates[0])
    return _begin_step(step, table)


@kernel
def _reject(step: ExplicitStep, table: np.ndarray) -> int:
    step.rejected += 1
    step.too_long = step.h
    step.next_step = step.h * (max(0.2, 0.9 * step.error ** (-1.0 / step.order)) if step.error < np.inf else 0.1)
    if step.next_step < step.smallest:
        return fail(step, Reason.HELD if _is_near_singular(step) else Reason.TOO_SMALL, Stage.NEXT)
    clip(step, step.next_step)
    return _ask_stage(step, table, 1)


@kernel
def _choose_next(step: ExplicitStep) -> None:
    """Choose the length of the next step."""
    most = LIMITS.largest_growth if step.is_guess else 5.0
    grown = step.h * min(most, 0.9 * max(step.error, LIMITS.round_off) ** (-1.0 / step.order))
    if step.too_long > 0.0:  # where errors grow faster than their order says, that length would come again
        grown = min(grown, np.sqrt(step.h * step.too_long))
    step.is_guess, step.too_long = False, 0.0
    wish(step, grown)


@kernel
def _judge(step: ExplicitStep, table: np.ndarray) -> int:
    """Accept or reject a step that is complete, or ask for what its dense output takes beside."""
    copy(step.at, step.new)
    if not step.is_fixed:
        step.error = _error(step, table)
        if not step.error <= 1.0:
            return _reject(step, table)
        _choose_next(step)
    if step.extra == 0 or not (step.wants_dense or step.next_output < end_of(step)):
        return accept(step, step.new, Stage.AFTER)
    return _ask_stage(step, table, step.stages + 1)


@pointer(ADVANCE)
def advance_explicitly(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue with an explicit method: see `kanefe.kernels.steppers.step_commands`."""
    step = ExplicitStep(integers, reals, vectors)
    stage = step.stage
    if stage > 0:
        copy(step.slope, step.rates[stage])
        if stage == step.stages:
            return _judge(step, table)
        if stage == step.stages + step.extra:
            return accept(step, step.new, Stage.AFTER)
        return _ask_stage(step, table, stage + 1)
    if stage == Stage.BEGIN:
        step.looser = 1.0
        return ask_rates(step, Stage.FIRST)
    if stage == Stage.FIRST or stage == Stage.CLOSED:
        return _take_first(step, table)
    if stage == Stage.PROJECTED:
        return ask_rates(step, Stage.CLOSED)
    return _go_on(step, table) if stage == Stage.AFTER else _begin_step(step, table)


@pointer(INTERPOLATE)
def interpolate_explicitly(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step.

    A polynomial that meets state and rate at both ends, and further rows of the table (Hairer, Norsett & Wanner,
    Solving Ordinary Differential Equations I, 1993, II.6).
    """
    step = ExplicitStep(integers, reals, vectors)
    if t == step.time:
        copy(step.state, out)
        return
    h, stages, rates = step.h, step.stages, step.rates
    x = (t - step.time_old) / h
    left = 1.0 - x
    first = len(rates) + step.estimates
    _go_from(step.state_old, step.new, x * x * (1.0 + 2.0 * left), out)
    for j in range(len(rates)):
        weight = 0.0
        for row in range(step.dense - 1, -1, -1):  # ((... d2) x + d1) (1 - x) + ..., x and 1 - x in turn
            weight = (weight + table[first + row, 1 + j]) * (left if row % 2 == 0 else x)
        weight *= x * x * left
        if j == 0:
            weight += x * left * left
        elif j == stages:
            weight -= x * x * left
        if weight != 0.0:
            _add(rates[j], h * weight, out)
