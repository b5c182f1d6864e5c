"""Motions whose acceleration is set step by step, such as inputs of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.joints.base import Joint
from kanefe.joints.motion import Motion


class Course:
    """The motion of a coordinate with a constant acceleration from a time on.

    Attributes
    ----------
    piece : ndarray, shape (1, 5)
        A piece of a `Motion`: its start (s), and the coefficients of the powers 0 to 3 of the time since.
    """

    def __init__(self, piece: np.ndarray) -> None:
        self.piece = piece

    def position(self, t: float) -> float:
        """Return the coordinate at a time, rad or m."""
        since, x, v, half, _ = self.piece[0].tolist()
        s = t - since
        return (half * s + v) * s + x

    def velocity(self, t: float) -> float:
        """Return its rate, rad/s or m/s."""
        since, _, v, half, _ = self.piece[0].tolist()
        return v + 2.0 * half * (t - since)

    def acceleration(self, t: float) -> float:
        """Return its acceleration, rad/s2 or m/s2."""
        *_, half, _ = self.piece[0].tolist()
        return 2.0 * half + 0.0 * t  # also of many times

    def go_on(self, t: float, acceleration: float) -> None:
        """Continue from time t (s) with another acceleration, rad/s2 or m/s2."""
        self.piece[0] = t, self.position(t), self.velocity(t), 0.5 * acceleration, 0.0


def held_motion(motion: Motion, t: float) -> tuple[Motion, Course]:
    """Return a motion that continues from the state of another at time t (s), and the object that controls it."""
    x, v, a = (float(f(t)) for f in (motion.position, motion.velocity, motion.acceleration) if f is not None)
    course = Course(np.array([[t, x, v, 0.5 * a, 0.0]]))
    made = Motion(course.position, course.velocity, course.acceleration)
    object.__setattr__(made, "pieces", course.piece)
    return made, course


def driven_by(joint: Any, motions: Sequence[Motion | None]) -> Joint:
    """Return a joint with other motions of its coordinates."""
    changed: Joint = replace(joint, motion=motions[0] if len(motions) == 1 else tuple(motions))
    return changed
