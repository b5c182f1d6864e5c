"""Forces or impulses of contacts with Coulomb's friction: a complementarity problem over cones.

    y = G x + b,    0 <= x_N - least  _|_  y_N >= 0,    x_T opposes y_T and |x_T| <= mu x_N, = mu x_N where y_T != 0

for each of some contacts, whose normal and two directions along the surface are three rows after each other. One that
slips in a known direction d has ``x_T = -mu x_N d`` instead. The same problem of accelerations gives forces, of speeds
impulses (Glocker, "Set-Valued Force Laws", 2001; Acary & Brogliato, "Numerical Methods for Nonsmooth
Dynamical Systems", 2008).

Gauss and Seidel's iteration leads near a solution, Newton's to it: on the equations of Alart and Curnier, which say by
projections which of a contact's states holds (Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375). Problems nearby
lead to what these do not find in a few rounds.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.impacts.tolerances import SOLVING
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import Integers, RealRows, Reals, Record, Rows, copy, entry, in_place, inlined, kernel
from kanefe.kernels.values.filled import allocate
from kanefe.kernels.values.tensors import Vector


class Cone(Record):
    """What a contact of a problem can have.

    Attributes
    ----------
    mu, least : float
        Friction, and least normal force.
    step : float
        By what its rates are multiplied: the inverse of the largest of its own entries of G.
    along, across : float
        Direction of its slip; NaN: it is free to choose.
    """

    mu: float
    least: float
    step: float
    along: float
    across: float


Cones = Rows[Cone]
"""All contacts of a problem: of `Problem.each`."""


class Wanted(Record):
    """What `solve_one` is asked for.

    Attributes
    ----------
    contacts : int
    is_warm : bool
        Whether the forces are a first guess.
    is_solved : bool
        On return: whether there are forces.
    """

    contacts: int
    is_warm: bool
    is_solved: bool


@in_place
class Problem(NamedTuple):
    """A problem of k contacts, of the most that there may be, and its workspace.

    Attributes
    ----------
    G, b, x : ndarray, shapes (3 k, 3 k), (3 k,), (3 k,)
        What unit forces do, ``J M^-1 J^T``; rates without forces; forces.
    each : ndarray
        `Cones`.
    wanted : ndarray of int
        `Wanted`.
    projected, tried, value, order, shares, row, own_b, own_diagonal : ndarray, shape (3 k,)
        Workspace.
    slopes : ndarray, shape (3 k, 3 k)
        Derivative of `value` by `tried`.
    """

    G: RealRows
    b: Reals
    x: Reals
    each: RealRows
    wanted: Integers
    projected: Reals
    tried: Reals
    value: Reals
    order: Reals
    shares: Reals
    row: Reals
    own_b: Reals
    own_diagonal: Reals
    slopes: RealRows


def problem_of(count: int) -> Problem:
    """Return the memory of a problem of so many contacts at most."""
    n = 3 * count
    each, lines = np.zeros((count, Cone.number_count)), np.zeros((10, n))
    return Problem._make((np.zeros((n, n)), *lines[:2], each, *allocate(Wanted), *lines[2:], np.zeros((n, n))))


@inlined
def slips_along(cone: Cone) -> bool:
    """Return whether a contact slips in a known direction."""
    return not np.isnan(cone.along)


@inlined
def let_choose(cone: Cone) -> None:
    """Let a contact stick, or slip where it wants to."""
    cone.along = cone.across = np.nan


@entry()
def solve_one(problem: Problem) -> None:
    """Solve a problem: a unit of its own, called from many places."""
    wanted = Wanted(problem.wanted)
    wanted.is_solved = solve_cones(problem, wanted.contacts, wanted.is_warm)


@kernel
def solve_cones(problem: Problem, k: int, is_warm: bool) -> bool:
    """Write the forces of k contacts, from those of before where that is wanted; return whether there are some."""
    cones, n, x, value = Cones(problem.each), 3 * k, problem.x, problem.value
    all_free, longest, least = True, 0.0, 0.0
    _put_steps(problem, k)
    for i in range(k):
        longest, least = max(longest, cones[i].step), max(least, abs(cones[i].least))
        all_free = all_free and not slips_along(cones[i])
    if not is_warm:
        x[:n] = 0.0
    size = largest_of(problem.b, n) * longest + least
    if size == 0.0:
        x[:n] = 0.0
        return True
    if not is_warm and all_free:  # of what lies and sticks the forces of least norm often are those
        for i in range(n):
            value[i] = -problem.b[i]
            copy(problem.G[i, :n], problem.slopes[i])
        solve_least_norm(problem, n)
        if residual(problem, k, value) <= SOLVING.close * max(size, largest_of(value, n)):
            copy(value[:n], x)
            return True
    for _ in range(SOLVING.rounds):
        if _newton(problem, k, size):
            return True
        _sweep(problem, k)
        if not largest_of(x, n) <= SOLVING.farthest * size:
            return False
    return _solve_nearby(problem, k, size)


@kernel
def _put_steps(problem: Problem, k: int) -> None:
    """Write by what the rates of each contact are multiplied."""
    for i in range(k):
        Cones(problem.each)[i].step = 1.0 / max(_largest_of_block(problem.G, 3 * i), 1e-300)


@kernel
def _sweep(problem: Problem, k: int) -> None:
    """Go over the contacts by Gauss and Seidel's iteration."""
    for _ in range(SOLVING.sweeps):
        for i in range(k):
            put_three(problem.x, 3 * i, _project(problem, k, i, problem.x))


