"""What a run has before its first step is kept for the next run like it, which is the same to the bit."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import kanefe as kf
from bouncing_scenes import bouncing_ball, bouncing_brick, swinging_rod
from kanefe.order_n.tables.scene_tables import TableBuilder
from kanefe.tree.scales import displacement_scales
from loop_scenes import four_bar

NUMBERS = "coordinates", "speeds", "internal", "dissipated", "work"


class InPython(kf.Load):
    """A load of the user without a kernel, beside which others may have one."""

    def __init__(self, name, ends):
        self.name, self.ends = name, ends

    def action(self, t, ends, states):
        return kf.Action(np.zeros((2, 6)))


def is_same(one: kf.Result, other: kf.Result) -> bool:
    """Return whether two runs have the same states, events and counts, to the bit."""
    a, b = one.run.trajectory, other.run.trajectory
    counts = [{name: run.statistics[name] for name in ("steps", "rejected", "evaluations")} for run in (a, b)]
    return (
        counts[0] == counts[1]
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in NUMBERS)
        and a.events.keys() == b.events.keys()
        and all(np.array_equal(a.events[name], b.events[name]) for name in a.events)
    )


@pytest.mark.parametrize("make", [bouncing_ball, bouncing_brick, swinging_rod, four_bar])
@pytest.mark.parametrize("method", ["radau5", "dop853", "extrapolation"])
@pytest.mark.filterwarnings("ignore:impacts in which several")  # the corners of the brick strike as they may
def test_a_run_is_the_same_to_the_bit_each_time(make, method):
    scene = make()
    first = scene.simulate((0.0, 0.5), method=method)
    assert len(scene.freeze().set_ups) == 1  # else nothing is looked at here
    other = scene.simulate((0.0, 0.3), method=method)
    assert is_same(scene.simulate((0.0, 0.5), method=method), first)
    assert is_same(scene.simulate((0.0, 0.3), method=method), other)
    assert is_same(make().simulate((0.0, 0.5), method=method), first)


def test_what_a_start_is_warned_of_is_told_each_time():
    """A plate that fits between two walls leaves one for the other: by Newton's law there are no impulses."""
    scene = kf.System()
    plate = scene.add_rigid_body("plate", 1.0, 0.01, joint=kf.Prismatic("x", speed=1.0))
    for name, side, axis in (("left", -0.1, "x"), ("right", 0.1, "-x")):
        wall = scene.add_surface(f"{name} wall", scene.ground.frame(at=(side, 0.0, 0.0)), kf.shapes.Plane(axis))
        law = kf.Rigid(0.5, impact="newton")
        scene.add_contact(name, [plate.frame(at=(side, 0.0, 0.0))], wall, normal=law)
    for _ in range(3):
        with pytest.warns(kf.SimulationWarning, match="by Poisson's law.*the first at t = 0 s"):
            scene.simulate((0.0, 0.1))


def test_what_a_run_warns_of_is_its_own():
    scene, told = bouncing_brick(), []
    for _ in range(2):
        with pytest.warns(kf.SimulationWarning, match="which strikes first") as found:
            scene.simulate((0.0, 0.3))
        told.append([str(one.message) for one in found])
    assert told[0] == told[1]


def test_a_result_is_not_changed_by_the_next_run():
    scene = bouncing_ball()
    first = scene.simulate((0.0, 0.5))
    height, touched = first.position("ball").copy(), first.events["feet touch"].copy()
    assert len(touched)
    scene.simulate((0.0, 0.5), output_step=0.1)
    assert np.array_equal(first.position("ball"), height)
    assert np.array_equal(first.events["feet touch"], touched)


def test_runs_in_several_threads_do_not_meet():
    scene = bouncing_ball()
    first = scene.simulate((0.0, 0.5))
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: scene.simulate((0.0, 0.5)), range(8)))
    assert all(is_same(one, first) for one in found)


