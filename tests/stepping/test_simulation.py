"""Scenes that are stepped: the run of the same inputs, states kept and taken up again, counts, and what is refused."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.beams.body import beam_body
from steel_beams import steel_beam

DT = 0.02
TORQUES = tuple(0.3 * np.sin(0.7 * np.arange(25)))


@cache
def arm_body() -> kf.FlexibleBody:
    ends = {"root": "clamped", "tip": "rigid"}
    modes, damping = kf.CraigBampton(modes=3), kf.ModalDamping(0.02)
    return beam_body(steel_beam(6, planar=True), ends, reduction=modes, damping=damping)


def arm() -> kf.System:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    hub = scene.add_rigid_body("hub", 2.0, 0.05, joint=kf.Revolute("z"))
    body = scene.add_flexible_body("arm", arm_body(), parent=hub, at=(0.1, 0.0, 0.0))
    scene.add_rigid_body("tip", 0.2, 1e-4, parent=body.interface("tip"))
    return scene


def pendulum() -> kf.System:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    return scene


def bouncing() -> tuple[kf.System, kf.Event]:
    def bounce(t: float, state: kf.SceneState) -> Any:
        y = state.vector
        y[1] *= -0.8
        return y

    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_point("ball", 0.1, joint=kf.Prismatic("z", position=1.0))
    return scene, kf.Event("floor", lambda t, state: state.position("ball")[2], direction=-1, action=bounce)


def sampled(scene: kf.System, method: str, rtol: float) -> kf.Result:
    """Return the run in which a controller gives the same torques."""
    scene.add_controller(
        "same", lambda t, reads, memory: TORQUES[round(t / DT)], every=DT, reads="joint_speeds hub", drives="motor hub"
    )
    return scene.simulate((0.0, DT * len(TORQUES)), output_step=DT, method=method, rtol=rtol)


@pytest.mark.parametrize("method", ["auto", "radau5", "dop853", "extrapolation", "generalised-alpha"])
def test_steps_are_the_run_of_the_same_inputs(method: str) -> None:
    rtol = 1e-5 if method == "generalised-alpha" else 1e-8
    result = sampled(arm(), method, rtol)
    sim = arm().start(
        inputs="motor hub", outputs=("joint_coordinates hub", "position arm/tip y"), method=method, rtol=rtol, every=DT
    )
    found = []
    for torque in TORQUES:
        sim.step(DT, {"motor hub": torque})
        found.append(list(sim.outputs.values()))
    assert sim.time == pytest.approx(DT * len(TORQUES), rel=1e-12)
    wanted = np.column_stack((result.joint_coordinates("hub")[1:, 0], result.position("arm", "tip")[1:, 1]))
    # both are within the tolerance of 25 steps of the true motion
    np.testing.assert_allclose(found, wanted, rtol=0, atol=10.0 * rtol)


def test_a_restored_simulation_goes_on_to_the_bit() -> None:
    scene = pendulum()
    scene.add_rigid_body("crank", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(2.0)))
    scene.add_controller(
        "filter",
        lambda t, reads, memory: memory.setdefault("sum", []).append(t) or 0.01 * len(memory["sum"]),
        every=0.03,
        reads="joint_speeds rod",
        drives="motor rod",
    )
    sim = scene.start(inputs=("force rod y", "drive crank"), outputs=("joint_speeds rod", "joint_speeds crank"))
    sim.step(DT, {"force rod y": 0.3})
    kept, controlled = sim.save(), len(sim.controllers["filter"].times)

    def on(which: kf.Simulation) -> list[list[float]]:
        found = []
        for k in range(5):
            which.step(DT, {"drive crank": float(k), "force rod y": 0.1 * k})
            found.append([*which.outputs.values(), which.time])
        return found

    first = on(sim)
    copied = sim.copy()
    assert on(copied) == on(sim) != first
    for which in (sim, copied):
        which.restore(kept)
        assert which.time == DT
        assert len(which.controllers["filter"].times) == controlled
        assert on(which) == first


def test_events_and_their_actions_are_those_of_a_run() -> None:
    scene, floor = bouncing()
    result = scene.copy().simulate((0.0, 1.0), events=floor)
    sim = scene.start(events=floor)
    kept = sim.save()
    for _ in range(2):
        for _ in range(50):
            sim.step(DT)
        np.testing.assert_allclose(sim.events["floor"], result.events["floor"], rtol=0, atol=1e-9)
        assert sim.outputs["joint_coordinates ball"] == pytest.approx(result.joint_coordinates("ball")[-1, 0], abs=1e-9)
        sim.restore(kept)
        assert not len(sim.events["floor"])


def test_contacts_are_those_of_a_run() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 0.004, joint=kf.Prismatic("z", position=0.15))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("lies", skin, floor, normal=kf.HuntCrossley(1e5, damping=0.3))
    sim = scene.start(inputs="force ball z", outputs=("joint_coordinates ball", "load lies force_z"))
    for _ in range(15):
        sim.step(DT, {"force ball z": -5.0})
    scene.add_force(ball, (0.0, 0.0, -5.0))
    result = scene.simulate((0.0, 15 * DT), output_step=DT)
    assert len(result.events["lies touch"]) > 1
    np.testing.assert_allclose(sim.events["lies touch"], result.events["lies touch"], rtol=0, atol=1e-6)
    height, force = sim.outputs.values()
    assert height == pytest.approx(result.joint_coordinates("ball")[-1, 0], abs=1e-6)
    assert force == pytest.approx(result.load("lies")[-1, 2], abs=1e-1)  # 1e-6 m of 1e5 N/m


def test_an_end_by_an_event_is_told_and_can_be_taken_back() -> None:
    scene, floor = bouncing()
    sim = scene.start(events=kf.Event("floor", floor.function, direction=-1, terminal=True))
    kept = sim.save()
    while sim.status.is_finished:
        sim.step(DT)
    with pytest.raises(kf.ModelError, match=r"by the event 'floor'\. Remedy: restore an earlier state"):
        sim.step(DT)
    assert sim.time == pytest.approx(np.sqrt(2.0 / 9.81), abs=1e-9)
    assert sim.outputs["joint_coordinates ball"] == pytest.approx(0.0, abs=1e-9)
    sim.restore(kept)
    sim.step(DT)
    assert sim.status.is_finished


def test_a_step_that_fails_leaves_all_as_it_was() -> None:
    def force(t: float) -> float:
        if t > 0.05:
            raise ValueError("no more")
        return 1.0

    scene = pendulum()
    scene.add_torque(scene.body("rod"), force)
    sim = scene.start(inputs="motor rod")
    sim.step(DT, {"motor rod": 0.2})
    before = sim.time, sim.outputs, sim.inputs
    for _ in range(2):
        with pytest.raises(ValueError, match="no more"):
            sim.step(0.1, {"motor rod": 5.0})
        assert (sim.time, sim.outputs, sim.inputs) == before
    sim.step(0.01)
    assert sim.inputs == {"motor rod": 0.2}


def test_steps_with_the_same_inputs_do_not_begin_anew() -> None:
    """A method that begins anew evaluates once more; Radau's keeps its Jacobian where a held value jumps."""
    held, changed = (arm().start(inputs="motor hub", method="radau5", rtol=1e-2) for _ in range(2))
    for k in range(10):
        held.step(DT, {"motor hub": 0.0})
        changed.step(DT, {"motor hub": 1e-9 * (k % 2)})
    assert changed.statistics["evaluations"] >= held.statistics["evaluations"] + 9
    assert changed.statistics["jacobians"] == held.statistics["jacobians"] < 5


