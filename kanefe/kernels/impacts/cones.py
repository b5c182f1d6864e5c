"""The complementarity problem of contacts with Coulomb's friction in compiled code: see `kanefe.contact.rigid.cone`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.impacts.tolerances import (
    CLOSE,
    DEPENDENT,
    ENOUGH,
    FARTHEST,
    NEARBY,
    NEARLY,
    NEWTON_STEPS,
    ROUNDS,
    SWEEPS,
)


class ConeMemory(NamedTuple):
    """A problem of k contacts, of the most that there may be, and its workspace.

    Attributes
    ----------
    G, b : ndarray
        See `kanefe.contact.rigid.cone.Cones`; the first k contacts count.
    of_each : ndarray, shape (3, k)
        Friction, least normal force, and by what the rates of each contact are multiplied.
    slips : ndarray, shape (k, 3)
        Of which two count.
    lines : ndarray, shape (LINES, 3 k)
    dF : ndarray, shape (3 k, 3 k)
    """

    G: RealRows
    b: Reals
    of_each: RealRows
    slips: RealRows
    lines: RealRows
    dF: RealRows


MU, LEAST, STEP = range(3)
PROJECTED, TRIED, F, ORDER, SHARES, ROW, OWN_B, OWN_DIAGONAL = range(8)
LINES = 8


def cones_of(count: int) -> ConeMemory:
    """Return the memory of a problem of so many contacts at most."""
    n = 3 * count
    lines = np.zeros((LINES, n))
    return ConeMemory(
        np.zeros((n, n)), np.zeros(n), np.zeros((3, count)), np.zeros((count, 3)), lines, np.zeros((n, n))
    )


@inlined
def is_given(cones: ConeMemory, i: int) -> bool:
    """Return whether a contact slips in a known direction."""
    return not np.isnan(cones.slips[i, 0])


AHEAD_OF_IT, ROW_OF_FORCES, CONTACTS, IS_WARM, IS_SOLVED = range(5)
"""Numbers of `solve_one`: which of two problems, row of the forces, number of contacts, whether these are a first
guess; on return, whether there are forces."""


@entry()
def solve_one(problem: ConeMemory, ahead: ConeMemory, vectors: RealRows, wanted: Reals) -> None:
    """Solve one of two problems, into one of some rows of forces: a unit of its own, called from many places."""
    x, k, is_warm = vectors[int(wanted[ROW_OF_FORCES])], int(wanted[CONTACTS]), wanted[IS_WARM] != 0.0
    if wanted[AHEAD_OF_IT] != 0.0:
        done = solve_cones(ahead, k, x, is_warm)
    else:
        done = solve_cones(problem, k, x, is_warm)
    wanted[IS_SOLVED] = 1.0 if done else 0.0


@kernel
def solve_cones(cones: ConeMemory, k: int, x: np.ndarray, is_warm: bool) -> bool:
    """Write the forces of k contacts, from those in x where that is wanted; return whether there are some."""
    n, all_free, longest, largest, least = 3 * k, True, 0.0, 0.0, 0.0
    _put_steps(cones, k)
    for i in range(k):
        longest = max(longest, cones.of_each[STEP, i])
        least = max(least, abs(cones.of_each[LEAST, i]))
        all_free = all_free and not is_given(cones, i)
    for i in range(n):
        largest = max(largest, abs(cones.b[i]))
        x[i] = x[i] if is_warm else 0.0
    size = largest * longest + least
    if size == 0.0:
        x[:n] = 0.0
        return True
    if not is_warm and all_free:  # of what lies and sticks the forces of least norm often are those
        for i in range(n):
            cones.lines[F][i] = -cones.b[i]
            copy(cones.G[i, :n], cones.dF[i, :n])
        _solve(cones, n)
        if residual(cones, k, cones.lines[F]) <= CLOSE * max(size, largest_of(cones.lines[F], n)):
            copy(cones.lines[F][:n], x[:n])
            return True
    for _ in range(ROUNDS):
        if _newton(cones, k, x, size):
            return True
        _sweep(cones, k, x)
        if not largest_of(x, n) <= FARTHEST * size:
            return False
    return _solve_nearby(cones, k, x, size)


@kernel
def _put_steps(cones: ConeMemory, k: int) -> None:
    """Write by what the rates of each contact are multiplied: the inverse of the largest of its own entries."""
    for i in range(k):
        cones.of_each[STEP, i] = 1.0 / max(_largest_of_block(cones.G, 3 * i), 1e-300)


@kernel
def _sweep(cones: ConeMemory, k: int, x: np.ndarray) -> None:
    """Go over the contacts by Gauss and Seidel's iteration."""
    for _ in range(SWEEPS):
        for i in range(k):
            _project(cones, k, i, x)
            copy(cones.lines[PROJECTED][3 * i : 3 * i + 3], x[3 * i : 3 * i + 3])


