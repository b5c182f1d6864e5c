"""The linear systems of Radau's method: one real and one complex one, of the size of the speeds.

    (g - J) x = r,    g = gamma / h and (alpha + i beta) / h,    J = d(dy/dt)/dy.

Coordinates follow the speeds, ``dq/dt = T(q) u``, and are eliminated by hand, so that matrices have the size of the
speeds. With tangents z of the rotations, ``dq = T z``, and dR/dt = f(q, u) of speeds and quadratures,
internal states of loads that move, which have no coordinates, counting as speeds,

    (g - f_u - f_z Z) du = r_u + f_z z_r,    Z = (g - w~/2) / (g^2 + w^2/4) of a rotation, 1 / g else.

Internal states, of which points of contacts have three each, hardly depend on each other: they are eliminated first.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, factorise_from_last, solve, solve_from_last
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.steppers.radau_polynomial import EIGENVALUES, FACTORED, FOLLOWED, JACOBIAN_ROWS, ROOM, TURNS
from kanefe.kernels.steppers.step_commands import (
    COORDINATES,
    FACTORISATIONS,
    MAP,
    MAP_SIZE,
    SPEEDS,
    STATE,
    STEP,
    STRAIGHT,
)


@inlined
def _first_factor(integers: np.ndarray, vectors: np.ndarray) -> int:
    """Return where among all numbers of the vectors the factors are: m x m real, m pivots, m x m complex, m pivots.

    The Jacobian before them has a row for each speed, internal state, followed or not, and quadrature.
    """
    return (JACOBIAN_ROWS + vectors.shape[1] - integers[COORDINATES]) * vectors.shape[1]


@inlined
def _size(integers: np.ndarray) -> int:
    """Return how many unknowns the systems have: speeds, and states that are followed."""
    return int(integers[SPEEDS] + integers[FOLLOWED])


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
    m, size, w = integers[SPEEDS], _size(integers), vectors[TURNS]
    for i in range(size):
        by_tangents, by_speeds = vectors[JACOBIAN_ROWS + i, :m], vectors[JACOBIAN_ROWS + i, m : m + size]
        for j in range(size):
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
    r: np.ndarray,
) -> None:
    """Replace r, of the length of the state, by ``(g - J)^-1 r``; A holds factors, z is workspace."""
    n, m, size = integers[COORDINATES], integers[SPEEDS], _size(integers)
    q, du = vectors[STATE], r[n : n + size]
    _divide(integers, vectors, g, r)
    _tangents(integers, q, r, z)
    for i in range(size):
        for j in range(m):
            du[i] += vectors[JACOBIAN_ROWS + i, j] * z[j]
    if integers[FOLLOWED] > 0:
        solve_from_last(A, pivots, du)
    else:
        solve(A, pivots, du)
    _follow(integers, vectors, g, du, r)
    _tangents(integers, q, r, z)
    for i in range(size, len(r) - n):  # quadratures, and states that stay
        row = vectors[JACOBIAN_ROWS + i]
        total = r[n + i]
        for j in range(m):
            total += row[j] * z[j]
        for j in range(size):
            total += row[m + j] * du[j]
        r[n + i] = total / g


@kernel
def factorise_systems(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> bool:
    """Make the factors for the step; return whether there are any."""
    n, border, m, h = integers[COORDINATES], integers[SPEEDS], _size(integers), reals[STEP]
    copy(vectors[STATE, n : n + border], vectors[TURNS, :border])
    memory = vectors.reshape(-1)[_first_factor(integers, vectors) :]
    A = memory[: m * m].reshape(m, m)
    _assemble(integers, vectors, table[EIGENVALUES, 0] / h, A)
    if integers[FOLLOWED] > 0:
        is_regular = factorise_from_last(A, memory[m * m :], border)
    else:
        is_regular = factorise(A, memory[m * m :])
    memory = memory[m * m + m :]
    B = memory[: 2 * m * m].view(np.complex128).reshape(m, m)
    _assemble(integers, vectors, complex(table[EIGENVALUES, 1] / h, table[EIGENVALUES, 2] / h), B)
    if integers[FOLLOWED] > 0:
        is_regular = factorise_from_last(B, memory[2 * m * m :], border) and is_regular
    else:
        is_regular = factorise(B, memory[2 * m * m :]) and is_regular
    integers[FACTORISATIONS] += 1
    reals[FACTORED] = h if is_regular else 0.0
    return is_regular


@kernel
def solve_real(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, r: np.ndarray) -> None:
    """Replace r by the solution of the real system."""
    m = _size(integers)
    memory, g = vectors.reshape(-1)[_first_factor(integers, vectors) :], table[EIGENVALUES, 0] / reals[FACTORED]
    z = vectors[ROOM + 2, : integers[SPEEDS]]
    _solve(integers, vectors, g, memory[: m * m].reshape(m, m), memory[m * m :], z, r)


@kernel
def solve_complex(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, a: np.ndarray, b: np.ndarray
) -> None:
    """Replace ``a + i b`` by the solution of the complex system."""
    m, size = _size(integers), len(a)
    memory = vectors.reshape(-1)[_first_factor(integers, vectors) + m * m + m :]
    g = complex(table[EIGENVALUES, 1] / reals[FACTORED], table[EIGENVALUES, 2] / reals[FACTORED])
    B = memory[: 2 * m * m].view(np.complex128).reshape(m, m)
    r = vectors[ROOM : ROOM + 2].reshape(-1).view(np.complex128)
    z = vectors[ROOM + 2, : 2 * integers[SPEEDS]].view(np.complex128)
    for i in range(size):
        r[i] = complex(a[i], b[i])
    _solve(integers, vectors, g, B, memory[2 * m * m :], z, r)
    for i in range(size):
        a[i], b[i] = r[i].real, r[i].imag
