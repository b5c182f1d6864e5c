"""Ropes whose length is commanded: hoists at steady rates in closed form, work of the winch, slack, both routes."""

import pickle

import numpy as np
import pytest

import kanefe as kf

EA, MASS, G = 2e5, 50.0, 9.81
TIMES = np.linspace(0.0, 8.0, 81)
SMOOTH = 4.0 - 0.3 * TIMES - 0.1 * np.sin(2.0 * TIMES)


def wavy():
    """Three functions of time: paid out and drawn in."""
    return kf.Motion(
        lambda t: 4.0 - 0.3 * t - 0.1 * np.sin(2.0 * t),
        lambda t: -0.3 - 0.2 * np.cos(2.0 * t),
        lambda t: 0.4 * np.sin(2.0 * t),
    )


COMMANDS = {
    "table": ((0.0, 1.0, 8.0), (4.0, 3.8, 2.0)),
    "steady": kf.Motion.steady(-0.25, 4.0),
    "spline": kf.Motion.table(TIMES, SMOOTH),
    "functions": wavy(),
    "compiled functions": wavy().compiled(),
}


def hoist(length, *, position=0.0, speed=0.0, way=(), **options):
    """A weight 4 m below the drum, or the last of the points on its way, that hangs on a rope."""
    scene = kf.System(gravity=(0, 0, -G))
    weight = scene.add_point("weight", MASS, at=(0, 0, -4), joint=kf.Prismatic("z", position=position, speed=speed))
    ends = [scene.ground.frame(at=at) for at in way] or [scene.ground]
    scene.add(kf.Rope("hoist", (*ends, weight), **{"axial_stiffness": EA, "length": length, **options}))
    return scene


def in_pieces(length, **options):
    """A rope that runs over a moving arm to a body that turns."""
    scene = kf.System(gravity=(0, 0, -G))
    arm = scene.add_rigid_body("arm", 2.0, 0.1, joint=kf.Revolute("y"), com=(0.5, 0, 0))
    load = scene.add_rigid_body("load", 1.0, 0.02, joint=kf.Free(), at=(1.0, 0.1, -1.7))
    way = scene.ground.frame(at=(0, 0, 1)), arm.frame(at=(1, 0, 0)), load.frame(at=(0, 0, 0.1))
    scene.add(kf.Rope("rope", way, axial_stiffness=5e3, damping=300.0, length=length, **options))
    return scene.freeze()


@pytest.mark.parametrize("t", [0.0, 0.4, 1.0, 7.0])
@pytest.mark.parametrize("kind", COMMANDS)
def test_routes_agree_to_round_off(kind, t):
    """Taut at the end of the commands, slack at their start, moving both ways."""
    model = in_pieces(COMMANDS[kind], breaking_load=1e9)
    assert (model.route.name, model.route.is_autonomous) == ("order n", kind != "functions")
    for rate in (-2.0, 3.0):
        speeds = rate * np.ones(model.free_count)
        y = np.concatenate((model.initial_coordinates, speeds, model.initial_states, np.zeros(2)))
        found, wanted = model.route.evaluate(t, y).rates, model.literal.evaluate(t, y).rates
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10)
        assert model.route.energy(t, y).total == pytest.approx(model.literal.energy(t, y).total, rel=1e-12)


