"""Radau IIA of order 5: three stages, implicit, stable for modes of any frequency and damping.

Changes Z of the state at three nodes satisfy ``Z = h (A x I) F(Z)``. A transformation of the stages makes one real and
one complex system of the size of the state out of the Newton matrix (Hairer & Wanner, Solving Ordinary Differential
Equations II, 1996, IV.8, also for the choice of steps, for the error estimate and for when matrices are kept):

    (g - J) x = r,    g = gamma / h and (alpha + i beta) / h,    J = d(dy/dt)/dy.

`kanefe.kernels.steppers.radau_systems` reduces both to the size of the speeds. Euler parameters are integrated as they
are, and brought back to unit length after each step.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import ADVANCE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.radau_polynomial import (
    CHANGES,
    CORRECTION,
    DIFFERENTIATED_STEP,
    EIGENVALUES,
    ESTIMATE,
    FACTORED,
    FARTHEST,
    HAS_POLYNOMIAL,
    INVERSE,
    IS_FIRST,
    IS_FRESH,
    IS_WANTED,
    ITERATION,
    NODE,
    NODES,
    OLD_ERROR,
    OLD_STEP,
    POLYNOMIAL,
    POLYNOMIAL_STEP,
    RATE_OF_CONVERGENCE,
    RATES_AT,
    RATIO,
    REMAINING,
    STAGES,
    START,
    TRANSFORMED,
    WAS_REJECTED,
    WEIGHTS,
    T,
    guess_changes,
    normalise,
)
from kanefe.kernels.steppers.radau_systems import factorise_systems, solve_complex, solve_real
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    CONTINUES,
    DONE,
    ERROR,
    FAILED,
    HAS_LOOPS,
    IS_FIXED,
    JACOBIAN,
    JACOBIANS,
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
    first_step,
    has_jumped,
    scaled_size,
)

LARGEST_ITERATIONS, LARGEST_IF_FIXED = 7, 30
"""Largest number of iterations of a step, which is then shortened, and of a fixed step."""

SLOW = 0.1
"""Convergence rate above which the Jacobian is computed again for the next step. It is large, since a Jacobian costs
two to four evaluations per speed, and an iteration three."""

OUTGROWN = 10.0
"""Growth of the step since the last Jacobian that requires a new one. If stiffness has disappeared, such as that of a
contact, an iteration seems to converge, because its matrix makes the remaining correction look small."""

KEPT = 1.2
"""Growth of the step up to which the step and the factors are kept."""

SAME = 1e-6
"""Difference of two steps, relative to them, that factors are kept over: those between samples differ by round-off, and
the rate at which an iteration converges changes by no more than that."""

ANEW, HELD_JUMPS = 1, 2
"""Number that tells of the first step whether it follows a start, an event or a jump; or a sample, where what is held
changes."""

SAFETY = 0.9

LONGER, SHORTER = 8.0, 0.2

# Where to go on
BEGIN, FIRST, DIFFERENTIATED, ITERATING, REFINED, AFTER, PROJECTED = range(7)

# What comes of an iteration
GOES_ON, CONVERGED, DIVERGED = range(3)


@kernel
def _transform(table: np.ndarray, first: int, vectors: np.ndarray, source: int, target: int) -> None:
    """Write the products of a 3 x 3 matrix of the table with rows of vectors, also in place."""
    a, b, c = vectors[source], vectors[source + 1], vectors[source + 2]
    for i in range(vectors.shape[1]):
        x, y, z = a[i], b[i], c[i]
        for k in range(STAGES):
            vectors[target + k, i] = table[first + k, 0] * x + table[first + k, 1] * y + table[first + k, 2] * z


@kernel
def _shorten(integers: np.ndarray, reals: np.ndarray, share: float) -> bool:
    """Choose a share of the step for another try of it; return whether there is one."""
    integers[REJECTED] += 1
    integers[IS_WANTED] = reals[RATE_OF_CONVERGENCE] > SLOW and not integers[IS_FRESH]
    if integers[IS_FIXED]:  # the Jacobian of an earlier state may be what is wrong
        integers[REASON] = NO_CONVERGENCE
        return not integers[IS_FRESH]
    integers[REASON] = TOO_SMALL
    reals[NEXT_STEP] = share * reals[STEP]
    clip(integers, reals, reals[NEXT_STEP])
    return reals[NEXT_STEP] >= reals[SMALLEST]


@kernel
def _begin_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Begin a step, or the same step again with another length: see to its matrices, guess its changes."""
    while True:
        if integers[IS_WANTED] or (reals[STEP] > OUTGROWN * reals[DIFFERENTIATED_STEP] and not integers[IS_FRESH]):
            integers[JACOBIANS] += 1
            copy(vectors[STATE], vectors[AT])
            reals[TIME_AT] = reals[TIME]
            return ask(integers, JACOBIAN, DIFFERENTIATED)
        if abs(reals[FACTORED] - reals[STEP]) <= SAME * reals[STEP]:
            break
        if factorise_systems(integers, reals, vectors, table):
            break
        reals[RATE_OF_CONVERGENCE] = np.inf
        if not _shorten(integers, reals, 0.5):
            return ask(integers, FAILED, AFTER)
    guess_changes(integers, reals, vectors, table)
    _transform(table, INVERSE, vectors, CHANGES, TRANSFORMED)
    integers[ITERATION] = 0
    reals[RATE_OF_CONVERGENCE] = 0.0
    # of how a much shorter step has converged nothing is known for this one
    is_like_last = integers[HAS_POLYNOMIAL] and reals[STEP] <= FARTHEST * reals[POLYNOMIAL_STEP]
    reals[REMAINING] = max(reals[REMAINING], 1e-15) ** 0.8 if is_like_last else 1.0
    return _ask_node(integers, reals, vectors, table, 0)


