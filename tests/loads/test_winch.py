"""Winches: a tension that is held, limits of speed, slack, breaking, rest, both routes."""

import numpy as np
import pytest

import kanefe as kf

CABLE = {"stiffness": 1e5, "damping": 400.0, "speed": 0.5}


def drawn(tension=300.0, mass=20.0, **options):
    """A weight that a winch on the ground draws down, on a spring from above."""
    scene = kf.System(gravity=(0, 0, -9.81))
    spring = kf.CoordinateForce(stiffness=2e3, damping=60.0)
    block = scene.add_point("block", mass, at=(0, 0, 2), joint=kf.Prismatic("z", forces=spring))
    scene.add(kf.Winch("winch", (scene.ground, block), tension=tension, **{**CABLE, **options}))
    return scene


@pytest.mark.parametrize("state", [-2e-3, 3e-3, 2e-2], ids=["taut", "near", "slack"])
@pytest.mark.parametrize("options", [{}, {"breaking_load": 1e4}, {"tension": ((0.0, 1.0), (100.0, 600.0))}])
def test_routes_agree_to_round_off(state, options):
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_rigid_body("arm", 2.0, 0.1, joint=kf.Revolute("y"), com=(0.5, 0, 0))
    way = scene.ground.frame(at=(0, 0, -1)), scene.ground.frame(at=(0.8, 0.1, -1)), arm.frame(at=(1, 0, 0.1))
    scene.add(kf.Winch("winch", way, **{"tension": 300.0, **CABLE, **options}))
    model = scene.freeze()
    z = model.initial_states.copy()
    z[0] += state
    for t, speed in ((0.0, 0.7), (0.4, -0.7)):
        y = np.concatenate((model.initial_coordinates, [speed], z, np.zeros(2)))
        np.testing.assert_allclose(
            model.route.evaluate(t, y).rates, model.literal.evaluate(t, y).rates, rtol=1e-11, atol=1e-11
        )
        assert model.route.energy(t, y).total == pytest.approx(model.literal.energy(t, y).total, rel=1e-12)


def test_it_settles_at_its_tension_and_energy_is_kept():
    result = drawn().simulate((0.0, 4.0), rtol=1e-9)
    assert result.position("block")[-1, 2] == pytest.approx(2.0 - (300.0 + 20.0 * 9.81) / 2e3, abs=1e-6)
    assert result.load("winch")[-1, 3] == pytest.approx(300.0, rel=1e-5)
    assert abs(result.energy.balance_error).max() < 1e-6
    assert result.statistics["route"] != "literal"


def test_a_rest_is_found_and_stays():
    scene = drawn()
    rest = kf.equilibrium(scene)
    assert rest.load("winch")[3] == pytest.approx(300.0, rel=1e-9)
    result = scene.simulate((0.0, 0.5), start=rest.state, rtol=1e-8)
    # steps grow until what they amplify comes to the tolerance: 1e-8 of 2 m, in 1e5 N/m
    np.testing.assert_allclose(result.load("winch")[:, 3], 300.0, atol=2e-3)
    np.testing.assert_allclose(np.ptp(result.position("block")[:, 2]), 0.0, atol=1e-8)


def pulled(rate, **options):
    """The end of the cable moves away at a steady rate, m/s."""
    scene = kf.System()
    end = scene.add_frame("end", joint=kf.Prismatic("z", motion=kf.Motion.steady(rate, 1.0)))
    scene.add(kf.Winch("winch", (scene.ground, end), tension=300.0, **{**CABLE, **options}))
    scene.add_point("mass", 1.0)
    return scene.simulate((0.0, 0.4), rtol=1e-9, output_step=0.01)


def test_the_tension_rises_with_the_speed_up_to_what_the_winch_pays_out():
    """At v: T0 + D v, reached as 1 - exp(-k t / D); beyond the speed of the winch the cable is a spring."""
    slow = pulled(0.2)
    wanted = 300.0 + 400.0 * 0.2 * (1.0 - np.exp(-1e5 / 400.0 * slow.times))
    np.testing.assert_allclose(slow.load("winch")[:, 3], wanted, rtol=1e-7)
    fast = pulled(0.8).load("winch")[:, 3]
    np.testing.assert_allclose(np.diff(fast)[-5:], 1e5 * (0.8 - 0.5) * 0.01, rtol=1e-6)
    slack = pulled(-0.8).load("winch")
    assert slack[-1, 3] == 0.0
    np.testing.assert_allclose(np.diff(slack[-5:, 1]), -0.5 * 0.01, rtol=1e-9)


def test_it_breaks_at_its_breaking_load():
    result = pulled(0.8, breaking_load=3000.0)
    (moment,) = result.events["winch breaks"]
    tension = result.load("winch")[:, 3]
    assert np.all(tension[result.times > moment] == 0.0)
    assert 2500.0 < tension[result.times < moment].max() < 3000.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tension": -1.0}, "transmits no compression"),
        ({"tension": "much"}, "tension of winch 'w'"),
        ({"speed": 0.0}, "speed of winch 'w' must be > 0"),
        ({"damping": np.nan}, "damping of winch 'w'"),
        ({"breaking_load": -1.0}, "breaking_load"),
    ],
)
def test_bad_input_is_named(change, message):
    ground = kf.System().ground
    with pytest.raises(kf.ModelError, match=message):
        kf.Winch("w", (ground, ground), **{"tension": 1.0, **CABLE, **change})


def test_one_end_and_no_way_are_refused():
    scene = kf.System()
    with pytest.raises(kf.ModelError, match="two ends or more"):
        kf.Winch("w", (scene.ground,), tension=1.0, **CABLE)
    ball = scene.add_point("ball", 1.0)
    scene.add(kf.Winch("w", (scene.ground, ball), tension=1.0, **CABLE))
    with pytest.raises(kf.ModelError, match="points 0 and 1 of winch 'w' coincide"):
        scene.freeze()


def test_a_run_ends_where_its_cable_is_wound_up():
    scene = kf.System()
    block = scene.add_point("block", 50.0, at=(0, 0, 2), joint=kf.Prismatic("z"))
    cable = {"stiffness": 1e5, "damping": 500.0, "speed": 1.0}
    scene.add(kf.Winch("haul", (scene.ground, block), tension=200.0, **cable))
    with pytest.warns(kf.SimulationWarning, match="winch 'haul' is wound up at t = .* from 2 m to 0.001 of that"):
        scene.simulate((0.0, 10.0))
