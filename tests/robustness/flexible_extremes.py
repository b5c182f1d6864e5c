"""Stiffness that differs by twelve powers of ten in one body: modes from 1 Hz to 1 MHz."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import ended, follow
from kanefe.equations.model import Model
from kanefe.frames import rotation_matrix
from kanefe.integrate.methods.table import METHODS
from kanefe.joints import Free
from kanefe.kane.energy import momenta
from kanefe.result import Result
from kanefe.states.state import State
from kanefe.system import System
from robustness.outcomes import implicit_methods, is_reported
from robustness.tripod import tripod

SOFT = 1.0
STIFF = (1e2, 1e4, 1e6)
"""Frequencies of the stiff mode, Hz; that of the third mode lies between the two."""

AMPLITUDE = 0.01
"""Initial displacement along the soft bar, m."""

DAMPING = 0.02
"""Damping ratio of every mode of the damped bodies."""

MOST_STEPS = 5000
"""Largest number of steps for ten periods of the soft mode: without numerical error in the stiff modes some hundreds
are needed."""

MOST_A_PERIOD = 200.0
"""Largest number of steps per period of a resolved mode at rtol 1e-6."""


def stiffness_ratios(effort: Effort) -> Iterator[Finding]:
    """Frequencies and motions of a mass on a soft and on stiff bars."""
    aligned, turned = [], []
    rng = np.random.default_rng(0)
    for stiff in STIFF:
        wanted = np.array((SOFT, np.sqrt(SOFT * stiff), stiff))
        aligned.append(np.abs(tripod(wanted, np.eye(3)).frequencies / wanted - 1.0).max())
        axes = rotation_matrix(rng.standard_normal(4))
        turned.append(np.abs(tripod(wanted, axes).frequencies / wanted - 1.0).max())
    what = "mass on three bars, 1 Hz beside 100 Hz ... 1 MHz,"
    yield Finding.of(f"{what} bars along x, y and z", aligned, "frequencies, relative", 1e-9, "K is exact: round-off")
    yield Finding.of(
        f"{what} turned in space",
        turned,
        "frequencies, relative",
        1e-3,
        "K has the round-off of its largest number: 1e12 times 2e-16 of the softest",
    )
    for method in implicit_methods():
        yield from _soft_motion(method, effort)
        yield from _struck(method, effort)


def _soft_motion(method: str, effort: Effort) -> Iterator[Finding]:
    """Ten periods of the soft mode: right, and not held up by the stiff ones."""
    errors, counts = [], []
    periods = effort.count(10, 2)
    for stiff in STIFF:
        model = _held(stiff, (AMPLITUDE, 0.0, 0.0), np.zeros(3))
        run = follow(model, periods / SOFT, rtol=1e-6, method=method)
        moved = run.coordinates @ _directions(model)
        exact = AMPLITUDE * np.cos(2.0 * np.pi * SOFT * run.times)
        errors.append(float(max(np.abs(moved[:, 0] - exact).max(), np.abs(moved[:, 1:]).max()) / AMPLITUDE))
        counts.append(run.statistics["steps"])
    what = f"soft mode of 1 Hz beside 100 Hz ... 1 MHz, {periods} periods"
    # rtol is of the body's size, some 100 amplitudes: 1e-4 of the amplitude a step, of which errors of phase add up
    yield Finding.of(what, errors, "error over amplitude", 0.05, "rtol of the body's size, over ten periods", method)
    yield Finding.of(what, counts, "steps", MOST_STEPS, "the soft mode alone takes some hundreds", method)


def _struck(method: str, effort: Effort) -> Iterator[Finding]:
    """All modes struck at the start in a free flight that turns: energy does not grow, momentum stays."""
    span = float(effort.count(5, 1))
    for damping in (0.0, DAMPING):
        growth, changes, missing, steps, untold = [], [], [], [], 0
        for stiff in STIFF:
            model = _struck_flight(stiff, damping)
            run = ended(model, span, rtol=1e-6, method=method, output_step=0.1, most_steps=MOST_STEPS * int(span))
            missing.append(1.0 - run.times[-1] / span)
            steps.append(run.statistics["steps"] / (run.times[-1] * stiff))
            untold += not is_reported(run)
            energy = Result(model, run).energy
            growth.append(float((energy.total - energy.total[0]).max() / energy.total[0]))
            momentum = np.array(
                [momenta(State(model, *at))[1] for at in zip(run.times, run.coordinates, run.speeds, strict=True)]
            )
            changes.append(float(np.abs(momentum - momentum[0]).max() / np.abs(momentum).max()))
        # one that damps what it doesn't resolve, and so keeps its step, or one that resolves every speed above atol
        follows = METHODS[method].takes_atol and not damping
        what = (
            f"free body with all modes from 1 Hz to 100 Hz ... 1 MHz struck at 0.1 m/s, damping {damping:g}, "
            f"tumbling, {span:g} s"
        )
        if follows:
            yield Finding.of(
                what,
                steps,
                "steps a period of the fastest mode",
                MOST_A_PERIOD,
                "known limit: vibrations above the tolerance are followed, where damping is zero for ever; an estimate "
                "of order 3 takes a hundred",
                method,
            )
            yield Finding(
                what,
                len(STIFF),
                "neither finished nor told with advice",
                float(untold),
                0.0,
                f"some end at {MOST_STEPS} steps a second, which is said",
                method,
            )
        else:
            yield Finding.of(
                what,
                missing,
                f"time not run in {MOST_STEPS} steps a second, relative",
                0.0,
                "vibrations of 1e-8 m at 1 MHz need not be followed, or die out",
                method,
            )
        yield Finding.of(what, growth, "energy gained, relative", 1e-3, "rtol 1e-6 a step, thousands of steps", method)
        yield Finding.of(what, changes, "angular momentum, relative", 0.01, "rtol 1e-6 rad a step", method)


def _struck_flight(stiff: float, damping: float) -> Model:
    scene = System()
    body = tripod((SOFT, np.sqrt(SOFT * stiff), stiff), np.eye(3), damping=damping)
    scene.add_flexible_body("body", body, joint=Free(angular_velocity=(0.3, 0.5, -0.4)))
    return _struck_model(scene.freeze(), (AMPLITUDE, 0.0, 0.0), np.array((0.0, 0.1, 0.1)))


def _held(stiff: float, displacement: tuple[float, float, float], speed: np.ndarray) -> Model:
    scene = System()
    scene.add_flexible_body("body", tripod((SOFT, np.sqrt(SOFT * stiff), stiff), np.eye(3)))
    return _struck_model(scene.freeze(), displacement, speed)


def _struck_model(model: Model, displacement: tuple[float, float, float], speed: np.ndarray) -> Model:
    """Return the model with its mass displaced and moving along the bars."""
    q, u = model.initial_coordinates.copy(), model.initial_speeds.copy()
    terms = model.flexible_terms("body")
    shapes = terms.body.basis[:3, : terms.body.free_count]
    q[terms.eta], u[terms.speeds] = np.linalg.solve(shapes, displacement), np.linalg.solve(shapes, speed)
    return replace(model, initial_coordinates=q, initial_speeds=u)


def _directions(model: Model) -> np.ndarray:
    """Return what takes the modal coordinates to the motion of the mass along the bars, (3, 3)."""
    body = model.flexible_terms("body").body
    return np.asarray(body.basis[:3, : body.free_count].T)


CASES = (StressCase("stiffness-ratio", "stiffness ratio 1 Hz to 1 MHz in one body", stiffness_ratios),)
