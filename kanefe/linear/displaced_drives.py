"""A model whose driven coordinates are displaced from their motions, for derivatives in linear analyses."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from kanefe.equations.model import Model
from kanefe.joints import Motion
from kanefe.joints.held_motion import driven_by


class Drive(NamedTuple):
    """A driven coordinate: index of its body, and which coordinate of the joint."""

    body: int
    coordinate: int


class Shift(NamedTuple):
    """Deviation of a driven coordinate from its motion at a time, rad or m, and its first two rates."""

    position: float
    speed: float
    acceleration: float


def shifted(model: Model, t: float, shifts: dict[Drive, Shift]) -> Model:
    """Return the model with drives displaced at time t (s); the model itself without displacements."""
    moved = {drive: shift for drive, shift in shifts.items() if any(shift)}
    if not moved:
        return model
    bodies = list(model.bodies)
    for drive, shift in moved.items():
        body = bodies[drive.body]
        motions = list(body.joint.motions)
        motion = motions[drive.coordinate]
        if motion is None:
            raise TypeError("the coordinate is not driven")
        motions[drive.coordinate] = _displaced(motion, shift, t)
        bodies[drive.body] = replace(body, joint=driven_by(body.joint, motions))
    return replace(model, bodies=tuple(bodies))


def _displaced(motion: Motion, shift: Shift, t0: float) -> Motion:
    x, v, a = shift
    velocity, acceleration = motion.velocity, motion.acceleration
    if velocity is None or acceleration is None:
        raise TypeError("the motion has no rates")  # Motion guarantees it
    return Motion(
        lambda t: float(motion.position(t)) + x + v * (t - t0) + 0.5 * a * (t - t0) ** 2,
        lambda t: float(velocity(t)) + v + a * (t - t0),
        lambda t: float(acceleration(t)) + a,
        motion.span,
    )
