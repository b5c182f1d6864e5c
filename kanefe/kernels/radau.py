"""Radau IIA of order 5: three stages, implicit, stable for modes of any frequency and damping.

Changes Z of the state at three nodes satisfy ``Z = h (A x I) F(Z)``. A transformation of the stages makes one real and
one complex system of the size of the state out of the Newton matrix (Hairer & Wanner, Solving Ordinary Differential
Equations II, 1996, IV.8, also for the choice of steps, for the error estimate and for when matrices are kept):

    (g - J) x = r,    g = gamma / h and (alpha + i beta) / h,    J = d(dy/dt)/dy.

Coordinates follow the speeds, ``dq/dt = T(q) u``, and are eliminated by hand, so that matrices have the size of the
speeds. With tangents z of the rotations, ``dq = T z``, and dR/dt = f(q, u) of speeds and quadratures,

    (g - f_u - f_z Z) du = r_u + f_z z_r,    Z = (g - w~/2) / (g^2 + w^2/4) of a rotation, 1 / g else.

Euler parameters are integrated as they are, and brought back to unit length after each step.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.lu import factorise, solve
from kanefe.kernels.stepping import (
    ACCEPTED,
    AT,
    COORDINATES,
    DONE,
    ERROR,
    FACTORISATIONS,
    FAILED,
    HAS_LOOPS,
    IS_FIXED,
    JACOBIAN,
    JACOBIANS,
    MAP,
    MAP_SIZE,
    NEXT_STEP,
    NO_CONVERGENCE,
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
    SPEEDS,
    STAGE,
    STATE,
    STATE_OLD,
    STEP,
    STOP,
    STRAIGHT,
    TIME,
    TIME_AT,
    TIME_OLD,
    TOO_SMALL,
    accept,
    ask,
    clip,
    first_step,
    scaled_size,
)
from kanefe.kernels.vectors import copy

STAGES = 3

LARGEST_ITERATIONS, LARGEST_IF_FIXED = 7, 30
"""Iterations of a step, which is shortened if they do not do, and of one that cannot be."""

SLOW = 1e-2
"""Rate of convergence above which the Jacobian is made anew for the next step."""

KEPT = 1.2
"""Growth of the step up to which it and the factors are kept."""

SAFETY = 0.9

LONGER, SHORTER = 8.0, 0.2

# Integers of the method: node and iteration in work; whether no step has been accepted since the start, the last try
# was rejected, the Jacobian is that of this state, is wanted, and a step's polynomial is there to extrapolate
NODE, ITERATION, IS_FIRST, WAS_REJECTED, IS_FRESH, IS_WANTED, HAS_POLYNOMIAL = range(OF_METHOD, OF_METHOD + 7)

# Reals of the method: step of the factors (0: none) and of the polynomial, sizes of the last two corrections, rate of
# convergence, its share of the remaining error, step and error of the last accepted step
FACTORED, POLYNOMIAL_STEP, CORRECTION, RATIO, RATE_OF_CONVERGENCE, REMAINING, OLD_STEP, OLD_ERROR = range(
    REALS_OF_METHOD, REALS_OF_METHOD + 8
)
REALS = REALS_OF_METHOD + 8

# Rows of the method: rates at the start of the step, changes Z at the nodes, the same transformed, rates at the nodes,
# Z of the last accepted step, error, room for a complex vector of the state and for two of the speeds, rates of
# rotations with which the matrices were made, the Jacobian (derivatives of the speeds' and quadratures' rates by
# tangents, then by speeds); and the factors
START = ROWS_OF_METHOD
CHANGES = START + 1
TRANSFORMED = CHANGES + STAGES
RATES_AT = TRANSFORMED + STAGES
POLYNOMIAL = RATES_AT + STAGES
ESTIMATE = POLYNOMIAL + STAGES
ROOM = ESTIMATE + 1
TURNS = ROOM + 4
JACOBIAN_ROWS = TURNS + 1

# Rows of the table: nodes, T and its inverse, weights of the error estimate, and gamma, alpha, beta
NODES, T, INVERSE, WEIGHTS, EIGENVALUES = 0, 1, 1 + STAGES, 1 + 2 * STAGES, 2 + 2 * STAGES

# Where to go on
BEGIN, FIRST, DIFFERENTIATED, ITERATING, REFINED, AFTER, PROJECTED = range(7)

# What comes of an iteration
GOES_ON, CONVERGED, DIVERGED = range(3)


def rows_needed() -> tuple[int, int]:
    """Return how many rows of vectors the method takes: so many, and so many for every speed.

    A row has at least two numbers for every speed, and two more: one for each row of the Jacobian, and two for three
    squares of factors with their pivots.
    """
    return JACOBIAN_ROWS + 2, 3


@inlined
def _first_factor(integers: np.ndarray, vectors: np.ndarray) -> int:
    """Return where among all numbers of the vectors the factors are: m x m real, m pivots, m x m complex, m pivots."""
    return (JACOBIAN_ROWS + integers[SPEEDS] + 2) * vectors.shape[1]


@inlined
def _turned(g: complex, w: np.ndarray, speed: int, a: tuple) -> tuple:
    """Return ``(g - J)^-1 a`` of Euler parameters, whose rates are half their product with the angular velocity w."""
    x, y, z = 0.5 * w[speed], 0.5 * w[speed + 1], 0.5 * w[speed + 2]
    share = 1.0 / (g * g + (x * x + y * y + z * z))
    return (
        share * (g * a[0] - a[1] * x - a[2] * y - a[3] * z),
        share * (g * a[1] + a[0] * x + a[2] * z - a[3] * y),
        share * (g * a[2] + a[0] * y + a[3] * x - a[1] * z),
        share * (g * a[3] + a[0] * z + a[1] * y - a[2] * x),
    )


@kernel
def _assemble(integers: np.ndarray, vectors: np.ndarray, g: complex, A: np.ndarray) -> None:
    """Write ``g - f_u - f_z Z``."""
    m, w = integers[SPEEDS], vectors[TURNS]
    for i in range(m):
        by_tangents, by_speeds = vectors[JACOBIAN_ROWS + i, :m], vectors[JACOBIAN_ROWS + i, m : 2 * m]
        for j in range(m):
            A[i, j] = -by_speeds[j]
        A[i, i] += g
        for row in range(integers[MAP_SIZE]):
            kind, s = integers[MAP + 3 * row], integers[MAP + 3 * row + 2]
            if kind == STRAIGHT:
                A[i, s] -= by_tangents[s] / g
                continue
            x, y, z = 0.5 * w[s], 0.5 * w[s + 1], 0.5 * w[s + 2]
            a, b, c = by_tangents[s], by_tangents[s + 1], by_tangents[s + 2]
            share = 1.0 / (g * g + (x * x + y * y + z * z))
            A[i, s] -= share * (g * a + y * c - z * b)
            A[i, s + 1] -= share * (g * b + z * a - x * c)
            A[i, s + 2] -= share * (g * c + x * b - y * a)


@kernel
def _tangents(integers: np.ndarray, q: np.ndarray, r: np.ndarray, z: np.ndarray) -> None:
    """Write the tangents z of changes r of the coordinates."""
    for row in range(integers[MAP_SIZE]):
        kind, at, s = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], integers[MAP + 3 * row + 2]
        if kind == STRAIGHT:
            z[s] = r[at]
            continue
        e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
        z[s] = 2.0 * (e0 * r[at + 1] - e1 * r[at] + e3 * r[at + 2] - e2 * r[at + 3])
        z[s + 1] = 2.0 * (e0 * r[at + 2] - e2 * r[at] + e1 * r[at + 3] - e3 * r[at + 1])
        z[s + 2] = 2.0 * (e0 * r[at + 3] - e3 * r[at] + e2 * r[at + 1] - e1 * r[at + 2])


@kernel
def _divide(integers: np.ndarray, vectors: np.ndarray, g: complex, r: np.ndarray) -> None:
    """Replace changes r of the coordinates by ``(g - J)^-1 r``, with J of the coordinates alone."""
    w = vectors[TURNS]
    for row in range(integers[MAP_SIZE]):
        kind, at, s = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], integers[MAP + 3 * row + 2]
        if kind == STRAIGHT:
            r[at] = r[at] / g
        else:
            turned = _turned(g, w, s, (r[at], r[at + 1], r[at + 2], r[at + 3]))
            r[at], r[at + 1], r[at + 2], r[at + 3] = turned


@kernel
def _follow(integers: np.ndarray, vectors: np.ndarray, g: complex, du: np.ndarray, r: np.ndarray) -> None:
    """Add to changes r of the coordinates what changes of the speeds bring, ``(g - J)^-1 T du``."""
    q, w = vectors[STATE], vectors[TURNS]
    for row in range(integers[MAP_SIZE]):
        kind, at, s = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], integers[MAP + 3 * row + 2]
        if kind == STRAIGHT:
            r[at] += du[s] / g
            continue
        e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
        x, y, z = 0.5 * du[s], 0.5 * du[s + 1], 0.5 * du[s + 2]
        rates = (
            -(e1 * x + e2 * y + e3 * z),
            e0 * x + e2 * z - e3 * y,
            e0 * y + e3 * x - e1 * z,
            e0 * z + e1 * y - e2 * x,
        )
        turned = _turned(g, w, s, rates)
        r[at] += turned[0]
        r[at + 1] += turned[1]
        r[at + 2] += turned[2]
        r[at + 3] += turned[3]


@kernel
def _solve(
    integers: np.ndarray,
    vectors: np.ndarray,
    g: complex,
    A: np.ndarray,
    pivots: np.ndarray,
    z: np.ndarray,
    du: np.ndarray,
    r: np.ndarray,
) -> None:
    """Replace r, of the length of the state, by ``(g - J)^-1 r``; A holds factors, z and du are room."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    q = vectors[STATE]
    _divide(integers, vectors, g, r)
    _tangents(integers, q, r, z)
    for i in range(m):
        du[i] = r[n + i]
        for j in range(m):
            du[i] += vectors[JACOBIAN_ROWS + i, j] * z[j]
    solve(A, pivots, du)
    copy(du, r[n : n + m])
    _follow(integers, vectors, g, du, r)
    _tangents(integers, q, r, z)
    for i in range(m, len(r) - n):  # quadratures
        row = vectors[JACOBIAN_ROWS + i]
        total = r[n + i]
        for j in range(m):
            total += row[j] * z[j] + row[m + j] * du[j]
        r[n + i] = total / g


