"""Generalised-alpha and HHT on the rotation group, of order 2: see `generalised_alpha_state` for the formula.

Stable for elastic modes of any frequency, which are damped where the step does not resolve them. The unknowns are
iterated until ``M du1 = F`` at the end of the step. Where all that is stiff are modes, springs, dampers and stops along
joints, a linearly implicit sweep is a Newton step in order n, with matrices that are never old:

    (M + s C + r K) x = F + (s C + r K) du1,    x the next du1.

What it does not know (gyroscopic terms, functions of the user) converges with the step, and by Anderson's mixing. With
loads between frames the few directions in which they stiffen it are added. Else, with many of them, contacts of
flexible bodies, or loops and loads, the Newton matrix is made from the Jacobian. Directions and Jacobians are kept over
steps as long as the iteration converges fast: see `generalised_alpha_systems`.

An iteration has a bounded number of evaluations. One of a fixed step that has come near enough is left there, and
counted; a free step is shortened. Free steps follow the third-order part of the move, filtered by the same matrix so
that modes that they do not resolve do not hold them down.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import ADVANCE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.directions_wanted import DIRECTIONS, MOST_DIRECTIONS, SHARE_OF_RATES
from kanefe.kernels.steppers.generalised_alpha_state import (
    AHEAD_SHARE,
    ALLOWED,
    AT_START,
    BEFORE,
    BEGUN,
    BETA,
    CHANGE,
    CORRECTION,
    ENDS,
    FACTORED,
    FIRST_UNCONVERGED,
    FOLLOWED,
    FOUND,
    HALVINGS,
    HAS_JACOBIAN,
    HAS_JERK,
    HAS_STIFFNESS,
    IS_FRESH,
    IS_WANTED,
    ITERATION,
    JERK,
    KNOWN,
    LARGEST_LEFT,
    LAST_UNCONVERGED,
    LEFT,
    MEMORY,
    MIXED_FROM,
    NEW,
    RESIDUAL,
    STEP_BEFORE,
    STEP_OF_A,
    TAKES_JACOBIAN,
    TRIED,
    UNCONVERGED,
    know_step,
    push_by,
    put_ahead,
    put_end,
    reach,
)
from kanefe.kernels.steppers.generalised_alpha_systems import are_factored, factorise_newton, solve_newton
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING, mix
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    COORDINATES,
    DONE,
    ERROR,
    EVALUATIONS,
    FAILED,
    HAS_LOOPS,
    IMPLICIT,
    IS_FIXED,
    JACOBIAN,
    JACOBIANS,
    NEXT_OUTPUT,
    NEXT_STEP,
    NO_CONVERGENCE,
    PROJECT,
    RATES,
    REASON,
    REJECTED,
    RELATIVE,
    SHARE_STIFFNESS,
    SLOPE,
    SMALLEST,
    SPEEDS,
    STAGE,
    STATE,
    STEP,
    STOP,
    TIME,
    TIME_AT,
    TOO_SMALL,
    accept,
    ask,
    clip,
    even_part,
    has_jumped,
    largest_share,
)

FIRST_SHARE = 1e-4
"""First step of a run that chooses its steps, relative to its length."""

LARGEST_ITERATIONS, LARGEST_IF_FIXED = 8, 20
"""Largest number of iterations of a step, which is then shortened, and of a fixed step."""

CONVERGED = 1e-3
"""Largest correction that is the last one, in the displacement that it causes, relative to the error allowed."""

NEAR = 1e4
"""Largest correction, relative to the same, with which a fixed step is left: a thousandth of the bodies' size."""

SLOW = 0.25
"""Convergence rate above which an iteration has a new Jacobian."""

KEPT = 1.2
"""Growth of the step up to which the step and the factors are kept."""

MOST_HALVINGS = 4
"""Number of times that a Newton step is halved."""

# Where to go on
BEGIN, FIRST, AHEAD, OF_JERK, MADE, JERK_FILTERED, ITERATED, DIFFERENTIATED, FILTERED, AFTER, PROJECTED = range(11)


