"""A consistent start: found where it can be, untouched where it is one, and named where there is none."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.start_report import StartWarning
from kanefe.integrate.auto.vibrations import vibrations
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run import integrate
from kanefe.literal.consistent_start import consistent_start
from kanefe.states.constraints import constraint_rates, constraint_residuals
from kanefe.states.state import State
from loop_scenes import four_bar, marker_place, parallelogram, spatial_loop
from random_starts import slender
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
    with pytest.warns(StartWarning, match="of 'w0' is 1 and starts at 2; .* of 'w1' is 3 and starts at 2"):
        np.testing.assert_allclose(scene.freeze().initial_speeds, [2.0, 2.0], rtol=1e-14)


def test_two_loops_and_a_flexible_link_start_without_a_shock():
    """Speeds that nobody gave follow in the joints, as if all were rigid: no elastic coordinate takes any of them."""
    found = {}
    for kind in ("rigid", "flexible"):
        scene = kf.System()
        crank = scene.add_rigid_body("crank", 0.5, 1e-3, joint=kf.Revolute("z", motion=kf.Motion.steady(40.0)))
        where = {"parent": crank, "at": (0.1, 0, 0), "joint": kf.Revolute("z", position=kf.Guess(1.0))}
        if kind == "rigid":
            end = scene.add_rigid_body("coupler", 0.3, 4e-3, **where).frame(at=(0.35, 0, 0))
        else:
            end = scene.add_flexible_body("coupler", slender("flexible"), **where).interface("tip")
        joint = kf.Revolute("z", position=kf.Guess(1.8))
        rocker = scene.add_rigid_body("rocker", 1.0, 0.03, com=(0.15, 0, 0), at=(0.4, 0, 0), joint=joint)
        scene.add_loop_joint("pin", kf.Revolute("z"), end, rocker.frame(at=(0.3, 0, 0)))
        joint = kf.Revolute("z", position=kf.Guess(-1.6))
        rod = scene.add_rigid_body("rod", 0.6, 0.0125, com=(0.25, 0, 0), parent=rocker, at=(0.3, 0, 0), joint=joint)
        slider = scene.add_rigid_body("slider", 3.0, at=(0, 0.3, 0), joint=kf.Prismatic("x", position=kf.Guess(0.8)))
        scene.add_loop_joint("slider pin", kf.Revolute("z"), rod.frame(at=(0.5, 0, 0)), slider)
        report = scene.start_report()
        assert not report.mended
        assert max(abs(row.rate) for row in report.rows) < 1e-12  # of 4 m/s
        found[kind] = [one.value for one in report.speeds]
        for body in report.bodies:
            assert (body.strain_energy, body.largest_speed) == (0.0, 0.0)
    np.testing.assert_allclose(found["flexible"], found["rigid"], rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.5])
def test_zero_is_a_start_as_any_other(angle):
    model = four_bar_at(angle).freeze()
    assert model.initial_coordinates[0] == angle
    assert model.initial_speeds[0] == 0.0


def four_bar_at(angle, **start):
    """Return a four-bar whose crank is given, and nothing else."""
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z", position=angle, **start))
    coupler = scene.add_rigid_body("coupler", 1, 0.1, parent=crank, at=(1, 0, 0), joint=kf.Revolute("z"))
    rocker = scene.add_rigid_body("rocker", 1, 0.1, at=(2, 0, 0), joint=kf.Revolute("z"))
    scene.add_loop_joint("pin", kf.Revolute("z"), coupler.frame(at=(2, 0, 0)), rocker.frame(at=(0, 1.5, 0)))
    return scene


def test_a_given_speed_of_zero_stays_zero():
    """Of two wheels that a third turns, the one that is given as resting rests, and the other takes it all."""
    scene = kf.System()
    speeds = (3.0, 0.0, None)
    wheels = [
        scene.add_rigid_body(f"w{i}", 1.0, 0.1, joint=kf.Revolute("z", speed=speed)) for i, speed in enumerate(speeds)
    ]
    scene.add_gear("sum", dict.fromkeys(wheels, 1.0))
    np.testing.assert_allclose(scene.freeze().initial_speeds, [3.0, 0.0, -3.0], rtol=1e-14)


def test_a_guess_chooses_the_branch_and_none_or_a_guess_moves_in_silence(recwarn):
    ends = []
    for sign in (1.0, -1.0):
        scene = kf.System()
        crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z", position=0.0))
        joint = kf.Revolute("z", position=kf.Guess(sign))
        rod = scene.add_rigid_body("rod", 1, 0.1, parent=crank, at=(0.6, 0, 0), joint=joint)
        rail = kf.Planar(position=(kf.Guess(1.4), 0.5 * sign), angle=0.0)
        slider = scene.add_rigid_body("slider", 1, 0.1, joint=rail)
        scene.add_loop_joint("pin", kf.Revolute("z"), rod.frame(at=(1, 0, 0)), slider)
        ends.append(scene.freeze().initial_coordinates)
    for q, sign in zip(ends, (1.0, -1.0), strict=True):
        np.testing.assert_allclose(q, [0, sign * np.pi / 6, 0.6 + np.sqrt(0.75), 0.5 * sign, 0], rtol=1e-12, atol=0)
    assert not recwarn.list


def test_a_start_that_contradicts_the_loops_is_mended_and_told():
    scene = four_bar(speed=2.0)
    scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", position=0.0, speed=0.0))
    scene.add_gear("gear", {scene.body("crank"): 1.0, scene.body("wheel"): 1.0}, 1.3)
    with pytest.warns(
        StartWarning, match=r"angle \[rad\] of 'crank' is 1 and starts at .* rate \[rad/s\] of 'wheel' is 0 "
    ):
        scene.freeze()
    mended = {(one.body, one.name): one.change for one in scene.start_report().mended}
    assert mended["wheel", "angle [rad]"] == pytest.approx(0.3 - mended["crank", "angle [rad]"], abs=1e-11)
    assert "mended" in str(scene.start_report())


def test_the_report_is_read_as_a_table():
    text = str(four_bar_at(0.0, speed=2.0).start_report())
    assert [line.split()[:5] for line in text.splitlines()[2:4]] == [
        ["crank:", "angle", "[rad]", "0", "0"],
        ["coupler:", "angle", "[rad]", "follows", "0.812756"],
    ]
    assert "acceleration" in text
    assert "strain energy" not in text


def test_accelerations_of_the_report_are_those_of_the_equations():
    scene = four_bar_at(0.3, speed=2.0)
    report = scene.start_report()
    model = scene.freeze()
    rates = model.rhs(0.0, model.initial_state)[model.coordinate_count :]
    assert list(report.accelerations.values()) == rates.tolist()
    assert max(abs(row.acceleration) for row in report.rows) < 1e-12 * max(abs(rates))
    assert report.kinetic_energy == pytest.approx(model.energy(0.0, model.initial_state).kinetic, rel=1e-15)


def test_a_guess_takes_numbers():
    for wrong in (None, kf.Guess(1.0)):
        with pytest.raises(kf.ModelError, match="a Guess takes numbers"):
            kf.Guess(wrong)
    with pytest.raises(
        kf.ModelError, match=r"position of a revolute joint must be one finite number, Guess\(...\) or None"
    ):
        kf.Revolute("z", position=kf.Guess((1.0, 2.0)))
    with pytest.raises(kf.ModelError, match="velocity of a translation joint must be 3 finite numbers"):
        kf.Translation(velocity=(1.0, None))
    with pytest.raises(kf.ModelError, match="driven by a motion takes its start from it"):
        kf.Revolute("z", position=0.0, motion=kf.Motion.steady(1.0))


def test_speeds_that_no_joint_can_have_are_an_error_that_names_the_drive():
    scene = kf.System()
    slide = scene.add_rigid_body("slide", 1.0, 0.1, joint=kf.Prismatic("x", motion=kf.Motion.steady(0.2)))
    scene.add_loop_joint("bolt", kf.Fixed(), scene.ground, slide)
    with pytest.raises(kf.ModelError, match=r"'bolt' .* opens at 0.2 m/s \(position along x\) by the driven .*'slide'"):
        scene.freeze()


def test_elastic_coordinates_that_are_given_stay():
    """Joints move instead, though they are given too: it is told."""
    body = slender("flexible")
    eta = np.linspace(1e-4, 2e-4, body.free_count)
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("z"), modal_coordinates=eta)
    scene.add_loop_joint("pin", kf.Planar(), scene.ground, arm.interface("tip"))
    slot = scene.add_rigid_body("slot", 1.0, 0.1, at=(0.3, 0.1, 0), joint=kf.Planar(velocity=(0.0, 1.0)))
    scene.add_loop_joint("hold", kf.Revolute("z"), arm.interface("tip"), slot)
    model = scene.freeze()
    np.testing.assert_array_equal(model.initial_coordinates[model.bodies[0].flexible.eta], eta)
    assert scene.start_report().bodies[0].change == 0.0


def test_elastic_coordinates_that_cannot_stay_are_told():
    body = slender("flexible")
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body, modal_coordinates=np.full(body.free_count, 1e-4))
    tip = scene.ground.frame(at=body.interface("tip").position)
    scene.add_loop_joint("hold", kf.Spherical(), tip, arm.interface("tip"))
    with pytest.warns(StartWarning, match="modal coordinates or speeds of 'arm'"):
        scene.freeze()
    (mended,) = scene.start_report().mended
    assert mended.body == "arm"
    assert mended.change > 0.1
    assert "mended" in str(scene.start_report())


def test_what_only_bends_takes_no_more_than_joints_leave():
    """A beam whose ends are pulled apart by 1 mm and aside by 1 cm: the slider takes what it can, to the digit."""
    scene = kf.System()
    body = slender("flexible")
    tip = body.interface("tip").position
    carriage = scene.add_rigid_body("carriage", 1.0, 0.1, joint=kf.Prismatic("x"))
    arm = scene.add_flexible_body("arm", body, parent=carriage)
    scene.add_distance("stay", arm.interface("tip"), scene.ground.frame(at=tip + np.array((0.3, 0.2, 0))), 0.25)
    scene.add_loop_joint(
        "rail", kf.Fixed(), arm.interface("tip"), scene.ground.frame(at=tip + np.array((0.01, 0.002, 0)))
    )
    with pytest.raises(kf.ModelError, match="cannot be assembled"):
        scene.freeze()
    scene = kf.System()
    carriage = scene.add_rigid_body("carriage", 1.0, 0.1, joint=kf.Prismatic("x"))
    arm = scene.add_flexible_body("arm", body, parent=carriage)
    scene.add_loop_joint(
        "rail", kf.Spherical(), arm.interface("tip"), scene.ground.frame(at=tip + np.array((0.01, 0.002, 0)))
    )
    model = scene.freeze()
    k = body.free_count
    bend = body.interface("tip").motion[:2, :k]
    eta = model.initial_coordinates[1:]
    np.testing.assert_allclose(model.initial_coordinates[0] + (bend @ eta)[0], 0.01, atol=1e-5)
    flexibility = np.linalg.solve(body.stiffness[:k, :k], bend[1])
    np.testing.assert_allclose(eta, flexibility * 0.002 / (bend[1] @ flexibility), atol=1e-5 * np.abs(eta).max())


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
    monkeypatch.setattr("kanefe.literal.consistent_start.consistent_start", counted)
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