@kernel
def _solve_nearby(problem: Problem, k: int, size: float) -> bool:
    """Write the solution to which those of problems ``(G + rho) x + b - rho x_before`` lead, with less and less rho.

    Of points that depend on each other, such as the corners of a box, G has no inverse. Where b needs a long way along
    what it does not see, sweeps go there by steps as short as b misses its range (the proximal point algorithm: R. T.
    Rockafellar, SIAM J. Control Optim. 14 (1976) 877-898).
    """
    n, x, base, own_b, own = 3 * k, problem.x, 0.0, problem.own_b, problem.own_diagonal
    for i in range(n):
        own_b[i], own[i] = problem.b[i], problem.G[i, i]
        base = max(base, own[i])
    rho, is_solved = base, False
    for _ in range(SOLVING.nearby):
        for i in range(n):
            problem.b[i], problem.G[i, i] = own_b[i] - rho * x[i], own[i] + rho
        _put_steps(problem, k)
        is_near = _newton(problem, k, size)
        if not is_near:
            _sweep(problem, k)
            is_near = _newton(problem, k, size)
        for i in range(n):
            problem.b[i], problem.G[i, i] = own_b[i], own[i]
        _put_steps(problem, k)
        biggest = largest_of(x, n)
        if not biggest <= SOLVING.farthest * size:
            break
        left = residual(problem, k, x)
        is_solved = left <= SOLVING.enough * size
        if left <= SOLVING.nearly * max(size, biggest):
            break
        rho = max(0.5 * rho, SOLVING.dependent * base) if is_near else 4.0 * rho
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
def residual(problem: Problem, k: int, x: np.ndarray) -> float:
    """Return how far forces are from a solution: the largest change that a projection makes, in their unit."""
    worst = 0.0
    for i in range(k):
        put_three(problem.projected, 3 * i, _project(problem, k, i, x) - three(x, 3 * i))
        change = largest_of(problem.projected[3 * i :], 3)
        worst = change if change > worst or np.isnan(change) else worst
    return worst


@inlined
def summed(G: np.ndarray, k: int, i: int, x: np.ndarray, start: Vector) -> Vector:
    """Return a vector and what forces of k contacts do to contact i."""
    row, a, b, c = 3 * i, start.x, start.y, start.z
    for j in range(3 * k):
        a, b, c = a + G[row, j] * x[j], b + G[row + 1, j] * x[j], c + G[row + 2, j] * x[j]
    return Vector(a, b, c)


