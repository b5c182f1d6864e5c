"""Measures of the slopes of a node: the rotation A_Gn of its frame from three parameters theta.

The default is the rotation vector, which is regular up to a full turn. Extrinsic x-y-z Tait-Bryan angles, the paper's
choice (Eq. 23), are the option ``slopes="tait-bryan"``; they are singular at theta_y = 90 degrees.

A measure gives the rotation, the tangent map T of ``w_Gn_G = T(theta) dtheta`` and the remainder ``dT/dt dtheta``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import (
    Matrix,
    Vector,
    cross,
    euler_parameters_from_rotation_vector,
    multiply,
    rotation_matrix,
    rotation_vector,
    skew,
)


@dataclass(frozen=True)
class SlopeMeasure:
    """One parametrisation of a rotation by slopes.

    Attributes
    ----------
    rotation : callable
        theta (3,) -> A_Gn (3, 3).
    tangent : callable
        theta (3,) -> T (3, 3) with ``w_Gn_G = T dtheta``.
    remainder : callable
        theta (3,), dtheta (3,) -> ``dT/dt dtheta`` (3,), in components of G.
    from_euler_parameters : callable
        e (4,) -> theta (3,).
    """

    name: str
    rotation: Callable[[Vector], Matrix]
    tangent: Callable[[Vector], Matrix]
    remainder: Callable[[Vector, Vector], Vector]
    from_euler_parameters: Callable[[Vector], Vector]


def _series(first: int, factor: Callable[[int], float] = lambda k: 1.0) -> tuple[float, ...]:
    """Return the coefficients (-1)^k factor(k) / (2k + first)! of x^(2k), highest first; ten are round-off at x = 1."""
    return tuple((-1) ** k * factor(k) / math.factorial(2 * k + first) for k in reversed(range(10)))


# a = (1-cos)/x^2, b = (x-sin)/x^3 and their derivatives a'/x, b'/x
_SERIES = (_series(2), _series(3), _series(4, lambda k: -2.0 * (k + 1)), _series(5, lambda k: -2.0 * (k + 1)))


def exponential_coefficients(x: float) -> tuple[float, ...]:
    """Return a, b, a'/x and b'/x of an angle; by series below 1 rad, where the closed forms cancel."""
    if x < 1.0:
        return tuple(_horner(coefficients, x * x) for coefficients in _SERIES)
    if not math.isfinite(x):  # a trial step of an integrator, which it then repeats with a smaller one
        return (math.nan,) * 4
    s, c, square = math.sin(x), math.cos(x), x * x  # x**2 would raise OverflowError
    return (
        (1 - c) / square,
        (x - s) / (x * square),
        (x * s - 2 * (1 - c)) / (square * square),
        (x * (1 - c) - 3 * (x - s)) / (x * square * square),
    )


def _horner(coefficients: tuple[float, ...], x: float) -> float:
    value = 0.0
    for coefficient in coefficients:
        value = value * x + coefficient
    return value


def _exponential_rotation(theta: Vector) -> Matrix:
    return rotation_matrix(euler_parameters_from_rotation_vector(theta))


def _exponential_tangent(theta: Vector) -> Matrix:
    a, b, _, _ = exponential_coefficients(float(np.linalg.norm(theta)))
    t = skew(theta)
    return np.eye(3) + a * t + b * (t @ t)


def _exponential_remainder(theta: Vector, dtheta: Vector) -> Vector:
    _, b, da, db = exponential_coefficients(float(np.linalg.norm(theta)))
    x = cross(theta, dtheta)
    along = float(theta @ dtheta)
    return da * along * x + db * along * cross(theta, x) + b * cross(dtheta, x)


def tait_bryan_euler_parameters(theta: Vector) -> Vector:
    """Return Euler parameters of the extrinsic rotations theta_x, then theta_y, then theta_z (rad), shape (4,).

    The same rotation is the intrinsic z-y-x sequence of yaw, pitch and roll.
    """
    x, y, z = (np.array((math.cos(t / 2), math.sin(t / 2))) for t in theta)
    e_x = np.array((x[0], x[1], 0.0, 0.0))
    e_y = np.array((y[0], 0.0, y[1], 0.0))
    e_z = np.array((z[0], 0.0, 0.0, z[1]))
    return multiply(e_z, multiply(e_y, e_x))


def tait_bryan_angles(e: Vector) -> Vector:
    """Return extrinsic x-y-z Tait-Bryan angles in rad of Euler parameters (Eq. 23, corrected), shape (3,).

    The printed formula has e1 and e2, and the sign of theta_y, interchanged, and halves the arguments on one side only:
    it gives 2 theta_x, -theta_y and 2 theta_z for small angles. At theta_y = +-90 degrees only the sum or difference
    of the other two is defined; there theta_z is set to zero and the rotation is reproduced.
    """
    e0, e1, e2, e3 = e / np.linalg.norm(e)
    # arcsin loses half of its digits near 90 degrees; the half-angles below do not: e0 + e2 and e1 - e3 are
    # proportional to cos and sin of the difference of theta_x and theta_z, e0 - e2 and e1 + e3 to those of their sum
    plus = math.hypot(e0 + e2, e1 - e3)
    minus = math.hypot(e0 - e2, e1 + e3)
    pitch = 2.0 * math.atan2(plus, minus) - math.pi / 2
    if min(plus, minus) < 1e-14:
        half = 2.0 * math.atan2(e1 - e3, e0 + e2) if plus > minus else 2.0 * math.atan2(e1 + e3, e0 - e2)
        return np.array((_wrapped(half), pitch, 0.0))
    difference = math.atan2(e1 - e3, e0 + e2)  # (theta_x - theta_z) / 2
    total = math.atan2(e1 + e3, e0 - e2)  # (theta_x + theta_z) / 2
    return np.array((_wrapped(total + difference), pitch, _wrapped(total - difference)))


def _wrapped(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    return math.remainder(angle, 2 * math.pi)


def _tait_bryan_rotation(theta: Vector) -> Matrix:
    return rotation_matrix(tait_bryan_euler_parameters(theta))


def _tait_bryan_tangent(theta: Vector) -> Matrix:
    _, y, z = theta
    cy, sy, cz, sz = math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    return np.array(((cz * cy, -sz, 0.0), (sz * cy, cz, 0.0), (-sy, 0.0, 1.0)))


def _tait_bryan_remainder(theta: Vector, dtheta: Vector) -> Vector:
    T = _tait_bryan_tangent(theta)
    w_z = T[:, 2] * dtheta[2]
    w_zy = w_z + T[:, 1] * dtheta[1]
    return cross(w_z, T[:, 1]) * dtheta[1] + cross(w_zy, T[:, 0]) * dtheta[0]


SLOPE_MEASURES = {
    "rotation-vector": SlopeMeasure(
        name="rotation-vector",
        rotation=_exponential_rotation,
        tangent=_exponential_tangent,
        remainder=_exponential_remainder,
        from_euler_parameters=rotation_vector,
    ),
    "tait-bryan": SlopeMeasure(
        name="tait-bryan",
        rotation=_tait_bryan_rotation,
        tangent=_tait_bryan_tangent,
        remainder=_tait_bryan_remainder,
        from_euler_parameters=tait_bryan_angles,
    ),
}


def slope_measure(name: str) -> SlopeMeasure:
    """Return the slope measure called `name`; raise a ModelError that lists the names there are."""
    if name not in SLOPE_MEASURES:
        raise ModelError(f"there are no slopes called {name!r}. Remedy: one of {', '.join(sorted(SLOPE_MEASURES))}")
    return SLOPE_MEASURES[name]
