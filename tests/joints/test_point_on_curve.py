"""Points on curves: arc length, frames along the curve, pendulums and laps in closed form, and the end of a curve."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of
from kanefe.frames import rotation_matrix
from scenes import derivatives

GRAVITY = 9.81
# of the circle through 60 points: the spline misses it by 9e-11 of the radius, and the length of a lap by 3e-10
INTERPOLATION = 1e-9


def circle(count, radius=1.0):
    """Return points of a circle in the plane x, z, the first one at its bottom."""
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack((np.sin(angle), 0.0 * angle, -np.cos(angle)))


def helix(turns=1.5, count=60):
    angle = np.linspace(0.0, 2 * np.pi * turns, count)
    return np.column_stack((np.cos(angle), np.sin(angle), 0.3 * angle))


def knot(count=40):
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    reach = 2.0 + np.cos(3 * angle)
    return np.column_stack((reach * np.cos(2 * angle), reach * np.sin(2 * angle), np.sin(3 * angle)))


class InPython(kf.PointOnCurve):
    """The same without a kernel: it takes the literal route."""

    def links(self):
        return None


def test_a_bead_in_a_round_groove_swings_like_a_pendulum():
    start, radius = 2.0, 0.8
    joint = kf.PointOnCurve(circle(60, radius), closed=True, position=start * radius)
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    scene.add_point("bead", 0.3, joint=joint)
    period = 4 * np.sqrt(radius / GRAVITY) * ellipk(np.sin(start / 2) ** 2)
    bottom = kf.Event("bottom", lambda t, state: state.joint_coordinates("bead")[0], direction=1)
    result = scene.simulate((0.0, 1.5 * period), rtol=1e-11, events=[bottom])
    # errors of steps add up to some 100 rtol
    np.testing.assert_allclose(result.events["bottom"], [0.75 * period], rtol=INTERPOLATION + 1e-9)
    assert result.statistics["route"].startswith("order n")
    assert abs(result.energy.balance_error).max() < 1e-8 * result.energy.total.max()


ROUND_OFF = 5e-14
"""Of places up to 4 m on a spline: some tens of roundings, whose order is that of the linear algebra at hand."""


def test_a_straight_curve_is_a_prismatic_joint_to_round_off():
    direction = np.array((1.0, 2.0, -2.0)) / 3.0
    for count in (2, 3, 4, 5, 9):
        line = np.sort(np.random.default_rng(count).uniform(0.0, 4.0, count))
        line[0] = 0.0
        joint = kf.PointOnCurve(np.outer(line, direction), turns=True)
        other = kf.Prismatic(direction)
        for s in np.linspace(0.0, joint.length, 7):
            q, u = np.array((s,)), np.array((1.3,))
            np.testing.assert_allclose(joint.pose(q)[0], other.pose(q)[0], rtol=0, atol=ROUND_OFF)
            for found, wanted in zip(joint.partial_velocities(q), other.partial_velocities(q), strict=True):
                np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13)
            # curvature: round-off of the tangent over the distance of the points, 0.01 m and more
            np.testing.assert_allclose(joint.remainders(q, u), 0.0, atol=1e-11)
    states = []
    points = np.outer(np.linspace(0, 4, 9), direction)
    for each in (kf.PointOnCurve(points, position=0.5, speed=0.3), kf.Prismatic(direction, position=0.5, speed=0.3)):
        model = scene_of(each).freeze()
        y = np.concatenate((model.initial_state, (0.0, 0.0)))
        states.append(model.route.evaluate(0.0, y).rates)
    np.testing.assert_allclose(states[0], states[1], rtol=0, atol=1e-12 * abs(states[1]).max())


@pytest.mark.parametrize(("points", "closed"), [(knot(), True), (helix(), False), (circle(7), True)])
def test_the_coordinate_is_the_arc_length(points, closed):
    joint = kf.PointOnCurve(points, closed=closed)
    places = np.linspace(0.0, joint.length, 500)
    tangents = np.array([joint.partial_velocities([s])[0][:, 0] for s in places])
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, rtol=0, atol=1.1e-12)  # ARC_LENGTH
    passed = [min(np.linalg.norm(joint.pose([s])[0] - point) for s in places) for point in points]
    assert max(passed) <= 0.5 * joint.length / 499  # a place of 500 is that near to every point


def test_lengths_are_those_of_what_the_points_are_of():
    assert kf.PointOnCurve(circle(60), closed=True).length == pytest.approx(2 * np.pi, rel=INTERPOLATION)
    # an open curve has its largest errors in its first and last pieces
    assert kf.PointOnCurve(helix()).length == pytest.approx(3 * np.pi * np.hypot(1.0, 0.3), rel=1e-7)
    width, height = 2.0, 0.7
    angle = np.linspace(0.0, 2 * np.pi, 160, endpoint=False)
    ellipse = np.column_stack((width * np.cos(angle), height * np.sin(angle), 0.0 * angle))
    wanted, _ = quad(lambda x: np.hypot(width * np.sin(x), height * np.cos(x)), 0.0, 2 * np.pi, epsrel=1e-12)
    assert kf.PointOnCurve(ellipse, closed=True).length == pytest.approx(wanted, rel=1e-7)


def test_a_curve_far_from_its_frame_is_the_same_curve():
    near, far = (kf.PointOnCurve(knot() + offset, closed=True) for offset in (0.0, 1e6))
    assert far.length == pytest.approx(near.length, rel=1e-10)  # points of 1e6 m are rounded to 1e-10 m
    assert len(far.pieces.x) == pytest.approx(len(near.pieces.x), rel=0.05)


def test_laps_of_a_closed_curve_are_counted():
    joint = kf.PointOnCurve(knot(), closed=True, turns=True, position=0.5, speed=4.0)
    scene = kf.System()
    scene.add_point("bead", 0.3, joint=joint)
    result = scene.simulate((0.0, 25.0), rtol=1e-10)
    s = result.joint_coordinates("bead")[-1, 0]
    assert s > 3 * joint.length
    # nothing pushes it along the curve, whose arc length is right to 1e-12 and so its slope to 1e-10 within a piece
    assert s == pytest.approx(0.5 + 4.0 * 25.0, rel=1e-8)
    np.testing.assert_allclose(result.position("bead")[-1], joint.pose([s % joint.length])[0], rtol=0, atol=1e-12)
    axes = rotation_matrix(result.rotation("bead")[-1])
    np.testing.assert_allclose(axes, joint.pose([s % joint.length])[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("points", "closed"), [(knot(), True), (helix(), False)])
def test_a_frame_without_up_does_not_spin_about_the_curve_but_closes_it(points, closed):
    joint = kf.PointOnCurve(points, closed=closed, turns=True)
    places = np.linspace(0.0, joint.length, 300)[:-1]
    spins = []
    for s in places:
        axes, (V, W) = joint.pose([s])[1], joint.partial_velocities([s])
        np.testing.assert_allclose(axes[:, 0], V[:, 0], rtol=0, atol=1e-11)
        spins.append(W[:, 0] @ V[:, 0])
    # reflections from piece to piece: the fourth power of pieces of 0.02 m
    np.testing.assert_allclose(spins, np.mean(spins) if closed else 0.0, rtol=0, atol=1e-5)
    if closed:
        ends = joint.pose([0.0])[1], joint.pose([joint.length * (1 - 1e-15)])[1]
        np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-11)


def test_up_stays_up():
    joint = kf.PointOnCurve(helix(), turns=True, up="z")
    for s in np.linspace(0.0, joint.length, 50):
        axes = joint.pose([s])[1]
        assert axes[2, 1] == pytest.approx(0.0, abs=1e-14)  # y is level
        assert axes[2, 2] > 0.9


VARIANTS = {
    "parallel": {"points": helix(), "position": 0.4, "speed": -0.7},
    "turning": {"points": helix(), "turns": True, "position": 0.4, "speed": -0.7},
    "up": {"points": knot(), "closed": True, "turns": True, "up": (0.3, 0.1, 1.0), "position": 40.0, "speed": 2.0},
    "driven": {"points": helix(), "turns": True, "motion": kf.Motion.steady(0.8, 0.3)},
    "with forces": {"points": helix(), "turns": True, "forces": kf.CoordinateForce(stiffness=30.0, damping=2.0)},
    "before its start": {"points": helix(), "turns": True, "motion": kf.Motion.steady(-0.8, -0.3)},
    "behind its end": {"points": helix(), "turns": True, "motion": kf.Motion.steady(0.8, 30.0)},
}


@pytest.mark.parametrize("options", VARIANTS.values(), ids=VARIANTS)
def test_both_routes_agree_to_round_off(options):
    assert_routes_agree(scene_of(kf.PointOnCurve(**options)).freeze(), 0.4)


def test_both_routes_agree_with_a_flexible_body_in_a_loop():
    assert_routes_agree(scene_of(kf.PointOnCurve(**VARIANTS["turning"]), is_flexible=True).freeze())


def test_energy_is_kept_and_the_reaction_is_across_the_curve():
    joint = kf.PointOnCurve(knot(), closed=True, turns=True, speed=3.0)
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    # a body without inertia, so that the moment of the reaction does no work along the curve either
    scene.add_point("bead", 0.3, joint=joint)
    rail = kf.System(gravity=(0, 0, -GRAVITY))
    rail.add_rigid_body("wagon", 2.0, (0.2, 0.3, 0.25), com=(0.1, 0.05, -0.2), joint=joint)
    result = scene.simulate((0.0, 5.0), rtol=1e-9)
    tangents = np.array([joint.partial_velocities(q)[0][:, 0] for q in result.joint_coordinates("bead")])
    reactions = zip(result.rotation("bead"), result.joint_reaction("bead")[:, :3], strict=True)
    forces = np.array([rotation_matrix(e) @ force for e, force in reactions])
    along = abs(np.sum(forces * tangents, axis=1))
    assert along.max() < 1e-9 * np.linalg.norm(forces, axis=1).max()  # rtol
    for run in (result, rail.simulate((0.0, 5.0), rtol=1e-9)):
        # errors of 1e-9 a step add up over some hundred steps
        assert abs(run.energy.balance_error).max() < 1e-6 * run.energy.kinetic.max()


def test_derivatives_are_exact():
    model = scene_of(kf.PointOnCurve(**VARIANTS["turning"])).freeze()
    y = np.concatenate((model.initial_state, (0.0, 0.0)))
    at = model.coordinate_names().index("slider: arc length [m]")
    row = model.route.derivatives(0.0, y, np.eye(len(y))[at : at + 1])[0]
    wanted, _ = derivatives(lambda s: model.route.evaluate(0.0, y + s * np.eye(len(y))[at]).rates, step=2e-4)
    # differences within a piece, of 0.01 m: round-off of 1e-13 over their step
    np.testing.assert_allclose(row, wanted, rtol=0, atol=3e-9 * (1.0 + abs(wanted).max()))


@pytest.mark.parametrize("kind", [kf.PointOnCurve, InPython])
@pytest.mark.parametrize(("position", "speed"), [(0.5, 2.0), (1.0, -2.0), (0.0, -1.0)])
def test_a_run_that_leaves_the_curve_fails_and_says_where(kind, position, speed):
    joint = kind(((0, 0, 0), (1, 0, 0), (2, 0, 0)), position=position, speed=speed)
    scene = kf.System()
    scene.add_point("bead", 0.3, joint=joint)
    with pytest.warns(kf.SimulationWarning, match="arc length of the .* joint of body 'bead'"):
        result = scene.simulate((0.0, 3.0), rtol=1e-9)
    end = (2.0 - position) / speed if speed > 0.0 else -position / speed
    assert result.status.kind == "failed"
    assert result.status.time == pytest.approx(end, abs=1e-8)  # 1e-9 of the range beyond its end
    assert "between 0 and 2 m" in str(result.status)
    assert "Remedy: a joint of a larger range" in str(result.status)
    assert result.times[-1] == result.status.time
    assert result.events == {}
    assert result.statistics["route"] == ("literal" if kind is InPython else "order n")


def test_a_driven_point_may_go_to_the_end_and_not_beyond():
    line = ((0, 0, 0), (1, 0, 0), (2, 0, 0))

    def run(motion, stop):
        scene = kf.System()
        base = scene.add_rigid_body("base", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0))
        scene.add_point("bead", 0.3, parent=base, joint=kf.PointOnCurve(line, motion=motion))
        return scene.simulate((0.0, stop))

    times = np.linspace(0.0, 1.0, 11)
    assert run(kf.Motion.table(times, 2.0 * times**2 * (3.0 - 2.0 * times)), 1.0).status.is_finished
    with pytest.warns(kf.SimulationWarning, match="comes to its end"):
        assert run(kf.Motion.steady(1.0), 3.0).status.time == pytest.approx(2.0, abs=1e-8)
    with pytest.raises(kf.ModelError, match=r"starts at 3\. Remedy: a start within its range"):
        run(kf.Motion.steady(-1.0, 3.0), 1.0)


TWICE = circle(9)[[0, 1, 1, 2, 3, 4]]
BAD = [
    ({"points": [(0, 0, 0)]}, r"finite numbers of shape \(n, 3\), 2 of them or more"),
    ({"points": circle(9)[:2], "closed": True}, "3 of them or more"),
    ({"points": [(0, 0), (1, 0)]}, r"shape \(2, 2\) was given"),
    ({"points": "a circle"}, r"shape \(\) was given"),
    ({"points": [(0, 0, 0), (1, np.nan, 0)]}, "a number is not finite"),
    ({"points": TWICE}, "points 1 and 2 of a point-on-curve joint coincide. Remedy"),
    ({"points": np.vstack((circle(9), circle(9)[:1])), "closed": True}, "last point .* is the first again. Remedy"),
    ({"points": [(0, 0, 0), (1, 0, 0), (0.5, 0, 0)]}, "turns back on itself behind point .*Remedy"),
    ({"points": circle(9), "position": 7.0}, "starts at an arc length of 7 m, but its curve goes from 0 to .*Remedy"),
    ({"points": circle(9), "position": np.nan}, "position of a point-on-curve joint must be one finite number"),
    ({"points": circle(9), "closed": 1}, "closed of a point-on-curve joint must be True or False"),
    ({"points": circle(9), "up": "z"}, "has nothing up. Remedy: turns=True"),
    ({"points": circle(9), "turns": True, "up": (0, 0, 0)}, "axis of a point-on-curve joint"),
    ({"points": circle(60), "closed": True, "turns": True, "up": "z"}, "runs along up at an arc length of .*Remedy"),
    ({"points": circle(9), "motion": 3.0}, "motion of a point-on-curve joint must be a Motion"),
    ({"points": circle(9), "speed": 1.0, "motion": kf.Motion.steady(1.0)}, "Remedy: leave out position and speed"),
]


@pytest.mark.parametrize(("options", "message"), BAD, ids=[message[:30] for _, message in BAD])
def test_bad_input_is_named(options, message):
    with pytest.raises(kf.ModelError, match=message):
        kf.PointOnCurve(**options)
