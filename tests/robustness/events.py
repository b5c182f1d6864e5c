"""Storms of events: thousands of impacts on stops, loads that jump a thousand times a second."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import controlled_methods, ended, follow, is_accurate, tolerance
from kanefe.equations.model import Model
from kanefe.integrate.events.event import Event
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.trajectory import Trajectory
from kanefe.joints import CoordinateForce, Prismatic, Revolute
from kanefe.result import Result
from kanefe.system import System
from kanefe.tree.scene_state import SceneState
from robustness.outcomes import all_finite

GAP, SPEED, STOP = 1e-3, 1.0, 1e6
"""Half the distance between two stops (m), speed (m/s) and stiffness (N/m) for a mass of 1 kg: an impact every 5 ms."""

LUCKY_ESTIMATE = 3e-6
"""Relative change of energy at an impact whose kink lies where the error estimate vanishes. This happens at one of some
hundred impacts, depending on round-off, so short runs are judged by it. The worst of 1,900 with radau5 is 2.5e-6."""


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


def _rattled(model: Model, span: float, method: str, **options: Any) -> Trajectory:
    """Run the rattler; errors count against the gap: the scene has no length by which kanefe could measure them."""
    rtol = tolerance(method, 1e-10, 1e-9)
    atol = {"atol": rtol * GAP} if METHODS[method].takes_atol else {}
    return follow(model, span, rtol=rtol, method=method, **atol, **options)


def impacts(effort: Effort) -> Iterator[Finding]:
    """Rattle between stops, and come to rest on one."""
    span = 10.0 if not effort.is_quick else 0.25
    for method in controlled_methods(rattler()):
        model = rattler()
        run = _rattled(model, span, method, output_step=span / 50)
        count = int((span + GAP / SPEED) / (2.0 * GAP / SPEED + math.pi / math.sqrt(STOP)))
        error = float(np.abs(run.coordinates[:, 0] - exact_place(run.times)).max() / GAP)
        energy = Result(model, run).energy
        what, note = (
            f"mass between two stops 2 mm apart, 1 m/s, {count} impacts",
            f"{method}, {run.statistics['steps']} steps",
        )
        if is_accurate(method):  # of a method of low order energy is what can be asked for: its phase is lost
            reason = "errors of time add up impact by impact"
            yield Finding(what, count, "place over half the gap", error, 1e-2, reason, note)
        limit = LUCKY_ESTIMATE + 4e-8 * count
        reason = "rtol 1e-10 of place and speed a step, a hundred steps an impact, on one side; one lucky estimate"
        if not is_accurate(method):
            limit, reason = 0.2, "order 2, and a kink of the force at every impact"
        yield Finding(
            what,
            count,
            "energy, relative",
            float(np.abs(energy.balance_error).max() / energy.total[0]),
            limit,
            reason,
            note,
        )
    for method in controlled_methods(rattler()):
        yield from _resting(method, 1e-7)
        if is_accurate(method):
            yield from _resting(method, 1e-9)
        yield from _switching(method, effort)


def _resting(method: str, rtol: float) -> Iterator[Finding]:
    """Let a ball bounce on a damped stop until it lies still: ever smaller bounces, then none."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    force = CoordinateForce(limits=(0.0, None), limit_stiffness=1e5, limit_damping=40.0)
    scene.add_point("ball", 1.0, joint=Prismatic("z", position=0.5, forces=force))
    model = scene.freeze()
    run = follow(model, 10.0, rtol=rtol, method=method, output_step=0.01)
    sunk = float(abs(run.coordinates[-1, 0] + 9.81 / 1e5))
    bounces = int(np.count_nonzero(np.diff(np.sign(run.speeds[:, 0])) > 0))
    what = f"ball that bounces on a damped stop until it lies, rtol {rtol:g}"
    note = f"{method}, {run.statistics['steps']} steps"
    yield Finding(
        what,
        bounces,
        "depth at rest [m]",
        sunk,
        1e-6,
        "a hundredth of the depth of 1e-4 m",
        note,
    )
    energy = Result(model, run).energy
    limit, reason = 1e-3, "the tolerance at every jump"
    if method == "extrapolation":
        limit, reason = 0.02, "known limit: a jump between the first two substeps of all columns is taken for a tangent"
    elif not is_accurate(method):
        limit, reason = 0.02, "order 2, and a jump of the force at every landing"
    yield Finding(
        what,
        bounces,
        "energy, relative",
        float(np.abs(energy.balance_error).max() / energy.kinetic.max()),
        limit,
        reason,
        note,
    )


RATE, TORQUE = 1000.0, 1e3
"""Sign changes per second, and amplitude of the torque, N m."""

SWITCHES = 20
"""Number of switches of each run: methods are not informed of pulses shorter than a sixtieth of a run, and may step
over one."""


