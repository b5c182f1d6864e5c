"""Points, frames without mass, rotors, and gravity by body."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError, SimulationError
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import momenta
from kanefe.kane.reactions import joint_reactions
from kanefe.states.state import State
from scenes import lattice_body, random_inertia, random_state, unit_axis


def test_a_thrown_point_flies_a_parabola() -> None:
    g = np.array((0.0, 0.0, -9.81))
    scene = kf.System(gravity=g)
    scene.add_point("ball", 0.2, at=(1, 0, 2), joint=kf.Translation(velocity=(3.0, 0.0, 4.0)))
    result = scene.simulate((0.0, 1.0), rtol=1e-9)
    t = result.times[:, None]
    exact = np.array((1, 0, 2)) + np.array((3.0, 0.0, 4.0)) * t + 0.5 * g * t**2
    assert result.position("ball") == pytest.approx(
        exact, abs=1e-12
    )  # of second order in time: exact but for round-off
    assert result.body("ball").mass == 0.2


def test_frames_without_mass_make_a_cardan_joint() -> None:
    rng = np.random.default_rng(0)
    inertia, com = random_inertia(rng), rng.uniform(-0.2, 0.2, 3)
    models = []
    for by_frames in (True, False):
        scene = kf.System(gravity=(1.0, -2.0, 3.0))
        if by_frames:
            cross = scene.add_frame("cross", joint=kf.Revolute("x"))
            scene.add_rigid_body("end", 2.0, inertia, com=com, parent=cross, joint=kf.Revolute("y"))
        else:
            scene.add_rigid_body("end", 2.0, inertia, com=com, joint=kf.Universal("x", "y"))
        models.append(scene.freeze())
    q, u = rng.standard_normal(2), rng.standard_normal(2)
    found = [accelerations(State(model, 0.0, q, u)) for model in models]
    assert found[0] == pytest.approx(found[1], abs=1e-12 * abs(found[1]).max())


def test_a_frame_that_carries_nothing_is_named() -> None:
    scene = kf.System()
    scene.add_frame("cross", joint=kf.Revolute("x"))
    with pytest.raises(SimulationError, match=r"nothing has inertia along cross: rate \[rad/s\]"):
        scene.simulate((0.0, 1.0))


def rotor_scene(explicit: bool, gravity: bool = True) -> kf.System:
    """Return a tumbling body on an arm with a flywheel: as spin in the body, or as a child on a driven joint."""
    rng = np.random.default_rng(3)
    mass, inertia, com = 2.0, random_inertia(rng), rng.uniform(-0.1, 0.1, 3)
    axis, spot = unit_axis(rng), rng.uniform(-0.2, 0.2, 3)
    J, transverse, wheel_mass, rate = 0.03, 0.02, 0.4, 70.0
    wheel = transverse * np.eye(3) + (J - transverse) * np.outer(axis, axis)
    scene = kf.System(gravity=(0.0, 0.0, -9.81) if gravity else (0.0, 0.0, 0.0))
    if gravity:
        base: Any = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("y"))
    else:
        base = None
    options = {"parent": base, "at": (0.4, 0.0, 0.1), "joint": kf.Free(angular_velocity=(0.5, -1.0, 2.0))}
    if explicit:
        carrier = scene.add_rigid_body("carrier", mass, inertia, com=com, **options)
        joint = kf.Revolute(axis, motion=kf.Motion.steady(rate))
        scene.add_rigid_body("wheel", wheel_mass, wheel, parent=carrier, at=spot, joint=joint)
        return scene
    total = mass + wheel_mass
    together = (mass * com + wheel_mass * spot) / total

    def about(I_C: np.ndarray, m: float, c: np.ndarray) -> np.ndarray:
        r = c - together
        return I_C + m * (r @ r * np.eye(3) - np.outer(r, r))

    both = about(inertia, mass, com) + about(wheel, wheel_mass, spot)
    carrier = scene.add_rigid_body("carrier", total, both, com=together, **options)
    turned = carrier.frame(orientation=(0.3, 0.4, -0.1, 0.8))
    scene.add_rotor(turned, turned.axes.T @ axis, J, rate)  # the axis in the axes of the frame it is given in
    return scene


@pytest.mark.parametrize("gravity", [True, False])
def test_a_rotor_is_a_driven_wheel_whose_mass_the_carrier_has(gravity: bool) -> None:
    models = [rotor_scene(explicit, gravity).freeze() for explicit in (True, False)]
    q, u = random_state(models[1], 5)
    du = [accelerations(State(model, 0.7, q, u)) for model in models]
    assert du[0] == pytest.approx(du[1], abs=1e-11 * abs(du[0]).max())
    for wheel, rotor in zip(*(momenta(State(model, 0.7, q, u)) for model in models), strict=True):
        assert wheel == pytest.approx(rotor, abs=1e-12 * (1 + abs(wheel).max()))
    number = models[0].index("carrier")
    reactions = [joint_reactions(State(m, 0.7, q, u), x)[number] for m, x in zip(models, du, strict=True)]
    assert reactions[0] == pytest.approx(reactions[1], abs=1e-10 * (1 + abs(reactions[0]).max()))


def test_a_dual_spin_body_keeps_its_angular_momentum() -> None:
    result = rotor_scene(explicit=False, gravity=False).simulate((0.0, 1.0), rtol=1e-9)
    angular = result.momentum.angular
    assert np.linalg.norm(angular[0]) > 1.0  # the rotor's share is 0.03 * 70
    assert angular == pytest.approx(np.broadcast_to(angular[0], angular.shape), abs=1e-6)
    assert abs(result.energy.balance_error).max() < 1e-7  # w x h does no work


def test_rotors_add_up() -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Spherical())
    scene.add_rotor(body, "x", 0.1, 3.0)
    scene.add_rotor(body, (0, 0, 2.0), 0.2, -4.0)
    assert scene.freeze().bodies[0].rigid.rotor == pytest.approx((0.3, 0.0, -0.8))


def test_gravity_acts_on_the_bodies_that_have_it() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_point("heavy", 1.0)
    scene.add_point("light", 1.0, joint=kf.Translation(velocity=(0.0, 0.0, 2.0)), gravity=False)
    scene.add_flexible_body("arm", lattice_body(0), joint=kf.Free(), gravity=False)
    scene.add_flexible_body("falling", lattice_body(1), joint=kf.Free())
    result = scene.simulate((0.0, 0.5), rtol=1e-8, output_step=0.25)
    assert result.position("heavy")[-1, 2] == pytest.approx(-0.5 * 9.81 * 0.25, abs=1e-10)
    assert result.position("light")[-1, 2] == pytest.approx(1.0, abs=1e-12)
    assert result.position("arm")[-1, 2] == pytest.approx(0.0, abs=1e-13)
    assert result.position("falling")[-1, 2] < -1.0
    assert result.acceleration("light")[:, 2] == pytest.approx(0.0, abs=1e-14)
    assert result.joint_reaction("light") == pytest.approx(np.zeros((3, 6)), abs=1e-14)
    assert abs(result.energy.balance_error).max() < 1e-6  # and the weightless have no energy of position


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (
            lambda s, hub, arm: s.add_rotor(arm.interface("tip"), "z", 0.1, 1.0),
            "is not a rigid body .* Remedy: a rigid",
        ),
        (lambda s, hub, arm: s.add_rotor(arm, "z", 0.1, 1.0), "'arm' is not a rigid body and carries no rotor"),
        (lambda s, hub, arm: s.add_rotor(s.ground, "z", 0.1, 1.0), "the ground is not a rigid body"),
        (lambda s, hub, arm: s.add_rotor("hub", "z", 0.1, 1.0), "the carrier of a rotor must be a body"),
        (lambda s, hub, arm: s.add_rotor(hub, (0, 0, 0), 0.1, 1.0), "axis of a rotor.* length above zero"),
        (
            lambda s, hub, arm: s.add_rotor(hub, "z", -0.1, 1.0),
            "the inertia of the rotor in 'hub' must be finite and >=",
        ),
        (lambda s, hub, arm: s.add_rotor(hub, "z", 0.1, np.nan), "the rate of the rotor in 'hub' must be one finite"),
        (lambda s, hub, arm: s.add_point("p", -1.0), "mass of body 'p' must be finite and >= 0 kg"),
        (lambda s, hub, arm: s.add_point("hub", 1.0), "already has a body called 'hub'"),
        (lambda s, hub, arm: s.add_frame("f", parent=arm), "carries other bodies at its interfaces only"),
        (
            lambda s, hub, arm: s.add_point("p", 1.0, gravity=9.81),
            "gravity of body 'p' must be True or False, not 9.81",
        ),
    ],
)
def test_bad_input_is_named(add: Any, message: str) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1)
    arm = scene.add_flexible_body("arm", lattice_body(0), parent=hub)
    with pytest.raises(ModelError, match=message):
        add(scene, hub, arm)


def test_a_point_on_a_body_is_fixed_and_one_on_the_ground_is_free() -> None:
    """As is told in docs/howto/joints.md."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    arm = scene.add_flexible_body("arm", lattice_body(0))
    scene.add_point("tip", 0.5, parent=arm.interface("tip"))
    scene.add_point("falling", 0.5, parent=scene.ground.frame(at=(0.0, 0.0, 1.0)))
    result = scene.simulate((0.0, 0.5))
    assert result.position("tip") == pytest.approx(result.position("arm", "tip"), abs=1e-12)
    assert result.position("falling")[-1, 2] == pytest.approx(1.0 - 0.5 * 9.81 * 0.25, abs=1e-6)
