"""Forces or impulses of contacts with Coulomb's friction: a complementarity problem over cones.

    y = G x + b,    0 <= x_N - least  _|_  y_N >= 0,    x_T opposes y_T and |x_T| <= mu x_N, = mu x_N where y_T != 0

for each of some contacts, whose normal and two directions along the surface are three rows after each other. One that
slips in a known direction d has ``x_T = -mu x_N d`` instead. The same problem of accelerations gives forces, of speeds
impulses (Glocker, "Set-Valued Force Laws", 2001; Acary & Brogliato, "Numerical Methods for Nonsmooth
Dynamical Systems", 2008).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
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


class Cones(NamedTuple):
    """A problem of k contacts.

    Attributes
    ----------
    G : ndarray, shape (3 k, 3 k)
        What unit forces do, ``J M^-1 J^T``.
    b : ndarray, shape (3 k,)
    mu : ndarray, shape (k,)
    least : ndarray, shape (k,)
        Of the normal forces.
    slips : ndarray, shape (k, 2)
        Directions of those that slip in one that is known; NaN of others.
    """

    G: Matrix
    b: Vector
    mu: Vector
    least: Vector
    slips: Matrix


def solved(problem: Cones, first: Vector | None = None) -> Vector | None:
    """Return the forces x (3 k,), or None if none were found: there may be none, or several.

    Gauss and Seidel's iteration leads near a solution, Newton's to it: on the equations of Alart and Curnier, which say
    by projections which of a contact's states holds (Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375). Problems
    nearby lead to what these do not find in a few rounds.
    """
    G, b = problem.G, problem.b
    k = len(problem.mu)
    if not k:
        return np.zeros(0)
    r = _steps(G, k)
    x = np.zeros(3 * k) if first is None else first.copy()
    size = float(np.abs(b).max() * r.max()) + float(np.abs(problem.least).max())
    if size == 0.0:
        return np.zeros(3 * k)
    if first is None and np.all(np.isnan(problem.slips)):
        # of what lies and sticks the forces of least norm often are those: each point carries its part
        held = np.linalg.lstsq(G, -b, rcond=DEPENDENT)[0]
        if residual(problem, held) <= CLOSE * max(size, float(np.abs(held).max())):
            return held
    for _ in range(ROUNDS):
        found = _newton(problem, x, r, size)
        if found is not None:
            return found
        _sweep(problem, x, r)
        if not np.abs(x).max() <= FARTHEST * size:
            return None
    return _solved_nearby(problem, x, size)


def _sweep(problem: Cones, x: Vector, r: Vector) -> None:
    """Go over the contacts by Gauss and Seidel's iteration."""
    for _ in range(SWEEPS):
        for i in range(len(problem.mu)):
            rows = slice(3 * i, 3 * i + 3)
            x[rows] = _projected(problem, i, x[rows] - r[i] * (problem.G[rows] @ x + problem.b[rows]))


def _solved_nearby(problem: Cones, x: Vector, size: float) -> Vector | None:
    """Return the solution to which those of problems ``(G + rho) x + b - rho x_before`` lead, with less and less rho.

    Of points that depend on each other, such as the corners of a box, G has no inverse. Where b needs a long way along
    what it does not see, sweeps go there by steps as short as b misses its range (the proximal point algorithm: R. T.
    Rockafellar, SIAM J. Control Optim. 14 (1976) 877-898).
    """
    own, solution = problem, None
    rho = base = float(np.diag(problem.G).max())
    for _ in range(NEARBY):
        problem = own._replace(G=own.G + rho * np.eye(len(x)), b=own.b - rho * x)
        r = _steps(problem.G, len(problem.mu))
        found = _newton(problem, x, r, size)
        if found is None:
            _sweep(problem, x, r)
            found = _newton(problem, x, r, size)
        x = x if found is None else found
        biggest = float(np.abs(x).max())
        if not biggest <= FARTHEST * size:
            break
        left = residual(own, x)
        solution = x.copy() if left <= ENOUGH * size else None
        if left <= NEARLY * max(size, biggest):
            break
        rho = 4.0 * rho if found is None else max(0.5 * rho, DEPENDENT * base)
    return solution


def residual(problem: Cones, x: Vector) -> float:
    """Return how far forces are from a solution: the largest change that a projection makes, in their unit."""
    y, worst = problem.G @ x + problem.b, 0.0
    r = _steps(problem.G, len(problem.mu))
    for i in range(len(problem.mu)):
        rows = slice(3 * i, 3 * i + 3)
        worst = max(worst, float(np.abs(_projected(problem, i, x[rows] - r[i] * y[rows]) - x[rows]).max()))
    return worst


def _steps(G: Matrix, k: int) -> Vector:
    """Return by what the rates of each contact are multiplied: the inverse of the largest of its own entries."""
    largest = np.array([np.linalg.eigvalsh(G[3 * i : 3 * i + 3, 3 * i : 3 * i + 3])[-1] for i in range(k)])
    return 1.0 / np.maximum(largest, 1e-300)


def _projected(problem: Cones, i: int, p: Vector) -> Vector:
    """Return the nearest force that a contact can have: with the friction of the normal force that it has then."""
    normal = max(p[0], problem.least[i])
    slip = problem.slips[i]
    if not np.isnan(slip[0]):
        return np.array((normal, *(-problem.mu[i] * normal * slip)))
    along = float(np.hypot(p[1], p[2]))
    most = problem.mu[i] * max(normal, 0.0)
    kept = 1.0 if along <= most else most / along
    return np.array((normal, kept * p[1], kept * p[2]))


def _newton(problem: Cones, x: Vector, r: Vector, size: float) -> Vector | None:
    """Return the solution that Newton's method finds from near it, or None."""
    x = x.copy()
    for _ in range(NEWTON_STEPS):
        F, dF = _equations(problem, x, r)
        if np.abs(F).max() <= CLOSE * max(size, float(np.abs(x).max())):
            return x
        x = x - np.linalg.lstsq(dF, F, rcond=DEPENDENT)[0]
        if not np.all(np.isfinite(x)):
            return None
    return None


def _equations(problem: Cones, x: Vector, r: Vector) -> tuple[Vector, Matrix]:
    """Return ``x - projected(x - r y)`` and its derivative."""
    G, k = problem.G, len(problem.mu)
    p = x - np.repeat(r, 3) * (G @ x + problem.b)
    dp = np.eye(3 * k) - np.repeat(r, 3)[:, None] * G
    F, dF = x.copy(), np.eye(3 * k)
    for i in range(k):
        n, t = 3 * i, slice(3 * i + 1, 3 * i + 3)
        is_pressed = p[n] > problem.least[i]
        normal = p[n] if is_pressed else problem.least[i]
        d_normal = dp[n] if is_pressed else np.zeros(3 * k)
        F[n] -= normal
        dF[n] -= d_normal
        mu, slip = problem.mu[i], problem.slips[i]
        if not np.isnan(slip[0]):
            F[t] += mu * normal * slip
            dF[t] += mu * np.outer(slip, d_normal)
            continue
        along = float(np.hypot(*p[t]))
        most = mu * max(normal, 0.0)
        if along <= most:
            F[t] -= p[t]
            dF[t] -= dp[t]
        elif most > 0.0:
            unit = p[t] / along
            F[t] -= most * unit
            dF[t] -= mu * np.outer(unit, d_normal) + most / along * (np.eye(2) - np.outer(unit, unit)) @ dp[t]
    return F, dF
