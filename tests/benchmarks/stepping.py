"""A scene that is stepped: `sim.step`, a functional mock-up unit and a run, over the same torques of the demo's arm."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

import kanefe as kf
from benchmarks.clocks import Race, check_agreement, repeated, seconds
from benchmarks.goals import Figure, Goal
from fmu_units import Unit
from kanefe_fem.demo import beam_arm, motor_torque

DT, COUNT = 0.01, 200

UNIT = Goal("demo's arm, steps of 10 ms: functional mock-up unit / sim.step", 1.2)
STEPPED = Goal("demo's arm, steps of 10 ms: sim.step / simulate with a sampled controller", 1.2)
OVERHEAD = Goal("pendulum: sim.step of 10 ms [us]", 200.0)

TORQUES = [motor_torque(k * DT) for k in range(COUNT)]
OUTPUTS = "joint_coordinates hub"


def arm() -> kf.System:
    """Return the scene of the demo without its motor."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", mass=4.0, inertia=(0.02, 0.02, 0.03), joint=kf.Revolute("z"))
    body = scene.add_flexible_body("arm", beam_arm(), parent=hub, at=(0.1, 0.0, 0.0))
    scene.add_rigid_body("tip", mass=0.5, inertia=(2e-4, 2e-4, 2e-4), parent=body.interface("tip"))
    return scene


def stepping(rounds: int) -> list[Figure]:
    """Race the three over 200 steps of the demo, whose angle must come out the same."""
    scene = arm()
    sim = scene.start(inputs="motor hub", outputs=OUTPUTS)
    start = sim.save()
    sampled = scene.copy()
    sampled.add_controller(
        "same", lambda t, reads, memory: TORQUES[round(t / DT)], every=DT, reads="joint_speeds hub", drives="motor hub"
    )
    angles: dict[str, float] = {}

    def steps() -> None:
        sim.restore(start)
        for torque in TORQUES:
            sim.step(DT, {"motor hub": torque})
        angles["sim.step"] = sim.outputs[OUTPUTS]

    def run() -> None:
        result = sampled.copy().simulate((0.0, COUNT * DT), output_step=DT, progress=False)
        angles["simulate"] = float(result.joint_coordinates("hub")[-1, 0])

    with tempfile.TemporaryDirectory() as folder:
        unit = Unit(scene.to_fmu(Path(folder) / "arm.fmu", inputs="motor hub", outputs=OUTPUTS))
        begun = unit.state()

        def units() -> None:
            unit.go_back(begun)
            for torque in TORQUES:
                unit.set("motor hub", torque)
                unit.step(DT)
            (angles["unit"],) = unit.get([OUTPUTS])

        for each in (steps, run, units):
            each()
        check_agreement("unit", np.array([angles["unit"]]), np.array([angles["sim.step"]]), 1e-12)
        check_agreement("run", np.array([angles["simulate"]]), np.array([angles["sim.step"]]), 1e-6)
        of_unit = Race(partial(seconds, units), partial(seconds, steps), rounds)
        of_run = Race(partial(seconds, steps), partial(seconds, run), rounds)
    told = [f"{1e3 * t / COUNT:.3g} ms" for t in (of_unit.ours, of_unit.theirs, of_run.theirs)]
    return [
        UNIT.figure(of_unit.ratio, f"{told[0]} and {told[1]} a step"),
        STEPPED.figure(of_run.ratio, f"{told[1]} and {told[2]} a step"),
    ]


def overhead(rounds: int) -> list[Figure]:
    """Time steps of a pendulum, of which the motion itself takes the smaller part."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    sim = scene.start(inputs="motor rod")
    sim.step(DT)
    taken = min(repeated(lambda: sim.step(DT), 200) for _ in range(rounds))
    return [OVERHEAD.figure(1e6 * taken, f"{sim.statistics['evaluations'] / sim.statistics['steps']:.3g} evaluations")]


GROUPS = {stepping: [UNIT, STEPPED], overhead: [OVERHEAD]}
"""Goals of each group, which stand in its place where it cannot be measured."""