@kernel
def _solve_nearby(cones: ConeMemory, k: int, x: np.ndarray, size: float) -> bool:
    """Write the solution to which those of problems ``(G + rho) x + b - rho x_before`` lead, with less and less rho.

    See `kanefe.contact.rigid.cone.solved`.
    """
    n, base, own_b, own = 3 * k, 0.0, cones.lines[OWN_B], cones.lines[OWN_DIAGONAL]
    for i in range(n):
        own_b[i], own[i] = cones.b[i], cones.G[i, i]
        base = max(base, own[i])
    rho, is_solved = base, False
    for _ in range(NEARBY):
        for i in range(n):
            cones.b[i], cones.G[i, i] = own_b[i] - rho * x[i], own[i] + rho
        _put_steps(cones, k)
        is_near = _newton(cones, k, x, size)
        if not is_near:
            _sweep(cones, k, x)
            is_near = _newton(cones, k, x, size)
        for i in range(n):
            cones.b[i], cones.G[i, i] = own_b[i], own[i]
        _put_steps(cones, k)
        biggest = largest_of(x, n)
        if not biggest <= FARTHEST * size:
            break
        left = residual(cones, k, x)
        is_solved = left <= ENOUGH * size
        if left <= NEARLY * max(size, biggest):
            break
        rho = max(0.5 * rho, DEPENDENT * base) if is_near else 4.0 * rho
    return is_solved


@inlined
def largest_of(x: np.ndarray, n: int) -> float:
    """Return the largest size of n numbers; NaN if one is."""
    found = 0.0
    for i in range(n):
        found = abs(x[i]) if abs(x[i]) > found or np.isnan(x[i]) else found
    return found


@kernel
def _largest_of_block(G: np.ndarray, at: int) -> float:
    """Return the largest eigenvalue of a symmetric block of three rows, in closed form."""
    a, b, c = G[at, at], G[at + 1, at + 1], G[at + 2, at + 2]
    p, q, r = G[at + 1, at], G[at + 2, at], G[at + 2, at + 1]
    beside = p * p + q * q + r * r
    mean = (a + b + c) / 3.0
    a, b, c = a - mean, b - mean, c - mean
    spread = np.sqrt((a * a + b * b + c * c + 2.0 * beside) / 6.0)
    if spread == 0.0:
        return mean
    a, b, c, p, q, r = a / spread, b / spread, c / spread, p / spread, q / spread, r / spread
    half = 0.5 * (a * (b * c - r * r) - p * (p * c - q * r) + q * (p * r - b * q))
    return mean + 2.0 * spread * np.cos(np.arccos(min(max(half, -1.0), 1.0)) / 3.0)


@kernel
def residual(cones: ConeMemory, k: int, x: np.ndarray) -> float:
    """Return how far forces are from a solution: the largest change that a projection makes, in their unit."""
    worst = 0.0
    for i in range(k):
        _project(cones, k, i, x)
        for row in range(3 * i, 3 * i + 3):
            change = abs(cones.lines[PROJECTED][row] - x[row])
            worst = change if change > worst or np.isnan(change) else worst
    return worst


@kernel
def _step(cones: ConeMemory, k: int, i: int, x: np.ndarray) -> None:
    """Write the forces of a contact less a step along its rates."""
    for row in range(3 * i, 3 * i + 3):
        rate = cones.b[row]
        for j in range(3 * k):
            rate += cones.G[row, j] * x[j]
        cones.lines[PROJECTED][row] = x[row] - cones.of_each[STEP, i] * rate


