"""Steps end just before an event and the run goes on from it: no step passes a kink, and none is tried in vain."""

from __future__ import annotations

from functools import cache

import pytest

import kanefe as kf
from kanefe.integrate.trajectory import Trajectory

END = 3.0
"""Three bounces, s."""


def bouncing() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Prismatic("z", position=1.0))
    scene.add_contact(
        "feet", scene.add_surface("skin", ball, kf.shapes.Sphere(0.1)), floor, normal=kf.HuntCrossley(1e5)
    )
    return scene


def ran(method: str, rtol: float, output_step: float = END) -> Trajectory:
    run = bouncing().simulate((0.0, END), method=method, rtol=rtol, output_step=output_step).run
    assert run is not None
    assert {name: len(times) for name, times in run.trajectory.events.items() if len(times)} == {
        "feet touch": 3,
        "feet lift": 3,
    }
    return run.trajectory


@cache
def exact() -> float:
    return float(ran("vern9", 1e-12).coordinates[-1, 0])


@pytest.mark.parametrize("method", ["dopri5", "dop853", "vern9"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_the_error_follows_rtol_over_bounces(method: str, rtol: float) -> None:
    # each bounce hands on what the steps before have: up to some ten errors of a step, 25 with order 5
    assert abs(ran(method, rtol).coordinates[-1, 0] - exact()) < 40.0 * rtol


def test_a_bounce_takes_its_own_steps_alone() -> None:
    counts = ran("dop853", 1e-6).statistics
    # 6 to begin; then a bounce takes 4 steps, a flight 2, but for the first, where nothing is known of either; and a
    # step goes across some lifts, and is taken again up to there
    assert counts["steps"] <= 33
    assert counts["rejected"] <= 9
    assert counts["evaluations"] <= 600


def test_states_between_a_step_and_the_event_behind_it_are_those_of_the_run() -> None:
    found = ran("dop853", 1e-8, output_step=1e-4)
    events = {name: found.events[name] for name in ("feet touch", "feet lift")}
    flight = found.times < events["feet touch"][0]
    assert found.coordinates[flight, 0] == pytest.approx(1.0 - 0.5 * 9.81 * found.times[flight] ** 2, abs=1e-9)
    is_low = found.coordinates[:, 0] < 0.1
    within = sum((found.times > a) & (found.times < b) for a, b in zip(*events.values(), strict=True))
    assert (is_low == within.astype(bool)).all()