@pytest.mark.parametrize("kind", COMMANDS)
def test_a_hoist_at_a_steady_rate_keeps_its_strain(kind):
    """With dl0/dt = r + a t the strain is e = m (g - a) / (EA + m a), and the weight at (1 + e) l0, for good."""
    a = 0.0 if kind in {"table", "steady"} else -0.08
    commands = {
        "table": ((0.0, 8.0), (4.0, 2.0)),
        "spline": kf.Motion.table(TIMES, 4.0 - 0.25 * TIMES + 0.5 * a * TIMES**2),
        "functions": kf.Motion(lambda t: 4.0 - 0.25 * t + 0.5 * a * t * t, lambda t: -0.25 + a * t, lambda t: a),
    }
    commands["compiled functions"] = commands["functions"].compiled()
    strain = MASS * (G - a) / (EA + MASS * a)
    drum = hoist(commands.get(kind, COMMANDS[kind]), position=-4.0 * strain, speed=0.25 * (1.0 + strain), damping=1e4)
    result = drum.simulate((0.0, 3.0), rtol=1e-9)
    l0 = 4.0 - 0.25 * result.times + 0.5 * a * result.times**2
    np.testing.assert_allclose(result.position("weight")[:, 2], -(1.0 + strain) * l0, atol=1e-7)
    np.testing.assert_allclose(result.load("hoist")[:, 2], EA * strain, rtol=1e-5)
    # the drum does T (1 + e) on each metre, and keeps what is elastic in it
    work = (EA * strain * (1.0 + strain) - 0.5 * EA * strain**2) * (4.0 - l0)
    np.testing.assert_allclose(result.energy.work, work, atol=1e-5)
    assert result.statistics["route"] == "order n"


def test_the_winch_pays_for_height_speed_and_what_is_dissipated():
    result = hoist(((0.5, 4.0), (4.0, 1.0)), damping=4e4).simulate((0.0, 3.0), rtol=1e-8)
    energy = result.energy
    gained = MASS * G * (result.position("weight")[-1, 2] - result.position("weight")[0, 2])
    moving = 0.5 * MASS * result.joint_speeds("weight")[-1, 0] ** 2
    strained = 0.5 * result.load("hoist")[-1, 2] ** 2 / EA * (4.0 - 3.0 / 3.5 * 2.5)
    assert energy.dissipated[-1] > 1.0
    assert energy.work[-1] == pytest.approx(gained + moving + strained + energy.dissipated[-1], abs=1e-4)
    assert abs(energy.balance_error).max() < 1e-4
    assert result.statistics["energy_balance"][1] < 1e-7


def test_a_balance_that_a_wrong_work_would_not_close():
    """Taut and slack, drawn in and paid out, over moving points; the run's own check is of its last state."""
    model = in_pieces(COMMANDS["spline"])
    for t, rate in ((0.3, 1.0), (6.0, -2.0)):
        y = np.concatenate((model.initial_coordinates, rate * np.ones(model.free_count), np.zeros(2)))
        h = 1e-5
        moved = [model.advance(y[: model.coordinate_count], s * rate * np.ones(model.free_count)) for s in (-h, h)]
        before, after = (
            model.literal.energy(t + s, np.concatenate((q, y[len(q) :]))) for s, q in zip((-h, h), moved, strict=True)
        )
        assert (after.elastic - before.elastic) / (2 * h) == pytest.approx(_power(model, t, y), rel=1e-6, abs=1e-6)


def _power(model, t, y):
    """Return how fast the rope stores energy, W: what is given less what it takes and does on its ends."""
    from kanefe.states.state import actions

    state = model.literal.view(t, y)
    (done,) = actions(state)
    twists = np.array([np.append(end.v, end.w) for end in state.load_ends(0)])
    return done.given - done.taken - float(np.sum(done.wrenches * twists))


