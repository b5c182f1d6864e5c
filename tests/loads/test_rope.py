"""Ropes: one tension over any number of points, never a push, an end at the breaking load."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.states.state import actions


def lifted(**options):
    """Two weights on one rope over two points of a beam."""
    scene = kf.System(gravity=(0, 0, -9.81))
    light = scene.add_point("light", 1.0, joint=kf.Prismatic("z", position=-1.0))
    heavy = scene.add_point("heavy", 2.0, joint=kf.Prismatic("z", position=-1.0), at=(1, 0, 0))
    beam = [scene.ground.frame(at=(x, 0, 0)) for x in (0.0, 1.0)]
    scene.add(kf.Rope("rope", (light, *beam, heavy), axial_stiffness=1e6, **options))
    return scene


def test_atwood():
    """One tension 2 m1 m2 g / (m1 + m2), and the length that EA gives at it."""
    result = lifted(damping=2e4).simulate((0.0, 0.4))
    length, _, tension, slack = result.load("rope")[-1]
    wanted = 4.0 * 9.81 / 3.0
    assert tension == pytest.approx(wanted, rel=1e-6)
    assert length == pytest.approx(3.0 * (1.0 + wanted / 1e6), rel=1e-10)
    assert slack == 0.0
    assert abs(result.energy.balance_error).max() < 1e-4


@pytest.mark.parametrize("stretch", [-0.01, 0.01], ids=["slack", "taut"])
@pytest.mark.parametrize("rate", [-2.0, 3.0])
def test_routes_agree_to_round_off(stretch, rate):
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_rigid_body("arm", 2.0, 0.1, joint=kf.Revolute("y"), com=(0.5, 0, 0))
    load = scene.add_rigid_body("load", 1.0, 0.02, joint=kf.Free(), at=(1.0, 0.1, -0.7))
    way = (
        scene.ground.frame(at=(0, 0, 1)),
        arm.frame(at=(0.5, 0, 0.1)),
        arm.frame(at=(1, 0, 0)),
        load.frame(at=(0, 0, 0.1)),
    )
    length = sum(
        np.linalg.norm(np.subtract(b, a))
        for a, b in zip(
            ((0, 0, 1), (0.5, 0, 0.1), (1, 0, 0)), ((0.5, 0, 0.1), (1, 0, 0), (1.0, 0.1, -0.6)), strict=True
        )
    )
    scene.add(kf.Rope("rope", way, axial_stiffness=5e3, damping=50.0, length=length - stretch, breaking_load=1e9))
    model = scene.freeze()
    y = np.concatenate((model.initial_coordinates, rate * np.ones(model.free_count), model.initial_states, (0.0, 0.0)))
    np.testing.assert_allclose(
        model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-11, atol=1e-11
    )
    assert model.route.energy(0.0, y).total == pytest.approx(model.literal.energy(0.0, y).total, rel=1e-12)
    elastic = 0.5 * 5e3 / (length - stretch) * max(0.0, stretch) ** 2
    (action,) = actions(model.literal.view(0.0, y))
    assert action.potential == pytest.approx(elastic, abs=1e-12)


def test_preload_is_the_tension_at_the_start():
    assert lifted(preload=40.0).simulate((0.0, 1e-4)).load("rope")[0, 2] == pytest.approx(40.0, rel=1e-9)


def test_slack_rope_lets_fall_freely_until_it_is_taut():
    scene = kf.System(gravity=(0, 0, -9.81))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=-1.0))
    scene.add(kf.Rope("rope", (scene.ground, ball), axial_stiffness=1e4, damping=50.0, length=1.5))
    result = scene.simulate((0.0, 0.3), output_step=0.01)
    np.testing.assert_allclose(result.position("ball")[:, 2], -1.0 - 4.905 * result.times**2, rtol=1e-9)
    assert np.all(result.load("rope")[:, 2:] == (0.0, 1.0))
    later = scene.simulate((0.0, 1.0))
    assert later.load("rope")[:, 2].max() > 100.0
    assert later.load("rope")[:, 2].min() == 0.0


def test_breaking_ends_the_rope_and_not_the_run():
    """Drawn slowly by 98.1 + 100 t: the moment is that of the load, and what it held is dissipated."""
    scene = kf.System(gravity=(0, 0, -9.81))
    ball = scene.add_point("ball", 10.0, at=(0, 0, -1), joint=kf.Prismatic("z"))
    scene.add_force(ball, lambda t: (0.0, 0.0, -100.0 * t))
    scene.add(
        kf.Rope("rope", (scene.ground, ball), axial_stiffness=1e6, damping=5e3, breaking_load=200.0, preload=98.1)
    )
    result = scene.simulate((0.0, 2.0))
    (moment,) = result.events["rope breaks"]
    assert moment == pytest.approx(1.019, abs=2e-3)  # the ball's inertia and the damper let it lag by less
    assert result.status.kind == "finished"
    assert np.all(result.load("rope")[result.times > moment, 2] == 0.0)
    assert abs(result.energy.balance_error).max() < 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axial_stiffness": 0.0}, "axial_stiffness of rope 'r'.*> 0"),
        ({"axial_stiffness": 1.0, "damping": -1.0}, "damping of rope 'r'"),
        ({"axial_stiffness": 1.0, "length": 1.0, "preload": 2.0}, "Remedy: one of them"),
        ({"axial_stiffness": 1.0, "breaking_load": "much"}, "breaking_load"),
    ],
)
def test_bad_input_is_named(options, message):
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, at=(1, 0, 0))
    with pytest.raises(kf.ModelError, match=message):
        kf.Rope("r", (scene.ground, ball), **options)


def test_one_end_and_points_at_one_place_are_refused():
    scene = kf.System()
    ball = scene.add_point("ball", 1.0)
    with pytest.raises(kf.ModelError, match="two ends or more"):
        kf.Rope("r", (ball,), axial_stiffness=1.0)
    scene.add(kf.Rope("r", (scene.ground, ball), axial_stiffness=1.0))
    with pytest.raises(kf.ModelError, match="points 0 and 1 of rope 'r' coincide"):
        scene.freeze()


@pytest.mark.parametrize("way", ["over a sheave", "to its drum"])
def test_a_run_ends_where_a_rope_is_wound_up(way):
    """A load that is hoisted from 5 m below its sheave, at which its rope has no direction."""
    scene = kf.System(gravity=(0, 0, -9.81))
    load = scene.add_point("load", 100.0, at=(1, 0, -5), joint=kf.Prismatic("z"))
    sheave = scene.ground.frame(at=(1, 0, 0))
    ends, length = ((scene.ground, sheave, load), 6.0) if way == "over a sheave" else ((sheave, load), 5.0)
    hoist = (0.0, 5.5), (length, length - 5.5 if way == "over a sheave" else 1e-3)
    scene.add(kf.Rope("hoist", ends, axial_stiffness=1e6, damping=1e4, length=hoist))
    with pytest.warns(kf.SimulationWarning, match="rope 'hoist' is wound up at t = (4.99|5.49)") as told:
        result = scene.simulate((0.0, 5.5))
    assert "has shrunk from 5 m to 0.001 of that" in str(told[0].message)
    assert result.statistics["steps"] < 3000


def test_a_slack_rope_may_pass_its_sheave():
    scene = kf.System()
    load = scene.add_point("load", 1.0, at=(0, 0, -1), joint=kf.Prismatic("z", speed=1.0))
    scene.add(kf.Rope("rope", (scene.ground, load), axial_stiffness=1e6, length=3.0))
    assert scene.simulate((0.0, 2.0)).position("load")[-1, 2] == pytest.approx(1.0, abs=1e-9)
