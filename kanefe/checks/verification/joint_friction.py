"""Cases of joints with load-dependent friction, stops and play.

While a joint sticks it is held by an elastic anchor. The closed forms are those of rigid anchors; results approach them
as the anchor stiffness increases.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY, falling_with_stiffness, run_of
from kanefe.joints import CoordinateForce, Cylindrical, JointFriction, Motion, Prismatic, Revolute, Screw
from kanefe.system import System


def coasting_wheel(reference: Reference) -> Iterator[Check]:
    """L01: a wheel that coasts to rest in its journal bearing."""
    values, errors = reference.values, []
    for stiffness in (1e6, 1e7):
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        friction = JointFriction(0.1, 0.01, stiffness=stiffness)
        scene.add_rigid_body("wheel", 2.0, 0.02, joint=Revolute("y", speed=10.0, friction=friction))
        result = run_of(scene, 11.0, 1e-9)
        errors.append(float(result.joint_coordinates("wheel")[-1, 0]) - values["turn"])
    yield Check.absolute("time at which it stops [s]", result.events["wheel stick"], [values["time"]], 1e-6)
    yield Check.absolute("angle turned through [rad]", errors[1] + values["turn"], values["turn"], 3e-5)
    yield falling_with_stiffness("the angle", errors, 1.0, 0.05)
    yield Check.relative("dissipated energy [J]", result.energy.dissipated[-1], values["energy"], 1e-6)


def spun_rotor(reference: Reference) -> Iterator[Check]:
    """L02: an unbalanced rotor, whose bearing is loaded by the inertia forces of its rotation and deceleration."""
    scene = System()
    joint = Revolute("z", speed=20.0, friction=JointFriction(0.3, 0.02, stiffness=1e7))
    scene.add_rigid_body("rotor", 1.0, 0.05, com=(0.1, 0.0, 0.0), joint=joint)
    speed = run_of(scene, 5.0).joint_speeds("rotor")[-1]
    yield Check.relative("speed after 5 s [rad/s]", speed, [reference.values["speed"]], 1e-6)


def drawer(reference: Reference) -> Iterator[Check]:
    """L03: a drawer that is pushed off its centre line: it jams if mu is larger than length / (2 offset)."""
    length, offset = 0.2, 0.3

    def push(t: float) -> tuple[float, float, float]:
        return 50.0 * min(2.0 * t, 1.0), 0.0, 0.0

    for share, moved in reference.values["speed"].items():
        scene = System()
        friction = JointFriction(float(share) * length / (2.0 * offset), length=length, stiffness=1e7)
        body = scene.add_rigid_body("drawer", 2.0, 0.1, joint=Prismatic("x", friction=friction))
        scene.add_force(body, push, point=(0.0, offset, 0.0))
        speed = run_of(scene, 2.0).joint_speeds("drawer")[-1, 0]
        yield Check.absolute(f"speed after 2 s, mu of {share} of the limit [m/s]", speed, moved, 1e-3)


def thread(reference: Reference) -> Iterator[Check]:
    """L04: torques to raise and to lower a load with a screw, and self-locking with sufficient friction."""
    values = reference.values
    lead, radius, mu = values["lead"], values["radius"], values["mu"]
    for way, name in ((1.0, "raise"), (-1.0, "lower")):
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        joint = Screw("z", lead=lead, motion=Motion.steady(2.0 * way), friction=JointFriction(mu, radius))
        scene.add_rigid_body("nut", 3.0, 0.01, joint=joint)
        torque = run_of(scene, 1.0).driving_force("nut")[-1]
        yield Check.relative(f"torque to {name} [N m]", torque, values[name], 1e-6)
    tangent = lead / (2.0 * math.pi * radius)
    for share, holds in ((0.99, 0.0), (1.01, 1.0)):
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        friction = JointFriction(share * tangent, radius, stiffness=1e7)
        scene.add_rigid_body("nut", 3.0, 0.01, joint=Screw("z", lead=lead, friction=friction))
        sticks = run_of(scene, 2.0).load("friction of nut")[-1, 2]
        yield Check.absolute(f"whether it holds with mu of {share} of the tangent of its lead", sticks, holds, 0.0)


def sliding_shaft(reference: Reference) -> Iterator[Check]:
    """L05: a shaft that slides and turns in its bearing: friction acts against the resulting velocity."""
    radius, mass = 0.05, 2.0
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    joint = Cylindrical("x", speed=(0.6, 0.8 / radius), friction=JointFriction(0.2, radius, stiffness=1e8))
    scene.add_rigid_body("shaft", mass, mass * radius**2, joint=joint)
    result = run_of(scene, 0.6)
    slid, turned = result.joint_coordinates("shaft")[-1]
    found = np.array((slid, turned * radius))
    yield Check.absolute("distances along and around the axis [m]", found, reference.values["ways"], 1e-5)
    yield Check.absolute("time [s]", result.events["shaft stick"][-1], reference.values["time"], 1e-5)


def rattling(reference: Reference) -> Iterator[Check]:
    """L06: a shaft that rattles in its backlash, without losses and with a restitution."""
    scene = System()
    key = CoordinateForce.backlash(0.04, stiffness=200.0)
    scene.add_rigid_body("shaft", 1.0, 0.02, joint=Revolute("z", speed=1.0, forces=key))
    result = run_of(scene, 2.0)
    angle = result.joint_coordinates("shaft")[:, 0]
    up = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    period = np.diff(result.times[up] - angle[up])  # in the backlash the speed is 1 rad/s
    yield Check.absolute("period [s]", period, np.full(len(period), reference.values["period"]), 1e-6)
    scene = System()
    key = CoordinateForce.backlash(0.04, stiffness=2e4, restitution=0.7)
    scene.add_rigid_body("shaft", 1.0, 0.02, joint=Revolute("z", speed=1.0, forces=key))
    result = run_of(scene, 0.3)
    kept = abs(float(result.joint_speeds("shaft")[-1, 0]))
    yield Check.absolute("impacts", float(len(result.events["shaft touch"])), reference.values["impacts"], 0.0)
    yield Check.relative("speed after them [rad/s]", kept, reference.values["kept"], 1e-6)


CASES = (
    Case("L01", coasting_wheel),
    Case("L02", spun_rotor),
    Case("L03", drawer),
    Case("L04", thread),
    Case("L05", sliding_shaft),
    Case("L06", rattling),
)
