"""Impulses of an impact of rigid contacts, Newton's or Poisson's, and speeds that are round-off."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.falling import AT
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, IS_POISSON, OF_POINT
from kanefe.kernels.impacts.cones import LEAST, MU, ORDER, ROW, SHARES, F, largest_of
from kanefe.kernels.impacts.decision import (
    ACTIVE,
    AT_REST_BELOW,
    FORCES,
    IS_CLOSED,
    IS_STRUCK,
    NOT_MOVING,
    OTHER,
    RATES_OF_POINTS,
    TAKES,
    Asking,
    Decision,
    X,
    solve,
)
from kanefe.kernels.impacts.tolerances import CLOSE, DEPENDENT, STRUCK

HOLDING = int(OF_POINT.friction) + int(AT.holding)


@inlined
def is_at_rest(decision: Decision, p: int) -> bool:
    """Return whether a point slips by round-off only: then its acceleration decides."""
    return (
        np.hypot(decision.vectors[RATES_OF_POINTS, 3 * p + 1], decision.vectors[RATES_OF_POINTS, 3 * p + 2])
        <= decision.speeds[AT_REST_BELOW, p]
    )


@kernel
def respond(decision: Decision, count: int, forces: np.ndarray, y: np.ndarray) -> None:
    """Add to free speeds what forces (3 points,) at the points that take part do."""
    flags = decision.flags
    for a in range(count):
        for i in range(3 * flags[TAKES, a], 3 * flags[TAKES, a] + 3):
            if forces[i] != 0.0:
                for c in range(len(y)):
                    y[c] += forces[i] * decision.now.responses[i, c]


@kernel
def put_active(decision: Decision, k: int) -> None:
    """Write the unit responses of the active points to the problem."""
    G, active = decision.now.G, decision.flags[ACTIVE]
    for a in range(k):
        for i in range(3):
            for b in range(k):
                for j in range(3):
                    decision.problem.G[3 * a + i, 3 * b + j] = G[3 * active[a] + i, 3 * active[b] + j]


@kernel
def strike(asking: Asking, decision: Decision, count: int, u: np.ndarray) -> tuple[bool, bool]:
    """Change free speeds and rates by the impulses of an impact; return whether there are some, and all are Poisson's.

    Where what is between several surfaces cannot part from all that it meets as Newton's law has it, that is Poisson's.
    """
    flags, vectors, speeds = decision.flags, decision.vectors, decision.speeds
    problem, pressed, rates = decision.problem, vectors[OTHER], vectors[RATES_OF_POINTS]
    copy(flags[TAKES][:count], flags[ACTIVE])
    put_active(decision, count)
    all_poisson = not _press(asking, decision, count, False)
    if all_poisson and not _press(asking, decision, count, True):
        return False, all_poisson
    vectors[FORCES][:] = 0.0
    least_struck = CLOSE * largest_of(pressed, 3 * count)
    for a in range(count):
        p = flags[TAKES, a]
        flags[IS_STRUCK, p] = pressed[3 * a] > least_struck
        copy(pressed[3 * a : 3 * a + 3], vectors[FORCES][3 * p : 3 * p + 3])
    respond(decision, count, vectors[FORCES], u)
    for a in range(count):
        p, size = flags[TAKES, a], 0.0
        for j in range(3 * count):
            size += abs(problem.G[3 * a, j]) * abs(pressed[j])
        for i in range(3):
            for j in range(3 * count):
                rates[3 * p + i] += problem.G[3 * a + i, j] * pressed[j]
        speeds[NOT_MOVING, p] = max(speeds[NOT_MOVING, p], STRUCK * size)
    return True, all_poisson


@kernel
def _press(asking: Asking, decision: Decision, count: int, all_poisson: bool) -> bool:
    """Write the impulses of an impact, by the laws of the points or by Poisson's; return whether there are some.

    Of Poisson's impact the second part follows, in which contacts by Newton's law keep what they have come to.
    """
    flags, vectors, points, problem = decision.flags, decision.vectors, asking.points, decision.problem
    x, pressed, rates = vectors[X], vectors[OTHER], vectors[RATES_OF_POINTS]
    for part in range(2):
        any_least = False
        for a in range(count):
            p = flags[TAKES, a]
            e, is_poisson = points.numbers[p, OF_POINT.restitution], all_poisson or points.places[p, IS_POISSON] != 0
            problem.of_each[MU, a] = points.numbers[p, HOLDING] if points.places[p, HAS_FRICTION] != 0 else 0.0
            problem.slips[a, 0] = problem.slips[a, 1] = np.nan
            problem.of_each[LEAST, a] = e * pressed[3 * a] if part == 1 and is_poisson else 0.0
            any_least = any_least or problem.of_each[LEAST, a] != 0.0
            for i in range(3):
                problem.b[3 * a + i] = rates[3 * p + i]
                if part == 1:
                    for j in range(3 * count):
                        problem.b[3 * a + i] += problem.G[3 * a + i, j] * pressed[j]
            problem.b[3 * a] += 0.0 if is_poisson else e * min(rates[3 * p], 0.0)
        if part == 1 and not any_least:
            break
        if not solve(asking, False, count, X, False):
            return False
        for i in range(3 * count):
            pressed[i] = x[i] if part == 0 else pressed[i] + x[i]
    return True


@kernel
def stop(asking: Asking, decision: Decision, count: int, u: np.ndarray) -> bool:
    """Take the round-off from the speeds of what is closed, and of what does not slip; return whether there was any."""
    points = asking.points
    now = decision.now
    flags, vectors = decision.flags, decision.vectors
    rates, problem, held, n, is_any = (
        vectors[RATES_OF_POINTS],
        decision.problem,
        vectors[OTHER],
        0,
        False,
    )
    for a in range(count):
        p = flags[TAKES, a]
        sticks = points.places[p, HAS_FRICTION] != 0 and is_at_rest(decision, p)
        for i in range(3):
            if flags[IS_CLOSED, p] != 0 and (i == 0 or sticks):
                held[n] = 3 * p + i
                is_any = is_any or rates[3 * p + i] != 0.0
                n += 1
    if not is_any:
        return False
    for a in range(n):
        i = int(held[a])
        problem.lines[F, a] = -rates[i]
        for b in range(n):
            problem.dF[a, b] = now.G[i, int(held[b])]
    lines = problem.lines
    rank, _ = factor_least(problem.dF, problem.lines[F], n, DEPENDENT, lines[ORDER], lines[SHARES], lines[ROW])
    solve_least(problem.dF, problem.lines[F], n, rank, lines[ORDER], lines[SHARES], lines[ROW])
    vectors[FORCES][:] = 0.0
    for a in range(n):
        vectors[FORCES, int(held[a])] = problem.lines[F, a]
    respond(decision, count, vectors[FORCES], u)
    for a in range(count):
        for i in range(3 * flags[TAKES, a], 3 * flags[TAKES, a] + 3):
            for b in range(n):
                rates[i] += now.G[i, int(held[b])] * problem.lines[F, b]
    for a in range(n):
        rates[int(held[a])] = 0.0
    return True
