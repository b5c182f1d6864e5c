"""Hinges: links that turn about the z of their joint by their coordinate."""

from typing import Any

import numpy as np

from kanefe.kernels.joints.axis import motion_along
from kanefe.kernels.joints.motion import ROUND_OFF
from kanefe.kernels.language import Matrix, Vector, cosine, dot, inlined, is_above, sine, turned_about_z
from kanefe.kernels.tree import AxisFrame, Link


@inlined
def move_revolute(
    link: Link, R: Matrix, drives: np.ndarray, q: np.ndarray, u: np.ndarray
) -> tuple[Matrix, Vector, Vector]:
    """Return axes, turning, and what the drive adds to its rate."""
    angle, rate, acceleration = motion_along(link, drives, q, u)
    return turned_about_z(R, cosine(angle), sine(angle)), rate * R.z, acceleration * R.z


@inlined
def eliminate_revolute(frame: AxisFrame, applied: Any, added: Any) -> bool:
    """Eliminate the speed; return whether it has inertia."""
    axis = frame.R.z
    Ul, Ua = frame.H @ axis, frame.J @ axis  # inertia times the motion
    inertia = dot(axis, Ua) + added
    pivot = 1.0 / inertia
    frame.Ul, frame.Ua, frame.pivot = Ul, Ua, pivot
    frame.rest = pivot * (applied - dot(axis, frame.n))
    return is_above(inertia, ROUND_OFF * frame.J.trace)
