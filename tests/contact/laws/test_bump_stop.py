"""A bump stop with hysteresis: both branches, what a cycle loses, and what bounces from it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import kanefe as kf
from acting_loads import WAYS, acted, assert_complex_steps_are_differences

K, SHARE, TURN = 2e4, 0.3, 2e-3
"""N/m, half the width of the loop over its middle, and m."""

DEEPEST = 0.02
STOP = kf.BumpStop((0.01, 0.05), (0.01 * K, 0.05 * K), hysteresis=SHARE, turning=TURN)


def pressed_by(motion: kf.Motion) -> kf.System:
    scene = kf.System()
    wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
    tip = scene.add_point("tip", 1.0, joint=kf.Prismatic("z", motion=motion))
    scene.add_contact("stop", tip, wall, normal=STOP)
    return scene


def going_in(d: float, start: float, at: float) -> float:
    """Return the branch at a depth on the way in, from one at another: ``dz/dd = (1 - z) / turning``."""
    return 1.0 - (1.0 - start) * math.exp(-(d - at) / TURN)


def going_out(d: float, start: float, at: float) -> float:
    return -1.0 + (1.0 + start) * math.exp(-(at - d) / TURN)


@pytest.mark.parametrize("rate", [1.0, 40.0])
def test_a_cycle_goes_along_both_branches_however_fast(rate: float) -> None:
    """From the middle at no depth to 20 mm and back, and the same again from where it was left."""
    motion = kf.Motion(
        lambda t: -0.5 * DEEPEST * (1.0 - math.cos(rate * t)),
        lambda t: -0.5 * DEEPEST * rate * math.sin(rate * t),
        lambda t: -0.5 * DEEPEST * rate**2 * math.cos(rate * t),
    )
    period = 2.0 * math.pi / rate
    result = pressed_by(motion).simulate((0.0, 2.0 * period), rtol=1e-9, output_step=period / 40.0)
    depth = result.contact("stop").penetration
    top = going_in(DEEPEST, 0.0, 0.0)
    left = going_out(0.0, top, DEEPEST)
    again = going_in(DEEPEST, left, 0.0)
    for i, d in enumerate(depth):
        cycle, way = divmod(i, 40)
        if cycle == 0:
            z = going_in(d, 0.0, 0.0) if way <= 20 else going_out(d, top, DEEPEST)
        else:
            z = going_in(d, left, 0.0) if way <= 20 else going_out(d, again, DEEPEST)
        wanted = K * max(d, 0.0) * (1.0 + SHARE * z)
        assert result.contact("stop").normal[i] == pytest.approx(wanted, abs=1e-5 * K * DEEPEST)
    lost = quad(lambda d: K * d * SHARE * (going_in(d, 0.0, 0.0) - going_out(d, top, DEEPEST)), 0.0, DEEPEST)[0]
    lost += quad(lambda d: K * d * SHARE * (going_in(d, left, 0.0) - going_out(d, again, DEEPEST)), 0.0, DEEPEST)[0]
    assert 0.8 < lost / (2.0 * SHARE * K * DEEPEST**2) < 1.0  # nearly the area between both branches, twice
    assert result.energy.dissipated[-1] == pytest.approx(lost, rel=1e-6)
    assert abs(result.energy.balance_error).max() < 1e-6 * lost


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("rate", [0.7, -0.7])
def test_it_is_its_equation(rate: float, way: str) -> None:
    model = pressed_by(kf.Motion.steady(0.0)).freeze()
    load, (wall, tip) = model.loads[0], model.literal.state(0.0, model.initial_state).load_ends(0)
    at, z = tip._replace(p=np.array((0.0, 0.0, -0.015)), v=np.array((0.0, 0.0, -rate))), 0.4
    done = acted(load, (wall, at), np.array((z,)), way)
    elastic = K * 0.015
    assert done.wrenches[1, 2] == pytest.approx(elastic * (1.0 + SHARE * z), rel=1e-12)
    assert done.potential == pytest.approx(0.5 * K * 0.015**2, rel=1e-12)
    assert done.taken == pytest.approx(elastic * SHARE * z * rate, rel=1e-12)
    assert done.rates == pytest.approx([(rate - abs(rate) * z) / TURN], rel=1e-12)
    assert_complex_steps_are_differences(load, (wall, at), np.array((z,)))
    free = acted(load, (wall, at._replace(p=np.array((0.0, 0.0, 0.01)))), np.array((z,)), way)
    assert not np.any(free.wrenches)
    assert free.rates == pytest.approx([0.0])


@pytest.mark.parametrize("method", ["auto", "radau5", "dop853"])
def test_what_bounces_loses_what_the_branches_say(method: str) -> None:
    """``m v^2 / 2`` in is the work of the first branch down to the depth where it stops, and out that of the second."""
    scene = kf.System()
    wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
    tip = scene.add_point("tip", 2.0, joint=kf.Prismatic("z", position=1e-3, speed=-1.0))
    scene.add_contact("stop", tip, wall, normal=STOP)
    result = scene.simulate((0.0, 0.1), rtol=1e-9, method=method)
    deepest = -float(result.position("tip")[:, 2].min())

    def stored(deep: float) -> float:
        return quad(lambda d: K * d * (1.0 + SHARE * going_in(d, 0.0, 0.0)), 0.0, deep)[0] - 1.0

    from scipy.optimize import brentq

    deep = brentq(stored, 1e-3, 0.1)
    assert deepest == pytest.approx(deep, rel=1e-3)  # of the output times
    top = going_in(deep, 0.0, 0.0)
    back = quad(lambda d: K * d * (1.0 + SHARE * going_out(d, top, deep)), 0.0, deep)[0]
    assert float(result.velocity("tip")[-1, 2]) == pytest.approx(math.sqrt(back), rel=1e-6)


def test_in_balance_and_small_motions_it_is_its_middle() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    tip = scene.add_point("tip", 2.0, joint=kf.Prismatic("z"))
    scene.add_contact("stop", tip, floor, normal=STOP)
    rest = kf.equilibrium(scene)
    assert float(rest.position("tip")[2]) == pytest.approx(-2.0 * 9.81 / K, rel=1e-9)
    assert rest.linearise().modes().frequencies[0] == pytest.approx(math.sqrt(K / 2.0) / (2.0 * math.pi), rel=1e-6)


def test_with_friction_its_states_are_its_own() -> None:
    """A point that slides: the branch comes after the anchor's states, and friction follows the force."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", 2.0, 1e-2, joint=kf.Translation(position=(0, 0, 1e-3), velocity=(1.0, 0, 0)))
    friction = kf.Coulomb(0.2, static=0.3, stiffness=1e5)
    scene.add_contact("c", block, floor, normal=STOP, friction=friction)
    result = scene.simulate((0.0, 0.05), rtol=1e-8)
    history = result.contact("c")
    touches = history.normal > 1.0
    assert touches.sum() > 10
    np.testing.assert_allclose(history.tangential[touches], 0.2 * history.normal[touches], rtol=1e-3)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_what_it_needs() -> None:
    with pytest.raises(kf.ModelError, match="hysteresis of BumpStop must be a number of 0 to below 1"):
        kf.BumpStop((1e-3,), (1.0,), 1.0, 1e-3)
    with pytest.raises(kf.ModelError, match="turning of BumpStop must be one number, finite and > 0"):
        kf.BumpStop((1e-3,), (1.0,), 0.1, 0.0)
    with pytest.raises(kf.ModelError, match="depths of BumpStop must rise"):
        kf.BumpStop((2e-3, 1e-3), (1.0, 2.0), 0.1, 1e-3)
    scene = pressed_by(kf.Motion.steady(0.0))
    with pytest.raises(kf.ModelError, match="screened runs are not supported for scenes with"):
        kf.screen(scene, (0.0, 1.0))
