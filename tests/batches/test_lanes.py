"""Runs evaluated at once in vector instructions: each is to the last bit what it is alone, whatever is beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

import kanefe as kf
from kanefe.batches import lanes as lanes_module
from kanefe.kernels.evaluation.rigid_lanes import lanes_here
from run_scenes import double_pendulum, soft_arm, thrown_pendulum

JOINTS: tuple[Callable[[np.random.Generator], kf.Joint], ...] = (
    lambda rng: kf.Revolute(rng.uniform(-1, 1, 3), forces=kf.CoordinateForce(stiffness=3.0, damping=0.2, armature=0.1)),
    lambda rng: kf.Prismatic(rng.uniform(-1, 1, 3), forces=kf.CoordinateForce(stiffness=30.0, damping=0.5)),
    lambda rng: kf.Spherical(angular_velocity=rng.uniform(-1, 1, 3), armature=float(rng.choice([0.0, 0.2]))),
    lambda rng: kf.Screw(rng.uniform(-1, 1, 3), lead=0.1),
    lambda rng: kf.Universal("x", "z"),
    lambda rng: kf.Cylindrical("y", speed=(0.2, 0.4)),
    lambda rng: kf.Revolute("y", motion=kf.Motion.table([0.0, 0.2, 0.5, 1.0], [0.0, 0.1, -0.2, 0.3])),
    lambda rng: kf.Fixed(),
)


def tree(seed: int, mass: float = 1.0) -> kf.System:
    """Return a random tree of bodies on joints of all kinds, with springs, motors, drives, forces and torques."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0.3, -1.0, -9.81))
    bodies: list[kf.RigidBody] = []
    for i in range(9):
        base = bodies[int(rng.integers(len(bodies)))] if bodies else None
        joint = kf.Free(velocity=rng.uniform(-1, 1, 3)) if i == 8 else JOINTS[int(rng.integers(len(JOINTS)))](rng)
        parent = scene.ground if base is None or i == 8 else base
        bodies.append(
            scene.add_rigid_body(
                f"body {i}",
                mass * rng.uniform(0.5, 2.0),
                rng.uniform(0.2, 0.3, 3),
                com=rng.uniform(-0.3, 0.3, 3),
                parent=parent,
                at=rng.uniform(-0.5, 0.5, 3),
                joint=joint,
                gravity=bool(rng.random() < 0.8),
            )
        )
    scene.add_force(bodies[3], mass * rng.uniform(-3, 3, 3), point=(0.1, 0.2, 0.0), follows=True)
    scene.add_force(bodies[4], rng.uniform(-3, 3, 3))
    scene.add_torque(bodies[5], rng.uniform(-1, 1, 3), follows=True)
    return scene


