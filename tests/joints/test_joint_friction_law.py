"""Dry friction along coordinates and under a joint's load against closed forms; Python and compiled alike."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from acting_loads import WAYS, acted, assert_complex_steps_are_differences
from kanefe.joints.joint_friction import RubbingSurfaces
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.force_elements.coordinate_friction import BALL, PADS, THREAD
from kanefe.loads.action import Action, End
from kanefe.loads.coordinate_friction import CoordinateFriction

k, c = 4e3, 30.0
ARMS = {1: (0.3,), 2: (0.3, 1.0), 3: (0.3, 0.3, 0.3)}
STRETCH, RATES = np.array((2e-3, -1e-3, 3e-3)), np.array((0.5, -0.2, 0.4))


def friction_of(count: int = 1, **given: Any) -> CoordinateFriction:
    numbers = {"sliding": 5.0, "static": 5.0, "stiffness": k, "damping": c, "arms": ARMS[count]} | given
    marks: Any = ("coordinate",) * count
    return CoordinateFriction("f", marks, coordinate="joint", units=("rad",) * count, **numbers)


def ends_of(count: int, rates: np.ndarray = RATES) -> list[End]:
    zero = np.zeros(3)
    return [End(np.array((0.1 * i, 0.0, 0.0)), np.eye(3), np.array((rates[i], 0, 0)), zero) for i in range(count)]


def pull_of(count: int, rates: np.ndarray = RATES) -> np.ndarray:
    return k * STRETCH[:count] + c * np.array(ARMS[count]) * rates[:count]


def check(done: Action, count: int, drag: np.ndarray) -> None:
    """Compare forces, energy, power and rates of friction with what its drag makes of them."""
    w, v = STRETCH[:count], np.array(ARMS[count]) * RATES[:count]
    rate = (drag - k * w) / c
    np.testing.assert_allclose(done.wrenches[:, 0], -drag * ARMS[count], rtol=1e-12)
    assert not np.any(done.wrenches[:, 1:])
    np.testing.assert_allclose(done.rates[:count], rate, rtol=1e-10, atol=1e-12)
    assert done.potential == pytest.approx(0.5 * k * w @ w, rel=1e-12)
    assert done.taken == pytest.approx(drag @ v - k * w @ rate, rel=1e-11)
    assert done.given == 0.0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_it_sticks_and_slips_in_all_directions_together(count: int, way: str) -> None:
    pull, states = pull_of(count), STRETCH[:count]
    size = float(np.linalg.norm(pull))
    sticks = friction_of(count, sliding=2.0 * size, static=2.0 * size)
    check(acted(sticks, ends_of(count), states, way), count, pull)
    slips = friction_of(count, sliding=0.3 * size, static=0.3 * size)
    check(acted(slips, ends_of(count), states, way), count, 0.3 * pull)


@pytest.mark.parametrize("way", WAYS)
def test_what_is_remembered_decides_by_which_cap(way: str) -> None:
    pull = pull_of(2)
    size = float(np.linalg.norm(pull))
    law = friction_of(2, sliding=0.01 * size, static=0.02 * size)
    for held, most in ((1.0, 0.02 * HELD_BEYOND), (0.0, 0.01)):  # held, it waits for its event up to a multiple
        check(acted(law, ends_of(2), np.append(STRETCH[:2], held), way), 2, most * pull)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("count", [1, 3])
def test_what_falls_is_the_root_of_its_equation(count: int, way: str) -> None:
    """``c s + F(s) = |p|``, with F falling from static to sliding."""
    pull = pull_of(count)
    size, speed = float(np.linalg.norm(pull)), 0.2
    law = friction_of(count, sliding=0.3 * size, static=0.5 * size, stribeck_speed=speed)

    def friction(s: float) -> float:
        return size * (0.3 + 0.2 * math.exp(-((s / speed) ** 2)))

    s = brentq(lambda s: c * s + friction(s) - size, 0.0, size / c, xtol=1e-14)
    drag = friction(s) / size * pull
    check(acted(law, ends_of(count), np.append(STRETCH[:count], 0.0), way), count, drag)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("felt", "load"), [(7.0, 10.0), (-2.0, 3.0)])
def test_it_grows_with_the_load_that_is_felt(felt: float, load: float, way: str) -> None:
    """``mu (base + load)``; a load below zero is none."""
    law = friction_of(1, sliding=0.1, static=0.1, base=3.0, load_time=0.1, bearing=RubbingSurfaces((0.3,), PADS, 0))
    done = acted(law, ends_of(1), np.array((STRETCH[0], felt, 0.0)), way)
    pull = pull_of(1)
    check(done, 1, 0.1 * load * np.sign(pull))


F, M, AXIS = np.array((3.0, -4.0, 5.0)), np.array((0.7, 0.4, -0.9)), np.array((0.0, 0.6, 0.8))


@pytest.mark.parametrize(
    ("bearing", "load"),
    [
        (RubbingSurfaces((0.3,), BALL, AXIS), math.sqrt(50.0)),
        (RubbingSurfaces((0.3,), PADS, AXIS), math.sqrt(50.0 - 1.6**2)),
        (RubbingSurfaces((0.3,), PADS, AXIS, thrust=2.0), math.sqrt(50.0 - 1.6**2) + 2.0 * 1.6),
        (RubbingSurfaces((0.3,), PADS, AXIS, twist=3.0), math.sqrt(50.0 - 1.6**2) + 3.0 * 0.48),
        (RubbingSurfaces((0.3,), THREAD, AXIS, thrust=1.1, twist=0.2), abs(1.1 * 1.6 + 0.2 * 5.0)),
    ],
    ids=["ball", "bearing", "collar", "rail", "thread"],
)
def test_the_load_of_a_reaction(bearing: RubbingSurfaces, load: float) -> None:
    """F . a = 1.6 N and M . a = -0.48 N m; a thread also feels its own drag, 5 N here."""
    assert bearing.load(np.append(F, M), 5.0) == pytest.approx(load, rel=1e-12)
    friction = friction_of(1, sliding=5.0, static=5.0, base=0.0, load_time=0.1, bearing=bearing)
    states = np.array((1.0, 1.0, 2.0))  # a pull above 5 N under a load that is felt of 1 N
    rates = friction.load_rates(np.append(F, M), ends_of(1), states)
    np.testing.assert_allclose(rates, (2.0 + 2.0 * (load - 1.0), load - 1.0) / np.array((0.1, 0.1)), rtol=1e-12)


def test_two_pads_take_a_moment_as_a_couple() -> None:
    """Between them 0.5 m: a moment of 6 N m across the axis is 12 N on each, beside half of a side force of 10 N."""
    pads = RubbingSurfaces((0.3,), PADS, np.array((0.0, 0.0, 1.0)), per_length=2.0)
    assert pads.load(np.array((10.0, 0, 0, 0, 6.0, 0)), 0.0) == pytest.approx((12.0 + 5.0) + (12.0 - 5.0))
    assert pads.load(np.array((10.0, 0, 0, 6.0, 0, 0)), 0.0) == pytest.approx(2.0 * math.hypot(12.0, 5.0))


@pytest.mark.parametrize("name", ["sticks", "slips", "falls"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_complex_steps_are_differences(name: str, count: int) -> None:
    size = float(np.linalg.norm(pull_of(count)))
    share = {"sticks": (2.0, 2.0, 0.0), "slips": (0.3, 0.4, 0.0), "falls": (0.3, 0.4, 0.2)}[name]
    law = friction_of(count, sliding=share[0] * size, static=share[1] * size, stribeck_speed=share[2])
    states = STRETCH[:count] if name == "sticks" else np.append(STRETCH[:count], 0.0)
    assert_complex_steps_are_differences(law, ends_of(count), states)
