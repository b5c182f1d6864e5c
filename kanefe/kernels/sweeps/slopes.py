"""Slopes of an interface read as a rotation: kernels of `kanefe.bodies.slopes`, for real and complex numbers.

Rotation vectors go through their square only, which is analytic: derivatives by a complex step are exact.
"""

import math
from enum import IntEnum
from typing import Any

import numpy as np

from kanefe.kernels.language import IDENTITY, Matrix, Vector, cross, dot, inlined, kernel, skew


class Slopes(IntEnum):
    """Measures of slopes: see `kanefe.bodies.slopes`."""

    ROTATION_VECTOR = 0
    TAIT_BRYAN = 1


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
def exponential_coefficients(square: Any) -> tuple[Any, Any, Any, Any, Any]:
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
def _polynomial(theta: Vector, of_skew: Any, of_square: Any) -> Matrix:
    """Return 1 + of_skew theta~ + of_square theta~^2."""
    turned = skew(theta).full
    return IDENTITY + of_skew * turned + of_square * (skew(theta) @ turned)


@kernel
def slope_motion(measure: int, theta: Vector, rates: Vector) -> tuple[Matrix, Matrix, Vector]:
    """Return A_Gn, the tangent T of w_Gn_G = T dtheta, and dT/dt dtheta."""
    if measure == Slopes.TAIT_BRYAN:
        return _tait_bryan_motion(theta, rates)
    s, c, b, da, db = exponential_coefficients(dot(theta, theta))
    turn, along = cross(theta, rates), dot(theta, rates)
    remainder = da * along * turn + db * along * cross(theta, turn) + b * cross(rates, turn)
    return _polynomial(theta, s, c), _polynomial(theta, c, b), remainder


@kernel
def _tait_bryan_motion(theta: Vector, rates: Vector) -> tuple[Matrix, Matrix, Vector]:
    cx, sx = np.cos(theta.x), np.sin(theta.x)
    cy, sy = np.cos(theta.y), np.sin(theta.y)
    cz, sz = np.cos(theta.z), np.sin(theta.z)
    zero, one = 0.0 * cx, 0.0 * cx + 1.0
    x, y = Vector(cz * cy, sz * cy, -sy), Vector(-sz, cz, zero)  # axes of the first two turns
    A = Matrix(
        cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx,
        sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx,
        -sy, cy * sx, cy * cx,
    )  # fmt: skip
    T = Matrix(x.x, y.x, zero, x.y, y.y, zero, x.z, y.z, one)
    along_z = Vector(zero, zero, rates.z)
    return A, T, rates.y * cross(along_z, y) + rates.x * cross(along_z + rates.y * y, x)