def in_plane(seed: int, mass: float = 1.0) -> kf.System:
    """Return a random planar tree, which turns, slides and floats, with stops, springs, a drive and forces."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    base = scene.ground
    for i in range(6):
        joint = (
            kf.Revolute("z", position=rng.uniform(-1, 1), forces=kf.CoordinateForce(stiffness=2.0, damping=0.1)),
            kf.Prismatic((1.0, rng.uniform(-1, 1), 0.0), forces=kf.CoordinateForce(stiffness=40.0)),
            kf.Planar(position=(0.1, 0.2), rate=1.0),
            kf.Revolute("z", motion=kf.Motion.table([0.0, 0.2, 0.5, 1.0], [0.0, 0.1, -0.2, 0.3])),
        )[i if i < 4 else int(rng.integers(2))]
        parent = scene.ground if i == 2 else base
        base = scene.add_rigid_body(
            f"body {i}",
            mass * rng.uniform(0.5, 2.0),
            0.2,
            com=(0.3, 0.1, 0),
            parent=parent,
            at=(0.5, 0, 0),
            joint=joint,
        )
    scene.add_force(base, (mass, 2.0, 0.0), point=(0.1, 0.0, 0.0), follows=True)
    scene.add_torque(base, (0.0, 0.0, 0.3))
    return scene


def starts_of(scene: kf.System, count: int, seed: int = 3) -> np.ndarray:
    first = scene.freeze().initial_state
    return first + 0.1 * np.random.default_rng(seed).uniform(-1.0, 1.0, (count, len(first)))


def check_bits(found: Sequence[kf.Result], alone: Sequence[kf.Result]) -> None:
    """Compare states and counts of runs: to the last bit."""
    assert len(found) == len(alone)
    for many, one in zip(found, alone, strict=True):
        assert many.run is not None
        assert one.run is not None
        np.testing.assert_array_equal(many.run.states, one.run.states)
        for name in ("method", "steps", "rejected", "evaluations"):
            assert many.statistics[name] == one.statistics[name], name


def check_lanes(found: Sequence[kf.Result]) -> None:
    """Check that all runs but the first were evaluated at once."""
    assert [result.statistics.get("lanes") for result in found[1:]] == [lanes_here()] * (len(found) - 1)


@pytest.mark.parametrize("options", [{"rtol": 1e-6}, {"method": "rk4", "step": 0.01}], ids=["free steps", "fixed"])
@pytest.mark.parametrize("make", [tree, in_plane])
@pytest.mark.parametrize("seed", range(3))
def test_lanes_are_the_runs_alone_to_the_last_bit(make: Callable[[int], kf.System], seed: int, options: dict) -> None:
    scene = make(seed)
    assert scene.freeze().route.name == ("order n" if make is tree else "order n, in the plane")
    options = {"method": "dop853"} | options
    starts = starts_of(scene, 2 * lanes_here() + 3)
    found = kf.simulate_many(scene, (0.0, 0.5), starts, threads=1, **options)
    check_lanes(found)
    check_bits(found, [scene.simulate((0.0, 0.5), start=start, **options) for start in starts])


@pytest.mark.parametrize("make", [tree, in_plane])
def test_lanes_with_other_numbers_in_each_scene(
    make: Callable[[int, float], kf.System], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Masses and forces are others in each lane; and lanes take turns."""
    monkeypatch.setattr(lanes_module, "TURN", 5)
    masses = np.linspace(1.0, 2.0, lanes_here() + 4)
    scenes = [make(2, mass) for mass in masses]
    assert scenes[0].freeze().drives
    found = kf.simulate_many(scenes, (0.0, 0.4), threads=1, method="dop853", rtol=1e-6)
    check_lanes(found)
    check_bits(found, [scene.simulate((0.0, 0.4), method="dop853", rtol=1e-6) for scene in scenes])


def test_threads_and_chaos() -> None:
    """Round-off would grow a million times in this run: there is none."""
    model = thrown_pendulum()
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y", speed=1.0))
    scene.add_rigid_body("lower", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Spherical(), parent=upper, at=(1, 0, 0))
    starts = starts_of(scene, 21, seed=1)
    assert len(starts[0]) == len(model.initial_state)
    found = kf.simulate_many(scene, (0.0, 6.0), starts, threads=2)
    check_lanes(found)
    check_bits(found, [scene.simulate((0.0, 6.0), start=start) for start in starts])


def test_why_runs_are_not_evaluated_at_once() -> None:
    rods = kf.System(gravity=(0, -9.81, 0))
    rod = rods.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    rods.add_spring("spring", rods.ground.frame(at=(1, 1, 0)), rod, stiffness=10.0)
    for scene, options, reason in (
        (soft_arm(), {}, "flexible bodies"),
        (rods, {}, "loads between frames"),
        (double_pendulum(), {"method": "radau5"}, "radau5 wants more than rates"),
    ):
        found = kf.simulate_many(scene, (0.0, 0.05), [scene.freeze().initial_state] * 3, threads=1, **options)
        assert [result.statistics["lanes"] for result in found[1:]] == [1, 1]
        assert [result.statistics["lanes_reason"] for result in found[1:]] == [reason] * 2
    event = kf.Event("low", lambda t, state: state.joint_coordinates("first")[0] + 9.0)
    first, second = kf.simulate_many(double_pendulum(), (0.0, 0.05), starts_of(double_pendulum(), 2), events=event)
    assert first.statistics["lanes_reason"] == "the first run, which chooses the method"
    assert second.statistics["lanes_reason"] == "events"
    with_load = double_pendulum()
    with_load.add_force(with_load.body("first"), (0.0, 1.0, 0.0))
    found = kf.simulate_many([double_pendulum(), double_pendulum(), with_load], (0.0, 0.05), threads=1)
    assert "differ" in found[2].statistics["lanes_reason"]
