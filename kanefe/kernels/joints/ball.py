"""Spherical links: three speeds, the angular velocity in axes of the link, and four Euler parameters.

An armature i is the same about all axes: with ``T = (J + i)^-1`` the parent feels ``M - H T H^T``, ``i H T`` and
``i T J``, and of what acts about the link the torque and ``i T`` of the rest.
"""

from typing import Any

import numpy as np

from kanefe.kernels.joints.handing import Felt
from kanefe.kernels.joints.motion import has_inverse, orientation, put_three, three
from kanefe.kernels.language import NO_INERTIA, NO_MATRIX, Matrix, Vector, diagonal, inlined, is_there, symmetric
from kanefe.kernels.tree import BallFrame, Link


@inlined
def move_ball(link: Link, R: Matrix, q: np.ndarray, u: np.ndarray) -> tuple[Matrix, Vector]:
    """Return axes and turning."""
    turned = R @ orientation(q, link.coordinate)
    return turned, turned @ three(u, link.speed)


@inlined
def eliminate_ball(link: Link, frame: BallFrame) -> bool:
    """Eliminate the speeds; return whether they have inertia."""
    resists = frame.J + diagonal(link.armature)
    turning = resists.inverse
    frame.turning = turning
    return has_inverse(resists, turning)


@inlined
def across_ball(link: Link, frame: BallFrame, applied: np.ndarray) -> Felt:
    """Return what the parent feels: without an armature it is against translations of the joint alone."""
    torque, H, T = frame.R @ three(applied, link.speed), frame.H, frame.turning
    _, f, n = force_through_ball(link, frame, torque, frame.f, frame.n)
    M, lever, J = frame.M - symmetric(H @ T @ H.T), NO_MATRIX, NO_INERTIA
    if is_there(link.armature):
        lever, J = link.armature * (H @ T), link.armature * symmetric(T @ frame.J)
    return Felt(M, lever, J, f, n)


@inlined
def force_through_ball(
    link: Link, frame: BallFrame, torque: Vector, f: Vector, n: Vector
) -> tuple[Vector, Vector, Vector]:
    """Return the turning against which a link needs f and n from its parent, and what is left of these."""
    turning = frame.turning @ (n - torque)
    return turning, f - frame.H @ turning, torque + link.armature * turning


@inlined
def accelerate_ball(
    link: Link, frame: BallFrame, a: Vector, alpha: Vector, applied: np.ndarray, du: np.ndarray
) -> Vector:
    """Write du; return the angular acceleration of the link."""
    R = frame.R
    turning = frame.turning @ (R @ three(applied, link.speed) + link.armature * alpha - frame.n - frame.H.T @ a)
    put_three(du, link.speed, R.T @ (turning - alpha))
    return turning


@inlined
def put_euler_rates(rates: np.ndarray, at: int, q: np.ndarray, w: Vector) -> None:
    """Write the rates of Euler parameters from the angular velocity in the moving frame."""
    e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
    rates[at] = -0.5 * (e1 * w.x + e2 * w.y + e3 * w.z)
    rates[at + 1] = 0.5 * (e0 * w.x + e2 * w.z - e3 * w.y)
    rates[at + 2] = 0.5 * (e0 * w.y + e3 * w.x - e1 * w.z)
    rates[at + 3] = 0.5 * (e0 * w.z + e1 * w.y - e2 * w.x)


@inlined
def put_turned(moved: np.ndarray, at: int, q: np.ndarray, x: Any, y: Any, z: Any) -> None:
    """Write unit Euler parameters turned by a rotation vector in the moving frame."""
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    square = x * x + y * y + z * z
    if square < 1e-8:  # the next terms of the series are below round-off
        c, s = 1.0 - square * (0.5 - square / 24.0), 1.0 - square * (1.0 / 6.0 - square / 120.0)
    else:
        angle = np.sqrt(square)
        c, s = np.cos(angle), np.sin(angle) / angle
    x, y, z = s * x, s * y, s * z
    e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
    a, b, d, e = (
        e0 * c - e1 * x - e2 * y - e3 * z,
        e0 * x + e1 * c + e2 * z - e3 * y,
        e0 * y - e1 * z + e2 * c + e3 * x,
        e0 * z + e1 * y - e2 * x + e3 * c,
    )
    length = 1.0 / np.sqrt(a * a + b * b + d * d + e * e)
    moved[at], moved[at + 1], moved[at + 2], moved[at + 3] = length * a, length * b, length * d, length * e
