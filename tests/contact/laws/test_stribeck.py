"""Stribeck's friction with breakaway: its curve on a belt, its breakaway under a growing pull, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import kanefe as kf
from acting_loads import WAYS, acted
from kanefe.kernels.contact.falling import slip_speed

MASS, G = 2.0, 9.81
CURVE = {"mu": 0.2, "breakaway": 0.4, "stribeck_speed": 0.05, "viscous": 0.3}


def block_on_belt(friction: object, belt: float, spring: float) -> kf.System:
    """Return a block on a belt, held by a spring and a damper that is more than critical."""
    scene = kf.System(gravity=(0, 0, -G))
    top = scene.add_surface("belt", scene.ground, kf.shapes.Plane("z"))
    forces = kf.CoordinateForce(stiffness=spring, damping=3.0 * math.sqrt(spring * MASS))
    slide = scene.add_rigid_body("slide", 1e-3, 1e-6, joint=kf.Prismatic("x", forces=forces))
    block = scene.add_point("block", MASS, parent=slide, joint=kf.Prismatic("z", position=-MASS * G / 1e6))
    law = kf.HuntCrossley(1e6, damping=1.0)
    scene.add_contact("c", block, top, normal=law, friction=friction, surface_velocity=(belt, 0.0, 0.0))
    return scene


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("belt", [0.02, 0.3])
def test_a_belt_is_rubbed_by_the_curve(exponent: float, belt: float) -> None:
    """A damped block comes to rest on it, where the spring pulls by ``N mu(belt)``."""
    friction = kf.Stribeck(**CURVE, exponent=exponent)
    result = block_on_belt(friction, belt, 500.0).simulate((0.0, 4.0), rtol=1e-8)
    wanted = 0.2 + 0.2 * math.exp(-((belt / 0.05) ** exponent)) + 0.3 * belt
    history = result.contact("c")
    assert friction.coefficient(belt) == pytest.approx(wanted, rel=1e-12)
    assert history.tangential[-1] / history.normal[-1] == pytest.approx(wanted, rel=1e-5)  # what still swings
    assert 500.0 * result.joint_coordinates("slide")[-1, 0] == pytest.approx(wanted * MASS * G, rel=1e-4)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_it_breaks_away_at_its_coefficient_and_not_before() -> None:
    """A pull that grows by 1 N/s."""
    friction = kf.Stribeck(**CURVE)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", MASS, 1e-2, joint=kf.Translation(position=(0, 0, -MASS * G / 1e6)))
    scene.add_contact("c", block, floor, normal=kf.HuntCrossley(1e6, damping=1.0), friction=friction)
    scene.add_force(block, lambda t: (t, 0.0, 0.0))
    result = scene.simulate((0.0, 9.0), rtol=1e-8)
    assert result.events["c slip"][0] == pytest.approx(0.4 * MASS * G, rel=1e-5)
    assert len(result.events["c slip"]) == 1
    # it moves on with what is left of the pull: of its curve, N mu(v)
    t, v = result.times[-1], float(result.velocity("block")[-1, 0])
    change = (v - float(result.velocity("block")[-2, 0])) / (t - result.times[-2])
    assert change == pytest.approx((t - friction.coefficient(v) * MASS * G) / MASS, rel=0.02)  # the mean of a step


@pytest.mark.parametrize("way", WAYS)
def test_coulomb_is_one_of_it(way: str) -> None:
    """With an exponent of 2 and without a viscous part."""
    laws = kf.Stribeck(0.2, 0.4, 0.05), kf.Coulomb(0.2, static=0.4, stribeck_speed=0.05)
    for seed in range(6):
        rng = np.random.default_rng(seed)
        found = []
        for law in laws:
            model = block_on_belt(law, 0.1, 500.0).freeze()
            q, u, z = model.parts(model.initial_state.copy())
            z[2:5], z[5] = 1e-5 * rng.standard_normal(3), seed % 2
            u[:] = 0.1 * np.random.default_rng(seed).standard_normal(len(u))
            state = model.literal.state(0.0, np.concatenate((q, u, z, (0.0, 0.0))))
            rng = np.random.default_rng(seed)
            found.append(acted(model.loads[0], state.load_ends(0), state.load_states(0), way))
        np.testing.assert_allclose(found[0].wrenches, found[1].wrenches, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(found[0].rates, found[1].rates, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 4.0])
def test_the_speed_of_the_slip_is_the_largest_root(exponent: float) -> None:
    """Of ``c s + F(s) = pull``; below the pull that fast sliding takes there is none."""
    c, least, fall, speed = 30.0, 2.0, 3.0, 0.1

    def left(s: float, pull: float) -> float:
        return c * s + least + fall * math.exp(-((s / speed) ** exponent)) - pull

    for pull in (6.0, 9.0, 40.0):
        grid = np.linspace(0.0, pull / c, 20001)[::-1]
        at = next(i for i, s in enumerate(grid) if left(s, pull) < 0.0)
        wanted = brentq(left, grid[at], grid[at - 1], args=(pull,), xtol=1e-15)
        assert slip_speed(pull, least, fall, c, speed, exponent) == pytest.approx(wanted, rel=1e-10)
    assert slip_speed(1.0, least, fall, c, speed, exponent) == 0.0


def test_rigid_contacts_take_it() -> None:
    """A block thrown along a floor stops when ``m dv/dt = -N mu(v)`` says."""
    friction = kf.Stribeck(**CURVE)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", MASS, 1e-2, joint=kf.Translation(velocity=(0.5, 0, 0)))
    scene.add_contact("c", block, floor, normal=kf.Rigid(), friction=friction)
    result = scene.simulate((0.0, 0.5), rtol=1e-9)
    from scipy.integrate import quad

    wanted = quad(lambda v: 1.0 / (G * friction.coefficient(v)), 0.0, 0.5)[0]
    assert result.events["c stick"][0] == pytest.approx(wanted, rel=1e-7)


def test_what_it_needs() -> None:
    with pytest.raises(kf.ModelError, match=r"breakaway of Stribeck, 0\.2, must be above mu, 0\.3"):
        kf.Stribeck(0.3, 0.2, 0.1)
    with pytest.raises(kf.ModelError, match="stribeck_speed of Stribeck must be one number, finite and > 0"):
        kf.Stribeck(0.3, 0.4, 0.0)
    with pytest.raises(kf.ModelError, match="viscous of Stribeck must be one number"):
        kf.Stribeck(0.3, 0.4, 0.1, viscous=-1.0)
    with pytest.raises(kf.ModelError, match="two coefficients of Coulomb must both be above zero"):
        kf.Coulomb((0.0, 0.4))
