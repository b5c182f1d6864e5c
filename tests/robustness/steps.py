"""Steps and tolerances far too large: a run ends with finite states, or says why it cannot and what to try."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from kanefe.checks.robustness.bodies import lattice
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import controlled_methods, ended, stepped_methods, suits
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.joints import Free, Motion, Prismatic, Revolute, Spherical
from kanefe.system import System
from robustness.outcomes import all_finite
from robustness.overconstrained import four_bar
from robustness.tripod import tripod

STEPS = (0.1, 1.0, 10.0, 1000.0)
"""Step sizes, s; the fastest motions of the scenes have periods from 2 s down to 1e-6 s."""

TOLERANCES = (1e-2, 0.1, 0.5, 0.99)
COUNT = 50
"""Number of steps of each run."""


def pendulum() -> Model:
    """Return a double pendulum."""
    scene = System(gravity=(0.0, -9.81, 0.0))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.5, 0, 0), joint=Revolute("z", position=0.3))
    scene.add_rigid_body("lower", 1.0, 0.1, com=(0.5, 0, 0), at=(1, 0, 0), parent=upper, joint=Revolute("z"))
    return scene.freeze()


def spinning_top() -> Model:
    """Return a heavy top at 100 rad/s."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    joint = Spherical(orientation=(1.0, 0.3, 0.1, 0.0), angular_velocity=(1.0, 2.0, 100.0))
    scene.add_rigid_body("top", 1.0, (0.1, 0.1, 0.05), com=(0.0, 0.0, 0.3), joint=joint)
    return scene.freeze()


def stiff_body() -> Model:
    """Return a body of 1 Hz, 1 kHz and 1 MHz on a hub that turns and falls."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=Free(angular_velocity=(0.5, 1.0, -0.3)))
    scene.add_flexible_body("body", tripod((1.0, 1e3, 1e6), np.eye(3)), parent=hub)
    return scene.freeze()


def soft_body() -> Model:
    """Return a soft damped flexible body on a hinge, with a driven body on its tip."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    arm = scene.add_flexible_body("arm", lattice(1, modes=2, damping=0.02), joint=Revolute("y"))
    scene.add_rigid_body(
        "wheel",
        0.3,
        0.01,
        com=(0.1, 0, 0),
        parent=arm.interface("tip"),
        joint=Revolute("z", motion=Motion.steady(20.0)),
    )
    return scene.freeze()


def stiff_spring() -> Model:
    """Return a point between a soft and a stiff spring."""
    scene = System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_point("ball", 1e-3, at=(0, 0, -1), joint=Prismatic("z"))
    scene.add_spring("stiff", scene.ground, ball, stiffness=1e9, damping=1.0, rest_length=0.999)
    return scene.freeze()


SCENES: dict[str, Callable[[], Model]] = {
    "double pendulum": pendulum,
    "spinning top": spinning_top,
    "body of 1 Hz to 1 MHz": stiff_body,
    "soft body with a driven wheel": soft_body,
    "stiff spring": stiff_spring,
    "four-bar": lambda: four_bar(Revolute("z")),
}


def too_large(effort: Effort) -> Iterator[Finding]:
    """Try every method with steps, or tolerances, that cannot work."""
    for method in stepped_methods():
        tries: list[tuple[float, dict[str, Any]]] = [(COUNT * h, {"step": h, "output_step": h}) for h in STEPS]
        yield _tried(method, f"steps of {STEPS[0]:g} ... {STEPS[-1]:g} s", tries)
    for method in controlled_methods():
        tries = [(1e-4 if effort.is_quick else 0.05, {"rtol": rtol}) for rtol in TOLERANCES]
        yield _tried(method, f"rtol of {TOLERANCES[0]:g} ... {TOLERANCES[-1]:g}", tries)


def _tried(method: str, what: str, tries: list[tuple[float, dict[str, Any]]]) -> Finding:
    wrong, failed, count, names = 0, 0, 0, []
    for name, scene in SCENES.items():
        if not suits(method, scene()):
            continue
        for span, options in tries:
            count += 1
            verdict = _verdict(scene(), span, method, options)
            failed += verdict == "told"
            if verdict not in ("finished", "told"):
                wrong += 1
                names.append(f"{name} {options.get('step', options.get('rtol'))}: {verdict}")
    note = f"{method}, {failed} end with advice" + (f"; {names[0]}" if names else "")
    return Finding(
        f"scenes of all kinds, {what}",
        count,
        "neither finite nor told with advice",
        float(wrong),
        0.0,
        "no NaN, no hang, no error without a remedy",
        note,
    )


def _verdict(model: Model, span: float, method: str, options: dict[str, Any]) -> str:
    """Return "finished", "told" of a failure that says when and what to try, or what went wrong."""
    try:
        with np.errstate(all="ignore"):
            run = ended(model, span, method=method, **options)
    except (SimulationError, ArithmeticError, ValueError, np.linalg.LinAlgError) as problem:
        return f"{type(problem).__name__}: {problem}"
    if not all_finite(run):
        return "not finite"
    status = run.status
    if status is None or status.is_finished:
        return "finished"
    return "told" if status.kind == "failed" and status.reason and status.remedy else str(status)


CASES = (StressCase("large-steps", "steps far too large", too_large),)
