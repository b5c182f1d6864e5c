"""Vibrations that nothing damps, by the method taken by itself: however they begin, they neither grow nor fade."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from kanefe.checks.robustness.bodies import lattice
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.equations.model import Model
from kanefe.integrate.events.event import Event
from kanefe.integrate.trajectory import Trajectory
from kanefe.joints import CoordinateForce, Fixed, Revolute
from kanefe.scene.scene import FlexibleMember
from kanefe.system import System
from kanefe.tree.scene_state import SceneState

TOLERANCES = tuple(10.0**-k for k in range(3, 11))
FEW_TOLERANCES = (1e-3, 1e-4, 1e-6)
AMPLITUDE = 0.02
"""Amplitude of the slowest mode relative to the one that moves the body by its own length."""

GROWTH = 100.0
"""Largest rise of the energy in a run of any length, as a multiple of rtol."""

FADING = 10.0
"""Largest loss of energy per period, as a multiple of rtol, for rtol of 1e-4 or less."""


def _amplitude(model: Model) -> tuple[np.ndarray, float]:
    """Return modal coordinates at the start, and the frequency of the slowest mode in rad/s."""
    terms = model.flexible_terms("body")
    body, k = terms.body, terms.body.free_count
    frequency = math.sqrt(float(np.diag(body.stiffness)[0] / np.diag(body.moments.elastic_mass)[0]))
    return AMPLITUDE * math.sqrt(body.mass) * np.eye(k)[0], frequency


def _held(coordinates: float = 0.0, speeds: float = 0.0) -> Model:
    """Return a clamped body whose slowest mode is bent, or moves, by shares of the amplitude."""
    body = lattice(2, modes=3)
    bare = System()
    bare.add_flexible_body("body", body, joint=Fixed())
    eta, frequency = _amplitude(bare.freeze())
    scene = System()
    bent, moving = (coordinates * eta).tolist(), (speeds * frequency * eta).tolist()
    scene.add_flexible_body("body", body, joint=Fixed(), modal_coordinates=bent, modal_speeds=moving)
    return scene.freeze()


def _by_deflection(rtol: float, span: float) -> Trajectory:
    return follow(_held(coordinates=1.0), span, rtol=rtol, output_step=span / 50)


def _by_speed(rtol: float, span: float) -> Trajectory:
    return follow(_held(speeds=1.0), span, rtol=rtol, output_step=span / 50)


def _by_event(rtol: float, span: float) -> Trajectory:
    """Strike the body at rest after a tenth of the run."""
    model = _held()
    eta, frequency = _amplitude(model)
    where = model.flexible_terms("body").speeds

    def strike(t: float, state: SceneState) -> np.ndarray:
        struck = state.vector.copy()
        struck[model.coordinate_count :][where] += frequency * eta
        return struck

    event = Event("strike", lambda t, state: t - 0.1 * span, action=strike)
    return follow(model, span, rtol=rtol, output_step=span / 50, events=event)


STARTS: dict[str, Callable[[float, float], Trajectory]] = {
    "a deflection": _by_deflection,
    "speeds": _by_speed,
    "an impulse in the run": _by_event,
}


def undamped(effort: Effort) -> Iterator[Finding]:
    """Follow the slowest mode of a clamped body over many periods."""
    model = _held(coordinates=1.0)
    _, frequency = _amplitude(model)
    periods = effort.count(10_000, 200)
    span = 2.0 * math.pi * periods / frequency
    for name, start in STARTS.items():
        growths, falls = [], []
        for rtol in FEW_TOLERANCES if effort.is_quick else TOLERANCES:
            run = start(rtol, span)
            energy = np.array([model.route.energy(t, y).total for t, y in zip(run.times, _states(run), strict=True)])
            begun = energy[energy > 0.0][0]
            growths.append((energy.max() / begun - 1.0) / rtol)
            if rtol <= 1e-4:
                falls.append((1.0 - energy[-1] / begun) / periods / rtol)
        what = f"auto, slowest mode without damping, {periods} periods from {name}, rtol {TOLERANCES[0]:g} and less"
        yield Finding.of(what, growths, "energy gained over rtol", GROWTH, "what a tolerance promises at most")
        yield Finding.of(what, falls, "energy lost a period over rtol", FADING, "some steps a period, rtol each")


def _states(run: Trajectory) -> np.ndarray:
    return np.hstack((run.coordinates, run.speeds, run.internal))


def stiff_joints(effort: Effort) -> Iterator[Finding]:
    """Run hard stops, dry friction and controllers in Python by the method that is taken by itself: few steps do."""
    span = float(effort.count(2, 1))
    for name, scene in (("a stop of 1e9 N m/rad", _stopped), ("dry friction", _rubbing), ("a controller", _controlled)):
        run = follow(scene().freeze(), span, rtol=1e-5, output_step=span / 10)
        yield Finding(
            f"auto, arm of modes from some to some hundred hertz with {name}, {span:g} s",
            1,
            "evaluations",
            float(run.statistics["evaluations"]),
            5e4 * span,
            "the modes alone take some thousands; what cannot take the stiffness, some million",
            str(run.statistics["method"]),
        )


def _arm(forces: CoordinateForce | None = None) -> tuple[System, FlexibleMember]:
    scene = System(gravity=(0.0, 0.0, -9.81))
    body = lattice(2, modes=3, damping=0.02, spring=1e5)
    arm = scene.add_flexible_body("body", body, joint=Revolute("y", position=-0.3, forces=forces))
    scene.add_rigid_body("load", 1e-2, 1e-6, parent=arm.interface("tip"))
    return scene, arm


def _stopped() -> System:
    return _arm(CoordinateForce(limits=(-1.0, 0.3), limit_stiffness=1e9, limit_damping=1e3))[0]


def _rubbing() -> System:
    return _arm(CoordinateForce(friction=5.0))[0]


def _controlled() -> System:
    scene, arm = _arm()

    def torque(t: float, state: SceneState) -> float:
        return float(-4e3 * state.joint_coordinates("body")[0] - 250.0 * state.joint_speeds("body")[0])

    scene.add_motor(arm, torque)
    return scene


CASES = (
    StressCase("undamped", "vibrations without damping, method auto", undamped),
    StressCase("stiff-joints", "stops, friction and controllers, method auto", stiff_joints),
)
