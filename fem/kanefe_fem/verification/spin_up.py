"""Spin-up of a flexible arm (D01): the scene and its checks, for arms of any elements."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Check, Reference
from kanefe.checks.verification.scenes import Sample, states_at
from kanefe.equations.model import Model
from kanefe.joints import Motion, Revolute
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System

LENGTH, EA, GA, EI, LINE_MASS, LINE_INERTIA = 10.0, 2.8e7, 1e7, 1.4e4, 1.2, 6e-4
"""Arm: length, m; EA and GA, N; EI, N m2; mass per length, kg/m; rotary inertia per length, kg m."""

DENSITY = 1000.0
AREA = LINE_MASS / DENSITY
SIDE = math.sqrt(12.0 * EI / EA)
"""Side of a square section with this ratio of EI to EA, m. The solid has its own density."""

START_TIME, FINAL_RATE = 15.0, 6.0

STEP = 0.01
"""Interval of the states in which the peak is searched, s; a parabola through three of them is accurate to 1e-6 m."""

Arm = Callable[[StiffeningLevel], FlexibleBody]
"""Function of the stiffening that makes the arm along x from the origin, with the interfaces "root", clamped, and
"tip"."""


def spin_up() -> Motion:
    """Return the angle of the hub."""
    a = 2.0 * math.pi / START_TIME
    rate = FINAL_RATE / START_TIME

    def angle(t: float) -> float:
        return rate * (0.5 * t * t + (math.cos(a * t) - 1.0) / a**2) if t < START_TIME else FINAL_RATE * (t - 7.5)

    def speed(t: float) -> float:
        return rate * (t - math.sin(a * t) / a) if t < START_TIME else FINAL_RATE

    def acceleration(t: float) -> float:
        return rate * (1.0 - math.cos(a * t)) if t < START_TIME else 0.0

    return Motion(angle, speed, acceleration)


def tip_motion(model: Model, state: Sample) -> np.ndarray:
    """Return translation and slopes of the tip in G, (6,), foreshortening included if the body has it."""
    terms = model.flexible_terms("arm")
    return terms.body.interface("tip").moved(state[1][terms.eta])[0]


def spin_up_checks(reference: Reference, arm: Arm, label: str) -> Iterator[Check]:
    """Yield the checks of D01 for one kind of arm."""
    values = reference.values
    stiffened = arm("full")
    yield from spun_checks(
        reference, stiffened, f"{stiffened.free_count} coordinates, {label}", (2e-3, 1e-2, 1e-2, 2e-2)
    )

    # without stiffening the arm is unstable above its first frequency of 3.80 rad/s
    expected = {float(t): v for t, v in values["linear_no_stiffening_v"].items() if float(t) <= 9.0}
    model = _scene(arm("none"))
    found = [tip_motion(model, state)[1] for state in _run(model, list(expected))]
    early = [i for i, t in enumerate(expected) if t <= 7.5]
    quantity = f"deflection to 7.5 s without stiffening, {label} [m]"
    yield Check.relative(quantity, np.array(found)[early], np.array(list(expected.values()))[early], 1e-2)
    late = float(found[list(expected).index(8.0)] < -2.0 and found[list(expected).index(9.0)] < -7.0)
    yield Check.absolute(f"whether it diverges without stiffening, {label}", late, 1.0, 0.0)


def spun_checks(
    reference: Reference, arm: FlexibleBody, label: str, tolerances: tuple[float, float, float, float]
) -> Iterator[Check]:
    """Yield the checks of an arm that stiffens: its largest deflection, when, its steady and its least stretch."""
    values = reference.values
    model = _scene(arm)
    times = np.arange(STEP, 18.0 + 0.5 * STEP, STEP).round(6)
    motion = np.array([tip_motion(model, state) for state in _run(model, times.tolist())])
    lateral, axial = motion[:, 1], motion[:, 0]
    low = int(np.argmin(lateral))
    a, b, c = np.polyfit(times[low - 1 : low + 2] - times[low], lateral[low - 1 : low + 2], 2)
    of_peak, of_time, of_steady, of_least = tolerances
    yield Check.relative(f"largest deflection of the tip, {label} [m]", c - b * b / (4 * a), values["peak_v"], of_peak)
    yield Check.absolute(f"its time, {label} [s]", times[low] - b / (2 * a), values["t_peak"], of_time)
    steady = axial[times > 16.0].mean()
    yield Check.relative(f"steady stretch, {label} [m]", steady, values["u_steady"], of_steady)
    yield Check.relative(f"largest foreshortening, {label} [m]", axial.min(), values["min_u"], of_least)


def _scene(body: FlexibleBody) -> Model:
    scene = System()
    scene.add_flexible_body("arm", body, joint=Revolute("z", motion=spin_up()))
    return scene.freeze()


def _run(model: Model, times: list[float]) -> list[Sample]:
    return states_at(model, times, 1e-6, method="generalised-alpha")
