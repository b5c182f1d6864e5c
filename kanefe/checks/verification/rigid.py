"""Cases of rigid bodies: pendulum, double pendulum, free top."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import Sample, frame_at, state_after, states_at, zero_crossings
from kanefe.joints import Free, Revolute
from kanefe.system import System

GRAVITY = (0.0, -9.81, 0.0)

RTOL = 1e-12
"""Relative tolerance of the runs: the double pendulum is chaotic and amplifies errors by some thousands in 5 s."""


def pendulum(reference: Reference) -> Iterator[Check]:
    """A01: a point mass on a massless rod, released from the horizontal."""
    scene = System(gravity=GRAVITY)
    scene.add_rigid_body("bob", mass=1.0, com=(-1.0, 0.0, 0.0), joint=Revolute("z"))
    model = scene.freeze()
    times = [float(t) for t in reference.values["xy"]]
    found = []
    for state in states_at(model, times, RTOL):
        bob = frame_at(model, "bob", state)
        found.append(bob.A_NF[:2, 0] * -1.0)
    yield Check.absolute("x, y at t = 1 ... 10 s [m]", found, list(reference.values["xy"].values()), 1e-8)
    # released at rest, the bob is at rest again after half a period
    (half,) = zero_crossings(model, lambda state: float(state[2][0]), 1, stop=1.5, rtol=RTOL)
    yield Check.absolute("period [s]", 2.0 * half, reference.values["period"], 1e-8)


def double_pendulum(reference: Reference) -> Iterator[Check]:
    """A03: two uniform rods in the plane, released from the horizontal."""
    inertia, com, end = 1.0 / 12.0, (0.0, -0.5, 0.0), (0.0, -1.0, 0.0)
    scene = System(gravity=GRAVITY)
    upper = scene.add_rigid_body("upper", 1.0, inertia, com=com, joint=Revolute("z", position=math.pi / 2))
    scene.add_rigid_body("lower", 1.0, inertia, com=com, joint=Revolute("z"), parent=upper, at=end)
    times = reference.values["times"]
    states = states_at(scene.freeze(), times, RTOL)
    # the angle of the second joint is relative to the first rod
    angles = np.array([np.cumsum(q) for _, q, _ in states])
    rates = np.array([np.cumsum(u) for _, _, u in states])
    for name, values, expected in (
        ("angles", angles, np.array(reference.values["theta_abs"])),
        ("rates", rates, np.array(reference.values["omega_abs"])),
    ):
        unit = "rad" if name == "angles" else "rad/s"
        early = np.array(times) <= 3.0
        yield Check.absolute(f"absolute {name} to t = 3 s [{unit}]", values[early], expected[early], 1e-8)
        yield Check.absolute(f"absolute {name} at t = 4, 5 s [{unit}]", values[~early], expected[~early], 1e-6)


def free_top(reference: Reference) -> Iterator[Check]:
    """A06: an asymmetric top that rotates about its intermediate axis, and flips."""
    start = (0.05, 2.0, 0.05)
    scene = System()
    scene.add_rigid_body("top", mass=1.0, inertia=(1.0, 2.0, 3.0), joint=Free(angular_velocity=start))
    model = scene.freeze()
    yield from attitude_checks(states_at(model, reference.values["times"], RTOL), reference, 1e-7)
    first, second = zero_crossings(model, lambda state: float(state[2][4]), 2, stop=20.0, rtol=RTOL)
    period = 2.0 * (second - first)
    yield Check.absolute("period of the body rates [s]", period, reference.values["period"], 1e-7)
    _, _, u = state_after(model, reference.values["period"], RTOL)
    yield Check.absolute("body rates after the period of the reference [rad/s]", u[3:], start, 1e-7)


def attitude_checks(states: list[Sample], reference: Reference, tolerance: float) -> Iterator[Check]:
    """Yield the checks of Euler parameters and body rates of a scene whose first joint is `Free`."""
    attitudes = []
    for (_, q, _), expected in zip(states, reference.values["quat"], strict=True):
        e = q[3:7] / np.linalg.norm(q[3:7])
        attitudes.append(math.copysign(1.0, e @ expected) * e)  # e and -e are the same rotation
    last = reference.values["times"][-1]
    yield Check.absolute(f"Euler parameters to t = {last:g} s", attitudes, reference.values["quat"], tolerance)
    rates = [u[3:6] for _, _, u in states]
    yield Check.absolute(f"body rates to t = {last:g} s [rad/s]", rates, reference.values["omega"], tolerance)


CASES = (Case("A01", pendulum), Case("A03", double_pendulum), Case("A06", free_top))
