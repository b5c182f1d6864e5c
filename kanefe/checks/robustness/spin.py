"""Rotors below, at, between and above critical speeds: stable and unstable where theory predicts it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy.linalg

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import controlled_methods, follow, is_accurate, tolerance
from kanefe.checks.verification.rotors import point_on_springs, spin_eigenvalues
from kanefe.joints import Spherical
from kanefe.system import System

FIRST, SECOND = 100.0, 120.0
"""Natural frequencies of the point of D04b across the shaft, rad/s: spins between them are unstable."""

SPINS = (0.0, 50.0, 90.0, 99.0, 99.99, 100.0, 100.01, 101.0, 110.0, 119.0, 119.99, 120.0, 120.01, 121.0, 150.0, 400.0)
FEW_SPINS = (50.0, 100.0, 110.0, 120.01)
SPAN = 0.2
START = (1e-3, 0.5e-3, 0.0, 0.0)
"""Initial x, y (m) and their rates (m/s) relative to the shaft."""


def exact_states(spin: float, times: np.ndarray) -> np.ndarray:
    """Return x, y and their rates, (T, 4), in the rotating frame: ``x'' = 2 s y' - (a^2 - s^2) x``, and so on."""
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2, 0], A[3, 1] = spin**2 - FIRST**2, spin**2 - SECOND**2
    A[2, 3], A[3, 2] = 2.0 * spin, -2.0 * spin
    return np.array([scipy.linalg.expm(A * t) @ START for t in times])


def is_unstable(spin: float) -> bool:
    """Return whether the displacement of the point grows exponentially."""
    return FIRST < spin < SECOND


def spinning_point(effort: Effort) -> Iterator[Finding]:
    """Check runs and eigenvalues of a point on two springs on a spinning shaft (D04b)."""
    swept = np.linspace(0.0, 400.0, effort.count(4001, 161)) + 0.05
    wrong = sum((spin_eigenvalues(point_on_springs(s)).real.max(initial=0.0) > 1e-6) != is_unstable(s) for s in swept)
    yield Finding(
        "D04b: point on springs, spins from 0 to 400 rad/s, critical between 100 and 120",
        len(swept),
        "eigenvalues on the wrong side",
        float(wrong),
        0.0,
        "predicted in closed form",
    )
    for method in controlled_methods():
        errors, growths = [], []
        # methods of second order take thousands of steps: the short form has one spin of each kind
        chosen = FEW_SPINS if effort.is_quick and not is_accurate(method) else SPINS
        for spin in chosen:
            model = point_on_springs(spin)
            model = replace(model, initial_coordinates=np.array(START[:2]), initial_speeds=np.array(START[2:]))
            rtol = tolerance(method, 1e-10, 1e-8)
            run = follow(model, SPAN, rtol=rtol, method=method, output_step=SPAN / 20)
            exact = exact_states(spin, run.times)[:, :2]
            errors.append(float(np.abs(run.coordinates - exact).max() / np.abs(exact).max()))
            found, wanted = (np.linalg.norm(x, axis=1).max() for x in (run.coordinates, exact))
            growths.append(abs(float(np.log(found / wanted))))
        limit, reason = 1e-6, "rtol 1e-10 of a step over hundreds of steps"
        if not is_accurate(method):
            # 1e-8 of the scene's length of 1 m, where the motion is of 1 mm
            limit, reason = 0.05, "rtol 1e-8 m a step over thousands of steps, of a motion of 1 mm"
        what = f"D04b: {len(chosen)} spins below, at, between and above, {SPAN:g} s"
        yield Finding.of(what, errors, "x and y, relative", limit, reason, method)
        yield Finding.of(what, growths, "growth against prediction, log", limit, reason, method)


def sleeping_top(effort: Effort) -> Iterator[Finding]:
    """Check an upright heavy top below, at and above the spin from which it is stable (Klein and Sommerfeld).

    The tilt ``z = x + i y`` of a top that spins at s satisfies ``A z'' - i C s z' - m g l z = 0`` while it is small.
    """
    mass, length, across, along, g = 1.0, 0.5, 0.3, 0.02, 9.81
    critical = 2.0 * math.sqrt(mass * g * length * across) / along
    about_com, start = across - mass * length**2, 1e-6
    errors = []
    for share in (0.0, 0.5, 0.9, 0.98, 1.0, 1.02, 1.1, 2.0):
        scene = System(gravity=(0.0, 0.0, -g))
        orientation = (1.0, 0.5 * start, 0.0, 0.0)
        joint = Spherical(orientation=orientation, angular_velocity=(0.0, 0.0, share * critical))
        scene.add_rigid_body("top", mass, (about_com, about_com, along), com=(0.0, 0.0, length), joint=joint)
        span = 2.5 if not effort.is_quick else 1.0
        run = follow(scene.freeze(), span, rtol=1e-11, method="dop853", output_step=span / 50)
        e = run.coordinates
        tilt = 2.0 * np.hypot(e[:, 1], e[:, 2]) / np.linalg.norm(e, axis=1)
        turning = 0.5 * along * share * critical / across
        growth = cmath.sqrt(mass * g * length / across * (1.0 - share**2)) or 1e-12
        exact = start * np.abs(np.cosh(growth * run.times) - 1j * turning * np.sinh(growth * run.times) / growth)
        errors.append(float(np.abs(tilt - exact).max() / exact.max()))
    yield Finding.of(
        f"upright top at 0 ... 2 times the critical {critical:.0f} rad/s, tilted by {start:g} rad",
        errors,
        "tilt against linear theory, relative",
        1e-3,
        "the square of the tilt, which grows to 0.02 rad",
    )


def spins(effort: Effort) -> Iterator[Finding]:
    """Run `spinning_point` and `sleeping_top`."""
    yield from spinning_point(effort)
    yield from sleeping_top(effort)


CASES = (StressCase("spin", "spin below, at and above the critical speed", spins),)
