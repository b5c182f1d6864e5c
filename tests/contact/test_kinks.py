"""Steps across a touch or a lift are taken again up to there, so that errors of bounces follow the tolerance."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf

SECONDS = 1.3


def bouncing(is_called: bool) -> kf.System:
    """Return a ball that bounces, beside a motor: where that is called, events are looked for in Python."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 0.3, 1e-3, joint=kf.Free(position=(0, 0, 0.15)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(3e5, 0.3))
    wheel = scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z"))
    if is_called:
        scene.add_motor(wheel, lambda t: 0.1)
    else:
        scene.add_motor(wheel, 0.1)
    return scene


@pytest.mark.parametrize("is_called", [False, True])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "vern9"])
def test_errors_of_bounces_follow_the_tolerance(method: str, is_called: bool) -> None:
    exact = bouncing(False).simulate((0.0, SECONDS), method="dop853", rtol=1e-12, output_step=0.05).position("ball")
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7):
        run = bouncing(is_called).simulate((0.0, SECONDS), method=method, rtol=rtol, output_step=0.05)
        assert len(run.events["drop touch"]) > 5
        # what is promised: ten times rtol of the size, which is of a metre
        assert np.abs(run.position("ball") - exact).max() < 10.0 * rtol


def test_a_step_across_a_touch_counts_as_rejected() -> None:
    run = bouncing(True).simulate((0.0, 0.15), method="dop853", rtol=1e-3)
    assert len(run.events["drop touch"]) == 1
    assert run.statistics["rejected"] >= 1
