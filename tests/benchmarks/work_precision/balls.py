"""Balls on a plane for both programs: one that drops, one that slips as it bounces, one that slides until it rolls.

The bouncing ball has a backspin with which it slips at each bounce, so that friction is the same force in both.
The one on a slope is compared with rigid contact, which both programs come near by their stiffness, and Exudyn by the
speed below which its friction is viscous.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane, Sphere
from kanefe.equations.model import Model
from kanefe.joints import Free
from kanefe.system import System

RADIUS, MASS, INERTIA, FRICTION, STIFFNESS = 0.1, 1.0, 4e-3, 0.3, 1e6

DROPPED, BOUNCING, ROLLING = 3.0, 1.0, 2.0
"""Durations of the runs with balls that are dropped, slip, and roll, s."""

SLOPE = math.radians(20.0)
DOWN, INTO = 9.81 * math.sin(SLOPE), 9.81 * math.cos(SLOPE)
START_SPEED = 1.0


class Ball(NamedTuple):
    """A ball over the plane z = 0.

    Attributes
    ----------
    position, velocity, omega, gravity : sequence of float, shape (3,)
        Of its centre (m, m/s), rad/s, and m/s2.
    stiffness : float
        Of the plane, N/m.
    friction : float
        Coefficient.
    longest : float
        Step above which the peer's adaptive method would take the ball through the plane unseen, s.
    """

    position: Sequence[float]
    velocity: Sequence[float]
    omega: Sequence[float]
    gravity: Sequence[float]
    stiffness: float
    friction: float = FRICTION
    longest: float = 0.05

    def model(self) -> Model:
        """Return it as kanefe has it, by defaults."""
        scene = System(gravity=self.gravity)
        plane = scene.add_surface("plane", scene.ground, Plane("z"))
        joint = Free(position=self.position, velocity=self.velocity, angular_velocity=self.omega)
        skin = scene.add_surface("skin", scene.add_rigid_body("ball", MASS, INERTIA, joint=joint), Sphere(RADIUS))
        friction = Coulomb(self.friction) if self.friction else None
        scene.add_contact("contact", skin, plane, normal=HuntCrossley(self.stiffness), friction=friction)
        return scene.freeze()

    @property
    def request(self) -> dict[str, Any]:
        """Return it as the peer is told."""
        own = {"radius": RADIUS, "mass": MASS, "inertia": INERTIA}
        return {**own, **self._asdict()}


def dropped_ball() -> Ball:
    """Return a ball that falls by 0.9 m and bounces three times within 3 s, without friction, on 1e5 N/m."""
    return Ball((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -9.81), 1e5, 0.0, 0.02)


def bouncing_ball() -> Ball:
    """Return a ball that falls with a backspin, bounces twice within 1 s, and slips all the time that it touches."""
    return Ball((0.0, 0.0, 0.4), (1.0, 0.0, 0.0), (0.0, -100.0, 0.0), (0.0, 0.0, -9.81), STIFFNESS)


def rolling_ball(stiffness: float = STIFFNESS) -> Ball:
    """Return a ball that slides down a slope of 20 degrees, seen in axes of the slope, from where it neither sinks."""
    depth = MASS * INTO / stiffness
    return Ball((0.0, 0.0, RADIUS - depth), (START_SPEED, 0.0, 0.0), (0.0, 0.0, 0.0), (DOWN, 0.0, -INTO), stiffness)


def rolled_way() -> float:
    """Return how far that ball comes on a rigid slope, m: friction mu N until its surface rests on the slope."""
    turning = FRICTION * INTO * MASS * RADIUS**2 / INERTIA  # of its surface, m/s2
    sliding = DOWN - FRICTION * INTO
    until = START_SPEED / (turning - sliding)
    rolling = DOWN / (1.0 + INERTIA / (MASS * RADIUS**2))
    left = ROLLING - until
    speed = START_SPEED + sliding * until
    return START_SPEED * until + 0.5 * sliding * until**2 + speed * left + 0.5 * rolling * left**2
