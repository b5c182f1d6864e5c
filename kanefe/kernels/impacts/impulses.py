"""Impulses of an impact of rigid contacts, and speeds that are round-off.

The laws are those of `kanefe.kane.rigid_contacts.impact_laws`, which is independent of this.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.rigid_points import (
    DISTRIBUTING,
    FIRST_STATE,
    HAS_FRICTION,
    HOLDING,
    LAW,
    NEWTON,
    OF_POINT,
    STRONGE,
    TAKEN,
)
from kanefe.kernels.impacts.cones import LEAST, MU, ORDER, ROW, SHARES, F, largest_of
from kanefe.kernels.impacts.decision import (
    ACCELERATIONS,
    ACTIVE,
    AT_REST_BELOW,
    FORCES,
    GROUP,
    IS_CLOSED,
    IS_STRUCK,
    NOT_MOVING,
    OTHER,
    RATES_OF_POINTS,
    TAKES,
    TOLD_OF_ORDER,
    TOLD_OF_POISSON,
    Asking,
    Decision,
    X,
    solve,
)
from kanefe.kernels.impacts.distributing import distribute
from kanefe.kernels.impacts.stronge import strike_one
from kanefe.kernels.impacts.tolerances import (
    ADDED,
    APART,
    CLOSE,
    CLOSELY,
    DEPENDENT,
    IN_TURN,
    JUMPS,
    ROUGHLY,
    STILL_IN_TURN,
    STRUCK,
)


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
def strike(asking: Asking, decision: Decision, count: int, u: np.ndarray, z: np.ndarray) -> bool:
    """Change free speeds, rates and energies of contacts by the impulses of an impact; return whether there are some.

    What has to be told with numbers is left to Python.
    """
    flags, vectors, speeds, now = decision.flags, decision.vectors, decision.speeds, decision.now
    rates, forces, places = vectors[RATES_OF_POINTS], vectors[FORCES], asking.points.places
    forces[:] = 0.0
    _put_groups(decision, count)
    for a in range(count):
        p, k, strikes = flags[TAKES, a], 0, False
        if flags[GROUP, p] != p:
            continue
        for b in range(count):
            q = flags[TAKES, b]
            if flags[GROUP, q] == p:
                flags[ACTIVE, k] = q
                k += 1
                strikes = strikes or rates[3 * q] < -speeds[NOT_MOVING, q]
        if not strikes:
            continue
        is_found, all_poisson = _press_together(asking, decision, k, rates, CLOSELY)
        if not is_found:
            return False
        for b in range(k):
            copy(vectors[OTHER][3 * b : 3 * b + 3], forces[3 * flags[ACTIVE, b] : 3 * flags[ACTIVE, b] + 3])
        if _gives_energy(decision, count, p):
            return False
        depends = k > 1 and not _shares(asking, decision, k) and _depends_on_order(asking, decision, count, p)
        for b in range(count):
            q = flags[TAKES, b]
            if flags[GROUP, q] == p:
                flags[TOLD_OF_POISSON, q], flags[TOLD_OF_ORDER, q] = all_poisson, depends
    largest = 0.0
    for a in range(count):
        largest = max(largest, largest_of(forces[3 * flags[TAKES, a] :], 3))
    respond(decision, count, forces, u)
    copy(rates, vectors[OTHER])
    for a in range(count):
        p, size, taken = flags[TAKES, a], 0.0, 0.0
        flags[IS_STRUCK, p] = forces[3 * p] > CLOSE * largest
        for i in range(3 * p, 3 * p + 3):
            gained = _moved(decision, count, -1, i)
            rates[i] += gained
            taken -= forces[i] * (vectors[OTHER, i] + 0.5 * gained)
        for b in range(count):
            for j in range(3 * flags[TAKES, b], 3 * flags[TAKES, b] + 3):
                size += abs(now.G[3 * p, j]) * abs(forces[j])
        speeds[NOT_MOVING, p] = max(speeds[NOT_MOVING, p], STRUCK * size)
        z[places[p, FIRST_STATE] + TAKEN] += taken
    return True


@kernel
def _shares(asking: Asking, decision: Decision, k: int) -> bool:
    """Return whether any of k active points distributes its impacts."""
    found = False
    for a in range(k):
        found = found or asking.points.places[decision.flags[ACTIVE, a], LAW] == DISTRIBUTING
    return found


@kernel
def _put_groups(decision: Decision, count: int) -> None:
    """Write of each point that takes part the least one whose impulses move it, and that nothing is told of it."""
    flags, G = decision.flags, decision.now.G
    for a in range(count):
        p = flags[TAKES, a]
        flags[GROUP, p], flags[TOLD_OF_POISSON, p], flags[TOLD_OF_ORDER, p] = p, 0, 0
    for _ in range(count):
        is_done = True
        for a in range(count):
            for b in range(a):
                p, q = flags[TAKES, a], flags[TAKES, b]
                least = min(flags[GROUP, p], flags[GROUP, q])
                if flags[GROUP, p] != flags[GROUP, q] and _coupling(G, p, q) > APART * np.sqrt(
                    _coupling(G, p, p) * _coupling(G, q, q)
                ):
                    flags[GROUP, p] = flags[GROUP, q] = least
                    is_done = False
        if is_done:
            break


@inlined
def _coupling(G: np.ndarray, p: int, q: int) -> float:
    """Return the largest response of a point to impulses at another."""
    found = 0.0
    for i in range(3 * p, 3 * p + 3):
        found = max(found, largest_of(G[i, 3 * q :], 3))
    return found


@kernel
def _moved(decision: Decision, count: int, group: int, i: int) -> float:
    """Return what the impulses of points that take part do to a rate; of one group, or of all."""
    flags, forces, moved = decision.flags, decision.vectors[FORCES], 0.0
    for b in range(count):
        q = flags[TAKES, b]
        if group < 0 or flags[GROUP, q] == group:
            for j in range(3 * q, 3 * q + 3):
                moved += decision.now.G[i, j] * forces[j]
    return moved


@kernel
def _gives_energy(decision: Decision, count: int, group: int) -> bool:
    """Return whether the impulses of a group give energy."""
    flags, vectors, given, exchanged = decision.flags, decision.vectors, 0.0, 0.0
    for a in range(count):
        p = flags[TAKES, a]
        if flags[GROUP, p] != group:
            continue
        for i in range(3 * p, 3 * p + 3):
            before, force = vectors[RATES_OF_POINTS, i], vectors[FORCES, i]
            after = before + _moved(decision, count, group, i)
            given += 0.5 * force * (before + after)
            exchanged += 0.5 * abs(force) * (abs(before) + abs(after))
    return given > ADDED * exchanged


@kernel
def _depends_on_order(asking: Asking, decision: Decision, count: int, group: int) -> bool:
    """Return whether points of a group that struck one after the other would part otherwise."""
    flags, vectors = decision.flags, decision.vectors
    rates, in_turn, size = vectors[RATES_OF_POINTS], vectors[ACCELERATIONS], 0.0
    for a in range(count):
        p = flags[TAKES, a]
        if flags[GROUP, p] == group:
            size = max(size, largest_of(rates[3 * p :], 3))
    for order in range(2):
        copy(rates, in_turn)
        is_over = False
        for _ in range(IN_TURN):
            first = -1
            for a in range(count):
                p = flags[TAKES, a if order == 0 else count - 1 - a]
                if first < 0 and flags[GROUP, p] == group and in_turn[3 * p] < -STILL_IN_TURN * size:
                    first = p
            if first < 0:
                is_over = True
                break
            flags[ACTIVE, 0] = first
            is_found, _ = _press_together(asking, decision, 1, in_turn, ROUGHLY)
            if not is_found:
                break
            for a in range(count):
                for i in range(3 * flags[TAKES, a], 3 * flags[TAKES, a] + 3):
                    for j in range(3):
                        in_turn[i] += decision.now.G[i, 3 * first + j] * vectors[OTHER, j]
        if not is_over:
            continue
        for a in range(count):
            p = flags[TAKES, a]
            if flags[GROUP, p] != group:
                continue
            for i in range(3 * p, 3 * p + 3):
                if abs(in_turn[i] - rates[i] - _moved(decision, count, group, i)) > JUMPS * size:
                    return True
    return False


@kernel
def _press_together(asking: Asking, decision: Decision, k: int, rates: np.ndarray, closely: float) -> tuple[bool, bool]:
    """Write the impulses of k active points; return whether there are some, and are Poisson's where Newton's are not.

    Where what is between several surfaces cannot part from all that it meets as Newton's law has it, that is Poisson's.
    """
    points, p, G = asking.points, decision.flags[ACTIVE, 0], decision.now.G
    law, i = points.places[p, LAW], 3 * p
    if k == 1 and law in (STRONGE, DISTRIBUTING):
        own = G[i, i], G[i, i + 1], G[i, i + 2], G[i + 1, i + 1], G[i + 1, i + 2], G[i + 2, i + 2]
        before, rubs = (rates[i], rates[i + 1], rates[i + 2]), points.places[p, HAS_FRICTION] != 0
        is_found, first, second, third = strike_one(own, before, points.numbers[p], rubs, closely, decision.turning)
        pressed = decision.vectors[OTHER]
        pressed[0], pressed[1], pressed[2] = first, second, third
        return is_found, False
    put_active(decision, k)
    if _shares(asking, decision, k):
        pressed = decision.vectors[OTHER]
        return distribute(points, decision.flags[ACTIVE], k, rates, decision.problem, pressed), False
    if _press(asking, decision, k, rates, False):
        return True, False
    return _press(asking, decision, k, rates, True), True


@kernel
def _press(asking: Asking, decision: Decision, k: int, rates: np.ndarray, all_poisson: bool) -> bool:
    """Write the impulses of k active points, by their laws or by Poisson's; return whether there are some.

    Of Poisson's impact the second part follows, as much of it as gives no energy; contacts by Newton's law keep what
    they have come to.
    """
    flags, vectors, points, problem = decision.flags, decision.vectors, asking.points, decision.problem
    x, pressed, share = vectors[X], vectors[OTHER], 1.0
    for part in range(2):
        any_least, any_newton = False, False
        for a in range(k):
            p = flags[ACTIVE, a]
            e, is_poisson = points.numbers[p, OF_POINT.restitution], all_poisson or points.places[p, LAW] != NEWTON
            problem.of_each[MU, a] = points.numbers[p, HOLDING] if points.places[p, HAS_FRICTION] != 0 else 0.0
            problem.slips[a, 0] = problem.slips[a, 1] = np.nan
            problem.of_each[LEAST, a] = e * pressed[3 * a] if part == 1 and is_poisson else 0.0
            any_least = any_least or problem.of_each[LEAST, a] != 0.0
            any_newton = any_newton or not is_poisson
            for i in range(3):
                problem.b[3 * a + i] = rates[3 * p + i]
                if part == 1:
                    for j in range(3 * k):
                        problem.b[3 * a + i] += problem.G[3 * a + i, j] * pressed[j]
            problem.b[3 * a] += 0.0 if is_poisson else e * min(rates[3 * p], 0.0)
        if part == 1 and not any_least:
            break
        if not solve(asking, False, k, X, False):
            return False
        if part == 1 and not any_newton:
            share = _share(decision, k, rates)
        for i in range(3 * k):
            pressed[i] = x[i] if part == 0 else pressed[i] + share * x[i]
    return True


@kernel
def _share(decision: Decision, k: int, rates: np.ndarray) -> float:
    """Return the largest share of the second part of impulses with which the whole gives no energy."""
    flags, problem, pressed, more = decision.flags, decision.problem, decision.vectors[OTHER], decision.vectors[X]
    gone = linear = squared = exchanged = 0.0
    for i in range(3 * k):
        before, first, second = rates[3 * flags[ACTIVE, i // 3] + i % 3], 0.0, 0.0
        for j in range(3 * k):
            first += problem.G[i, j] * pressed[j]
            second += problem.G[i, j] * more[j]
        gone += pressed[i] * (before + 0.5 * first)
        linear += more[i] * (before + first)
        squared += 0.5 * more[i] * second
        exchanged += abs(more[i]) * abs(before)
    if gone + linear + squared <= ADDED * exchanged or squared <= 0.0:
        return 1.0
    gone = min(gone, 0.0)
    return min(1.0, -2.0 * gone / (linear + np.sqrt(linear * linear - 4.0 * squared * gone)))


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
