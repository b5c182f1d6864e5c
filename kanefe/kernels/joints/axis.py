"""Links of one coordinate: what they share, and those along and about the z of their joint."""

from typing import Any

import numpy as np

from kanefe.kernels.joints.handing import Felt
from kanefe.kernels.joints.motion import ROUND_OFF, Relative
from kanefe.kernels.language import (
    Matrix,
    Vector,
    cosine,
    dot,
    inlined,
    is_above,
    is_there,
    outer,
    sine,
    square,
    turned_about_z,
)
from kanefe.kernels.tree import AxisFrame, Link


@inlined
def motion_along(link: Link, drives: np.ndarray, q: np.ndarray, u: np.ndarray) -> tuple[Any, Any, Any]:
    """Return coordinate, rate and what the drive gives of the acceleration of a link of one coordinate."""
    if link.drive < 0:
        position, rate, acceleration = q[link.coordinate], u[link.speed], 0.0
    else:
        position, rate, acceleration = drives[link.drive, 0], drives[link.drive, 1], drives[link.drive, 2]
    return position, rate, acceleration


@inlined
def move_axis(
    link: Link, R: Matrix, drives: np.ndarray, q: np.ndarray, u: np.ndarray
) -> tuple[Matrix, Vector, Relative]:
    """Return axes, arm, and motion as the parent sees it, of a link along and about an axis."""
    position, rate, acceleration = motion_along(link, drives, q, u)
    v, w = link.along * R.z, link.about * R.z
    turned = R
    if is_there(link.about):
        turned = turned_about_z(R, cosine(link.about * position), sine(link.about * position))
    return turned, position * v, Relative(rate * v, rate * w, acceleration * v, acceleration * w)


@inlined
def eliminate_along(frame: AxisFrame, v: Vector, w: Vector, applied: Any, added: Any) -> bool:
    """Eliminate a speed with partial velocities v and w; return whether it has inertia."""
    M, H, J = frame.M, frame.H, frame.J
    Ul, Ua = M @ v + H @ w, H.T @ v + J @ w  # inertia times the motion
    inertia = dot(v, Ul) + dot(w, Ua) + added
    largest = dot(v, v) * M.trace + dot(w, w) * J.trace
    pivot = 1.0 / inertia
    frame.Ul, frame.Ua, frame.pivot = Ul, Ua, pivot
    frame.rest = pivot * (applied - dot(v, frame.f) - dot(w, frame.n))
    return is_above(inertia, ROUND_OFF * largest)


@inlined
def across_axis(frame: AxisFrame) -> Felt:
    """Return inertia and force that the parent feels of a link whose speed is eliminated: M - U U^T / D, f + U rest."""
    Ul, Ua, rest = frame.Ul, frame.Ua, frame.rest
    el, ea = frame.pivot * Ul, frame.pivot * Ua
    M, H, J = frame.M - square(Ul, el), frame.H - outer(Ul, ea), frame.J - square(Ua, ea)
    return Felt(M, H, J, frame.f + rest * Ul, frame.n + rest * Ua)


@inlined
def force_along(
    frame: AxisFrame, v: Vector, w: Vector, applied: Any, f: Vector, n: Vector
) -> tuple[Any, Vector, Vector]:
    """Return the acceleration along a coordinate by what it needs from its parent, and what is left of that."""
    rest = frame.pivot * (applied - dot(v, f) - dot(w, n))
    return rest, f + rest * frame.Ul, n + rest * frame.Ua


@inlined
def acceleration_along(frame: AxisFrame, a: Vector, alpha: Vector) -> Any:
    """Return du of a speed, with the acceleration of the link as if it was fixed to its parent."""
    return frame.rest - frame.pivot * (dot(frame.Ul, a) + dot(frame.Ua, alpha))