@kernel
def _factorise(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> bool:
    """Make the factors for the step; tell whether there are any."""
    m, h = integers[SPEEDS], reals[STEP]
    n = integers[COORDINATES]
    copy(vectors[STATE, n : n + m], vectors[TURNS, :m])
    memory = vectors.reshape(-1)[_first_factor(integers, vectors) :]
    A = memory[: m * m].reshape(m, m)
    _assemble(integers, vectors, table[EIGENVALUES, 0] / h, A)
    is_regular = factorise(A, memory[m * m :])
    memory = memory[m * m + m :]
    B = memory[: 2 * m * m].view(np.complex128).reshape(m, m)
    _assemble(integers, vectors, complex(table[EIGENVALUES, 1] / h, table[EIGENVALUES, 2] / h), B)
    is_regular = factorise(B, memory[2 * m * m :]) and is_regular
    integers[FACTORISATIONS] += 1
    reals[FACTORED] = h if is_regular else 0.0
    return is_regular


@kernel
def _solve_real(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, r: np.ndarray) -> None:
    """Replace r by the solution of the real system."""
    m = integers[SPEEDS]
    memory, g = vectors.reshape(-1)[_first_factor(integers, vectors) :], table[EIGENVALUES, 0] / reals[FACTORED]
    z, du = vectors[ROOM + 2, :m], vectors[ROOM + 3, :m]
    _solve(integers, vectors, g, memory[: m * m].reshape(m, m), memory[m * m :], z, du, r)


@kernel
def _solve_complex(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, a: np.ndarray, b: np.ndarray
) -> None:
    """Replace ``a + i b`` by the solution of the complex system."""
    m, size = integers[SPEEDS], len(a)
    memory = vectors.reshape(-1)[_first_factor(integers, vectors) + m * m + m :]
    g = complex(table[EIGENVALUES, 1] / reals[FACTORED], table[EIGENVALUES, 2] / reals[FACTORED])
    B = memory[: 2 * m * m].view(np.complex128).reshape(m, m)
    r = vectors[ROOM : ROOM + 2].reshape(-1).view(np.complex128)
    z, du = vectors[ROOM + 2, : 2 * m].view(np.complex128), vectors[ROOM + 3, : 2 * m].view(np.complex128)
    for i in range(size):
        r[i] = complex(a[i], b[i])
    _solve(integers, vectors, g, B, memory[2 * m * m :], z, du, r)
    for i in range(size):
        a[i], b[i] = r[i].real, r[i].imag


@inlined
def _weight(table: np.ndarray, j: int, x: float) -> float:
    """Return at x, of the step, the polynomial that is one at node j and zero at the start and the other nodes."""
    nodes = table[NODES]
    weight = x / nodes[j]
    for k in range(STAGES):
        if k != j:
            weight *= (x - nodes[k]) / (nodes[j] - nodes[k])
    return weight


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
    """Choose a share of the step for another try of it; tell whether there is one."""
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
        if integers[IS_WANTED]:
            integers[JACOBIANS] += 1
            return ask(integers, JACOBIAN, DIFFERENTIATED)
        if reals[FACTORED] == reals[STEP] or _factorise(integers, reals, vectors, table):
            break
        reals[RATE_OF_CONVERGENCE] = np.inf
        if not _shorten(integers, reals, 0.5):
            return ask(integers, FAILED, AFTER)
    if integers[HAS_POLYNOMIAL]:
        ahead = reals[STEP] / reals[POLYNOMIAL_STEP]
        for k in range(STAGES):
            x = 1.0 + table[NODES, k] * ahead
            a, b, c = _weight(table, 0, x), _weight(table, 1, x), _weight(table, 2, x) - 1.0
            change = vectors[CHANGES + k]
            for i in range(len(change)):
                change[i] = a * vectors[POLYNOMIAL, i] + b * vectors[POLYNOMIAL + 1, i] + c * vectors[POLYNOMIAL + 2, i]
    else:
        vectors[CHANGES : CHANGES + STAGES] = 0.0
    _transform(table, INVERSE, vectors, CHANGES, TRANSFORMED)
    integers[ITERATION] = 0
    reals[RATE_OF_CONVERGENCE] = 0.0
    reals[REMAINING] = max(reals[REMAINING], 1e-15) ** 0.8
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
    _solve_real(integers, reals, vectors, table, a)
    _solve_complex(integers, reals, vectors, table, b, c)
    size, state = 0.0, vectors[STATE]
    for k in range(STAGES):
        size = max(size, scaled_size(integers, reals, vectors, vectors[RATES_AT + k], state, state))
    if not size < np.inf:
        return DIVERGED, 0.5
    iteration = integers[ITERATION]
    integers[ITERATION] += 1
    enough = max(1e-14 / reals[RELATIVE], min(0.03, np.sqrt(reals[RELATIVE])))
    if iteration > 0:
        ratio = size / reals[CORRECTION]
        rate = ratio if iteration == 1 else np.sqrt(ratio * reals[RATIO])
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
    _solve_real(integers, reals, vectors, table, error)
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
        return _try_again(integers, reals, vectors, table, 0.1 if integers[IS_FIRST] else max(1.0 / shrunk, SHORTER))
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
    _normalise(integers, new)
    ask(integers, ACCEPTED, AFTER)
    return accept(integers, reals, vectors, new)


@kernel
def _normalise(integers: np.ndarray, q: np.ndarray) -> None:
    """Bring Euler parameters to unit length."""
    for row in range(integers[MAP_SIZE]):
        if integers[MAP + 3 * row] != STRAIGHT:
            at = integers[MAP + 3 * row + 1]
            length = np.sqrt(q[at] ** 2 + q[at + 1] ** 2 + q[at + 2] ** 2 + q[at + 3] ** 2)
            for i in range(at, at + 4):
                q[i] /= length


def advance_radau(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Go on with the method: see `kanefe.kernels.stepping`."""
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
        return _begin_step(integers, reals, vectors, table)
    if stage == BEGIN:
        integers[IS_FIRST], integers[IS_WANTED], integers[HAS_POLYNOMIAL] = 1, 1, 0
        reals[REMAINING] = 1.0
    if stage == FIRST:
        copy(vectors[SLOPE], vectors[START])
        if reals[NEXT_STEP] <= 0.0:
            reals[NEXT_STEP] = first_step(integers, reals, vectors, vectors[START])
        clip(integers, reals, reals[NEXT_STEP])
        return _begin_step(integers, reals, vectors, table)
    if stage == AFTER:
        if reals[TIME] >= reals[STOP]:
            return ask(integers, DONE, AFTER)
        if integers[HAS_LOOPS]:
            return ask(integers, PROJECT, PROJECTED)
    copy(vectors[STATE], vectors[AT])
    reals[TIME_AT] = reals[TIME]
    return ask(integers, RATES, FIRST)


def interpolate_radau(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the collocation polynomial, of order 3."""
    if t >= reals[TIME]:
        copy(vectors[STATE], out)
        return
    x = (t - reals[TIME_OLD]) / reals[POLYNOMIAL_STEP]
    a, b, c = _weight(table, 0, x), _weight(table, 1, x), _weight(table, 2, x)
    for i in range(len(out)):
        change = a * vectors[POLYNOMIAL, i] + b * vectors[POLYNOMIAL + 1, i] + c * vectors[POLYNOMIAL + 2, i]
        out[i] = vectors[STATE_OLD, i] + change
    _normalise(integers, out)
