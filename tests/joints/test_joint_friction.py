"""Dry friction along joint coordinates: it holds without creep, slips by the textbook, and says when."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of
from kanefe.equations.model import Model

MASS, CAP = 2.0, 4.0
SPRING = CAP / 1e-7
"""Stiffness that an anchor has where none is given, in a scene of 1 m."""


def block(push: object = None, speed: float = 0.0, **law: object) -> kf.System:
    scene = kf.System()
    forces = kf.CoordinateForce(**{"friction": CAP, **law})
    body = scene.add_rigid_body("block", MASS, joint=kf.Prismatic("x", speed=speed, forces=forces))
    if push is not None:
        scene.add_force(body, push)
    return scene


@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
def test_below_the_cap_a_block_stays_where_it_is(rtol: float) -> None:
    push = 3.99
    result = block((push, 0, 0)).simulate((0.0, 1000.0), rtol=rtol)
    x = result.joint_coordinates("block")[:, 0]
    assert abs(x).max() < 1e-15
    assert not len(result.events["block slip"])
    assert result.load("friction of block")[-1] == pytest.approx((-push, push / SPRING, 1.0, 0.0), rel=1e-12)
    assert result.statistics["method"] == "radau5"
    assert result.statistics["steps"] < 400


@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
def test_the_anchor_of_a_shaken_block_stays(rtol: float) -> None:
    """With rtol above 1e-4 stages of a long step may lie beyond the cap, and move the anchor by some 1e-8 m."""

    def shake(t: float) -> tuple[float, float, float]:
        return (2.0 + 1.5 * math.sin(2 * math.pi * t) * min(t, 1.0), 0.0, 0.0)

    result = block(shake).simulate((0.0, 60.0), rtol=rtol)
    stretch = result.load("friction of block")[:, 1]
    assert np.ptp(stretch) > 5e-8  # what is pulled at gives way: m
    assert abs(result.joint_coordinates("block")[:, 0] - (stretch - stretch[0])).max() < 1e-14
    assert not len(result.events["block slip"])


@pytest.mark.parametrize("method", ["auto", "dop853", "dopri5", "extrapolation"])
def test_above_the_cap_it_slides_with_what_is_left(method: str) -> None:
    result = block((6.0, 0, 0)).simulate((0.0, 1.0), rtol=1e-8, method=method)
    v, t = result.joint_speeds("block")[:, 0], result.times
    late = t > 0.1
    assert np.diff(v[late]) / np.diff(t[late]) == pytest.approx((6.0 - CAP) / MASS, rel=1e-5)
    told = result.load("friction of block")[late]
    assert told[:, :3] == pytest.approx(np.tile((-CAP, 1e-7, 0.0), (late.sum(), 1)), rel=1e-4)
    assert told[:, 3] == pytest.approx(v[late], rel=1e-5)
    assert not len(result.events["block slip"])  # it slips from the start
    assert abs(result.energy.balance_error).max() < 1e-5
    assert result.energy.dissipated[-1] == pytest.approx(CAP * result.joint_coordinates("block")[-1, 0], rel=1e-6)


@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_a_slide_ends_where_the_textbook_says_as_the_anchor_grows_stiff(method: str) -> None:
    v, ends, times = 1.0, [], []
    for stiffness in (SPRING, 4.0 * SPRING):
        result = block(speed=v, friction_stiffness=stiffness).simulate((0.0, 0.8), rtol=1e-8, method=method)
        ends.append(result.joint_coordinates("block")[-1, 0] - MASS * v**2 / (2 * CAP))
        times.append(result.events["block stick"][-1] - MASS * v / CAP)
    # as it ends, the anchor's spring gives way by F / k
    assert abs(ends[0]) < 2.0 * CAP / SPRING
    assert abs(ends[1]) < 2.0 * CAP / (4.0 * SPRING)
    assert abs(times[0]) < 1e-5
    # the spring of the anchor is stretched from the start
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * MASS * v**2 + 0.125 * CAP**2 / SPRING, rel=1e-8)


@pytest.mark.parametrize(("stiffness", "within"), [(1e6, 1e-5), (1e7, 5e-6)])
def test_stick_and_slip_on_a_base_that_is_driven(stiffness: float, within: float) -> None:
    """A mass of 1 kg on a spring of 100 N/m, on a base at 0.1 m/s, that slips at 4 N and then rubs with 2.5 N."""
    k, v, static, sliding = 100.0, 0.1, 4.0, 2.5
    scene = kf.System()
    base = scene.add_frame("base", joint=kf.Prismatic("x", motion=kf.Motion.steady(v)))
    forces = kf.CoordinateForce(friction=sliding, static_friction=static, friction_stiffness=stiffness)
    mass = scene.add_rigid_body("mass", 1.0, parent=base, joint=kf.Prismatic("x", forces=forces))
    scene.add_spring("spring", scene.ground.frame(at=(-1, 0, 0)), mass, stiffness=k, rest_length=1.0)
    result = scene.simulate((0.0, 4.0), rtol=1e-9)
    w, D = math.sqrt(k), (static - sliding) / k
    slips = 2.0 / w * (math.pi - math.atan(D * w / v))
    period = 2.0 * D / v + slips
    assert period == pytest.approx(0.731760, abs=1e-6)
    slip, stick = result.events["mass slip"], result.events["mass stick"]
    assert len(slip) == 5
    assert np.diff(slip) == pytest.approx(period, abs=within)  # the anchor's spring stretches by 4e-6 m and less
    assert stick[:5] - slip == pytest.approx(slips, abs=within)
    amplitude = math.hypot(D, v / w)
    x = result.position("mass")[result.times > 0.5, 0]
    assert x.min() == pytest.approx(sliding / k - amplitude, abs=1e-4)  # of times 8 ms apart
    assert abs(result.energy.balance_error).max() < 1e-5


def test_a_hinge_holds_a_pendulum_aside() -> None:
    m, lever, cap = 1.0, 0.1, 1.2
    scene = kf.System(gravity=(0, 0, -9.81))
    forces = kf.CoordinateForce(friction=cap, friction_stiffness=1e6)
    scene.add_rigid_body("rod", m, 0.01, com=(lever, 0, 0), joint=kf.Revolute("y", forces=forces))
    result = scene.simulate((0.0, 100.0), rtol=1e-6, start=None)
    # it came down at once, so that it slipped by what twice its weight has above the cap
    angle = result.joint_coordinates("rod")[:, 0]
    assert abs(angle[-1] - angle[-100]) < 1e-14
    torque, _, sticks, _ = result.load("friction of rod")[-1]
    assert -torque == pytest.approx(9.81 * m * lever * math.cos(angle[-1]), rel=1e-9)
    assert sticks
    assert 9.81 * m * lever < cap


def test_a_hinge_that_slips_is_braked_by_its_friction() -> None:
    inertia, cap = 0.02, 0.5
    scene = kf.System()
    scene.add_rigid_body(
        "wheel", 1.0, inertia, joint=kf.Revolute("z", speed=10.0, forces=kf.CoordinateForce(friction=cap))
    )
    result = scene.simulate((0.0, 1.0), rtol=1e-8)
    assert result.events["wheel stick"][-1] == pytest.approx(inertia * 10.0 / cap, abs=1e-5)
    assert result.joint_coordinates("wheel")[-1, 0] == pytest.approx(inertia * 100.0 / (2 * cap), abs=4e-4)


def test_friction_and_stops_together() -> None:
    scene = block(speed=2.0, limits=(-0.1, 0.3), limit_stiffness=1e5, limit_damping=20.0)
    result = scene.simulate((0.0, 2.0), rtol=1e-8)
    x = result.joint_coordinates("block")[:, 0]
    assert 0.3 < x.max() < 0.32
    assert abs(x[-1] - x[-50]) < 1e-12
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * MASS * 2.0**2, rel=1e-5)
    assert abs(result.energy.balance_error).max() < 1e-5


def stretched(model: Model, stretch: float) -> Model:
    """Return a model whose anchors are stretched, and held where that is remembered."""
    model.initial_states.flags.writeable = True
    for load, where in zip(model.loads, model.load_states, strict=True):
        if load.kind == "friction":
            model.initial_states[where.start] = stretch
    model.initial_states.flags.writeable = False
    return model


CURVE = (0, 0, 0), (1, 0.2, 0), (2, 1, 0.4), (3, 1, 1)
LAW = {"friction": 2.0, "static_friction": 3.0, "friction_stiffness": 40.0, "friction_damping": 1.5}


@pytest.mark.parametrize("is_flexible", [False, True])
@pytest.mark.parametrize("stretch", [0.01, -0.4])
@pytest.mark.parametrize(
    "joint",
    [
        lambda law: kf.Prismatic((1, 2, 0), position=0.2, speed=-0.7, forces=law),
        lambda law: kf.Revolute("y", position=0.2, speed=0.9, forces=law),
        lambda law: kf.Screw("x", lead=0.3, position=0.2, speed=0.9, forces=law),
        lambda law: kf.Cylindrical("z", position=(0.1, 0.2), speed=(0.4, -0.8), forces=(law, law)),
        lambda law: kf.Universal("x", "y", forces=(law, law)),
        lambda law: kf.Planar(velocity=(0.3, -0.2), forces=(law, None, law)),
        lambda law: kf.PointOnCurve(CURVE, position=1.0, speed=0.5, forces=law),
        lambda law: kf.Prismatic("x", motion=kf.Motion.steady(0.3), forces=law),
    ],
    ids=["prismatic", "revolute", "screw", "cylindrical", "universal", "planar", "curve", "driven"],
)
def test_both_routes_agree_in_every_joint(joint, stretch: float, is_flexible: bool) -> None:
    model = stretched(scene_of(joint(kf.CoordinateForce(**LAW)), is_flexible=is_flexible).freeze(), stretch)
    assert_routes_agree(model)


def test_friction_in_a_driven_joint_is_work_of_its_drive() -> None:
    scene = kf.System()
    forces = kf.CoordinateForce(friction=CAP)
    scene.add_rigid_body("block", MASS, joint=kf.Prismatic("x", motion=kf.Motion.steady(0.5), forces=forces))
    scene.add_rigid_body("other", 1.0, joint=kf.Prismatic("z"))
    result = scene.simulate((0.0, 1.0), rtol=1e-8)
    assert result.driving_force("block")[-1] == pytest.approx(CAP, rel=1e-9)
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * CAP, abs=1e-4)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_the_reaction_of_a_joint_holds_its_friction() -> None:
    result = block((6.0, 0, 0)).simulate((0.0, 0.5), rtol=1e-8)
    assert result.joint_reaction("block")[-1] == pytest.approx((-CAP, 0, 0, 0, 0, 0), abs=1e-4)


def test_a_rest_hangs_on_friction_that_holds_what_it_has_to() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    stiffness = 1e5
    forces = kf.CoordinateForce(friction=30.0, static_friction=40.0, friction_stiffness=stiffness)
    scene.add_rigid_body("weight", MASS, joint=kf.Prismatic("z", position=0.3, forces=forces))
    rest = kf.equilibrium(scene)
    assert rest.joint_coordinates("weight")[0] == pytest.approx(0.3, rel=1e-12)  # it is held where it is
    modes = rest.linearise().modes()  # critical: the double root is known to half the digits
    assert modes.natural_frequencies[0] == pytest.approx(math.sqrt(stiffness / MASS) / (2 * math.pi), rel=1e-7)
    assert modes.damping_ratios[0] == pytest.approx(1.0, rel=1e-7)
    again = kf.System(gravity=(0, 0, -9.81))
    again.add_rigid_body("weight", MASS, joint=kf.Prismatic("z", forces=forces))
    result = again.simulate((0.0, 1.0), start=rest)
    assert abs(result.joint_coordinates("weight")[:, 0] - rest.joint_coordinates("weight")[0]).max() < 1e-14
    assert result.load("friction of weight")[0] == pytest.approx(
        (MASS * 9.81, -MASS * 9.81 / stiffness, 1.0, 0.0), rel=1e-12
    )


def test_damping_that_is_not_given_is_critical() -> None:
    friction = block().freeze().loads[0]
    assert friction.stiffness == pytest.approx(SPRING, rel=1e-14)
    assert friction.damping == pytest.approx(2.0 * math.sqrt(SPRING * MASS), rel=1e-14)


def test_names_and_what_is_said_of_them() -> None:
    law = kf.CoordinateForce(friction=1.0)
    scene = kf.System()
    scene.add_rigid_body("sleeve", 1.0, 0.1, joint=kf.Cylindrical("z", forces=(law, law)))
    result = scene.simulate((0.0, 0.1))
    assert set(result.events) == {f"sleeve {c} {what}" for c in ("distance", "angle") for what in ("slip", "stick")}
    assert result.load("friction of sleeve distance").shape == result.load("friction of sleeve angle").shape
    scene = block()
    scene.add_spring("friction of block", scene.ground, scene.body("block").frame(at=(1, 0, 0)), stiffness=1.0)
    with pytest.raises(kf.ModelError, match=r"a load is called 'friction of block', like the friction .* Remedy"):
        scene.freeze()


def test_a_frozen_scene_is_pickled_with_its_friction() -> None:
    model = block((1.0, 0, 0), static_friction=5.0).freeze()
    again = pickle.loads(pickle.dumps(model))
    y = model.initial_state
    np.testing.assert_array_equal(again.rhs(0.0, y), model.rhs(0.0, y))


def test_a_run_goes_on_inside_a_stick(tmp_path) -> None:
    options = {"rtol": 1e-8, "output_step": 0.05}
    whole = block(speed=1.0, static_friction=6.0).simulate((0.0, 1.0), **options)
    first = block(speed=1.0, static_friction=6.0)
    first.simulate((0.0, 1.0), checkpoint=tmp_path / "run", most_steps=whole.statistics["steps"] - 3, **options)
    second = block(speed=1.0, static_friction=6.0).simulate((0.0, 1.0), resume=tmp_path / "run", **options)
    np.testing.assert_array_equal(second.joint_coordinates("block"), whole.joint_coordinates("block"))


@pytest.mark.parametrize(
    ("kind", "remedy"),
    [
        (kf.Universal, "CoordinateForce"),
        (kf.Planar, "CoordinateForce"),
        (kf.Translation, "CoordinateForce"),
        (kf.Free, "a contact"),
        (kf.Fixed, "nothing moves in it"),
    ],
)
def test_joints_without_friction_from_their_load_say_so(kind, remedy):
    with pytest.raises(kf.ModelError, match=f"a {kind.__name__.lower()} joint has no friction.*Remedy: .*{remedy}"):
        kind(friction=kf.JointFriction(mu=0.1))
    assert pickle.loads(pickle.dumps(kind())) == kind()


def test_a_joint_without_friction_is_named_by_its_kind():
    with pytest.raises(kf.ModelError, match="a point-on-curve joint has no friction"):
        kf.PointOnCurve([(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 0)], friction=kf.JointFriction(mu=0.1))


def test_slip_and_stretch_have_the_sign_of_the_motion() -> None:
    """A mass that swings on a spring: where it slips its anchor goes with it, and friction is against both."""
    scene = kf.System()
    forces = kf.CoordinateForce(stiffness=100.0, friction=1.0)
    scene.add_rigid_body("mass", 1.0, joint=kf.Prismatic("x", position=0.1, forces=forces))
    result = scene.simulate((0.0, 1.5), rtol=1e-8)
    names = "force", "stretch", "sticks", "slip speed"
    force, stretch, sticks, slip = (result.load("friction of mass", name) for name in names)
    v = result.joint_speeds("mass")[:, 0]
    assert slip.min() < -0.1
    assert slip.max() > 0.1
    assert np.all(slip[sticks == 1.0] == 0.0)
    slips = sticks == 0.0
    assert np.all(force[slips] * slip[slips] < 0.0)
    assert np.all(force[slips] * stretch[slips] < 0.0)
    # what the spring of the anchor takes up where the motion turns is over within milliseconds
    assert np.median(np.abs(slip[slips] - v[slips])) < 1e-6
    units = {one.partition(" [")[0]: one.partition(" [")[2][:-1] for one in result.loads["friction of mass"]}
    assert units == {"force": "N", "stretch": "m", "sticks": "1", "slip speed": "m/s"}


def test_joints_of_several_directions_tell_each() -> None:
    friction = kf.JointFriction(0.2, 0.05)
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_rigid_body("sleeve", 1.0, 0.1, joint=kf.Cylindrical("x", speed=(-0.3, 6.0), friction=friction))
    scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Spherical(angular_velocity=(0, -2.0, 0), friction=friction))
    result = scene.simulate((0.0, 0.05))
    slid, turned = (result.load("friction of sleeve", f"slip speed {way}")[-1] for way in ("sliding", "turning"))
    v, w = result.joint_speeds("sleeve")[-1]
    # the anchor's spring still swings a little
    assert (slid, turned) == pytest.approx((v, 0.05 * w), rel=2e-2)
    assert result.load("friction of ball", "slip speed y")[-1] < 0.0
    assert result.load("friction of ball", "stretch y [m]")[-1] < 0.0