def test_a_run_after_one_that_was_stopped_begins_at_the_start():
    scene = bouncing_ball()
    first = scene.simulate((0.0, 0.5))
    stopped = scene.simulate((0.0, 0.5), most_steps=10)
    assert stopped.status.kind == "stopped"
    assert stopped.times[-1] < 0.5
    assert is_same(scene.simulate((0.0, 0.5)), first)


def test_what_may_be_otherwise_the_next_time_is_not_kept():
    pushed = swinging_rod(forces=kf.CoordinateForce(stiffness=1.0))
    assert pushed.simulate((0.0, 0.1)).run.model.set_ups

    strength = [1.0]
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    rod = scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    scene.add_motor(rod, lambda t: strength[0])
    first = scene.simulate((0.0, 0.1))
    strength[0] = 2.0
    assert scene.simulate((0.0, 0.1)).joint_coordinates("rod")[-1] != first.joint_coordinates("rod")[-1]

    scene = swinging_rod()
    scene.add_spring("spring", scene.body("rod").frame((1.0, 0.0, 0.0)), scene.ground, stiffness=1.0)
    with_own = scene.copy()
    with_own.add(InPython("own", (with_own.body("rod"), with_own.ground)))
    assert [one.freeze() is one.freeze() for one in (scene, with_own)] == [True, False]

    scene = swinging_rod()
    for level in (-0.1, -0.2):
        lowest = kf.Event("passes", lambda t, state, level=level: state.joint_coordinates("rod")[0] - level)
        found = scene.simulate((0.0, 0.5), events=lowest, rtol=1e-9)
        assert found.run.model.set_ups == {}
        at = np.interp(found.events["passes"][0], found.times, found.joint_coordinates("rod")[:, 0])
        assert at == pytest.approx(level, abs=1e-5)  # straight between outputs of 1 ms: a h^2 / 8 = 2e-6


@pytest.mark.parametrize("make", [bouncing_ball, bouncing_brick, swinging_rod, four_bar])
@pytest.mark.filterwarnings("ignore:impacts in which several")
def test_a_given_start_is_run_as_in_a_scene_of_its_own(make):
    scene = make()
    starts = [scene.simulate((0.0, 0.2)).at(t) for t in (0.1, 0.2)]
    for start in (*starts, None, starts[0]):
        assert is_same(scene.simulate((0.0, 0.3), start=start), make().simulate((0.0, 0.3), start=start))


def test_starts_of_one_scene_share_their_tables(monkeypatch):
    made = []
    monkeypatch.setattr(
        "kanefe.order_n.scene_in_tables.TableBuilder", lambda model: made.append(1) or TableBuilder(model)
    )
    scene = four_bar()
    for start in [scene.simulate((0.0, 0.2)).at(t) for t in (0.1, 0.2)]:
        scene.simulate((0.0, 0.1), start=start)
    scene.freeze(0.0, start)
    assert len(made) == 1


def test_starts_of_a_scene_with_functions_do_not_share():
    scene = kf.System()
    height = 1.0
    drive = kf.Motion(lambda t: height, lambda t: 0.0, lambda t: 0.0)
    carriage = scene.add_rigid_body("carriage", 1.0, 0.1, joint=kf.Prismatic("z", motion=drive))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), parent=carriage, joint=kf.Revolute("y"))
    scene.add_spring("slack at the start", scene.ground, carriage, stiffness=100.0)
    start = scene.freeze().initial_state
    for place in (1.0, 2.0):
        height = place  # where the drive stands from now on
        assert not scene.simulate((0.0, 0.1), start=start).load_force("slack at the start").any()


def test_the_size_of_points_on_slides_is_that_of_their_start():
    scene = kf.System()
    scene.add_rigid_body("point", 1.0, joint=kf.Prismatic("x", position=0.0))
    for place in (2.0, 5.0, 0.0):
        assert displacement_scales(scene.freeze(0.0, np.array([place, 0.0]))) == [place or 1.0]