def test_over_two_sheaves_the_way_is_what_counts():
    """From a drum at the ground up over two sheaves: 6 m of 10 are on the way to the second."""
    sheaves = ((-3.0, 0.0, -3.0), (-3.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    strain = MASS * G / EA
    scene = hoist(
        ((0.0, 4.0), (10.0, 8.0)),
        position=4.0 - ((1.0 + strain) * 10.0 - 6.0),
        speed=0.5 * (1.0 + strain),
        way=sheaves,
    )
    result = scene.simulate((0.0, 4.0), rtol=1e-9)
    np.testing.assert_allclose(
        result.position("weight")[:, 2], 6.0 - (1.0 + strain) * (10.0 - 0.5 * result.times), atol=1e-7
    )
    np.testing.assert_allclose(result.load("hoist")[:, 2], MASS * G, rtol=1e-4)


@pytest.mark.parametrize("kind", ["table", "functions", "compiled functions"])
def test_paid_out_faster_than_the_weight_falls_the_rope_is_slack(kind):
    """Paid out by 2 m/s from 0.5 s on: the weight, in free fall, comes to its end 2 v / g later."""
    if kind == "table":
        length = (0.0, 0.5, 3.0), (4.0, 4.0, 9.0)
    else:  # at once within a ms
        length = kf.Motion(_paid, _paid_rate, _paid_rate_of_rate)
        length = length.compiled() if kind == "compiled functions" else length
    scene = hoist(length, position=-4.0 * MASS * G / 1e8, axial_stiffness=1e8)
    result = scene.simulate((0.0, 1.0), events=["hoist slack", "hoist taut"], rtol=1e-8)
    assert result.events["hoist slack"][0] == pytest.approx(0.5, abs=3e-4)
    assert result.events["hoist taut"][0] == pytest.approx(0.5 + 2.0 * 2.0 / G, abs=2e-3)
    assert np.all(result.load("hoist")[(result.times > 0.51) & (result.times < 0.9), 2] == 0.0)


def _paid(t):
    s = min(max((t - 0.5) / 1e-3, 0.0), 1.0)
    return 4.0 + 1e-3 * s * s * s * (2.0 - s) + 2.0 * max(t - 0.501, 0.0)


def _paid_rate(t):
    s = min(max((t - 0.5) / 1e-3, 0.0), 1.0)
    return 2.0 * s * s * (3.0 - 2.0 * s)


def _paid_rate_of_rate(t):
    s = min(max((t - 0.5) / 1e-3, 0.0), 1.0)
    return 12e3 * s * (1.0 - s)


@pytest.mark.parametrize("kind", COMMANDS)
def test_it_breaks_where_it_is_drawn_against_what_holds(kind):
    """Between two fixed points T = EA (l / l0 - 1): the moment is that of its length."""
    scene = kf.System()
    scene.add_point("beside", 1.0, joint=kf.Prismatic("z"))
    ends = scene.ground, scene.ground.frame(at=(3.9, 0, 0))
    scene.add(kf.Rope("rope", ends, axial_stiffness=EA, length=COMMANDS[kind], breaking_load=0.1 * EA))
    result = scene.simulate((0.0, 4.0), rtol=1e-8)
    (moment,) = result.events["rope breaks"]
    broken = scene.freeze().loads[0].motions[0][0].position(moment)
    assert broken == pytest.approx(3.9 / 1.1, rel=1e-6)
    assert np.all(result.load("rope")[result.times > moment, 2] == 0.0)
    assert abs(result.energy.balance_error).max() < 1e-3 * result.energy.dissipated[-1]
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * EA * 0.1**2 * 3.9 / 1.1, rel=1e-3)


@pytest.mark.filterwarnings("ignore:linearise", "ignore:modes of a moving state")
def test_equilibrium_and_small_motions_at_a_time_of_the_command():
    scene = hoist(((0.0, 1.0, 5.0, 9.0), (4.0, 4.0, 2.0, 2.0)), position=-1e-3, damping=1e3)
    for t, l0 in ((0.0, 4.0), (6.0, 2.0)):
        rest = kf.equilibrium(scene, t=t, steady=False)
        assert rest.position("weight")[2] == pytest.approx(-l0 * (1.0 + MASS * G / EA), rel=1e-9)
        small = kf.linearise(scene, t=t, start=rest.state)
        assert small.modes().natural_frequencies[0] == pytest.approx(np.sqrt(EA / l0 / MASS) / (2.0 * np.pi))
    moving = kf.linearise(scene, t=3.0)  # where it is drawn in, what the damper has of it is in the stiffness
    assert moving.modes().natural_frequencies[0] == pytest.approx(
        np.sqrt((EA / 3.0 + 0.5 * 1e3 / 3.0**2) / MASS) / (2.0 * np.pi), rel=1e-6
    )
    functions = kf.linearise(hoist(wavy()), t=7.0).modes().natural_frequencies[0]
    assert functions == pytest.approx(np.sqrt(EA / wavy().position(7.0) / MASS) / (2.0 * np.pi))


def test_a_jerk_that_a_long_step_would_pass_over_is_seen():
    """Drawn in and paid out again within 60 ms of 20 s."""
    times = (0.0, 9.0, 9.03, 9.06, 20.0)
    swing = kf.System()
    weight = swing.add_point("weight", 1.0, at=(2.0, 0, 0), joint=kf.Prismatic("x"))
    swing.add(kf.Rope("rope", (swing.ground, weight), axial_stiffness=1.0, length=(times, (3.0, 3.0, 1.0, 3.0, 3.0))))
    result = swing.simulate((0.0, 20.0))
    assert result.joint_speeds("weight")[-1, 0] < -1e-3
    assert abs(result.energy.balance_error).max() < 1e-6


def test_commands_are_saved_with_their_scene():
    for kind in ("table", "steady", "spline"):
        again = pickle.loads(pickle.dumps(hoist(COMMANDS[kind])))
        assert again.simulate((0.0, 0.1)).position("weight")[-1, 2] != -4.0


@pytest.mark.parametrize(
    ("length", "message"),
    [
        (-1.0, "length of rope 'hoist' must be one number, finite and > 0"),
        (((0.0, 1.0), (2.0, np.nan)), "length of rope 'hoist' must be a table"),
        (((0.0, 0.0), (2.0, 3.0)), "times rising"),
        (((0.0, 1.0, 2.0), (2.0, 0.0, 1.0)), "length of rope 'hoist' must be > 0 m, but is 0 m at t = 1 s"),
        (kf.Motion(lambda t: 1.0 + t, lambda t: 2.0, lambda t: 0.0), "velocity of a Motion is 2"),
        (lambda t: 1.0, "length of rope 'hoist' must be one number"),
    ],
)
def test_bad_commands_are_named(length, message):
    with pytest.raises(kf.ModelError, match=message):
        hoist(length)


def test_a_length_and_a_preload_exclude_each_other():
    with pytest.raises(kf.ModelError, match="Remedy: one of them"):
        hoist(COMMANDS["table"], preload=10.0)


@pytest.mark.parametrize("kind", ["steady", "spline", "functions"])
def test_a_length_that_ends_within_the_run_is_refused_at_its_start(kind):
    draws = {
        "steady": kf.Motion.steady(-1.0, 4.0),
        "spline": kf.Motion.table(TIMES, 4.0 - TIMES),
        "functions": kf.Motion(lambda t: 4.0 - t, lambda t: -1.0, lambda t: 0.0),
    }
    scene = hoist(draws[kind])
    with pytest.raises(kf.ModelError, match=r"length of rope 'hoist' must be > 0 m, but is .* at t = 4"):
        scene.simulate((0.0, 5.0))
    scene.simulate((0.0, 0.5))


def test_a_command_is_not_asked_for_beyond_its_table():
    scene = hoist(COMMANDS["spline"])
    with pytest.raises(kf.ModelError, match="length of rope 'hoist' is given from 0 to 8 s"):
        scene.simulate((0.0, 9.0))
    with pytest.raises(kf.ModelError, match="length of rope 'hoist' is given from 0 to 8 s"):
        scene.simulate((-1.0, 1.0))


@pytest.mark.parametrize(
    ("length", "message"),
    [
        (kf.Motion.steady(-1.0, 4.0), "rope 'hoist' is wound up at t = 3.99"),
        (kf.Motion.table(TIMES[:30], SMOOTH[:30]), "the length of rope 'hoist' is given from 0 to 2.9 s"),
    ],
)
def test_stepped_from_outside_the_end_of_a_command_is_named(length, message):
    """A simulation does not know how far it will go: it fails at the moment, by name."""
    simulation = hoist(length, damping=1e4).start(every=0.1)

    def goes_on() -> None:
        for _ in range(50):
            simulation.step(0.1)

    with pytest.raises(kf.SimulationError, match=message):
        goes_on()
