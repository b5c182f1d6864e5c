"""Slopes of an interface read as a rotation: kernels of `kanefe.bodies.slopes`, for real and complex numbers.

Rotation vectors go through their square only, which is analytic: derivatives by a complex step are exact.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, plus, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import TAIT_BRYAN

# Coefficients of x^2k, lowest first, of sin x / x, (1 - cos x) / x^2, (x - sin x) / x^3 and of the derivatives of the
# last two divided by x. Ten terms are round-off at |x| = 1.
_TERMS = np.array(
    [
        [(-1) ** k / math.factorial(2 * k + 1) for k in range(10)],
        [(-1) ** k / math.factorial(2 * k + 2) for k in range(10)],
        [(-1) ** k / math.factorial(2 * k + 3) for k in range(10)],
        [(-1) ** (k + 1) * 2 * (k + 1) / math.factorial(2 * k + 4) for k in range(10)],
        [(-1) ** (k + 1) * 2 * (k + 1) / math.factorial(2 * k + 5) for k in range(10)],
    ]
)


@inlined
def exponential_coefficients(square: Any) -> Numbers:
    """Return the five functions of `_TERMS` of the square of an angle."""
    if square.real < 1.0:
        s = c = b = da = db = 0.0 * square
        for k in range(9, -1, -1):
            s = s * square + _TERMS[0, k]
            c = c * square + _TERMS[1, k]
            b = b * square + _TERMS[2, k]
            da = da * square + _TERMS[3, k]
            db = db * square + _TERMS[4, k]
        return s, c, b, da, db
    x = np.sqrt(square)
    sine, cosine = np.sin(x), np.cos(x)
    return (
        sine / x,
        (1.0 - cosine) / square,
        (x - sine) / (square * x),
        (x * sine - 2.0 * (1.0 - cosine)) / (square * square),
        (x * (1.0 - cosine) - 3.0 * (x - sine)) / (square * square * x),
    )


@inlined
def _polynomial(theta: Numbers, of_skew: Any, of_square: Any) -> Numbers:
    """Return I + of_skew theta~ + of_square theta~^2."""
    x, y, z = theta
    return (
        1.0 - of_square * (y * y + z * z), of_square * x * y - of_skew * z, of_square * x * z + of_skew * y,
        of_square * x * y + of_skew * z, 1.0 - of_square * (x * x + z * z), of_square * y * z - of_skew * x,
        of_square * x * z - of_skew * y, of_square * y * z + of_skew * x, 1.0 - of_square * (x * x + y * y),
    )  # fmt: skip


@kernel
def slope_motion(measure: int, theta: Numbers, rates: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return A_Gn, the tangent T of w_Gn_G = T dtheta, and dT/dt dtheta."""
    if measure == TAIT_BRYAN:
        return _tait_bryan_motion(theta, rates)
    s, c, b, da, db = exponential_coefficients(dot(theta, theta))
    turn = cross(theta, rates)
    along = dot(theta, rates)
    remainder = plus(times(da * along, turn), plus(times(db * along, cross(theta, turn)), times(b, cross(rates, turn))))
    return _polynomial(theta, s, c), _polynomial(theta, c, b), remainder


@kernel
def _tait_bryan_motion(theta: Numbers, rates: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    cx, sx = np.cos(theta[0]), np.sin(theta[0])
    cy, sy = np.cos(theta[1]), np.sin(theta[1])
    cz, sz = np.cos(theta[2]), np.sin(theta[2])
    A = (
        cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx,
        sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx,
        -sy, cy * sx, cy * cx,
    )  # fmt: skip
    zero, one = 0.0 * cx, 0.0 * cx + 1.0
    T = (cz * cy, -sz, zero, sz * cy, cz, zero, -sy, zero, one)
    along_z = (zero, zero, rates[2])
    along_zy = (-sz * rates[1], cz * rates[1], rates[2])
    remainder = plus(
        times(rates[1], cross(along_z, (-sz, cz, zero))), times(rates[0], cross(along_zy, (cz * cy, sz * cy, -sy)))
    )
    return A, T, remainder
