"""Figures of what contacts cost an evaluation: patches that touch, patches out of reach, and blocks of fine meshes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.clocks import Race, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.steel_bar import SIZE, bar_model
from kanefe.checks.verification.scenes import whole_run
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane, Sphere
from kanefe.equations.model import Model
from kanefe.fe_model.places import InBox
from kanefe.joints import Free
from kanefe.reduction import CraigBampton
from kanefe.reduction.build import flexible_body
from kanefe.system import System
from kanefe_fem.verification.sliding_block import block_on_slope

MODES, PATCHES, POINTS = 16, 8, 4
TOUCHING_GOAL = Goal(f"{MODES} modes, {PATCHES} patches of {POINTS} points on a floor: right-hand side / without", 1.5)
AWAY_GOAL = Goal("the same, none in reach", 1.05)
MESH_GOAL = Goal("block of 20k nodes on a slope (K03): step / that of 2k nodes", 1.1)
BALLS_GOAL = Goal("100 balls, 4,950 contacts of which none touches: right-hand side / without contacts", 2.0)

STATES, REPEATED = 200, 20
"""Number of states evaluated in one call, and of calls between two readings of the clock. More states leave the cache.
"""

CELLS = (10, 2, 1)
COARSE, FINE = (12, 12, 3), (30, 30, 6)
"""Numbers of quadratic hexahedra of a block along its edges: 2,289 and 20,293 nodes."""


def patches(machine: Machine) -> list[Figure]:
    """Compare evaluations of a bar that lies on patches, with friction and without, with those of the bar alone."""
    model = bar_model(CELLS)
    body = flexible_body(model, {}, reduction=CraigBampton(modes=MODES))

    def bar(count: int, height: float, friction: Coulomb | None = None) -> Model:
        scene, below = System(gravity=(0.0, 0.0, -9.81)), -SIZE[2] / 2
        member = scene.add_flexible_body("bar", body, joint=Free(position=(0.0, 0.0, height)))
        floor = scene.add_surface("floor", scene.ground, Plane("z"), at=(0.0, 0.0, below + 1e-5))
        for i in range(count):
            lower, upper = (
                (i / count - 1e-3, -1.0, -SIZE[2] / 2 - 1e-6),
                ((i + 1) / count + 1e-3, 1.0, -SIZE[2] / 2 + 1e-6),
            )
            patch = member.patch(InBox(lower, upper), most=POINTS)
            scene.add_contact(f"patch {i}", patch, floor, normal=HuntCrossley(1e7, 0.3), friction=friction)
        return scene.freeze()

    rounds, alone = machine.rounds, bar(0, 0.0)
    figures = []
    for goal, height in ((TOUCHING_GOAL, 0.0), (AWAY_GOAL, 1.0)):
        smooth, rough = (
            Race(_evaluations(bar(PATCHES, height, law)), _evaluations(alone), rounds) for law in (None, Coulomb(0.5))
        )
        told = (
            f"with friction, whose {PATCHES * (2 + 3 * POINTS)} states are evaluated too; without it {smooth.ratio:.3g}"
        )
        figures.append(goal.figure(rough.ratio, told))
    return figures


def balls(machine: Machine) -> list[Figure]:
    """Compare evaluations of balls that may all touch each other with those of balls that may not."""

    def cloud(is_touched: bool) -> Model:
        scene, places = System(), np.random.default_rng(1).uniform(-5.0, 5.0, (100, 3))
        skins = []
        for i, place in enumerate(places):
            ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.1, joint=Free(position=place))
            skins.append(scene.add_surface(f"skin {i}", ball, Sphere(0.05)))
        if is_touched:
            scene.add_contacts(skins, normal=HuntCrossley(1e5))
        return scene.freeze()

    race = Race(_evaluations(cloud(True)), _evaluations(cloud(False)), machine.rounds)
    return [BALLS_GOAL.figure(race.ratio, "frictionless; pairs are found by a sweep over the balls")]


def meshes(machine: Machine) -> list[Figure]:
    """Compare steps of a block that slides down a slope on meshes of two sizes."""
    fine, coarse = (block_on_slope(1.0, cells) for cells in (FINE, COARSE))

    def step(given: tuple[Model, float]) -> Callable[[], float]:
        model, frequency = given
        span = 50.0 / frequency

        def clock() -> float:
            found: list[int] = []
            took = seconds(
                lambda: found.append(whole_run(model, (0.0, span), 1e-7, output_step=span).statistics["steps"])
            )
            return took / found[0]

        return clock

    race = Race(step(fine), step(coarse), machine.rounds)
    return [MESH_GOAL.figure(race.ratio, "of runs of 50 radians of the contact's vibration, by the method of auto")]


def _evaluations(model: Model) -> Callable[[], float]:
    """Return a clock of an evaluation at the start, from state to state in compiled code, less the start of a call."""
    state = np.concatenate(model.parts(model.initial_state.copy()))

    def run_of(count: int) -> float:
        sweeps = model.route.sweeps(np.zeros(count), np.tile(state, (count, 1)))
        return seconds(lambda: None if sweeps is None else sweeps.rates)

    def clock() -> float:
        return sum(run_of(2 * STATES) - run_of(STATES) for _ in range(REPEATED)) / (STATES * REPEATED)

    return clock