def test_loads_and_motions_of_the_scene_are_inputs() -> None:
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", motion=kf.Motion.steady(1.0)))
    scene.add_point("mass", 0.5, parent=cart, joint=kf.Translation())
    scene.add_force(scene.body("mass"), lambda t: (0.0, 3.0 + t, 0.0))
    outputs = ("joint_coordinates cart", "driving_force cart", "position mass y")
    sim = scene.start(inputs=("drive cart", "load the force on 'mass'"), outputs=outputs)
    assert sim.inputs["load the force on 'mass' y"] == 3.0
    assert sim.units["drive cart"] == "m/s2"
    sim.step(1.0)
    sim.step(1.0, {"drive cart": 2.0, "load the force on 'mass' y": -3.0})
    x, force, y = sim.outputs.values()
    assert x == pytest.approx(1.0 + 1.0 + 1.0, abs=1e-12)
    assert force == pytest.approx(2.0 * 2.0, abs=1e-9)  # of the cart alone: the mass floats in it
    assert y == pytest.approx(3.0 + 6.0 - 3.0, abs=1e-9)


REFUSED: dict[str, Callable[[kf.System], Any]] = {
    "no input 'motr rod'. Did you mean 'motor rod'": lambda s: s.start(inputs="motor rod").step(0.1, {"motr rod": 1.0}),
    "input 'motor rod' must be a finite number, in N m": lambda s: s.start(inputs="motor rod").step(
        0.1, {"motor rod": np.nan}
    ),
    "must be a mapping of names": lambda s: s.start().step(0.1, 3.0),  # type: ignore[arg-type]
    "dt of a step must be above zero": lambda s: s.start().step(0.0),
    "is below the resolution of the time": lambda s: s.start(1e9).step(1e-9),
    "there is no 'motr'. Did you mean 'motor'": lambda s: s.start(inputs="motr rod"),
    "has no such load. It has: none": lambda s: s.start(inputs="load wind"),
    "no such driven coordinate": lambda s: s.start(inputs="drive rod"),
    "inputs must be texts": lambda s: s.start(inputs=3),  # type: ignore[arg-type]
    "outputs must be texts": lambda s: s.start(outputs=3),  # type: ignore[arg-type]
    "there is no 'positon'. Did you mean 'position'": lambda s: s.start(outputs="positon rod"),
    "no component 'up'. There are: force_x": lambda s: s.start(outputs="joint_reaction rod up"),
    "no body called 'rob'": lambda s: s.start(outputs="joint_reaction rob"),
    "the input 'motor rod' is there twice": lambda s: s.start(inputs=("motor rod", "motor rod")),
    "the name 'x' is of an input and of an output": lambda s: s.start(
        inputs={"x": "motor rod"}, outputs={"x": "joint_speeds rod"}
    ),
    "the output 'position rod x' is given twice": lambda s: s.start(outputs=("position rod x", "position rod x")),
    "cannot be stepped. Remedy: method='auto'": lambda s: s.start(method="scipy-bdf"),
    "every of a simulation must be above zero": lambda s: s.start(every=-1.0),
    "duration of a simulation must be above zero": lambda s: s.start(duration=0.0),
    "t of a simulation must be a finite time": lambda s: s.start(np.inf),
    "restore takes what save": lambda s: s.start().restore(3),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("text", ["drive cart", "load the force on 'mass'"])
def test_one_input_takes_the_place_of_a_value(text: str) -> None:
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", motion=kf.Motion.steady(1.0)))
    mass = scene.add_point("mass", 0.5, parent=cart, joint=kf.Prismatic("y"))
    scene.add_force(mass, lambda t: (0.0, 3.0, 0.0))
    with pytest.raises(kf.ModelError, match=r"is there twice\. Remedy: once, by one name"):
        scene.start(inputs={"one": text, "other": text})


@pytest.mark.parametrize("message", REFUSED)
def test_what_makes_no_sense_is_named(message: str) -> None:
    with pytest.raises(kf.ModelError) as refusal:
        REFUSED[message](pendulum())
    assert message in str(refusal.value)
