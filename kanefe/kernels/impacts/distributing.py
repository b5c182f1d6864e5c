"""An impact that several contacts share by their compliance, of which only ratios count: nothing moves meanwhile.

    dv/dt = G F,    F_N = k x^n,    dx/dt = -v_N of what approaches, -v_N / e^2 of what parts, x >= 0

with the friction of Coulomb's cones. Its time and depths shrink with the compliance and its speeds do not: those after
it are the limit of ever stiffer contacts. Of the energy ``k x^(n+1) / (n+1)`` a share of e^2 is given back, and
friction takes some (the distributing law of C. Liu, Z. Zhao & B. Brogliato, Proc. R. Soc. Lond. A 464 (2008) 3193-3211,
over time in place of the impulse of one contact).
"""

import numpy as np

from kanefe.kernels.contact.rigid_points import GivenPoints, RigidPoint
from kanefe.kernels.impacts.cones import Cones, Problem, largest_of
from kanefe.kernels.impacts.tolerances import SHARING
from kanefe.kernels.language import copy, inlined, kernel


@kernel
def distribute(points: GivenPoints, active: np.ndarray, rates: np.ndarray, problem: Problem, p: np.ndarray) -> bool:
    """Write the impulses of some points that share an impact; return whether it ends.

    Parameters
    ----------
    points : GivenPoints
    active : ndarray of int, shape (k,)
        Numbers of the points.
    rates : ndarray, shape (3 k or more,)
        m/s.
    problem : Problem
        With G of the points, of which it becomes a multiple.
    p : ndarray, shape (3 k or more,)
        On return.
    """
    k, n, unit, stiffness = len(active), 3 * len(active), 0.0, 0.0
    size, G, total = largest_of(rates, n), problem.G, problem.tried
    for i in range(n):
        unit = max(unit, G[i, i])
    for i in range(n):
        problem.b[i] = rates[i] / size
        for j in range(n):
            G[i, j] /= unit
    for a in range(k):
        stiffness = max(stiffness, points[active[a]].stiffness)
        cone, i = Cones(problem.each)[a], 3 * a + 1
        cone.mu = points[active[a]].friction.holding
        # largest response of the slip to friction
        largest = 0.5 * (G[i, i] + G[i + 1, i + 1]) + np.hypot(0.5 * (G[i, i] - G[i + 1, i + 1]), G[i, i + 1])
        cone.step = largest if cone.mu > 0.0 else 0.0
    if not _follow(points, active, problem, stiffness):
        return False
    share, taken, given = 1.0, 0.0, 0.0
    for i in range(n):
        taken -= total[i] * problem.b[i]
        for j in range(n):
            given += 0.5 * total[i] * G[i, j] * total[j]
    if given > 0.0:  # not the energy that the errors of steps have given
        share = min(1.0, taken / given)
    for i in range(n):
        p[i] = share * size / unit * total[i]
    return True


@kernel
def _follow(points: GivenPoints, active: np.ndarray, problem: Problem, stiffness: float) -> bool:
    """Follow the impact, at rates and responses relative to the largest; return whether it ends."""
    k, n, force, total, v, depth = len(active), 3 * len(active), problem.x, problem.tried, problem.value, problem.own_b
    force[:n] = total[:n] = depth[:k] = 0.0
    copy(problem.b[:n], v)
    for _ in range(SHARING.most_sharing_steps):
        is_over, shortest = True, 1.0
        for a in range(k):
            is_over = is_over and depth[a] == 0.0 and v[3 * a] >= -SHARING.over
            if v[3 * a] > 0.0 and depth[a] > 0.0:
                shortest = min(shortest, _parting(points[active[a]]))
        if is_over:
            return True
        h = SHARING.sharing_step * shortest
        for a in range(k):
            own = points[active[a]]
            depth[a] = _deeper(depth[a], v[3 * a], _parting(points[active[a]]), 0.5 * h)
            force[3 * a] = own.stiffness / stiffness * depth[a] ** own.exponent
        if not _rub(k, problem, h):
            return False
        for i in range(n):
            total[i] += h * force[i]
        for i in range(n):
            v[i] = problem.b[i]
            for j in range(n):
                v[i] += problem.G[i, j] * total[j]
        for a in range(k):
            depth[a] = _deeper(depth[a], v[3 * a], _parting(points[active[a]]), 0.5 * h)
    return False


@inlined
def _parting(given: RigidPoint) -> float:
    """Return the restitution of a point there."""
    return max(given.restitution, SHARING.least_restitution)


@inlined
def _deeper(depth: float, rate: float, e: float, h: float) -> float:
    """Return a depth a little later."""
    return max(depth - h * rate * (1.0 / (e * e) if rate > 0.0 else 1.0), 0.0)


@kernel
def _rub(k: int, problem: Problem, h: float) -> bool:
    """Write the friction against the slips at the end of a step; return whether it was found."""
    force, moved, cones, largest, n, worst = problem.x, problem.projected, Cones(problem.each), 0.0, 3 * k, 0.0
    copy(problem.value[:n], moved)
    for a in range(k):
        largest = max(largest, force[3 * a])
    for i in range(n):
        for j in range(n):
            moved[i] += h * problem.G[i, j] * force[j]
    for _ in range(SHARING.most_sweeps):
        worst = 0.0
        for a in range(k):
            if not cones[a].step > 0.0:
                continue
            i, by = 3 * a + 1, h * cones[a].step
            first, second = force[i] - moved[i] / by, force[i + 1] - moved[i + 1] / by
            length, most = np.hypot(first, second), cones[a].mu * force[3 * a]
            kept = most / length if length > most else 1.0
            first, second = kept * first - force[i], kept * second - force[i + 1]
            force[i] += first
            force[i + 1] += second
            for j in range(n):
                moved[j] += h * (problem.G[j, i] * first + problem.G[j, i + 1] * second)
            worst = max(worst, max(abs(first), abs(second)))
        if worst <= SHARING.held * largest:
            return True
    return worst <= SHARING.nearly_held * largest
