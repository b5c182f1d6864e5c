"""How often a run returns to Python: once, if its scene has no functions of the user."""

from collections import Counter

import numpy as np
import pytest

import kanefe as kf
from bouncing_scenes import bouncing_ball, swinging_rod
from kanefe.integrate.events.event_search import EventWatch
from kanefe.kernels.compiler.entries import Call
from loop_scenes import four_bar

LOOPS = "integrate", "pass_steps"
"""Kernels that go through a run."""


def spring_and_mass() -> kf.System:
    """Return a mass that hangs on a spring."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    mass = scene.add_rigid_body("mass", 1.0, 0.1, joint=kf.Prismatic("z", position=-0.5))
    scene.add_spring("spring", scene.ground, mass, stiffness=1e3, rest_length=0.3)
    return scene


def cradle() -> kf.System:
    """Return five balls on rods side by side, of which the first falls onto the others."""
    scene, radius = kf.System(gravity=(0.0, 0.0, -9.81)), 0.05
    skins = []
    for i in range(5):
        joint = kf.Revolute("y", position=0.3 if i == 0 else 0.0)
        ball = scene.add_rigid_body(f"ball {i}", 4.0, 0.004, com=(0, 0, -1), at=(2.0 * radius * i, 0, 0), joint=joint)
        skins.append(scene.add_surface(f"skin {i}", ball.frame(at=(0, 0, -1)), kf.shapes.Sphere(radius)))
    for i in range(4):
        scene.add_contact(f"contact {i}", skins[i], skins[i + 1], normal=kf.Hertz(1e9))
    return scene


def sliding_ball() -> kf.System:
    """Return a ball that slides over a floor until it rolls."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    joint = kf.Free(position=(0.0, 0.0, 0.1 - 9.81e-6), velocity=(1.0, 0.0, 0.0))  # pressed in by its weight
    ball = scene.add_rigid_body("ball", 1.0, 0.004, joint=joint)
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("feet", skin, floor, normal=kf.HuntCrossley(1e6), friction=kf.Coulomb(0.3))
    return scene


@pytest.fixture
def returns(monkeypatch) -> Counter:
    """Return what counts the returns from each kernel, and searches for events in Python."""
    counted, call, scan = Counter(), Call.__call__, EventWatch.scan

    def counted_call(self):
        counted[self._bound._entry.__name__] += 1
        return call(self)

    def counted_scan(self, *given):
        counted["scan"] += 1
        return scan(self, *given)

    monkeypatch.setattr("kanefe.integrate.loop.CHUNK_SECONDS", 1e3)  # else the clock, too, has a say
    monkeypatch.setattr(Call, "__call__", counted_call)
    monkeypatch.setattr(EventWatch, "scan", counted_scan)
    return counted


@pytest.mark.parametrize(
    ("make", "event"),
    [
        (swinging_rod, ""),
        (four_bar, ""),
        (spring_and_mass, ""),
        (bouncing_ball, "feet touch"),
        (cradle, "contact 0 touch"),
        (sliding_ball, "feet stick"),
    ],
)
def test_a_run_is_one_call_of_compiled_code(make, event, returns):
    scene, times = make(), np.linspace(0.0, 1.0, 1000)
    scene.simulate((0.0, 1.0), output_times=times)
    assert 1 <= sum(returns[loop] for loop in LOOPS) <= 8  # of a scene that is not known: 16, 64, 256 ... steps
    returns.clear()
    result = scene.simulate((0.0, 1.0), output_times=times)
    assert len(result.times) == 1000
    assert event == "" or len(result.events[event]) >= 1
    # one, and one for each look at the work, at 1e6 products and then as the steps grow by half
    assert sum(returns[loop] for loop in LOOPS) <= 8
    assert returns["scan"] == 0


def test_what_looks_at_the_state_in_python_is_asked_step_by_step(returns):
    lowest = kf.Event("lowest", lambda t, state: state.joint_coordinates("rod")[0] + 0.5 * np.pi)
    result = swinging_rod().simulate((0.0, 1.0), events=lowest)
    assert returns["scan"] == returns["integrate"] == result.statistics["steps"]
