"""Bushings that turn through half a turn are told: their moment jumps there."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import kanefe as kf
from scenes import lattice_body


def turning(speed: float, stiffness: tuple[float, ...] = (0, 0, 0, 0, 0, 0.02), **options: object) -> kf.System:
    """Return a body of 0.01 kg m2 on a bushing from the ground, that begins to turn about z."""
    scene = kf.System()
    body = scene.add_rigid_body("b", 1.0, 0.01, joint=kf.Free(angular_velocity=(0, 0, speed)))
    scene.add_bushing("mount", scene.ground, body, stiffness=stiffness, **options)
    return scene


def test_half_a_turn_fails_the_run_where_it_happens() -> None:
    """The swing ``speed / w sin wt`` of w = sqrt(2) 1/s comes to pi; from w pi on it does."""
    w = math.sqrt(2.0)
    with pytest.warns(kf.SimulationWarning, match="bushing 'mount' went through half a turn"):
        result = turning(5.0).simulate((0.0, 2.0))
    passed = math.asin(math.pi * w / 5.0) / w
    assert result.status.kind == "failed"
    row = int(np.searchsorted(result.times, passed))
    assert result.status.time == result.times[row]
    assert f"between t = {result.times[row - 1]:.6g} s and {result.times[row]:.6g} s" in result.status.reason
    assert "kf.Bearing" in result.status.remedy
    with pytest.raises(kf.SimulationError, match="half a turn"):
        result.raise_for_status()


@pytest.mark.parametrize(
    "scene",
    [
        turning(0.99 * math.pi * math.sqrt(2.0)),
        turning(-0.99 * math.pi * math.sqrt(2.0)),
        turning(20.0, stiffness=(10.0, 10.0, 10.0)),  # without springs against rotation nothing jumps
        turning(20.0, stiffness=(0.0,) * 6, law=lambda x, rates: np.zeros(6)),
    ],
    ids=["swings up to half a turn", "and back", "no moment", "law"],
)
def test_what_stays_below_half_a_turn_is_not_told(scene: kf.System) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", kf.SimulationWarning)
        assert scene.simulate((0.0, 6.0)).status.is_finished


def test_outputs_that_are_far_apart_tell_nothing_wrong() -> None:
    """From one end of the swing, 2.9 rad, to the other: not the shorter way of 0.5 rad through half a turn."""
    w = math.sqrt(2.0)
    scene = turning(2.9 * w)
    quarter = 0.5 * math.pi / w
    times = [quarter, 3.0 * quarter]
    with warnings.catch_warnings():
        warnings.simplefilter("error", kf.SimulationWarning)
        assert scene.simulate((0.0, 3.0 * quarter), output_times=times).status.is_finished


@pytest.mark.parametrize(
    ("free", "turns"),
    [(True, 0.6), (True, 1.4), (False, 0.6), (False, 1.4), (False, 2.0), (False, 2.2), (False, 7.0)],
)
def test_outputs_that_are_far_apart_hide_no_turns(free: bool, turns: float) -> None:
    """A wheel next to unloaded, known at start and end only; Euler parameters count two turns."""
    speed = 20.0 * math.pi
    scene = kf.System()
    joint = kf.Free(angular_velocity=(0, 0, speed)) if free else kf.Revolute("z", speed=speed)
    wheel = scene.add_rigid_body("wheel", 1.0, (1.0, 1.0, 1.0), joint=joint)
    scene.add_bushing("mount", scene.ground, wheel, stiffness=(0, 0, 0, 0, 0, 1e-9))
    span = (0.0, 0.1 * turns)
    with pytest.warns(kf.SimulationWarning, match="bushing 'mount' went through half a turn"):
        result = scene.simulate(span, output_times=span)
    assert result.status.kind == "failed"


def test_a_driven_shaft_that_ends_as_it_began_has_turned() -> None:
    scene, spinning = kf.System(), kf.Motion.steady(20 * math.pi)
    shaft = scene.add_rigid_body("shaft", 1.0, (0, 0, 1.0), joint=kf.Revolute("z", motion=spinning))
    scene.add_bushing("mount", scene.ground, shaft, stiffness=(0, 0, 0, 0, 0, 1e-9))
    scene.add_point("ball", 1.0, joint=kf.Prismatic("x"))  # something to integrate
    with pytest.warns(kf.SimulationWarning, match="bushing 'mount' went through half a turn"):
        scene.simulate((0.0, 0.2), output_times=(0.0, 0.2))


def test_swings_seen_at_their_fastest_only_are_no_turns() -> None:
    """Known once a period, at the same speed of 1.2 w, which would turn by 7.5 rad if it lasted."""
    w = math.sqrt(2.0)
    scene = kf.System()
    forces = kf.CoordinateForce(stiffness=0.02)
    wheel = scene.add_rigid_body("wheel", 1.0, (0, 0, 0.01), joint=kf.Revolute("z", speed=1.2 * w, forces=forces))
    scene.add_bushing("mount", scene.ground, wheel, stiffness=(0, 0, 0, 0, 0, 1e-9))
    with warnings.catch_warnings():
        warnings.simplefilter("error", kf.SimulationWarning)
        period = 2.0 * math.pi / w
        assert scene.simulate((0.0, 3.0 * period), output_times=period * np.arange(4)).status.is_finished


def test_interfaces_of_flexible_bodies_are_ends_too() -> None:
    scene = kf.System()
    body = scene.add_flexible_body("arm", lattice_body(), joint=kf.Free(angular_velocity=(0, 0, 6.0)))
    scene.add_bushing("mount", scene.ground, body.interface("root"), stiffness=(0, 0, 0, 0, 0, 1e-9))
    with pytest.warns(kf.SimulationWarning, match="bushing 'mount' went through half a turn"):
        result = scene.simulate((0.0, 1.0))
    # next to nothing holds it, but it stretches as it spins, and is slower then
    assert math.pi / 6.0 < result.status.time < math.pi / 6.0 + 0.02
