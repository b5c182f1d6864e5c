"""An impact that several contacts share by their compliance: see `kanefe.kane.rigid_contacts.distributing`."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, HOLDING, OF_POINT
from kanefe.kernels.impacts.cones import MU, STEP, ConeMemory
from kanefe.kernels.impacts.tolerances import (
    HELD,
    LEAST_RESTITUTION,
    MOST_SHARING_STEPS,
    MOST_SWEEPS,
    NEARLY_HELD,
    OVER,
    SHARING_STEP,
)
from kanefe.kernels.tables import RigidPoints

FORCE, TOTAL, SPEED, MOVED, DEPTH = range(5)
"""Rows of the lines of a problem: forces, impulses so far, rates, those with friction at the end of a step; and the
depth of each contact."""

STIFFEST = STEP
"""Row of each contact: largest response of its slip to friction; zero where there is none."""


@kernel
def distribute(
    points: RigidPoints, active: np.ndarray, k: int, rates: np.ndarray, cones: ConeMemory, p: np.ndarray
) -> bool:
    """Write the impulses p (3 k,) of k active points that share an impact; return whether it ends.

    Parameters
    ----------
    points : RigidPoints
    active : ndarray of int
        Numbers of the points.
    k : int
    rates : ndarray, shape (3 points,)
        m/s.
    cones : ConeMemory
        With G of the active points, of which it becomes a multiple.
    p : ndarray
    """
    n, size, unit, stiffness = 3 * k, 0.0, 0.0, 0.0
    for a in range(k):
        stiffness = max(stiffness, points.numbers[active[a], OF_POINT.stiffness])
        for i in range(3):
            cones.b[3 * a + i] = rates[3 * active[a] + i]
            size, unit = max(size, abs(cones.b[3 * a + i])), max(unit, cones.G[3 * a + i, 3 * a + i])
    for i in range(n):
        cones.b[i] /= size
        for j in range(n):
            cones.G[i, j] /= unit
    for a in range(k):
        rubs = points.places[active[a], HAS_FRICTION] != 0
        cones.of_each[MU, a] = points.numbers[active[a], HOLDING] if rubs else 0.0
        first, cross, second = (
            cones.G[3 * a + 1, 3 * a + 1],
            cones.G[3 * a + 1, 3 * a + 2],
            cones.G[3 * a + 2, 3 * a + 2],
        )
        largest = 0.5 * (first + second) + np.hypot(0.5 * (first - second), cross)
        cones.of_each[STIFFEST, a] = largest if cones.of_each[MU, a] > 0.0 else 0.0
    if not _follow(points, active, k, cones, stiffness):
        return False
    share, taken, given = 1.0, 0.0, 0.0
    for i in range(n):
        taken -= cones.lines[TOTAL, i] * cones.b[i]
        for j in range(n):
            given += 0.5 * cones.lines[TOTAL, i] * cones.G[i, j] * cones.lines[TOTAL, j]
    if given > 0.0:  # not the energy that the errors of steps have given
        share = min(1.0, taken / given)
    for i in range(n):
        p[i] = share * size / unit * cones.lines[TOTAL, i]
    return True


@kernel
def _follow(points: RigidPoints, active: np.ndarray, k: int, cones: ConeMemory, stiffness: float) -> bool:
    """Follow the impact, at rates and responses relative to the largest; return whether it ends."""
    n, lines = 3 * k, cones.lines
    v, depth, force, total = lines[SPEED], lines[DEPTH], lines[FORCE], lines[TOTAL]
    for i in range(n):
        v[i], depth[i], force[i], total[i] = cones.b[i], 0.0, 0.0, 0.0
    for _ in range(MOST_SHARING_STEPS):
        is_over, shortest = True, 1.0
        for a in range(k):
            is_over = is_over and depth[a] == 0.0 and v[3 * a] >= -OVER
            if v[3 * a] > 0.0 and depth[a] > 0.0:
                shortest = min(shortest, _parting(points, active[a]))
        if is_over:
            return True
        h = SHARING_STEP * shortest
        for a in range(k):
            own = points.numbers[active[a]]
            depth[a] = _deeper(depth[a], v[3 * a], _parting(points, active[a]), 0.5 * h)
            force[3 * a] = own[OF_POINT.stiffness] / stiffness * depth[a] ** own[OF_POINT.exponent]
        if not _rub(k, cones, h):
            return False
        for i in range(n):
            total[i] += h * force[i]
        for i in range(n):
            v[i] = cones.b[i]
            for j in range(n):
                v[i] += cones.G[i, j] * total[j]
        for a in range(k):
            depth[a] = _deeper(depth[a], v[3 * a], _parting(points, active[a]), 0.5 * h)
    return False


@inlined
def _parting(points: RigidPoints, p: int) -> float:
    """Return the restitution of a point there."""
    return max(points.numbers[p, OF_POINT.restitution], LEAST_RESTITUTION)


@inlined
def _deeper(depth: float, rate: float, e: float, h: float) -> float:
    """Return a depth a little later."""
    return max(depth - h * rate * (1.0 / (e * e) if rate > 0.0 else 1.0), 0.0)


@kernel
def _rub(k: int, cones: ConeMemory, h: float) -> bool:
    """Write the friction against the slips at the end of a step; return whether it was found."""
    force, moved, largest, n, worst = cones.lines[FORCE], cones.lines[MOVED], 0.0, 3 * k, 0.0
    copy(cones.lines[SPEED][:n], moved[:n])
    for a in range(k):
        largest = max(largest, force[3 * a])
    for i in range(n):
        for j in range(n):
            moved[i] += h * cones.G[i, j] * force[j]
    for _ in range(MOST_SWEEPS):
        worst = 0.0
        for a in range(k):
            if not cones.of_each[STIFFEST, a] > 0.0:
                continue
            i, by = 3 * a + 1, h * cones.of_each[STIFFEST, a]
            first, second = force[i] - moved[i] / by, force[i + 1] - moved[i + 1] / by
            length, most = np.hypot(first, second), cones.of_each[MU, a] * force[3 * a]
            kept = most / length if length > most else 1.0
            first, second = kept * first - force[i], kept * second - force[i + 1]
            force[i] += first
            force[i + 1] += second
            for j in range(n):
                moved[j] += h * (cones.G[j, i] * first + cones.G[j, i + 1] * second)
            worst = max(worst, max(abs(first), abs(second)))
        if worst <= HELD * largest:
            return True
    return worst <= NEARLY_HELD * largest
