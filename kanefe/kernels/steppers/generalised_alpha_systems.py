"""The Newton matrix of the generalised-alpha method from the Jacobian, for scenes whose stiffness no sweep knows.

With accelerations ``f(q, u, z)`` and rates ``g(q, u, z)`` of internal states, the shares s and r of damping and
stiffness, and the share p of the rates in z1, a correction of the unknowns solves

    (1 - s f_u - r f_q) ddu - f_z dz = du - f,
    (1 - p g_z) dz - p (s g_u + r g_q) ddu = z - known - p g.

Derivatives by q are along the speeds. Loops are held by f, whose derivatives know them.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.steppers.generalised_alpha_state import (
    FACTORED,
    FACTORED_SHARE,
    FOLLOWED,
    JACOBIAN_ROWS,
    SHARE_OF_RATES,
)
from kanefe.kernels.steppers.step_commands import (
    COORDINATES,
    FACTORISATIONS,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SPEEDS,
    STEP,
)

SAME = 1e-9
"""Relative change of a step, or of a share, up to which factors are those of the same: times are rounded."""


@inlined
def _factors(integers: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of the factors, behind the Jacobian, and their pivots."""
    size = integers[SPEEDS] + integers[FOLLOWED]
    first = (JACOBIAN_ROWS + vectors.shape[1] - integers[COORDINATES]) * vectors.shape[1]
    memory = vectors.reshape(-1)[first:]
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
    n = integers[COORDINATES]
    A, pivots = _factors(integers, vectors)
    solve(A, pivots, x[n : n + len(A)])
