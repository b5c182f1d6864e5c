"""Stops of joints with a coefficient of restitution, and backlash."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of

G = 9.81


def dropped(restitution: float, stiffness: float = 1e7, height: float = 1.0) -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    stop = kf.CoordinateForce(limits=(0.0, None), limit_stiffness=stiffness, limit_restitution=restitution)
    scene.add_rigid_body("ball", 1.0, joint=kf.Prismatic("z", position=height, forces=stop))
    return scene


@pytest.mark.parametrize("method", ["auto", "dop853", "generalised-alpha"])
@pytest.mark.parametrize("restitution", [0.3, 0.8, 1.0])
def test_what_hits_a_stop_leaves_with_its_share_of_the_speed(restitution: float, method: str) -> None:
    scene = kf.System()
    stop = kf.CoordinateForce(limits=(None, 0.1), limit_stiffness=1e5, limit_restitution=restitution)
    scene.add_rigid_body("slide", 2.0, joint=kf.Prismatic("x", speed=0.5, forces=stop))
    result = scene.simulate((0.0, 0.5), rtol=1e-8, method=method)
    within = 1e-3 if method == "generalised-alpha" else 1e-5
    assert result.joint_speeds("slide")[-1, 0] == pytest.approx(-restitution * 0.5, rel=within)
    assert result.events["slide touch"] == pytest.approx([0.2], abs=1e-6)
    assert len(result.events["slide lift"]) == 1
    lost = 0.5 * 2.0 * 0.5**2 * (1 - restitution**2)
    assert result.energy.dissipated[-1] == pytest.approx(lost, abs=2e-4 if method == "generalised-alpha" else 1e-6)


def test_a_ball_comes_to_rest_after_infinitely_many_bounces() -> None:
    """After ``sqrt(2 h / g) (1 + e)/(1 - e)``, to which the stop comes near as it grows stiff."""
    wanted = math.sqrt(2.0 / G) * 1.8 / 0.2
    assert wanted == pytest.approx(4.063713, abs=1e-6)
    errors = []
    for stiffness in (1e5, 1e7):
        result = dropped(0.8, stiffness).simulate((0.0, 5.0), rtol=1e-7)
        touches = result.events["ball touch"]
        hops = np.diff(touches)
        errors.append(abs(hops[0] - 2.0 * 0.8 * math.sqrt(2.0 / G)))
        assert hops[1] / hops[0] == pytest.approx(0.8, rel=20 * math.pi / math.sqrt(stiffness))
        assert result.joint_coordinates("ball")[-1, 0] == pytest.approx(-G / stiffness, rel=1e-3)
        assert touches[-1] == pytest.approx(wanted, abs=40 * math.pi / math.sqrt(stiffness))
    assert errors[1] < 0.2 * errors[0]  # in proportion to the time of a touch, pi sqrt(m / k)


def test_each_touch_has_damping_of_its_own() -> None:
    result = dropped(0.5).simulate((0.0, 2.0), rtol=1e-8)
    t, v = result.times, result.joint_speeds("ball")[:, 0]
    touches = result.events["ball touch"]
    speeds = [math.sqrt(2 * G)]
    for before, after in pairwise(touches[:4]):
        middle = int(np.searchsorted(t, 0.5 * (before + after)))
        speeds.append(v[middle] + G * (t[middle] - before))
    assert np.array(speeds[1:]) / speeds[:-1] == pytest.approx(0.5, rel=5e-3)  # the touch takes its time


@pytest.mark.parametrize("is_flexible", [False, True])
@pytest.mark.parametrize("beyond", [-0.01, 0.02])
@pytest.mark.parametrize(
    "joint",
    [
        lambda at, law: kf.Prismatic((1, 2, 0), position=at, speed=-0.7, forces=law),
        lambda at, law: kf.Revolute("y", position=-at, speed=0.9, forces=law),
        lambda at, law: kf.Cylindrical("z", position=(at, -at), speed=(0.4, -0.8), forces=(law, law)),
    ],
    ids=["prismatic", "revolute", "cylindrical"],
)
def test_both_routes_agree(joint, beyond: float, is_flexible: bool) -> None:
    law = kf.CoordinateForce(limits=(-0.3, 0.3), limit_stiffness=500.0, limit_restitution=0.6)
    model = scene_of(joint(0.3 + beyond, law), is_flexible=is_flexible).freeze()
    assert_routes_agree(model)
    if beyond > 0.0 and not is_flexible:
        y, exact = model.initial_state, model.jacobian(0.0, model.initial_state)
        steps = 1e-7 * np.eye(len(y))
        found = np.array([(model.rhs(0.0, y + d) - model.rhs(0.0, y - d)) / 2e-7 for d in steps]).T
        np.testing.assert_allclose(found, exact, rtol=1e-5, atol=1e-5 * abs(exact).max())


def test_what_rests_on_a_stop_is_in_balance() -> None:
    rest = kf.equilibrium(dropped(0.5, 1e5, height=-1e-5))
    assert rest.joint_coordinates("ball")[0] == pytest.approx(-G / 1e5, rel=1e-9)
    assert rest.load("stop of ball") == pytest.approx((G, G / 1e5), rel=1e-9)


def test_stops_without_restitution_stay_as_they_are() -> None:
    scene = kf.System()
    law = kf.CoordinateForce(limits=(None, 0.1), limit_stiffness=1e5, limit_damping=10.0)
    scene.add_rigid_body("slide", 2.0, joint=kf.Prismatic("x", speed=0.5, forces=law))
    model = scene.freeze()
    assert not model.loads
    assert model.has_stops


def test_backlash_is_free_within_its_play() -> None:
    key = kf.CoordinateForce.backlash(0.02, stiffness=1000.0, damping=3.0, rest=0.5)
    assert key.force(0.509, 8.0) == 0.0
    assert key.force(0.515, 0.0) == pytest.approx(-5.0, rel=1e-12)
    assert key.force(0.485, 0.0) == pytest.approx(5.0, rel=1e-12)
    assert key.force(0.511, -1.0) == 0.0  # it would pull
    assert key.potential(0.52) == pytest.approx(0.5 * 1000.0 * 0.01**2, rel=1e-12)


def test_a_shaft_rattles_in_its_play() -> None:
    """Without losses: across the play at its speed, and half a period on each flank."""
    play, stiffness, inertia, spin = 0.04, 200.0, 0.02, 1.0
    scene = kf.System()
    key = kf.CoordinateForce.backlash(play, stiffness=stiffness)
    scene.add_rigid_body("shaft", 1.0, inertia, joint=kf.Revolute("z", speed=spin, forces=key))
    result = scene.simulate((0.0, 2.0), rtol=1e-9)
    period = 2.0 * (play / spin + math.pi * math.sqrt(inertia / stiffness))
    angle, t = result.joint_coordinates("shaft")[:, 0], result.times
    upward = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    crossed = t[upward] - angle[upward] / spin
    assert np.diff(crossed) == pytest.approx(period, abs=1e-6)
    assert angle.max() <= 0.5 * play + spin * math.sqrt(inertia / stiffness) * (1 + 1e-6)
    assert abs(result.energy.balance_error).max() < 1e-7


def test_backlash_with_restitution_has_touches() -> None:
    scene = kf.System()
    key = kf.CoordinateForce.backlash(0.04, stiffness=2e4, restitution=0.7, friction=0.0)
    scene.add_rigid_body("shaft", 1.0, 0.02, joint=kf.Revolute("z", speed=1.0, forces=key))
    result = scene.simulate((0.0, 0.3), rtol=1e-8)
    assert len(result.events["shaft touch"]) == 4
    assert abs(result.joint_speeds("shaft")[-1, 0]) == pytest.approx(0.7**4, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"limits": (0, 1), "limit_restitution": 0.0}, "limit_restitution must be a number above 0, at most 1"),
        ({"limits": (0, 1), "limit_restitution": 1.1}, "limit_restitution must be a number above 0, at most 1"),
        ({"limits": (0, 1), "limit_restitution": 0.5, "limit_damping": 1.0}, "either limit_damping or limit_rest"),
        ({"limit_restitution": 0.5}, "without limits does nothing"),
    ],
)
def test_bad_stops_are_named(given: dict, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        kf.CoordinateForce(limit_stiffness=1e4, **given)


def test_bad_backlash_is_named() -> None:
    with pytest.raises(kf.ModelError, match="play of backlash must be one number, finite and > 0"):
        kf.CoordinateForce.backlash(0.0, stiffness=10.0)
    with pytest.raises(kf.ModelError, match=r"need a stop to push back. Remedy"):
        kf.CoordinateForce.backlash(0.1, stiffness=0.0)


def test_a_load_of_the_name_of_a_stop_is_named() -> None:
    scene = dropped(0.5)
    scene.add_spring("stop of ball", scene.ground, scene.body("ball").frame(at=(1, 0, 0)), stiffness=1.0)
    with pytest.raises(kf.ModelError, match=r"a load is called 'stop of ball', like the stop of that joint. Remedy"):
        scene.freeze()
