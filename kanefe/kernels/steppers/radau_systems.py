"""The linear systems of Radau's method: one real and one complex one, of the size of the speeds.

    (g - J) x = r,    g = gamma / h and (alpha + i beta) / h,    J = d(dy/dt)/dy.

Coordinates follow the speeds, ``dq/dt = T(q) u``, and are eliminated by hand, so that matrices have the size of the
speeds. With tangents z of the rotations, ``dq = T z``, and dR/dt = f(q, u) of speeds and quadratures,
internal states of loads that move, which have no coordinates, counting as speeds,

    (g - f_u - f_z Z) du = r_u + f_z z_r,    Z = (g - w~/2) / (g^2 + w^2/4) of a rotation, 1 / g else.

Internal states, of which points of contacts have three each, hardly depend on each other: they are eliminated first.

Where that is less work, du is found from the linearised equations of a tree, row by row, see
`kanefe.kernels.evaluation.linearised_tree`. They are those of forces, ``M (g du - r_u) = F_u du + F_z z`` with
``z = Z du + z_r``, and so are their solutions the same. Energies are then not part of them: they follow the rates.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.lu import factorise, factorise_from_last, solve, solve_from_last
from kanefe.kernels.algebra.sparse import Pattern, factorise_sparse, solve_sparse
from kanefe.kernels.language import copy, inlined, kernel
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.steppers.radau_polynomial import RadauStep


class Factors(NamedTuple):
    """Those of one of the systems: dense ones and their pivots, or those of a tree."""

    dense: np.ndarray
    pivots: np.ndarray
    of_tree: np.ndarray


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
def _assemble(step: RadauStep, g: complex, A: np.ndarray) -> None:
    """Write ``g - f_u - f_z Z``."""
    m, size, w, moves, jacobian = step.speeds, step.unknowns, step.turns, step.moves, step.jacobian
    for i in range(size):
        by_tangents, by_speeds = jacobian[i, :m], jacobian[i, m : m + size]
        for j in range(size):
            A[i, j] = -by_speeds[j]
        A[i, i] += g
        for row in range(len(moves)):
            s = moves[row, 2]
            if moves[row, 0] == STRAIGHT:
                A[i, s] -= by_tangents[s] / g
                continue
            x, y, z = 0.5 * w[s], 0.5 * w[s + 1], 0.5 * w[s + 2]
            a, b, c = by_tangents[s], by_tangents[s + 1], by_tangents[s + 2]
            share = 1.0 / (g * g + (x * x + y * y + z * z))
            A[i, s] -= share * (g * a + y * c - z * b)
            A[i, s + 1] -= share * (g * b + z * a - x * c)
            A[i, s + 2] -= share * (g * c + x * b - y * a)


@inlined
def _pattern(step: RadauStep) -> Pattern:
    return Pattern(step.row_starts, step.columns, step.diagonals)


@kernel
def _assemble_tree(step: RadauStep, g: complex, A: np.ndarray) -> None:
    """Write the linearised equations of a tree, ``known + g masses`` and how coordinates follow."""
    known, masses, w, moves, places = step.known, step.masses, step.turns, step.moves, step.turn_places
    for i in range(len(known)):
        A[i] = known[i]
    for i in range(len(masses)):
        A[step.mass_places[i]] += g * masses[i]
    for row in range(len(moves)):
        s = moves[row, 2]
        if moves[row, 0] == STRAIGHT:
            A[places[s, 0]] -= 1.0 / g
            continue
        x, y, z = 0.5 * w[s], 0.5 * w[s + 1], 0.5 * w[s + 2]
        share = 1.0 / (g * g + (x * x + y * y + z * z))
        a, b, c = places[s], places[s + 1], places[s + 2]
        A[a[0]] -= share * g
        A[b[1]] -= share * g
        A[c[2]] -= share * g
        A[a[1]] -= share * z
        A[a[2]] += share * y
        A[b[0]] += share * z
        A[b[2]] -= share * x
        A[c[0]] -= share * y
        A[c[1]] += share * x


@kernel
def _solve_tree(step: RadauStep, A: np.ndarray, z: np.ndarray, du: np.ndarray) -> None:
    """Replace rates du by the solution of the linearised equations of a tree, with tangents z of coordinates known."""
    masses, coordinates, unknowns = step.masses, step.of_coordinates, step.of_unknowns
    x = step.tree_row.view(A.dtype)[: step.tree_size]
    x[:] = 0.0
    for i in range(len(masses)):
        x[step.mass_rows[i]] += masses[i] * du[step.mass_speeds[i]]
    for i in range(len(z)):
        x[coordinates[i]] += z[i]
    solve_sparse(_pattern(step), A, x)
    for i in range(len(du)):
        du[i] = x[unknowns[i]]


@kernel
def _tangents(step: RadauStep, r: np.ndarray, z: np.ndarray) -> None:
    """Write the tangents z of changes r of the coordinates."""
    moves, q = step.moves, step.state
    for row in range(len(moves)):
        at, s = moves[row, 1], moves[row, 2]
        if moves[row, 0] == STRAIGHT:
            z[s] = r[at]
            continue
        e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
        z[s] = 2.0 * (e0 * r[at + 1] - e1 * r[at] + e3 * r[at + 2] - e2 * r[at + 3])
        z[s + 1] = 2.0 * (e0 * r[at + 2] - e2 * r[at] + e1 * r[at + 3] - e3 * r[at + 1])
        z[s + 2] = 2.0 * (e0 * r[at + 3] - e3 * r[at] + e2 * r[at + 1] - e1 * r[at + 2])


@kernel
def _divide(step: RadauStep, g: complex, r: np.ndarray) -> None:
    """Replace changes r of the coordinates by ``(g - J)^-1 r``, with J of the coordinates alone."""
    moves, w = step.moves, step.turns
    for row in range(len(moves)):
        at, s = moves[row, 1], moves[row, 2]
        if moves[row, 0] == STRAIGHT:
            r[at] = r[at] / g
        else:
            turned = _turned(g, w, s, (r[at], r[at + 1], r[at + 2], r[at + 3]))
            r[at], r[at + 1], r[at + 2], r[at + 3] = turned


@kernel
def _follow(step: RadauStep, g: complex, du: np.ndarray, r: np.ndarray) -> None:
    """Add to changes r of the coordinates what changes of the speeds bring, ``(g - J)^-1 T du``."""
    moves, q, w = step.moves, step.state, step.turns
    for row in range(len(moves)):
        at, s = moves[row, 1], moves[row, 2]
        if moves[row, 0] == STRAIGHT:
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
def _solve(step: RadauStep, g: complex, factors: Factors, z: np.ndarray, r: np.ndarray) -> None:
    """Replace r, of the length of the state, by ``(g - J)^-1 r``; z is workspace."""
    n, m, size, jacobian, (A, pivots, of_tree) = step.coordinates, step.speeds, step.unknowns, step.jacobian, factors
    du = r[n : n + size]
    _divide(step, g, r)
    _tangents(step, r, z)
    if step.tree_size > 0:
        _solve_tree(step, of_tree, z, du)
        _follow(step, g, du, r)
        for i in range(n + size, len(r)):
            r[i] = r[i] / g
        return
    for i in range(size):
        for j in range(m):
            du[i] += jacobian[i, j] * z[j]
    if step.followed > 0:
        solve_from_last(A, pivots, du)
    else:
        solve(A, pivots, du)
    _follow(step, g, du, r)
    _tangents(step, r, z)
    for i in range(size, len(r) - n):  # quadratures, and states that stay
        row = jacobian[i]
        total = r[n + i]
        for j in range(m):
            total += row[j] * z[j]
        for j in range(size):
            total += row[m + j] * du[j]
        r[n + i] = total / g


@inlined
def _real_factors(step: RadauStep) -> Factors:
    return Factors(step.factors, step.pivots, step.tree_factors)


@inlined
def _complex_factors(step: RadauStep) -> Factors:
    numbers, size = step.complex_factors.reshape(-1).view(np.complex128), step.factor_size
    return Factors(numbers.reshape(size, size), step.complex_pivots, step.complex_tree_factors.view(np.complex128))


@kernel
def _factorised(step: RadauStep, g: complex, factors: Factors) -> bool:
    """Make the factors of ``g - J``; return whether there are any."""
    A, pivots, of_tree = factors
    if step.tree_size > 0:
        _assemble_tree(step, g, of_tree)
        return factorise_sparse(_pattern(step), of_tree, step.tree_row.view(of_tree.dtype)[: step.tree_size])
    _assemble(step, g, A)
    if step.followed > 0:
        return factorise_from_last(A, pivots, step.speeds)
    return factorise(A, pivots)


@kernel
def factorise_systems(step: RadauStep) -> bool:
    """Make the factors for the step; return whether there are any."""
    n, h = step.coordinates, step.h
    copy(step.state[n : n + step.speeds], step.turns)
    is_regular = _factorised(step, step.gamma / h, _real_factors(step))
    g = complex(step.alpha / h, step.beta / h)
    is_regular = _factorised(step, g, _complex_factors(step)) and is_regular
    step.factorisations += 1
    step.factored = h if is_regular else 0.0
    return is_regular


@kernel
def solve_real(step: RadauStep, r: np.ndarray) -> None:
    """Replace r by the solution of the real system."""
    _solve(step, step.gamma / step.factored, _real_factors(step), step.tangents[: step.speeds], r)


@kernel
def solve_complex(step: RadauStep, a: np.ndarray, b: np.ndarray) -> None:
    """Replace ``a + i b`` by the solution of the complex system."""
    g = complex(step.alpha / step.factored, step.beta / step.factored)
    r, z = step.room.view(np.complex128), step.tangents.view(np.complex128)
    for i in range(len(a)):
        r[i] = complex(a[i], b[i])
    _solve(step, g, _complex_factors(step), z, r)
    for i in range(len(a)):
        a[i], b[i] = r[i].real, r[i].imag