@inlined
def rates_by(problem: Problem, k: int, i: int, x: np.ndarray) -> Vector:
    """Return the rates of contact i with the forces of k contacts."""
    return summed(problem.G, k, i, x, three(problem.b, 3 * i))


@kernel
def _project(problem: Problem, k: int, i: int, x: np.ndarray) -> Vector:
    """Return the nearest force that a contact can have after a step: with the friction of its normal force then."""
    cone = Cones(problem.each)[i]
    p = three(x, 3 * i) - cone.step * rates_by(problem, k, i, x)
    normal = max(p.x, cone.least)
    if slips_along(cone):
        return Vector(normal, -cone.mu * normal * cone.along, -cone.mu * normal * cone.across)
    along, most = np.hypot(p.y, p.z), cone.mu * max(normal, 0.0)
    kept = 1.0 if along <= most else most / along
    return Vector(normal, kept * p.y, kept * p.z)


@kernel
def _newton(problem: Problem, k: int, size: float) -> bool:
    """Write the solution that Newton's method finds from near it, if it does."""
    n, tried, value = 3 * k, problem.tried, problem.value
    copy(problem.x[:n], tried)
    for _ in range(SOLVING.newton_steps):
        for i in range(k):
            _put_equations(problem, k, i)
        if largest_of(value, n) <= SOLVING.close * max(size, largest_of(tried, n)):
            copy(tried[:n], problem.x)
            return True
        solve_least_norm(problem, n)
        for i in range(n):
            tried[i] -= value[i]
        if not largest_of(tried, n) < np.inf:
            return False
    return False


@kernel
def _put_equations(problem: Problem, k: int, i: int) -> None:
    """Write ``x - projected(x - r y)`` of a contact and its derivative."""
    G, slopes, cone, n = problem.G, problem.slopes, Cones(problem.each)[i], 3 * i
    r, mu, x = cone.step, cone.mu, three(problem.tried, n)
    p = x - r * rates_by(problem, k, i, problem.tried)
    is_pressed = p.x > cone.least
    normal, moves = p.x if is_pressed else cone.least, 1.0 if is_pressed else 0.0
    along, most = np.hypot(p.y, p.z), mu * max(normal, 0.0)
    holds, slips = along <= most, slips_along(cone)
    # the friction of what slips, its change with the normal force, and with its own step
    c = cone.along if slips else p.y / along if along > 0.0 else 0.0
    s = cone.across if slips else p.z / along if along > 0.0 else 0.0
    by_normal = mu if slips else 0.0 if holds or most == 0.0 else -mu
    by_step = 0.0 if slips or most == 0.0 else 1.0 if holds else most / along
    rubs = mu * normal if slips else -most
    sticks = holds and not slips
    first = x.y - p.y if sticks else x.y + rubs * c
    put_three(problem.value, n, Vector(x.x - normal, first, x.z - p.z if sticks else x.z + rubs * s))
    cc, cs, ss = (1.0, 0.0, 1.0) if holds else (1.0 - c * c, -c * s, 1.0 - s * s)
    for j in range(3 * k):
        one, two = 1.0 if j == n else 0.0, 1.0 if j == n + 1 else 0.0
        three_ = 1.0 if j == n + 2 else 0.0
        d_normal = moves * (one - r * G[n, j])
        d_first, d_second = by_step * (two - r * G[n + 1, j]), by_step * (three_ - r * G[n + 2, j])
        slopes[n, j] = one - d_normal
        slopes[n + 1, j] = two + by_normal * c * d_normal - (cc * d_first + cs * d_second)
        slopes[n + 2, j] = three_ + by_normal * s * d_normal - (cs * d_first + ss * d_second)


@kernel
def solve_least_norm(problem: Problem, n: int) -> None:
    """Replace the value by the least solution of ``slopes x = value``."""
    slopes, value, order, shares, row = problem.slopes, problem.value, problem.order, problem.shares, problem.row
    rank, _ = factor_least(slopes, value, n, SOLVING.dependent, order, shares, row)
    solve_least(slopes, value, n, rank, order, shares, row)
