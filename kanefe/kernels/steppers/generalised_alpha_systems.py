"""The Newton matrix of the generalised-alpha method, for scenes whose stiffness is not along modes and joints alone.

With accelerations ``f(q, u, z)`` and rates ``g(q, u, z)`` of internal states, the shares s and r of damping and
stiffness, and the share p of the rates in z1, a correction of the unknowns solves

    (1 - s f_u - r f_q) ddu - f_z dz = du - f,
    (1 - p g_z) dz - p (s g_u + r g_q) ddu = z - known - p g.

with derivatives by q along the speeds, all from the Jacobian. Loops are held by f, whose derivatives know them.

Where loads between frames have few directions, a linearly implicit sweep gives x in the place of f, which knows all but
these loads. With the rows of `kanefe.kernels.evaluation.stiff_directions`,

    ddu = (du - x) + Z y,    (1 - W Z) y = W (du - x) + V rest,    dz = X ddu + Y rest,    rest = z - known - p g,

and what is factorised is as large as there are directions (Woodbury 1950).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.steppers.directions_wanted import MOST_DIRECTIONS, RANK, SHARE_OF_RATES
from kanefe.kernels.steppers.generalised_alpha_state import (
    FACTORED,
    FACTORED_SHARE,
    FOLLOWED,
    JACOBIAN_ROWS,
)
from kanefe.kernels.steppers.step_commands import (
    COORDINATES,
    FACTORISATIONS,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SPEEDS,
    STEP,
)
from kanefe.kernels.sweeps.elastic import total

SAME = 1e-9
"""Relative change of a step, or of a share, up to which factors are those of the same: times are rounded."""


@inlined
def _factors(integers: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of the factors, behind the Jacobian or the directions, and their pivots."""
    size, rows = integers[SPEEDS] + integers[FOLLOWED], vectors.shape[1] - integers[COORDINATES]
    if integers[MOST_DIRECTIONS] > 0:
        size, rows = integers[RANK], 2 * integers[MOST_DIRECTIONS] + integers[FOLLOWED]
    memory = vectors.reshape(-1)[(JACOBIAN_ROWS + rows) * vectors.shape[1] :]
    return memory[: size * size].reshape(size, size), memory[size * size : size * size + size]


@inlined
def are_factored(integers: np.ndarray, reals: np.ndarray) -> bool:
    """Return whether there are factors of this step."""
    h, share = reals[STEP], reals[SHARE_OF_RATES]
    is_share = integers[FOLLOWED] == 0 or abs(reals[FACTORED_SHARE] - share) <= SAME * share
    return bool(abs(reals[FACTORED] - h) <= SAME * h and is_share)


@kernel
def factorise_newton(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> bool:
    """Make the factors for the step; return whether there are any."""
    m, followed = integers[SPEEDS], integers[FOLLOWED]
    s, r, share = reals[SHARE_DAMPING], reals[SHARE_STIFFNESS], reals[SHARE_OF_RATES]
    A, pivots = _factors(integers, vectors)
    if integers[MOST_DIRECTIONS] > 0:
        Z, W = vectors[JACOBIAN_ROWS:], vectors[JACOBIAN_ROWS + integers[MOST_DIRECTIONS] :]
        for i in range(len(A)):
            for j in range(len(A)):
                A[i, j] = (1.0 if i == j else 0.0) - total(W[i, :m], Z[j, :m])
    else:
        for i in range(m + followed):
            row, weight = vectors[JACOBIAN_ROWS + i], 1.0 if i < m else share
            for j in range(m):
                A[i, j] = -weight * (r * row[j] + s * row[m + j])
            for j in range(followed):
                A[i, m + j] = -weight * row[2 * m + j]
            A[i, i] += 1.0
    integers[FACTORISATIONS] += 1
    is_regular = factorise(A, pivots)
    reals[FACTORED], reals[FACTORED_SHARE] = reals[STEP] if is_regular else 0.0, share
    return is_regular


@kernel
def solve_newton(integers: np.ndarray, vectors: np.ndarray, x: np.ndarray) -> None:
    """Replace a difference of the unknowns, in their places of a row, by the correction."""
    n, m, most = integers[COORDINATES], integers[SPEEDS], integers[MOST_DIRECTIONS]
    A, pivots = _factors(integers, vectors)
    end = n + m + integers[FOLLOWED]
    if most == 0:
        solve(A, pivots, x[n:end])
        return
    rank, W, X = len(A), JACOBIAN_ROWS + most, JACOBIAN_ROWS + 2 * most
    columns = vectors.reshape(-1)[(X + integers[FOLLOWED] + most + 1) * vectors.shape[1] :]
    for i in range(rank):
        columns[i] = total(vectors[W + i, : end - n], x[n:end])
    solve(A, pivots, columns[:rank])
    for j in range(rank):
        for i in range(m):
            x[n + i] += columns[j] * vectors[JACOBIAN_ROWS + j, i]
    for i in range(end - n - m):
        columns[i] = total(vectors[X + i, : end - n], x[n:end])
    copy(columns[: end - n - m], x[n + m : end])