def _switching(method: str, effort: Effort) -> Iterator[Finding]:
    """Turn a disc by a torque that changes its sign a thousand times a second, from any moment of it."""
    rng = np.random.default_rng(0)
    runs = effort.count(50, 4)
    span = SWITCHES / RATE
    rtol = tolerance(method, 1e-6, 1e-8)
    errors, steps = [], 0
    for phase in rng.uniform(0.0, 2.0, runs).tolist():
        scene = System()
        disc = scene.add_rigid_body("disc", 1.0, 1.0, joint=Revolute("z"))
        scene.add_motor(disc, lambda t, phase=phase: TORQUE if (t * RATE + phase) % 2.0 < 1.0 else -TORQUE)
        run = follow(scene.freeze(), span, rtol=rtol, method=method, output_step=span / 10)
        errors.append(float(np.abs(run.coordinates[:, 0] - _switched_angle(run.times, phase)).max()))
        steps += run.statistics["steps"]
    figure, worst, limit = "angle [rad]", float(np.max(errors)), 1e-4 * SWITCHES * span
    reason = "1e-6 of the speed of 1 rad/s a step, a hundred steps a jump, over the time left"
    if not is_accurate(method):
        # an error of angle e at a jump leaves one of speed, sqrt(2 e torque), of random sign
        figure, worst = "angle, root mean square of the runs [rad]", float(np.sqrt(np.mean(np.square(errors))))
        limit = 2.0 * math.sqrt(2.0 * rtol * TORQUE * SWITCHES / 3.0) * span
        reason = "1e-8 rad a jump; the error of speed is its root: twice the deviation of their sum"
    yield Finding(
        f"torque of 1000 N m on 1 kg m2 that changes its sign 1000 times a second: {runs} runs of {SWITCHES} changes",
        runs * SWITCHES,
        figure,
        worst,
        limit,
        reason,
        f"{method}, {steps} steps",
    )


def _switched_angle(t: np.ndarray, phase: float) -> np.ndarray:
    """Return the angle: the speed is a triangle wave, from zero at the start."""
    x = t * RATE + phase
    first = _wave(np.array(phase))
    return TORQUE / RATE**2 * (_wave_sum(x) - _wave_sum(np.array(phase)) - first * (x - phase))


def _wave(x: np.ndarray) -> np.ndarray:
    return np.asarray(1.0 - np.abs(x % 2.0 - 1.0))


def _wave_sum(x: np.ndarray) -> np.ndarray:
    """Return the integral of the triangle wave from zero."""
    rest = x % 2.0
    return np.asarray(np.floor(x / 2.0) + np.where(rest < 1.0, 0.5 * rest**2, 1.0 - 0.5 * (2.0 - rest) ** 2))


def named_events(effort: Effort) -> Iterator[Finding]:
    """Find thousands of named events, and bounces that would never end."""
    span = 10.0 if not effort.is_quick else 0.25

    def middle(t: float, state: SceneState) -> float:
        return float(state.joint_coordinates("mass")[0])

    half = 2.0 * GAP / SPEED + math.pi / math.sqrt(STOP)
    for method in controlled_methods(rattler()):
        if not is_accurate(method):
            continue
        model = rattler()
        run = _rattled(model, span, method, events=Event("middle", middle))
        found = run.events["middle"]
        # the start itself is no passage
        exact = half * np.arange(1, int(span / half) + 1)
        note = f"{method}, {len(found)} found"
        missed = abs(len(found[found > 0.1 * half]) - len(exact))
        yield Finding(
            "mass between two stops: its passages of the middle",
            len(exact),
            "passages missed or made up",
            float(missed),
            0.0,
            "each is a change of sign",
            note,
        )
        if not missed:
            error = float(np.abs(found[found > 0.1 * half] - exact).max())
            yield Finding(
                "mass between two stops: its passages of the middle",
                len(exact),
                "time of a passage [s]",
                error,
                1e-5,
                "a hundredth of half the gap at 1 m/s, as its place",
                note,
            )
        yield _restitution(method)
    yield _endless()


def _bouncer(share: float) -> tuple[Model, Event]:
    """Return a ball 1 m above the floor, and its bounces, which leave a share of its speed."""

    def height(t: float, state: SceneState) -> float:
        return float(state.joint_coordinates("ball")[0])

    def bounce(t: float, state: SceneState) -> np.ndarray:
        y = state.vector
        y[1] *= -share
        return np.asarray(y)

    scene = System(gravity=(0.0, 0.0, -9.81))
    scene.add_point("ball", 0.1, joint=Prismatic("z", position=1.0))
    return scene.freeze(), Event("floor", height, direction=-1, action=bounce)


def _restitution(method: str) -> Finding:
    """Bounce 500 times without loss."""
    count = 500
    model, event = _bouncer(1.0)
    first = math.sqrt(2.0 / 9.81)
    run = follow(model, first * 2 * count, rtol=1e-9, method=method, events=event)
    exact = first * (2 * np.arange(count) + 1)
    found = run.events["floor"]
    error = float(np.abs(found - exact).max()) if len(found) == count else float("nan")
    return Finding(
        f"ball that bounces {count} times without loss, by an event that turns its speed",
        count,
        "time [s]",
        error,
        1e-6,
        "its flights are parabolas: the time of each landing, twice a bounce",
        f"{method}, {len(found)} found",
    )


def _endless() -> Finding:
    """Bounce with loss: infinitely often before 4.5 s. The run must end, and say why."""
    model, event = _bouncer(0.8)
    run = ended(model, 10.0, rtol=1e-6, method="dop853", events=event)
    status = run.status
    told = status is not None and not status.is_finished and bool(status.reason) and bool(status.remedy)
    end = math.sqrt(2.0 / 9.81) * (1.0 + 2.0 * 0.8 / (1.0 - 0.8))
    is_there = abs(float(run.times[-1]) - end) < 1e-3 and all_finite(run)
    return Finding(
        f"ball that bounces ever faster, infinitely often before {end:.3f} s",
        len(run.events["floor"]),
        "not stopped there with advice",
        float(not (told and is_there)),
        0.0,
        "a storm of events is named, not followed for ever",
        "" if status is None else str(status)[:120],
    )


def storms(effort: Effort) -> Iterator[Finding]:
    """Try all of them."""
    yield from impacts(effort)
    yield from named_events(effort)


CASES = (StressCase("events", "event storms", storms),)