@kernel
def _project(cones: ConeMemory, k: int, i: int, x: np.ndarray) -> None:
    """Write the nearest force that a contact can have after a step: with the friction of its normal force then."""
    _step(cones, k, i, x)
    p, n = cones.lines[PROJECTED], 3 * i
    p[n] = max(p[n], cones.of_each[LEAST, i])
    if is_given(cones, i):
        p[n + 1], p[n + 2] = (
            -cones.of_each[MU, i] * p[n] * cones.slips[i, 0],
            -cones.of_each[MU, i] * p[n] * cones.slips[i, 1],
        )
        return
    along, most = np.hypot(p[n + 1], p[n + 2]), cones.of_each[MU, i] * max(p[n], 0.0)
    kept = 1.0 if along <= most else most / along
    p[n + 1], p[n + 2] = kept * p[n + 1], kept * p[n + 2]


@kernel
def _newton(cones: ConeMemory, k: int, x: np.ndarray, size: float) -> bool:
    """Write the solution that Newton's method finds from near it, if it does."""
    n, tried = 3 * k, cones.lines[TRIED]
    copy(x[:n], tried[:n])
    for _ in range(NEWTON_STEPS):
        for i in range(k):
            _put_equations(cones, k, i)
        if largest_of(cones.lines[F], n) <= CLOSE * max(size, largest_of(tried, n)):
            copy(tried[:n], x[:n])
            return True
        _solve(cones, n)
        for i in range(n):
            tried[i] -= cones.lines[F][i]
        if not largest_of(tried, n) < np.inf:
            return False
    return False


@kernel
def _put_equations(cones: ConeMemory, k: int, i: int) -> None:
    """Write ``x - projected(x - r y)`` of a contact and its derivative."""
    G, dF, r, n = cones.G, cones.dF, cones.of_each[STEP, i], 3 * i
    x, p, value = cones.lines[TRIED], cones.lines[PROJECTED], cones.lines[F]
    _step(cones, k, i, x)
    is_pressed = p[n] > cones.of_each[LEAST, i]
    normal, moves = p[n] if is_pressed else cones.of_each[LEAST, i], 1.0 if is_pressed else 0.0
    mu, along = cones.of_each[MU, i], np.hypot(p[n + 1], p[n + 2])
    most = mu * max(normal, 0.0)
    holds, slips = along <= most, is_given(cones, i)
    # the friction of what slips, its change with the normal force, and with its own step
    c = cones.slips[i, 0] if slips else p[n + 1] / along if along > 0.0 else 0.0
    s = cones.slips[i, 1] if slips else p[n + 2] / along if along > 0.0 else 0.0
    by_normal = mu if slips else 0.0 if holds or most == 0.0 else -mu
    by_step = 0.0 if slips or most == 0.0 else 1.0 if holds else most / along
    rubs = mu * normal if slips else -most
    value[n] = x[n] - normal
    value[n + 1] = x[n + 1] - p[n + 1] if holds and not slips else x[n + 1] + rubs * c
    value[n + 2] = x[n + 2] - p[n + 2] if holds and not slips else x[n + 2] + rubs * s
    cc, cs, ss = (1.0, 0.0, 1.0) if holds else (1.0 - c * c, -c * s, 1.0 - s * s)
    for j in range(3 * k):
        one, two = 1.0 if j == n else 0.0, 1.0 if j == n + 1 else 0.0
        three = 1.0 if j == n + 2 else 0.0
        d_normal = moves * (one - r * G[n, j])
        d_first, d_second = by_step * (two - r * G[n + 1, j]), by_step * (three - r * G[n + 2, j])
        dF[n, j] = one - d_normal
        dF[n + 1, j] = two + by_normal * c * d_normal - (cc * d_first + cs * d_second)
        dF[n + 2, j] = three + by_normal * s * d_normal - (cs * d_first + ss * d_second)


@kernel
def _solve(cones: ConeMemory, n: int) -> None:
    """Replace F by the least solution of ``dF x = F``."""
    rank, _ = factor_least(
        cones.dF, cones.lines[F], n, DEPENDENT, cones.lines[ORDER], cones.lines[SHARES], cones.lines[ROW]
    )
    solve_least(cones.dF, cones.lines[F], n, rank, cones.lines[ORDER], cones.lines[SHARES], cones.lines[ROW])
