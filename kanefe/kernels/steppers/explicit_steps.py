"""Explicit Runge-Kutta methods with dense output: one function for all, a table of coefficients for each.

Rows of the table: ``c_i, a_i0, a_i1, ...`` for the stages, the row after the last of which is the step itself, with its
own rate (first same as last); further stages of the dense output; then the weights of the error estimates and of the
dense output, again from the second column on.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.compiler.arrays import ADVANCE, INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    DONE,
    ERROR,
    FAILED,
    HAS_LOOPS,
    HELD,
    IS_FIXED,
    LAST_STEP,
    NEXT_OUTPUT,
    NEXT_STEP,
    OF_METHOD,
    PROJECT,
    RATES,
    REALS_OF_METHOD,
    REASON,
    REJECTED,
    RELATIVE,
    ROWS_OF_METHOD,
    SLOPE,
    SMALLEST,
    STAGE,
    STATE,
    STATE_OLD,
    STEP,
    STOP,
    TIME,
    TIME_AT,
    TIME_OLD,
    TOO_SMALL,
    WANTS_DENSE,
    WEAKEST,
    WORST,
    accept,
    ask,
    clip,
    first_step,
    has_jumped,
    scaled_size,
)

# Integers of the method; whether the step is the first one, of which nothing was known
STAGES, EXTRA, ESTIMATES, DENSE, ORDER, IS_GUESS = range(OF_METHOD, OF_METHOD + 6)

# Reals of the method: usual step and usual pivot of the constraints, by how much the tolerance has grown, and the
# length that was rejected before this step, or zero
USUAL_STEP, USUAL_WEAKEST, LOOSER, TOO_LONG = range(REALS_OF_METHOD, REALS_OF_METHOD + 4)
REALS = REALS_OF_METHOD + 4

# Rows of the method: the new state, the error, and the rates
NEW, DIFFERENCE, FIRST_RATE = range(ROWS_OF_METHOD, ROWS_OF_METHOD + 3)

# Where to go on, besides the number of a stage
BEGIN, FIRST, AFTER, PROJECTED, CLOSED, NEXT = 0, -1, -2, -3, -4, -5

# By which the first step may grow, which is a guess far on the safe side: as in CVODE (Hindmarsh et al., ACM Trans.
# Math. Software 31 (2005) 363-396)
LARGEST_GROWTH = 1e4
# Error, relative to the tolerance, below which it is round-off: a first step must not depend on units
ROUND_OFF = 1e-10
# Share of the usual pivot below which a step that falls to a tenth creeps up to a singular position
SINGULAR = 1e-3
# Share of the usual step below which a mechanism is held for good: at a dead centre its speeds grow without bound
SMALLEST_CREEP = 1e-5
# To which the relative tolerance may grow there: the error of one step
LARGEST_RELATIVE = 1e-6


@inlined
def weigh(vectors: np.ndarray, weights: np.ndarray, count: int, h: float, out: np.ndarray) -> None:
    """Add h times a weighted sum of rates to `out`."""
    for j in range(count):
        weight = h * weights[1 + j]
        if weight != 0.0:
            _add(vectors[FIRST_RATE + j], weight, out)


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
def _stage(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, stage: int) -> int:
    """Ask for the rates of a stage."""
    at = vectors[AT]
    copy(vectors[STATE], at)
    weigh(vectors, table[stage], stage, reals[STEP], at)
    reals[TIME_AT] = reals[TIME] + table[stage, 0] * reals[STEP]
    return ask(integers, RATES, stage)


@kernel
def _size(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> float:
    """Return the size of the error of a step; of the method of order 8, of its estimates of order 5 and 3."""
    stages, h = integers[STAGES], reals[STEP]
    first = stages + 1 + integers[EXTRA]
    error = vectors[DIFFERENCE]
    error[:] = 0.0
    weigh(vectors, table[first], stages + 1, h, error)
    looser = max(1.0, reals[LOOSER])
    size = scaled_size(integers, reals, vectors, error, vectors[STATE], vectors[NEW]) / looser
    if integers[ESTIMATES] < 2 or size == 0.0 or not size < np.inf:
        return size
    worst = integers[WORST]  # the component that counts is that of the first estimate
    error[:] = 0.0
    weigh(vectors, table[first + 1], stages + 1, h, error)
    low = scaled_size(integers, reals, vectors, error, vectors[STATE], vectors[NEW]) / looser
    integers[WORST] = worst
    ratio = 0.1 * low / size  # of squares, those of small errors would vanish
    return size / np.sqrt(1.0 + ratio * ratio)


@inlined
def _is_near_singular(reals: np.ndarray) -> bool:
    return reals[WEAKEST] < SINGULAR * reals[USUAL_WEAKEST]


@kernel
def _passes_singular_position(reals: np.ndarray) -> bool:
    """Let the error grow tenfold with every step that creeps up to a singular position, and take it back behind.

    Beside such a position the rates have an error of round-off divided by the square of the distance, which no step is
    small enough for. The position itself is passed by the momentum of the step. False: the mechanism is held there.
    """
    step = reals[TIME] - reals[TIME_OLD]
    if _is_near_singular(reals) and step <= SMALLEST_CREEP * reals[USUAL_STEP]:
        return False
    reals[USUAL_WEAKEST] = max(reals[USUAL_WEAKEST], reals[WEAKEST])
    if not _is_near_singular(reals):
        reals[USUAL_STEP] = step
    if _is_near_singular(reals) and step < 0.1 * reals[USUAL_STEP]:
        reals[LOOSER] = min(10.0 * max(1.0, reals[LOOSER]), LARGEST_RELATIVE / reals[RELATIVE])
    else:
        reals[LOOSER] = 1.0
    return True


@pointer(ADVANCE)
def advance_explicitly(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue with an explicit method: see `kanefe.kernels.steppers.step_commands`."""
    stage, stages = integers[STAGE], integers[STAGES]
    if stage == BEGIN:
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        reals[LOOSER] = 1.0
        return ask(integers, RATES, FIRST)
    if stage == FIRST:
        copy(vectors[SLOPE], vectors[FIRST_RATE])
        if reals[NEXT_STEP] <= 0.0:
            reals[NEXT_STEP] = first_step(integers, reals, vectors, vectors[FIRST_RATE])
            integers[IS_GUESS] = 1
        stage = NEXT
    elif stage == PROJECTED:
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        return ask(integers, RATES, CLOSED)
    elif stage == CLOSED:
        copy(vectors[SLOPE], vectors[FIRST_RATE])
        if not integers[IS_FIXED] and not _passes_singular_position(reals):
            integers[REASON] = HELD
            return ask(integers, FAILED, CLOSED)
        stage = NEXT
    elif stage == AFTER:
        if integers[HAS_LOOPS]:
            return ask(integers, PROJECT, PROJECTED)
        if has_jumped(integers, reals):
            copy(vectors[STATE], vectors[AT])
            reals[TIME_AT] = reals[TIME]
            return ask(integers, RATES, FIRST)
        copy(vectors[FIRST_RATE + stages], vectors[FIRST_RATE])
        stage = NEXT
    if stage == NEXT:
        if reals[TIME] >= reals[STOP]:
            return ask(integers, DONE, NEXT)
        clip(integers, reals, reals[NEXT_STEP])
        return _stage(integers, reals, vectors, table, 1)
    copy(vectors[SLOPE], vectors[FIRST_RATE + stage])
    if stage == stages:  # the step is complete
        copy(vectors[AT], vectors[NEW])
        if not integers[IS_FIXED]:
            error = _size(integers, reals, vectors, table)
            reals[ERROR] = error
            if not error <= 1.0:
                integers[REJECTED] += 1
                reals[TOO_LONG] = reals[STEP]
                factor = max(0.2, 0.9 * error ** (-1.0 / integers[ORDER])) if error < np.inf else 0.1
                reals[NEXT_STEP] = reals[STEP] * factor
                if reals[NEXT_STEP] < reals[SMALLEST]:
                    integers[REASON] = HELD if _is_near_singular(reals) else TOO_SMALL
                    return ask(integers, FAILED, NEXT)
                clip(integers, reals, reals[NEXT_STEP])
                return _stage(integers, reals, vectors, table, 1)
            most = LARGEST_GROWTH if integers[IS_GUESS] else 5.0
            grown = reals[STEP] * min(most, 0.9 * max(error, ROUND_OFF) ** (-1.0 / integers[ORDER]))
            if reals[TOO_LONG] > 0.0:  # where errors grow faster than their order says, that length would come again
                grown = min(grown, np.sqrt(reals[STEP] * reals[TOO_LONG]))
            integers[IS_GUESS], reals[TOO_LONG] = 0, 0.0
            # a step cut short says little about the next one
            reals[NEXT_STEP] = max(grown, reals[NEXT_STEP]) if reals[STEP] < reals[NEXT_STEP] else grown
        ends = reals[STOP] if integers[LAST_STEP] else reals[TIME] + reals[STEP]
        if integers[EXTRA] == 0 or not (integers[WANTS_DENSE] or reals[NEXT_OUTPUT] < ends):
            ask(integers, ACCEPTED, AFTER)
            return accept(integers, reals, vectors, vectors[NEW])
        return _stage(integers, reals, vectors, table, stages + 1)
    if stage == stages + integers[EXTRA]:
        ask(integers, ACCEPTED, AFTER)
        return accept(integers, reals, vectors, vectors[NEW])
    return _stage(integers, reals, vectors, table, stage + 1)


@pointer(INTERPOLATE)
def interpolate_explicitly(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step.

    A polynomial that meets state and rate at both ends, and further rows of the table (Hairer, Norsett & Wanner,
    Solving Ordinary Differential Equations I, 1993, II.6).
    """
    if t == reals[TIME]:
        copy(vectors[STATE], out)
        return
    h = reals[STEP]
    x = (t - reals[TIME_OLD]) / h
    left = 1.0 - x
    stages, extra, rows = integers[STAGES], integers[EXTRA], integers[DENSE]
    first = stages + 1 + extra + integers[ESTIMATES]
    _go_from(vectors[STATE_OLD], vectors[NEW], x * x * (1.0 + 2.0 * left), out)
    for j in range(stages + 1 + extra):
        weight = 0.0
        for row in range(rows - 1, -1, -1):  # ((... d2) x + d1) (1 - x) + ..., x and 1 - x in turn
            weight = (weight + table[first + row, 1 + j]) * (left if row % 2 == 0 else x)
        weight *= x * x * left
        if j == 0:
            weight += x * left * left
        elif j == stages:
            weight -= x * x * left
        if weight != 0.0:
            _add(vectors[FIRST_RATE + j], h * weight, out)
