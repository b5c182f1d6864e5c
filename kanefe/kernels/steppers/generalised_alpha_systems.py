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

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.language import copy, inlined, kernel
from kanefe.kernels.steppers.generalised_alpha_state import AlphaStep, span_of
from kanefe.kernels.sweeps.elastic import total

SAME = 1e-9
"""Relative change of a step, or of a share, up to which factors are those of the same: times are rounded."""


@inlined
def are_factored(step: AlphaStep) -> bool:
    """Return whether there are factors of this step."""
    h, share = step.h, step.share_of_rates
    is_share = step.followed == 0 or abs(step.factored_share - share) <= SAME * share
    return bool(abs(step.factored - h) <= SAME * h and is_share)


@kernel
def factorise_newton(step: AlphaStep) -> bool:
    """Make the factors for the step; return whether there are any."""
    m, followed, most, share = step.speeds, step.followed, step.most_directions, step.share_of_rates
    if most > 0:
        step.factor_size = step.rank
        A, Z, W = step.factors, step.jacobian, step.jacobian[most:]
        for i in range(len(A)):
            for j in range(len(A)):
                A[i, j] = (1.0 if i == j else 0.0) - total(W[i, :m], Z[j, :m])
    else:
        A, jacobian, s, r = step.factors, step.jacobian, step.share_damping, step.share_stiffness
        for i in range(m + followed):
            row, weight = jacobian[i], 1.0 if i < m else share
            for j in range(m):
                A[i, j] = -weight * (r * row[j] + s * row[m + j])
            for j in range(followed):
                A[i, m + j] = -weight * row[2 * m + j]
            A[i, i] += 1.0
    step.factorisations += 1
    is_regular = factorise(A, step.pivots)
    step.factored, step.factored_share = step.h if is_regular else 0.0, share
    return is_regular


@kernel
def solve_newton(step: AlphaStep, x: np.ndarray) -> None:
    """Replace a difference of the unknowns, in their places of a row, by the correction."""
    (n, moving, end), most, columns, rest = span_of(step), step.most_directions, step.columns, step.rest
    if most == 0:
        solve(step.factors, step.pivots, x[n:end])
        return
    Z, W, X = step.jacobian, step.jacobian[most:], step.jacobian[2 * most :]
    for i in range(len(columns)):
        columns[i] = total(W[i, : end - n], x[n:end])
    solve(step.factors, step.pivots, columns)
    for j in range(len(columns)):
        for i in range(moving - n):
            x[n + i] += columns[j] * Z[j, i]
    for i in range(len(rest)):
        rest[i] = total(X[i, : end - n], x[n:end])
    copy(rest, x[moving:end])
