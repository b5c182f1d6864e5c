"""Runs and analyses that start from a state: of a result, of an equilibrium, of another scene, or a vector."""

import numpy as np
import pytest

import kanefe as kf
from loop_scenes import four_bar
from scenes import lattice_body


def wheel(joint: kf.Joint | None = None, anchor: float = 0.4) -> kf.System:
    """Return a wheel with a crank on a spring that is slack at the start."""
    scene = kf.System(gravity=(0, -9.81, 0))
    hub = scene.add_rigid_body("hub", 2.0, 0.3, joint=joint or kf.Revolute("z", position=0.3, speed=1.0))
    arm = scene.add_rigid_body("arm", 1.0, 0.05, com=(0.2, 0, 0), at=(0.1, 0, 0), parent=hub, joint=kf.Revolute("z"))
    scene.add_spring("spring", scene.ground.frame(at=(anchor, 0.5, 0)), arm.frame(at=(0.4, 0, 0)), stiffness=50.0)
    return scene


def test_two_runs_in_a_row_are_one():
    """The second one begins where the first ends; its spring keeps the length it had in the start of the scene."""
    options = {"method": "dop853", "rtol": 1e-9}
    scene = wheel(kf.Revolute("z", motion=kf.Motion.steady(3.0)))
    whole = scene.simulate((0.0, 1.0), output_step=0.5, **options)
    rest = scene.simulate((0.5, 1.0), start=whole.at(0.5), output_step=0.5, **options)
    # each run has an error of some 1e-9
    np.testing.assert_allclose(rest.joint_coordinates("arm")[-1], whole.joint_coordinates("arm")[-1], atol=1e-7)
    again = scene.simulate((0.5, 1.0), start=rest.at(0.5).state, output_step=0.5, **options)
    assert not np.allclose(
        again.joint_coordinates("arm")[-1], whole.joint_coordinates("arm")[-1], atol=1e-3
    )  # a vector has no scene
    np.testing.assert_array_equal(rest.joint_coordinates("arm")[0], whole.joint_coordinates("arm")[1])


def test_what_was_driven_is_let_go_with_its_speed():
    driven = wheel(kf.Revolute("z", motion=kf.Motion.steady(3.0, 0.2))).simulate((0.0, 0.4), output_step=0.4)
    model = wheel().freeze(0.4, driven.at(0.4))
    assert model.initial_coordinates[0] == pytest.approx(1.4, abs=1e-12)
    assert model.initial_speeds[0] == 3.0
    assert model.initial_coordinates[1] == driven.joint_coordinates("arm")[-1, 0]


def test_a_run_from_an_equilibrium_stays():
    scene = wheel(kf.Revolute("z", position=-1.5))
    found = kf.equilibrium(scene)
    result = scene.simulate((0.0, 1.0), start=found, rtol=1e-8)
    assert np.ptp(result.position("arm"), axis=0).max() < 1e-7
    assert kf.equilibrium(scene, start=found).iterations == 0
    assert kf.linearise(scene, start=found).modes().frequencies == pytest.approx(
        found.linearise().modes().frequencies, rel=1e-9
    )


def test_a_state_that_a_function_sees_is_a_start():
    seen = []
    scene = kf.System()
    scene.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x", speed=2.0))
    scene.simulate((0.0, 1.0), events=kf.Event("half", lambda t, state: (seen.append(state), t - 0.5)[1]))
    late = max(seen, key=lambda state: state.time)
    assert scene.freeze(0.0, late).initial_coordinates == pytest.approx(2.0 * late.time)


def test_loops_are_closed_in_a_given_state():
    scene = four_bar()
    result = scene.simulate((0.0, 0.3), output_step=0.3, rtol=1e-8)
    model = scene.freeze(0.3, result.at(0.3))
    np.testing.assert_allclose(model.initial_coordinates, result.at(0.3).q, atol=1e-10)
    with pytest.raises(kf.ModelError, match=r"'pin' between .* open"):
        scene.freeze(0.3, result.at(0.3).state + 0.1)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ([1.0], "has shape .*4 entries.*result.at"),
        ([0.0, np.nan, 0.0, 0.0], "arm: angle .* is nan"),
        (kf.Prismatic("z"), r"'hub' is on a revolute joint, on a prismatic joint"),
        ("other", "has the bodies other, and none of them"),
    ],
)
def test_a_start_that_is_none_is_refused(start, words):
    if isinstance(start, (kf.Prismatic, str)):
        scene = kf.System()
        name, joint = ("hub", start) if isinstance(start, kf.Prismatic) else (start, kf.Revolute("z"))
        scene.add_rigid_body(name, 1.0, 0.1, joint=joint)
        start = scene.simulate((0.0, 0.1), output_step=0.1).at(0.1)
    with pytest.raises(kf.ModelError, match=words):
        wheel().simulate((0.0, 1.0), start=start)


def test_a_whole_result_is_no_start():
    scene = wheel()
    result = scene.simulate((0.0, 0.1), output_step=0.1)
    with pytest.raises(kf.ModelError, match=r"a state at one time, not a Result. Remedy: result.at\(t\)"):
        scene.simulate((0.1, 0.2), start=result)


def test_other_modes_take_what_they_can_of_a_state_and_the_same_ones_all():
    scenes = []
    for body in (lattice_body(0), lattice_body(0, reduction=kf.CraigBampton(modes=2))):
        scene = kf.System()
        scene.add_flexible_body("arm", body, modal_speeds=np.arange(body.free_count))
        scenes.append(scene)
    found = kf.linearise(scenes[0]).state
    state = kf.Instant(scenes[0].freeze(), 0.0, found)
    assert scenes[0].copy().freeze(0.0, state).initial_speeds == pytest.approx(np.arange(len(found) // 2))
    with pytest.warns(kf.AccuracyWarning, match="'arm': the other body can take the deformation"):
        model = scenes[1].freeze(0.0, state)
    bodies = [scene.body("arm").body for scene in scenes]
    wanted = bodies[0].node_displacements(np.arange(bodies[0].free_count, dtype=float))
    found = bodies[1].node_displacements(model.initial_speeds)
    assert np.linalg.norm(found - wanted) < np.linalg.norm(wanted)
    for i in range(bodies[1].free_count):  # no other combination of the modes is nearer
        other = bodies[1].node_displacements(np.eye(bodies[1].free_count)[i])
        assert abs(np.sum(other * (found - wanted))) < 1e-9 * np.linalg.norm(other) * np.linalg.norm(wanted)
