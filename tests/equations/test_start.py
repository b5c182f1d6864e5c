"""A consistent start: found where it can be, untouched where it is one, and named where there is none."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.auto.vibrations import vibrations
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run import integrate
from kanefe.kane.constraints import constraint_rates, constraint_residuals
from kanefe.kane.loop_closure import consistent_start
from kanefe.kane.state import State
from loop_scenes import four_bar, marker_place, parallelogram, spatial_loop
from robustness import overconstrained
from scenes import lattice_body


def openings(model, t=0.0):
    """Return residuals and rates of all rows at the start."""
    state = State(model, t, model.initial_coordinates, model.initial_speeds)
    J = constraint_rates(state).J
    return constraint_residuals(state), J @ state.full[: J.shape[1]]


@pytest.mark.parametrize("scene", [four_bar, lambda: spatial_loop(0), lambda: spatial_loop(1)])
def test_the_start_is_closed_and_stays_closed(scene):
    for values in openings(scene().freeze()):
        # a scene of about one metre and some rad/s
        assert np.abs(values).max() < 1e-11


def test_a_start_that_was_given_is_kept_and_the_others_follow():
    model = four_bar(speed=2.0).freeze()
    assert model.initial_coordinates[0] == 1.0
    assert model.initial_speeds[0] == 2.0
    tip = marker_place(model, "coupler", 0.0, model.initial_coordinates, (2, 0, 0))
    # the closed form of the two circles, upper branch
    x, y = np.cos(1.0), np.sin(1.0)
    d = np.hypot(2 - x, -y)
    along, across = np.array((2 - x, -y)) / d, np.array((y, 2 - x)) / d
    a = (4.0 - 1.8**2 + d * d) / (2 * d)
    np.testing.assert_allclose(tip[:2], (x, y) + a * along + np.sqrt(4 - a * a) * across, atol=1e-12)


@pytest.mark.parametrize("braces", range(5))
def test_a_given_speed_is_kept_beside_rows_that_nothing_moves(braces):
    """What a joint between two parts of one rigid body says of the speeds is round-off, and no reason to change any."""
    model = overconstrained.four_bar(kf.Spherical(), braces=braces)
    assert model.initial_speeds[0] == 6.0


def test_a_consistent_start_is_untouched_to_the_bit():
    model = parallelogram(0.3).freeze()
    np.testing.assert_array_equal(model.initial_coordinates, [0.3, 0.3, -0.3])
    np.testing.assert_array_equal(model.initial_speeds, [-1.0, -1.0, 1.0])


def test_contradicting_speeds_change_least_in_the_metric_of_mass():
    """Two equal wheels geared one to one and started against the gear share their momentum."""
    scene = kf.System()
    wheels = [
        scene.add_rigid_body(f"w{i}", 1.0, 0.1, joint=kf.Revolute("z", speed=s)) for i, s in enumerate((1.0, 3.0))
    ]
    scene.add_gear("belt", {wheels[0]: 1.0, wheels[1]: -1.0})
    np.testing.assert_allclose(scene.freeze().initial_speeds, [2.0, 2.0], rtol=1e-14)


def test_a_welded_arch_bends_to_close():
    """Nothing but the flexible body can move: it takes the shape of least strain energy, the static one."""
    scene = kf.System()
    arm = scene.add_flexible_body("arm", lattice_body(1))
    frame = arm.body.interface("tip")
    shift = np.array((0.02, -0.03, 0.01))
    scene.add_loop_joint("pull", kf.Spherical(), scene.ground.frame(at=frame.position + shift), arm.interface("tip"))
    model = scene.freeze()
    k = arm.body.free_count
    K, motion = arm.body.stiffness[:k, :k], frame.motion[:3, :k]
    flexibility = np.linalg.solve(K, motion.T)
    expected = flexibility @ np.linalg.solve(motion @ flexibility, shift)
    np.testing.assert_allclose(model.initial_coordinates, expected, rtol=0.15, atol=0.02 * np.abs(expected).max())
    np.testing.assert_allclose(motion @ model.initial_coordinates, shift, atol=1e-12)


def test_a_driven_start_is_that_of_its_time():
    scene = four_bar(motion=kf.Motion.steady(2.0, 0.4))
    result = scene.simulate((0.5, 0.6), rtol=1e-8, output_step=0.05)
    model = result._channels.model
    q = result._channels.trajectory.coordinates[0]
    assert result.joint_coordinates("crank")[0, 0] == pytest.approx(1.4, abs=1e-15)
    ends = marker_place(model, "coupler", 0.5, q, (2, 0, 0)), marker_place(model, "rocker", 0.5, q, (0, 1.8, 0))
    np.testing.assert_allclose(*ends, atol=1e-12)


def test_loops_are_closed_once_a_time(monkeypatch):
    asked = []

    def counted(model, t):
        asked.append(t)
        return consistent_start(model, t)

    scene = four_bar(motion=kf.Motion.steady(2.0, 0.4)).freeze()  # which closes them too
    monkeypatch.setattr("kanefe.kane.loop_closure.consistent_start", counted)
    for start in (0.5, 0.7):
        vibrations(Dynamics(scene), start, 0.1)  # as where a method is chosen
        integrate(scene, (start, start + 0.1))
    assert asked == [0.5, 0.7]
    start = scene.route.start(0.7)
    start[:] = 0.0
    assert np.any(scene.route.start(0.7))  # what is kept is not what was given


def test_what_cannot_be_closed_is_named_with_its_gap():
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z", position=0.2))
    scene.add_loop_joint("hook", kf.Spherical(), scene.ground.frame(at=(1.5, 0, 0)), crank.frame(at=(1, 0, 0)))
    with pytest.raises(
        kf.ModelError, match=r"spherical loop joint 'hook' between .* stays open by 0.5 m \(position along x\)"
    ):
        scene.freeze()


def test_a_loop_out_of_plane_is_named():
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z"))
    scene.add_loop_joint("hook", kf.Spherical(), scene.ground.frame(at=(0.6, 0.8, 0.25)), crank.frame(at=(1, 0, 0)))
    with pytest.raises(kf.ModelError, match=r"'hook'.*stays open by 0.25 m \(position along z\)"):
        scene.freeze()


def test_an_axis_that_cannot_hold_is_named_and_not_where_the_search_gave_up():
    """Bars on hinges of three directions meet in a point, and not along an axis: their lengths are right."""
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z", position=1.0))
    bar = scene.add_rigid_body("bar", 1, 0.1, parent=crank, at=(1, 0, 0), joint=kf.Revolute((0, 0.1, 1)))
    rocker = scene.add_rigid_body("rocker", 1, 0.1, at=(2, 0, 0), joint=kf.Revolute((0, -1, 1)))
    scene.add_loop_joint("pin", kf.Revolute("z"), bar.frame(at=(2, 0, 0)), rocker.frame(at=(0, 1.8, 0)))
    with pytest.raises(kf.ModelError, match=r"'pin' .*closes but for its axis.* rad \(tilt of axis z.*frame\(orient"):
        scene.freeze()


def test_opposite_axes_are_refused():
    scene = kf.System()
    body = scene.add_rigid_body("body", 1, 0.1, joint=kf.Free(orientation=(0, 0, 0, 1)))
    scene.add_loop_joint("guide", kf.Prismatic("x"), scene.ground, body)
    with pytest.raises(kf.ModelError, match=r"'guide' .* closes with the axes of its ends opposite"):
        scene.freeze()


def test_the_report_names_redundant_rows_and_a_singular_start():
    report = parallelogram(0.3).freeze().constraint_report()
    assert (report.constraints, report.rows, report.rank, report.degrees_of_freedom) == (1, 5, 2, 1)
    # out of the plane nothing moves
    assert report.redundant == (
        "pin: position along z",
        "pin: tilt of axis z towards y",
        "pin: tilt of axis z towards x",
    )
    assert not report.is_singular
    flat = parallelogram(np.pi / 2).freeze().constraint_report()
    assert (flat.rank, flat.degrees_of_freedom, flat.redundant) == (2, 1, report.redundant)
    assert flat.singular == ("pin: position along x",)
    assert "singular start" in str(flat)


FRAMES = {
    "free": lambda s, a, b: s.add_loop_joint("j", kf.Free(), a, b),
    "driven": lambda s, a, b: s.add_loop_joint("j", kf.Revolute("z", motion=kf.Motion.steady(1.0)), a, b),
    "started": lambda s, a, b: s.add_loop_joint("j", kf.Revolute("z", position=0.1), a, b),
    "no joint": lambda s, a, b: s.add_loop_joint("j", "revolute", a, b),
    "one body": lambda s, a, b: s.add_loop_joint("j", kf.Spherical(), a, a.frame(at=(1, 0, 0))),
    "other scene": lambda s, a, b: s.add_loop_joint("j", kf.Spherical(), a, kf.System().ground),
    "no name": lambda s, a, b: s.add_loop_joint("", kf.Spherical(), a, b),
    "slash": lambda s, a, b: s.add_loop_joint("a/b", kf.Spherical(), a, b),
    "twice": lambda s, a, b: [s.add_distance("j", a, b, 1.0) for _ in range(2)],
    "no length": lambda s, a, b: s.add_distance("j", a, b, 0.0),
    "gear of nothing": lambda s, a, b: s.add_gear("g", {}),
    "gear of the ground": lambda s, a, b: s.add_gear("g", {s.ground: 1.0}),
    "gear of a free body": lambda s, a, b: s.add_gear("g", {b: 1.0}),
    "gear of zero": lambda s, a, b: s.add_gear("g", {a: 0.0}),
    "gear of no coordinate": lambda s, a, b: s.add_gear("g", {(a, 3): 1.0}),
    "rack on a hinge": lambda s, a, b: s.add_rack("r", a, a, 0.1),
    "flat rack": lambda s, a, b: s.add_rack("r", a, a, 0.0),
    "flat wheel": lambda s, a, b: s.add_rolling_wheel("w", b, -1.0),
}
MESSAGES = {
    "free": "a free joint cannot close a loop",
    "driven": "loop joint 'j' cannot be driven",
    "started": "loop joint 'j' has a start or forces of its own",
    "no joint": "loop joint 'j' takes a joint",
    "one body": "both ends of loop joint 'j' are on 'a'",
    "other scene": "end b of loop joint 'j': the ground belongs to another system",
    "no name": "the name of a constraint must be a text",
    "slash": "without '/'",
    "twice": "already has a constraint called 'j'",
    "no length": "length of distance 'j' must be above zero m",
    "gear of nothing": "gear 'g' takes a dict",
    "gear of the ground": "the ground has no joint",
    "gear of a free body": "the free joint of 'b' has no coordinate that can be coupled",
    "gear of zero": "the coefficient of 'a' must be a number other than zero",
    "gear of no coordinate": "3 is not one of the 1 coordinates of 'a'",
    "rack on a hinge": "the rack of rack 'r' is on a revolute joint",
    "flat rack": "radius of rack 'r' must be a length",
    "flat wheel": "radius of rolling wheel 'w' must be above zero m",
}


@pytest.mark.parametrize("what", FRAMES)
def test_bad_input_is_named(what):
    scene = kf.System()
    a = scene.add_rigid_body("a", 1, 0.1, joint=kf.Revolute("z"))
    b = scene.add_rigid_body("b", 1, 0.1, joint=kf.Free())
    with pytest.raises(kf.ModelError, match=MESSAGES[what].replace("'/'", "'/'")):
        FRAMES[what](scene, a, b)


def test_nothing_is_added_after_freeze():
    scene = four_bar()
    scene.freeze()
    with pytest.raises(kf.ModelError, match="distance 'd' cannot be added or changed: the scene was frozen"):
        scene.add_distance("d", scene.ground, scene.ground, 1.0)
