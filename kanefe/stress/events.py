"""Storms of events: thousands of impacts on stops, loads that jump a thousand times a second."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.integrate.run import integrate
from kanefe.joints import CoordinateForce, Prismatic, Revolute
from kanefe.model import Model
from kanefe.results import Result
from kanefe.stress.case import Effort, Finding, StressCase
from kanefe.stress.runs import controlled_methods
from kanefe.system import System

GAP, SPEED, STOP = 1e-3, 1.0, 1e6
"""Half the way between two stops (m), speed (m/s) and stiffness (N/m) of a mass of 1 kg: an impact every 5 ms."""


def rattler() -> Model:
    """Return a mass that flies to and fro between two stops."""
    scene = System()
    force = CoordinateForce(limits=(-GAP, GAP), limit_stiffness=STOP)
    scene.add_point("mass", 1.0, joint=Prismatic("x", speed=SPEED, forces=force))
    return scene.freeze()


def exact_place(t: np.ndarray) -> np.ndarray:
    """Return where the mass is: flights at constant speed, and half periods of a spring at the stops."""
    omega = math.sqrt(STOP)
    flight, contact = 2.0 * GAP / SPEED, math.pi / omega
    half = flight + contact
    phase = t + 0.5 * flight  # since it left the lower stop
    number = np.floor(phase / half)
    rest = phase - number * half
    x = np.where(rest < flight, SPEED * rest - GAP, GAP + SPEED / omega * np.sin(omega * (rest - flight)))
    return np.where(number % 2 == 0, x, -x)


def impacts(effort: Effort) -> Iterator[Finding]:
    """Rattle between stops, and come to rest on one."""
    span = 10.0 if not effort.is_quick else 0.25
    for method in controlled_methods():
        rtol = 1e-10 if method == "dop853" else 1e-9
        model = rattler()
        run = integrate(model, (0.0, span), rtol=rtol, method=method, output_step=span / 50, progress=False)
        count = int((span + GAP / SPEED) / (2.0 * GAP / SPEED + math.pi / math.sqrt(STOP)))
        error = float(np.abs(run.coordinates[:, 0] - exact_place(run.times)).max() / GAP)
        energy = Result(model, run).energy
        what, note = (
            f"mass between two stops 2 mm apart, 1 m/s, {count} impacts",
            f"{method}, {run.statistics['steps']} steps",
        )
        if method == "dop853":  # of a method of low order energy is what can be asked for: its phase is lost
            reason = "errors of time add up impact by impact"
            yield Finding(what, count, "place over half the gap", error, 1e-2, reason, note)
        limit = 1e-5 if method == "dop853" else 0.2
        yield Finding(
            what, count, "energy, relative", float(np.abs(energy.balance_error).max() / energy.total[0]), limit,
            "the tolerance at every kink of the force, which jumps in its slope only", note,
        )  # fmt: skip
    for method in controlled_methods():
        yield from _resting(method)
        yield from _switching(method, effort)


def _resting(method: str) -> Iterator[Finding]:
    """Let a ball bounce on a damped stop until it lies still: ever smaller bounces, then none."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    force = CoordinateForce(limits=(0.0, None), limit_stiffness=1e5, limit_damping=40.0)
    scene.add_point("ball", 1.0, joint=Prismatic("z", position=0.5, forces=force))
    model = scene.freeze()
    run = integrate(model, (0.0, 10.0), rtol=1e-7, method=method, output_step=0.01, progress=False)
    sunk = float(abs(run.coordinates[-1, 0] + 9.81 / 1e5))
    bounces = int(np.count_nonzero(np.diff(np.sign(run.speeds[:, 0])) > 0))
    note = f"{method}, {run.statistics['steps']} steps"
    yield Finding(
        "ball that bounces on a damped stop until it lies", bounces, "depth at rest [m]", sunk, 1e-6,
        "a hundredth of the depth of 1e-4 m", note,
    )  # fmt: skip
    energy = Result(model, run).energy
    yield Finding(
        "ball that bounces on a damped stop until it lies", bounces, "energy, relative",
        float(np.abs(energy.balance_error).max() / energy.kinetic.max()), 1e-3 if method == "dop853" else 0.02,
        "the tolerance at every jump" if method == "dop853" else "order 2, and a jump of the force at every landing",
        note,
    )  # fmt: skip


def _switching(method: str, effort: Effort) -> Iterator[Finding]:
    """Turn a disc by a torque that changes its sign a thousand times a second."""
    scene = System()
    disc = scene.add_rigid_body("disc", 1.0, 1.0, joint=Revolute("z"))
    rate, torque = 1000.0, 1e3
    scene.add_motor(disc, lambda t: torque if (t * rate) % 2.0 < 1.0 else -torque)
    model = scene.freeze()
    span = 1.0 if not effort.is_quick else 0.1
    rtol = 1e-6 if method == "dop853" else 1e-8
    run = integrate(model, (0.0, span), rtol=rtol, method=method, output_step=span / 10, progress=False)
    # each pair of pulses adds torque / rate^2 to the angle, and leaves no speed
    exact = torque * run.times / (2.0 * rate)
    error = float(np.abs(run.coordinates[:, 0] - exact).max())
    limit = 1e-5 * span * rate * span
    reason = "1e-6 of the speed of 1 rad/s a step, some ten steps a jump, over the time left"
    if method != "dop853":
        # an error of angle e at a jump leaves one of speed, sqrt(2 e torque), of random sign
        limit = 4.0 * math.sqrt(2.0 * rtol * torque * span * rate / 3.0) * span
        reason = "1e-8 rad a jump; the error of speed is its root: four times the deviation of their sum"
    yield Finding(
        f"torque of 1000 N m on 1 kg m2 that changes its sign {span * rate:.0f} times", int(span * rate), "angle [rad]",
        error, limit, reason, f"{method}, {run.statistics['steps']} steps",
    )  # fmt: skip


CASES = (StressCase("events", "event storms", impacts),)
