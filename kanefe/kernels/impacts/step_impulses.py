"""Impulses of closed contacts in a step over impacts, of those that move each other together.

The law is that of `kanefe.kane.rigid_contacts.step_impulses`: Newton's restitution, as far as that makes no energy.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, HOLDING, OF_POINT
from kanefe.kernels.impacts.cones import LEAST, MU, largest_of, residual
from kanefe.kernels.impacts.decision import ACTIVE, IS_NEW, TAKES, Decision, X, solve
from kanefe.kernels.impacts.march import (
    BEFORE_STEP,
    FREELY,
    IMPULSE,
    OWN_LOWERED,
    OWN_RESIDUAL,
    ImpactScene,
    March,
)
from kanefe.kernels.impacts.tolerances import HALVINGS, ROUND_OFF_OF_FORCES


@kernel
def solve_islands(scene: ImpactScene, decision: Decision, march: March, count: int) -> bool:
    """Write the impulses of closed points, of those that move each other together; return whether there are some."""
    flags, reals, vectors = decision.flags, march.reals, march.vectors
    takes, members, is_done = flags[TAKES], flags[ACTIVE], flags[IS_NEW]
    reals[OWN_RESIDUAL] = reals[OWN_LOWERED] = 0.0
    for a in range(count):
        is_done[a] = 0
    for a in range(count):
        if is_done[a] != 0:
            continue
        members[0], is_done[a], k, seen = a, 1, 1, 0
        while seen < k:
            for b in range(count):
                if is_done[b] == 0 and _moves(decision.now.G, takes[members[seen]], takes[b]):
                    members[k], is_done[b] = b, 1
                    k += 1
            seen += 1
        if not _solve_island(scene, decision, march, k):
            return False
        reals[OWN_RESIDUAL] = max(reals[OWN_RESIDUAL], _left(decision, march, k))
        for b in range(k):
            for i in range(3):
                vectors[IMPULSE, 3 * members[b] + i] = decision.vectors[X, 3 * b + i]
    return True


@kernel
def _solve_island(scene: ImpactScene, decision: Decision, march: March, k: int) -> bool:
    """Write the impulses of k active points, which make no energy; return whether there are some.

    See `kanefe.kane.rigid_contacts.step_impulses`.
    """
    _put_problem(scene, decision, k)
    if not _solve_by(scene, decision, march, k, 1.0, 0.0):
        return False
    if not _makes_energy(decision, march, k):
        return True
    if not _solve_by(scene, decision, march, k, 0.0, 0.0):
        return False
    if _makes_energy(decision, march, k):
        return _solve_by(scene, decision, march, k, 0.0, 1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        if not _solve_by(scene, decision, march, k, share, 0.0) or _makes_energy(decision, march, k):
            high = share
        else:
            low = share
    march.reals[OWN_LOWERED] += 1.0
    return _solve_by(scene, decision, march, k, low, 0.0)


@kernel
def _solve_by(scene: ImpactScene, decision: Decision, march: March, k: int, share: float, of_all: float) -> bool:
    """Write the impulses by shares of the restitution, and of the rates before that count in all directions."""
    numbers, members, vectors = scene.loops.points.numbers, decision.flags[ACTIVE], march.vectors
    for a in range(k):
        at = 3 * members[a]
        for i in range(3):
            decision.problem.b[3 * a + i] = vectors[FREELY, at + i] + of_all * vectors[BEFORE_STEP, at + i]
        e = share * numbers[decision.flags[TAKES, members[a]], OF_POINT.restitution]
        decision.problem.b[3 * a] += e * vectors[BEFORE_STEP, at]
    return solve(scene.asking, False, k, X, False)


@kernel
def _makes_energy(decision: Decision, march: March, k: int) -> bool:
    """Return whether the impulses of k active points do work beyond round-off."""
    G, x, vectors, members = decision.problem.G, decision.vectors[X], march.vectors, decision.flags[ACTIVE]
    work = size = fastest = 0.0
    for a in range(k):
        for i in range(3):
            before, freely = vectors[BEFORE_STEP, 3 * members[a] + i], vectors[FREELY, 3 * members[a] + i]
            after = freely
            for j in range(3 * k):
                after += G[3 * a + i, j] * x[j]
            work += 0.5 * x[3 * a + i] * (before + after)
            size += abs(x[3 * a + i])
            fastest = max(fastest, max(abs(before), abs(freely)))
    return work > ROUND_OFF_OF_FORCES * fastest * size


@inlined
def _moves(G: np.ndarray, p: int, q: int) -> bool:
    """Return whether a force at a point moves another one."""
    found = False
    for i in range(3 * p, 3 * p + 3):
        for j in range(3 * q, 3 * q + 3):
            found = found or G[i, j] != 0.0
    return found


@kernel
def _put_problem(scene: ImpactScene, decision: Decision, k: int) -> None:
    """Write the problem of the impulses of k active points among the closed ones, but for the law."""
    problem, G, members = decision.problem, decision.now.G, decision.flags[ACTIVE]
    points, takes = scene.loops.points, decision.flags[TAKES]
    for a in range(k):
        p = takes[members[a]]
        for i in range(3 * a, 3 * a + 3):
            for b in range(k):
                for j in range(3):
                    problem.G[i, 3 * b + j] = G[3 * p + i - 3 * a, 3 * takes[members[b]] + j]
        problem.of_each[MU, a] = points.numbers[p, HOLDING] if points.places[p, HAS_FRICTION] != 0 else 0.0
        problem.of_each[LEAST, a] = 0.0
        problem.slips[a, 0] = problem.slips[a, 1] = np.nan


@kernel
def _left(decision: Decision, march: March, k: int) -> float:
    """Return the residual of the impulses of k active points, of the largest."""
    problem, x, softest, fastest = decision.problem, decision.vectors[X], 0.0, 0.0
    for a in range(k):
        for i in range(3):
            softest = max(softest, problem.G[3 * a + i, 3 * a + i])
            fastest = max(fastest, abs(march.vectors[BEFORE_STEP, 3 * decision.flags[ACTIVE, a] + i]))
    return residual(problem, k, x) / max(max(largest_of(x, 3 * k), fastest / softest), 1e-300)