@kernel
def _ask_node(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, node: int) -> int:
    integers[NODE] = node
    at, state, change = vectors[AT], vectors[STATE], vectors[CHANGES + node]
    for i in range(len(at)):
        at[i] = state[i] + change[i]
    reals[TIME_AT] = reals[TIME] + table[NODES, node] * reals[STEP]
    return ask(integers, RATES, ITERATING)


@kernel
def _correct(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> tuple[int, float]:
    """Take one simplified Newton iteration; return what comes of it and, where it diverges, a share of the step."""
    h = reals[STEP]
    gamma, alpha, beta = table[EIGENVALUES, 0] / h, table[EIGENVALUES, 1] / h, table[EIGENVALUES, 2] / h
    _transform(table, INVERSE, vectors, RATES_AT, RATES_AT)
    a, b, c = vectors[RATES_AT], vectors[RATES_AT + 1], vectors[RATES_AT + 2]
    for i in range(len(a)):
        second, third = vectors[TRANSFORMED + 1, i], vectors[TRANSFORMED + 2, i]
        a[i] -= gamma * vectors[TRANSFORMED, i]
        b[i] -= alpha * second - beta * third
        c[i] -= alpha * third + beta * second
    solve_real(integers, reals, vectors, table, a)
    solve_complex(integers, reals, vectors, table, b, c)
    size, state = 0.0, vectors[STATE]
    for k in range(STAGES):
        size = max(size, scaled_size(integers, reals, vectors, vectors[RATES_AT + k], state, state))
    if not size < np.inf:
        return DIVERGED, 0.5
    iteration = integers[ITERATION]
    integers[ITERATION] += 1
    enough = max(1e-14 / reals[RELATIVE], min(0.03, np.sqrt(reals[RELATIVE])))
    # what a jump of held drives does to stiff parts may push others once, by matrices of before: that tells no rate
    first = 2 if integers[IS_FIRST] == HELD_JUMPS and not integers[IS_FRESH] else 1
    if iteration >= first:
        ratio = size / reals[CORRECTION]
        rate = ratio if iteration == first else np.sqrt(ratio * reals[RATIO])
        reals[RATIO], reals[RATE_OF_CONVERGENCE] = ratio, rate
        if not rate < 0.99:
            return DIVERGED, 0.5
        reals[REMAINING] = rate / (1.0 - rate)
        left = (LARGEST_IF_FIXED if integers[IS_FIXED] else LARGEST_ITERATIONS) - 1 - iteration
        if left < 0:
            return DIVERGED, 0.5
        missed = reals[REMAINING] * size * rate**left / enough
        if missed >= 1.0:  # it would take too many iterations
            return DIVERGED, 0.8 * min(max(missed, 1e-4), 20.0) ** (-1.0 / (4.0 + left))
    reals[CORRECTION] = size
    for k in range(STAGES):
        transformed, correction = vectors[TRANSFORMED + k], vectors[RATES_AT + k]
        for i in range(len(transformed)):
            transformed[i] += correction[i]
    _transform(table, T, vectors, TRANSFORMED, CHANGES)
    return (CONVERGED if reals[REMAINING] * size <= enough else GOES_ON), 0.0


@kernel
def _error(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, rates: np.ndarray) -> float:
    """Return the size of the error: the difference to a formula of order 3, which stiff parts are filtered out of."""
    error, weights, h = vectors[ESTIMATE], table[WEIGHTS], reals[STEP]
    for i in range(len(error)):
        change = weights[0] * vectors[CHANGES, i]
        change += weights[1] * vectors[CHANGES + 1, i] + weights[2] * vectors[CHANGES + 2, i]
        error[i] = change / h + rates[i]
    solve_real(integers, reals, vectors, table, error)
    new = vectors[AT]
    for i in range(len(new)):
        new[i] = vectors[STATE, i] + vectors[CHANGES + 2, i]
    return scaled_size(integers, reals, vectors, error, vectors[STATE], new)


@kernel
def _try_again(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, share: float) -> int:
    """Begin the step again with a share of its length."""
    if _shorten(integers, reals, share):
        return _begin_step(integers, reals, vectors, table)
    return ask(integers, FAILED, AFTER)


@kernel
def _judge(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, error: float) -> int:
    """Accept or reject a step, and choose the next one."""
    h = reals[STEP]
    reals[ERROR] = error
    most = 2.0 * LARGEST_ITERATIONS
    safety = min(SAFETY, SAFETY * (1.0 + most) / (integers[ITERATION] + most))
    bounded = max(error, 1e-10)
    shrunk = bounded**0.25 / safety if error < np.inf else np.inf
    if not error < 1.0:
        integers[WAS_REJECTED] = 1
        share = 0.1 if integers[IS_FIRST] == ANEW else max(1.0 / shrunk, SHORTER)
        return _try_again(integers, reals, vectors, table, share)
    shrunk = min(max(shrunk, 1.0 / LONGER), 1.0 / SHORTER)
    if not integers[IS_FIRST]:  # Gustafsson's predictive controller
        foreseen = reals[OLD_STEP] / h * (bounded * bounded / reals[OLD_ERROR]) ** 0.25 / SAFETY
        shrunk = max(shrunk, min(max(foreseen, 1.0 / LONGER), 1.0 / SHORTER))
    reals[OLD_STEP], reals[OLD_ERROR] = h, max(1e-2, error)
    grown = h / shrunk
    if integers[WAS_REJECTED]:
        grown = min(grown, h)
    if reals[RATE_OF_CONVERGENCE] <= SLOW and h <= grown <= KEPT * h:
        grown = h
    # a step cut short says little about the next one
    reals[NEXT_STEP] = max(grown, reals[NEXT_STEP]) if h < reals[NEXT_STEP] else grown
    return _finish(integers, reals, vectors)


@kernel
def _finish(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the step; its polynomial stays."""
    for k in range(STAGES):
        copy(vectors[CHANGES + k], vectors[POLYNOMIAL + k])
    reals[POLYNOMIAL_STEP] = reals[STEP]
    integers[HAS_POLYNOMIAL], integers[IS_FIRST], integers[WAS_REJECTED], integers[IS_FRESH] = 1, 0, 0, 0
    integers[IS_WANTED] = reals[RATE_OF_CONVERGENCE] > SLOW
    new, last = vectors[AT], vectors[CHANGES + 2]
    for i in range(len(new)):
        new[i] = vectors[STATE, i] + last[i]
    normalise(integers, new)
    ask(integers, ACCEPTED, AFTER)
    return accept(integers, reals, vectors, new)


@pointer(ADVANCE)
def advance_radau(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    stage = integers[STAGE]
    if stage == ITERATING:
        node = integers[NODE]
        copy(vectors[SLOPE], vectors[RATES_AT + node])
        if node + 1 < STAGES:
            return _ask_node(integers, reals, vectors, table, node + 1)
        outcome, share = _correct(integers, reals, vectors, table)
        if outcome == GOES_ON:
            return _ask_node(integers, reals, vectors, table, 0)
        if outcome == DIVERGED:
            reals[RATE_OF_CONVERGENCE] = np.inf
            integers[WAS_REJECTED] = 1  # the error of what is left would ask for a step that fails again
            return _try_again(integers, reals, vectors, table, share)
        if integers[IS_FIXED]:
            return _finish(integers, reals, vectors)
        error = _error(integers, reals, vectors, table, vectors[START])
        if error >= 1.0 and (integers[IS_FIRST] or integers[WAS_REJECTED]):
            # once more from a state behind the transient, which the formula of order 3 does not damp well
            at = vectors[AT]
            for i in range(len(at)):
                at[i] = vectors[STATE, i] + vectors[ESTIMATE, i]
            reals[TIME_AT] = reals[TIME]
            return ask(integers, RATES, REFINED)
        return _judge(integers, reals, vectors, table, error)
    if stage == REFINED:
        return _judge(integers, reals, vectors, table, _error(integers, reals, vectors, table, vectors[SLOPE]))
    if stage == DIFFERENTIATED:
        integers[IS_WANTED], integers[IS_FRESH], reals[FACTORED] = 0, 1, 0.0
        reals[DIFFERENTIATED_STEP] = reals[STEP]
        return _begin_step(integers, reals, vectors, table)
    if stage == BEGIN and integers[CONTINUES] and reals[DIFFERENTIATED_STEP] > 0.0:
        # matrices and step are as good as before, but how the last iteration has converged tells nothing of the next
        integers[IS_FIRST], reals[REMAINING] = HELD_JUMPS, 1.0
    elif stage == BEGIN:
        integers[IS_FIRST], integers[IS_WANTED], integers[HAS_POLYNOMIAL] = ANEW, 1, 0
        reals[REMAINING] = 1.0
    if stage == FIRST:
        copy(vectors[SLOPE], vectors[START])
        if reals[NEXT_STEP] <= 0.0:
            reals[NEXT_STEP] = first_step(integers, reals, vectors, vectors[START])
        clip(integers, reals, reals[NEXT_STEP])
        return _begin_step(integers, reals, vectors, table)
    if stage == AFTER:
        reals[SHARE_STIFFNESS] = reals[STEP] ** 2  # in a metric of masses alone the loops would push stiff modes
        if reals[TIME] >= reals[STOP]:
            return ask(integers, DONE, AFTER)
        if integers[HAS_LOOPS]:
            return ask(integers, PROJECT, PROJECTED)
    if stage != BEGIN and has_jumped(integers, reals):
        # vibrations may begin, which a long step would damp unseen; the Jacobian is that of before
        integers[IS_FIRST], integers[HAS_POLYNOMIAL], reals[REMAINING], reals[NEXT_STEP] = ANEW, 0, 1.0, 0.0
    copy(vectors[STATE], vectors[AT])
    reals[TIME_AT] = reals[TIME]
    return ask(integers, RATES, FIRST)
