"""Steps of a viscoelastic arm with a tool against those of an elastic one of the same modes, of the same number."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import kanefe as kf
from benchmarks.clocks import Race, seconds
from benchmarks.goals import Figure, Goal

STEP = "a step of a viscoelastic arm on a hinge with a tool / of an elastic one of the same {modes} modes, {method}"

METHODS: dict[str, Mapping[str, Any]] = {
    "dop853": {"method": "dop853", "rtol": 1e-6},
    "radau5": {"method": "radau5", "step": 2e-3},
    "generalised-alpha": {"method": "generalised-alpha", "step": 1e-3},
}
SPANS = {"dop853": 0.02, "radau5": 1.0, "generalised-alpha": 1.0}
"""Lengths of runs, s."""

MODES = 2, 6
"""Normal modes kept; the six of the tip come on top."""

GOALS = {(modes, name): Goal(STEP.format(modes=modes + 6, method=name), 1.3) for modes in MODES for name in METHODS}


def arm(modes: int, prony: list[tuple[float, float]]) -> kf.System:
    """Return the arm."""
    from kanefe_fem import Material, Rectangle, beam_body, straight_beam

    material = Material(E=210e9, nu=0.3, rho=7850.0, prony=prony)
    damping = None if prony else kf.RayleighDamping(stiffness=1e-5)
    model = straight_beam(1.0, Rectangle(0.05, 0.01), material)
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=modes), damping)
    scene = kf.System(gravity=(0, 0, -9.81))
    member = scene.add_flexible_body("arm", body, joint=kf.Revolute("y", speed=0.5))
    scene.add_rigid_body("tool", 1.0, 0.01, parent=member.interface("tip"))
    return scene


def step(scene: kf.System, name: str) -> float:
    """Return the CPU time of a step by a method, s."""
    found: list[Any] = []
    taken = seconds(lambda: found.append(scene.simulate((0.0, SPANS[name]), **METHODS[name])))
    return float(taken / found[0].statistics["steps"])


def of_viscoelastic_steps(rounds: int) -> list[Figure]:
    """Compare the time of a step."""
    figures = []
    for (modes, name), goal in GOALS.items():
        scenes = arm(modes, [(0.3, 0.02)]), arm(modes, [])

        race = Race(partial(step, scenes[0], name), partial(step, scenes[1], name), rounds)
        figures.append(goal.figure(race.ratio, f"{1e6 * race.ours:.3g} us against {1e6 * race.theirs:.3g} us"))
    return figures


GROUPS = {of_viscoelastic_steps: list(GOALS.values())}
