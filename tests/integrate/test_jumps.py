"""Jumps of functions of time are found before a run to round-off, and steps end there on the side that they are on."""

import math
import warnings
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.jumps import jumps_of, without

TIMES = np.linspace(0.0, 40.0, 961)


def _rows(function: Callable[[float], object]) -> np.ndarray:
    return np.array([np.atleast_1d(function(t)) for t in TIMES.tolist()], dtype=float)


def _counted(function: Callable[[float], object]) -> tuple[Callable[[float], object], list[float]]:
    asked: list[float] = []

    def counting(t: float) -> object:
        asked.append(t)
        return function(t)

    return counting, asked


@pytest.mark.parametrize(
    ("function", "where"),
    [
        (lambda t: 3.0 if 0.24006 <= t < 6.0 else -1.0, [0.24006, 6.0]),
        (lambda t: (0.0, 2.0 * (t >= 7.3), math.sin(t) - 5.0 * (t >= 9.1)), [7.3, 9.1]),
        # two between samples, of which none sees what is between, and a small one on what moves
        (lambda t: 1.0 * (t >= 3.342) + 1.0 * (t >= 3.351), [3.342, 3.351]),
        (lambda t: 20.0 * math.sin(0.5 * t) + 0.5 * (t >= 7.7), [7.7]),
    ],
)
def test_jumps_are_found_to_the_last_digit(function: Callable[[float], object], where: list[float]) -> None:
    rows = _rows(function)
    found = jumps_of(function, TIMES, rows)
    assert found.after.tolist() == where
    assert found.before.tolist() == [math.nextafter(t, 0.0) for t in where]
    # what is left is smooth: no change of a sample is half as large as the smallest jump
    assert np.abs(np.diff(without(found, TIMES, rows), axis=0)).max() < 0.5


@pytest.mark.parametrize(
    "function",
    [
        lambda t: math.sin(2.0 * t),
        lambda t: abs(t - 3.3),
        lambda t: min(max((t - 3.0) / 1e-3, 0.0), 1.0),  # steep, but no jump
        lambda t: math.sin(60.0 * t),  # faster than the samples
        lambda t: float(hash(str(t)) % 1000),  # noise jumps everywhere
    ],
)
def test_what_is_smooth_or_noise_has_no_jumps_and_costs_few_calls(function: Callable[[float], float]) -> None:
    counting, asked = _counted(function)
    assert len(jumps_of(counting, TIMES, _rows(function)).after) == 0
    assert len(asked) < 5 * len(TIMES)


JUMPS = 0.24006, 6.0, 12.24006


def _push(t: float) -> float:
    return 7.5 * (JUMPS[0] <= t < JUMPS[1]) - 5.0 * (JUMPS[1] <= t < JUMPS[2])


def _impulse(t: np.ndarray) -> np.ndarray:
    first, second = (np.clip(t, a, b) - a for a, b in (JUMPS[:2], JUMPS[1:]))
    return 7.5 * first - 5.0 * second


@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "extrapolation", "generalised-alpha", "scipy-bdf"])
@pytest.mark.parametrize("is_compiled", [False, True])
def test_a_momentum_is_the_impulse_of_a_force_that_jumps(method: str, is_compiled: bool) -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 80.0, joint=kf.Revolute("z"))
    scene.add_motor(wheel, kf.compiled(_push) if is_compiled else _push)
    result = scene.simulate((0.0, 20.0), output_step=0.02, rtol=1e-3, method=method)
    # a constant force is exact in each method: round-off, of the numbers that are added
    assert np.abs(80.0 * result.joint_speeds("wheel")[:, 0] - _impulse(result.times)).max() < 1e-11 * 45.0


@pytest.mark.parametrize("method", ["dop853", "radau5", "extrapolation"])
def test_a_vibration_that_jumps_begin_is_that_of_the_closed_form(method: str) -> None:
    scene = kf.System()
    block = scene.add_rigid_body("block", 2.0, joint=kf.Prismatic("y", forces=kf.CoordinateForce(stiffness=200.0)))
    scene.add_force(block, lambda t: (0.0, _push(t), 0.0))
    result = scene.simulate((0.0, 20.0), output_step=0.01, rtol=1e-8, method=method)
    steps = zip((*JUMPS,), (7.5, -12.5, 5.0), strict=True)
    exact = sum(height / 200.0 * (1.0 - np.cos(10.0 * np.clip(result.times - t, 0.0, None))) for t, height in steps)
    # the size of the scene is a metre; 32 periods, of which each may lose a part of the tolerance
    assert np.abs(result.joint_coordinates("block")[:, 0] - exact).max() < 10.0 * 1e-8


def test_a_jump_within_a_sample_of_the_start_and_one_at_a_sample_of_a_controller() -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 2.0, joint=kf.Revolute("z"))
    scene.add_motor(wheel, lambda t: 3.0 * (t > 0.0) + 1.0 * (t >= 0.3))
    scene.add_controller(
        "none", lambda t, reads, memory: 0.0, reads=("joint_speeds wheel",), drives=("motor wheel",), every=0.1
    )
    result = scene.simulate((0.0, 1.0), output_step=0.05, rtol=1e-3)
    exact = 3.0 * result.times + np.clip(result.times - 0.3, 0.0, None)
    assert np.abs(2.0 * result.joint_speeds("wheel")[:, 0] - exact).max() < 1e-12


def test_a_function_of_the_state_that_jumps_is_named_with_the_remedy() -> None:
    def told(torque: Callable[..., float]) -> list[str]:
        scene = kf.System()
        wheel = scene.add_rigid_body("wheel", 1.0, 80.0, joint=kf.Revolute("z", speed=1.0))
        scene.add_motor(wheel, torque)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene.simulate((0.0, 10.0), rtol=1e-6, method="dop853")
        return [str(one.message) for one in caught]

    (text,) = told(lambda t, state: -20.0 if state.joint_coordinates("wheel")[0] > 2.3 else 10.0)
    assert "motor of 'wheel' jumps by 30" in text
    assert "kf.Event" in text
    assert not told(lambda t, state: -20.0 * math.tanh(50.0 * (state.joint_coordinates("wheel")[0] - 2.3)))