@kernel
def _ask_end(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Ask for the accelerations at the end of the step."""
    put_end(integers, reals, vectors, table)
    is_plain = integers[TAKES_JACOBIAN] and integers[MOST_DIRECTIONS] == 0
    return ask(integers, RATES if is_plain else IMPLICIT, ITERATED)


@kernel
def _up_to_output(integers: np.ndarray, reals: np.ndarray, wanted: float) -> float:
    """Return the step that is wanted, or a shorter one, so that free steps end at outputs.

    Within a step, modes that it does not resolve are not known: their energy there would be that of the interpolation.
    """
    rest = reals[NEXT_OUTPUT] - reals[TIME]
    return wanted if integers[IS_FIXED] or not reals[SMALLEST] < rest < np.inf else even_part(wanted, rest)


@kernel
def _begin_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Begin a step, or the same step again with another length; first see to the rate of change of a."""
    clip(integers, reals, _up_to_output(integers, reals, reals[NEXT_STEP]))
    know_step(integers, reals, vectors, table)
    integers[ITERATION] = integers[MIXED_FROM] = integers[IS_FRESH] = integers[HALVINGS] = 0
    if not integers[HAS_JERK] and integers[SPEEDS] > 0:
        put_ahead(integers, reals, vectors)
        return ask(integers, RATES, AHEAD)
    return _ask_end(integers, reals, vectors, table)


@kernel
def _filter(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, row: int, stage: int) -> int:
    """Take from a row of accelerations what the step does not resolve; what it asks for to do so, or 0 if it is done.

    The state AT has the accelerations du: with pushes by du - x a linearly implicit evaluation gives
    ``du - x + (M + s C + r K)^-1 M x``.
    """
    n, m = integers[COORDINATES], integers[SPEEDS]
    if integers[TAKES_JACOBIAN] and integers[MOST_DIRECTIONS] == 0:
        _solve_filter(integers, reals, vectors, row)
        return 0
    if not (integers[TAKES_JACOBIAN] or integers[HAS_STIFFNESS]):
        return 0
    for i in range(n, n + m):
        vectors[CHANGE, i] = vectors[FOUND, i] - vectors[row, i]
    push_by(integers, reals, vectors, vectors[CHANGE])
    return ask(integers, IMPLICIT, stage)


@kernel
def _solve_filter(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, row: int) -> None:
    if are_factored(integers, reals) or factorise_newton(integers, reals, vectors):
        solve_newton(integers, vectors, vectors[row])


@kernel
def _take_filtered(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, row: int) -> None:
    n = integers[COORDINATES]
    for i in range(n, n + integers[SPEEDS]):
        vectors[row, i] = vectors[SLOPE, i] - vectors[CHANGE, i]
    if integers[TAKES_JACOBIAN]:
        _solve_filter(integers, reals, vectors, row)


@kernel
def _size(integers: np.ndarray, vectors: np.ndarray, weight: float, change: np.ndarray) -> float:
    """Write a change of the unknowns, weighted if of accelerations, in what is allowed; return the largest part."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    end = n + m + integers[FOLLOWED]
    for i in range(n, end):
        vectors[RESIDUAL, i] = (weight if i < n + m else 1.0) * change[i] / vectors[ALLOWED, i]
    return largest_share(integers, vectors[RESIDUAL], n, end)


@kernel
def _shorten(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, step: float) -> int:
    """Try a shorter step; fixed ones are not."""
    integers[REASON], integers[IS_WANTED] = NO_CONVERGENCE, 1
    if integers[IS_FIXED]:
        if not integers[TAKES_JACOBIAN] or integers[IS_FRESH]:
            return ask(integers, FAILED, AFTER)
        know_step(integers, reals, vectors, table)  # the Jacobian of an earlier state may be what is wrong
        integers[ITERATION] = integers[MIXED_FROM] = integers[HALVINGS] = 0
        return _ask_end(integers, reals, vectors, table)
    integers[REJECTED] += 1
    integers[REASON] = TOO_SMALL
    reals[NEXT_STEP] = step
    if step < reals[SMALLEST]:
        return ask(integers, FAILED, AFTER)
    return _begin_step(integers, reals, vectors, table)


@kernel
def _go_on_or_leave(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, size: float
) -> int:
    """Ask for another iteration, accept a fixed step that is near enough, or have it shorter."""
    integers[ITERATION] += 1
    most = LARGEST_IF_FIXED if integers[IS_FIXED] else LARGEST_ITERATIONS
    if not integers[IS_FIXED] and integers[ITERATION] > 2 and size > reals[CORRECTION]:
        most = 0
    if integers[ITERATION] < most:
        reals[CORRECTION] = size
        return _ask_end(integers, reals, vectors, table)
    if not integers[IS_FIXED] or size > NEAR:
        return _shorten(integers, reals, vectors, table, 0.25 * reals[STEP])
    if integers[UNCONVERGED] == 0:
        reals[FIRST_UNCONVERGED] = reals[TIME_AT]
    integers[UNCONVERGED] += 1
    reals[LAST_UNCONVERGED] = reals[TIME_AT]
    reals[LARGEST_LEFT] = max(reals[LARGEST_LEFT], size)
    return _finish(integers, reals, vectors, table)


@kernel
def _needs_jacobian(integers: np.ndarray, reals: np.ndarray, is_differentiated: bool) -> bool:
    """Return whether there is no Jacobian, or no directions for this length of the step."""
    is_old = integers[MOST_DIRECTIONS] > 0 and not (is_differentiated or are_factored(integers, reals))
    return bool(integers[IS_WANTED] or is_old or not integers[HAS_JACOBIAN])


@kernel
def _iterate(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, is_differentiated: bool
) -> int:
    """Take the iteration that a linearly implicit evaluation has done, with what directions of loads add."""
    n, m, change = integers[COORDINATES], integers[SPEEDS], vectors[CHANGE]
    for i in range(n, n + m):
        change[i] = vectors[SLOPE, i] - vectors[FOUND, i]
    if integers[TAKES_JACOBIAN]:
        if _needs_jacobian(integers, reals, is_differentiated):
            return _ask_jacobian(integers, DIFFERENTIATED)
        if not (are_factored(integers, reals) or factorise_newton(integers, reals, vectors)):
            return _shorten(integers, reals, vectors, table, 0.5 * reals[STEP])
        solve_newton(integers, vectors, change)
    size = _size(integers, vectors, reals[SHARE_STIFFNESS], change)
    if not size < np.inf:
        return _shorten(integers, reals, vectors, table, 0.25 * reals[STEP])
    is_slow = integers[ITERATION] > 0 and size > max(CONVERGED, SLOW * reals[CORRECTION])
    if is_slow and integers[TAKES_JACOBIAN] and not integers[IS_FRESH]:
        integers[MIXED_FROM] = integers[ITERATION]
        return _ask_jacobian(integers, DIFFERENTIATED)
    copy(vectors[FOUND], vectors[NEW])
    for i in range(n, n + m):
        vectors[NEW, i] += change[i]
    if size <= CONVERGED:
        copy(vectors[NEW, n : n + m], vectors[FOUND, n : n + m])
        return _finish(integers, reals, vectors, table)
    memory, call = vectors[MEMORY : MEMORY + ROWS_OF_MIXING], integers[ITERATION] - integers[MIXED_FROM]
    mix(memory, call, vectors[RESIDUAL], vectors[NEW], vectors[FOUND])
    return _go_on_or_leave(integers, reals, vectors, table, size)


@kernel
def _correct(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, is_differentiated: bool
) -> int:
    """Take a Newton step, after seeing to its matrix, or go back half of the last one if that has led away.

    Away is where the same matrix gives a larger correction (Deuflhard, Newton Methods for Nonlinear Problems, 2011,
    3.1): friction that begins to hold, or a contact that closes, sends Newton's method to and fro.
    """
    n, m, change = integers[COORDINATES], integers[SPEEDS], vectors[TRIED]
    end = n + m + integers[FOLLOWED]
    if _needs_jacobian(integers, reals, is_differentiated):
        return _ask_jacobian(integers, DIFFERENTIATED)
    if not (are_factored(integers, reals) or factorise_newton(integers, reals, vectors)):
        return _shorten(integers, reals, vectors, table, 0.5 * reals[STEP])
    for i in range(n, n + m):
        change[i] = vectors[FOUND, i] - vectors[SLOPE, i]
    for i in range(n + m, end):
        change[i] = vectors[FOUND, i] - vectors[KNOWN, i] - reals[SHARE_OF_RATES] * vectors[SLOPE, i]
    solve_newton(integers, vectors, change)
    size = _size(integers, vectors, reals[SHARE_STIFFNESS], change)
    if not size < np.inf:
        return _shorten(integers, reals, vectors, table, 0.25 * reals[STEP])
    share = 1.0
    if integers[ITERATION] > 0 and size > CONVERGED and not is_differentiated:
        if integers[IS_FIXED] and size > reals[CORRECTION] and integers[HALVINGS] < MOST_HALVINGS:
            integers[HALVINGS] += 1
            share = -0.5
        elif size > SLOW * reals[CORRECTION] and (integers[IS_FIXED] or not integers[IS_FRESH]):
            return _ask_jacobian(integers, DIFFERENTIATED)
    if share > 0.0:
        copy(change[n:end], vectors[CHANGE, n:end])
        integers[HALVINGS] = 0
    for i in range(n, end):
        vectors[CHANGE, i] *= abs(share)
        vectors[FOUND, i] -= vectors[CHANGE, i] if share > 0.0 else -vectors[CHANGE, i]
    if size <= CONVERGED:
        return _finish(integers, reals, vectors, table)
    return _go_on_or_leave(integers, reals, vectors, table, size if share > 0.0 else reals[CORRECTION])


@kernel
def _ask_jacobian(integers: np.ndarray, stage: int) -> int:
    """Ask for the Jacobian, or the directions, of the state that was evaluated last."""
    integers[JACOBIANS] += 1
    if integers[MOST_DIRECTIONS] == 0:
        return ask(integers, JACOBIAN, stage)
    integers[EVALUATIONS] += 1
    return ask(integers, DIRECTIONS, stage)


@kernel
def _take_jacobian(integers: np.ndarray, reals: np.ndarray) -> None:
    integers[HAS_JACOBIAN], integers[IS_FRESH], integers[IS_WANTED] = 1, 1, 0
    reals[FACTORED] = 0.0


@kernel
def _finish(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Write the end of the step, and find its error where it is not fixed."""
    n, h = integers[COORDINATES], reals[STEP]
    reach(integers, reals, vectors, table, vectors[NEW])
    for i in range(vectors.shape[1] - 2, vectors.shape[1]):
        vectors[NEW, i] = vectors[STATE, i] + 0.5 * h * (vectors[KNOWN, i] + vectors[SLOPE, i])
        vectors[FOUND, i] = vectors[SLOPE, i]
    if integers[IS_FIXED]:
        return _accept(integers, reals, vectors)
    end = n + integers[SPEEDS]
    third = (table[0, BETA] - 1.0 / 6.0) * h * h / reals[SHARE_STIFFNESS]
    for i in range(n, end):
        vectors[TRIED, i] = third * (vectors[ENDS, i] - vectors[BEGUN, i])
    for i in range(end, end + integers[FOLLOWED]):
        rates = vectors[LEFT, i] + (vectors[FOUND, i] - vectors[KNOWN, i]) / reals[SHARE_OF_RATES]
        vectors[TRIED, i] = vectors[FOUND, i] - vectors[AT_START, i] - 0.5 * h * rates
        vectors[CHANGE, i] = np.sqrt(reals[RELATIVE]) * vectors[TRIED, i]
    asked = _filter(integers, reals, vectors, TRIED, FILTERED)
    return asked if asked != 0 else _judge(integers, reals, vectors, table)


@kernel
def _judge(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Accept or reject a step by its error, and choose the next one.

    The error is the third-order part of the move, with what the move has from the errors of internal states, their
    difference to the trapezoidal rule: both have passed the matrix. States themselves are kept to the root of the
    tolerance, for those that are of interest and move nothing.
    """
    n, h = integers[COORDINATES], reals[STEP]
    end = n + integers[SPEEDS]
    copy(vectors[CHANGE, end : end + integers[FOLLOWED]], vectors[TRIED, end : end + integers[FOLLOWED]])
    error = _size(integers, vectors, reals[SHARE_STIFFNESS], vectors[TRIED])
    reals[ERROR] = error
    if not error <= 1.0:
        return _shorten(integers, reals, vectors, table, h * max(0.2, 0.9 * error ** (-1.0 / 3.0)))
    grown = h * min(2.0, 0.9 * max(error, 1e-6) ** (-1.0 / 3.0))
    if integers[TAKES_JACOBIAN] and h <= grown <= KEPT * h:
        grown = h
    # a step cut short says little about the next one
    reals[NEXT_STEP] = max(grown, reals[NEXT_STEP]) if h < reals[NEXT_STEP] else grown
    return _accept(integers, reals, vectors)


@kernel
def _accept(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the step; what the next one begins with stays."""
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    for i in range(n, n + m):
        vectors[JERK, i] = (vectors[ENDS, i] - vectors[BEGUN, i]) / h
        vectors[LEFT, i] = vectors[ENDS, i]
    integers[HAS_JERK], reals[STEP_OF_A], reals[STEP_BEFORE] = 1, h, h
    for i in range(n + m, n + m + integers[FOLLOWED]):
        vectors[LEFT, i] = (vectors[FOUND, i] - vectors[KNOWN, i]) / reals[SHARE_OF_RATES]
    for i in range(n, n + m + integers[FOLLOWED]):
        vectors[BEFORE, i] = vectors[AT_START, i]
        vectors[AT_START, i] = vectors[FOUND, i]
    for i in range(vectors.shape[1] - 2, vectors.shape[1]):
        vectors[BEFORE, i] = vectors[KNOWN, i]
        vectors[KNOWN, i] = vectors[FOUND, i]
    ask(integers, ACCEPTED, AFTER)
    return accept(integers, reals, vectors, vectors[NEW])


@pointer(ADVANCE)
def advance_generalised_alpha(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    stage = integers[STAGE]
    n, m = integers[COORDINATES], integers[SPEEDS]
    if stage == AFTER:
        if integers[HAS_LOOPS]:
            return ask(integers, PROJECT, PROJECTED)
        stage = PROJECTED
    if stage == BEGIN or (stage == PROJECTED and has_jumped(integers, reals)):
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        return ask(integers, RATES, FIRST)
    if stage == FIRST:
        copy(vectors[SLOPE, n:], vectors[LEFT, n:])
        copy(vectors[SLOPE, n : n + m], vectors[AT_START, n : n + m])
        copy(vectors[STATE, n + m :], vectors[AT_START, n + m :])
        copy(vectors[SLOPE, len(vectors[SLOPE]) - 2 :], vectors[KNOWN, len(vectors[SLOPE]) - 2 :])
        integers[HAS_JERK], reals[STEP_OF_A], reals[STEP_BEFORE] = 0, 0.0, 0.0
        if reals[NEXT_STEP] <= 0.0:
            reals[NEXT_STEP] = FIRST_SHARE * (reals[STOP] - reals[TIME])
        stage = PROJECTED
    if stage == PROJECTED:
        for i in range(n + m, n + m + integers[FOLLOWED]):
            vectors[AT_START, i] = vectors[STATE, i]
        if reals[TIME] >= reals[STOP]:
            return ask(integers, DONE, AFTER)
        return _begin_step(integers, reals, vectors, table)
    if stage in (ITERATED, DIFFERENTIATED):
        if stage == DIFFERENTIATED:
            _take_jacobian(integers, reals)
        # friction that begins to hold is not smooth: nothing is to be learnt for it from the last iterations
        if integers[TAKES_JACOBIAN] and (integers[MOST_DIRECTIONS] == 0 or integers[FOLLOWED] > 0):
            return _correct(integers, reals, vectors, table, stage == DIFFERENTIATED)
        return _iterate(integers, reals, vectors, table, stage == DIFFERENTIATED)
    if stage == FILTERED:
        _take_filtered(integers, reals, vectors, TRIED)
        return _judge(integers, reals, vectors, table)
    if stage == AHEAD:
        for i in range(n, n + m):
            vectors[JERK, i] = (vectors[SLOPE, i] - vectors[AT_START, i]) / (AHEAD_SHARE * reals[STEP])
            vectors[FOUND, i] = vectors[AT_START, i]
        vectors[JERK, n + m : n + m + integers[FOLLOWED]] = 0.0
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        is_made = integers[HAS_JACOBIAN] and (integers[MOST_DIRECTIONS] == 0 or are_factored(integers, reals))
        if integers[TAKES_JACOBIAN] and not is_made:
            return _ask_jacobian(integers, OF_JERK)
        stage = MADE
    elif stage == OF_JERK:
        _take_jacobian(integers, reals)
        integers[IS_FRESH] = 0  # it is that of the start
        stage = MADE
    if stage == MADE:
        asked = _filter(integers, reals, vectors, JERK, JERK_FILTERED)
        if asked != 0:
            return asked
    else:  # JERK_FILTERED
        _take_filtered(integers, reals, vectors, JERK)
    integers[HAS_JERK] = 1
    know_step(integers, reals, vectors, table)
    return _ask_end(integers, reals, vectors, table)
