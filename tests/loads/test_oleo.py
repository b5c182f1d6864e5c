"""Oleo struts: gas and oil against an independent integration, books of energy, rest on the gas."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kanefe as kf

AREA, PRESSURE, VOLUME, EXPONENT, AMBIENT = 3e-3, 8e5, 8e-4, 1.3, 101325.0
COMPRESSION, REBOUND = 6000.0, 15000.0
GAS = {"area": AREA, "pressure": PRESSURE, "volume": VOLUME, "exponent": EXPONENT}
UPPER, LOWER, GRAVITY = 600.0, 30.0, 9.81
TYRE, STOP = 4e5, 1e7


def landing(speed, lift=0.0, **options):
    """A mass on a strut on a wheel without rotation, whose tyre is a spring that does not pull."""
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    body = scene.add_point("body", UPPER, joint=kf.Prismatic("z", position=1.0, speed=-speed))
    stop = kf.CoordinateForce(limits=(0.0, None), limit_stiffness=STOP)
    wheel = scene.add_point("wheel", LOWER, parent=body, at=(0, 0, -1), joint=kf.Prismatic("z", forces=stop))
    scene.add(kf.Oleo("oleo", (body, wheel), **{**GAS, "orifice": COMPRESSION, "rebound": REBOUND, **options}))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    scene.add_contact("tyre", wheel, floor, normal=kf.KelvinVoigt(TYRE))
    if lift:
        scene.add_force(body, (0, 0, lift))
    return scene


def independent(t, y, lift):
    """Heights of body and wheel and their rates; the strut as it is printed."""
    z, x, dz, dx = y
    stroke, rate = 1.0 - (z - x), dx - dz
    gas = AREA * (PRESSURE * (1.0 - stroke * AREA / VOLUME) ** -EXPONENT - AMBIENT)
    strut = gas + (COMPRESSION if rate > 0 else REBOUND) * rate * abs(rate) - STOP * max(0.0, -stroke)
    return dz, dx, (lift + strut) / UPPER - GRAVITY, (max(0.0, -TYRE * x) - strut) / LOWER - GRAVITY


def test_a_drop_test_is_that_of_an_independent_integration():
    """Sink speed of a drop of 0.508 m, lift of two thirds of the weight: peak, whole histories, energy."""
    speed, lift = math.sqrt(2 * GRAVITY * 0.508), 2 / 3 * (UPPER + LOWER) * GRAVITY
    scene = landing(speed, lift)
    result = scene.simulate((0.0, 1.0), rtol=1e-9, output_step=1e-3)
    # the strut begins at its full extension, pressed against the stop by the gas
    wanted = solve_ivp(
        independent,
        (0.0, 1.0),
        (1.0, 0.0, -speed, -speed),
        args=(lift,),
        rtol=1e-10,
        atol=1e-12,
        max_step=1e-3,
        t_eval=result.times,
        method="DOP853",
    )
    np.testing.assert_allclose(result.position("body")[:, 2], wanted.y[0], atol=2e-7)
    told = result.load("oleo")
    np.testing.assert_allclose(told[:, 0], 1.0 - wanted.y[0] + wanted.y[1], atol=2e-7)
    peak = (told[:, 2] + told[:, 3]).max()
    assert peak > 2.0 * UPPER * GRAVITY
    energy = result.energy
    lost = energy.dissipated[-1]
    assert lost > 0.5 * 0.5 * (UPPER + LOWER) * speed**2
    assert abs(energy.balance_error).max() < 1e-6 * 0.5 * (UPPER + LOWER) * speed**2
    assert result.statistics["route"] != "literal"


def test_it_rests_on_its_gas():
    rest = kf.equilibrium(landing(0.0))
    stroke, rate, gas, oil = rest.load("oleo")
    assert (rate, oil) == (0.0, 0.0)
    assert gas == pytest.approx(UPPER * GRAVITY, rel=1e-9)
    left = (PRESSURE * AREA / (UPPER * GRAVITY + AMBIENT * AREA)) ** (1 / EXPONENT)
    assert stroke == pytest.approx(VOLUME / AREA * (1 - left), rel=1e-9)


def test_small_motions_have_the_stiffness_of_the_gas():
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    mass = scene.add_point("mass", UPPER, at=(0, 0, 1), joint=kf.Prismatic("z"))
    scene.add(kf.Oleo("oleo", (scene.ground, mass), **GAS, orifice=COMPRESSION))
    rest = kf.equilibrium(scene)
    room = 1 - rest.load("oleo")[0] * AREA / VOLUME
    stiffness = EXPONENT * PRESSURE * AREA**2 / VOLUME * room ** (-EXPONENT - 1)
    (frequency,) = rest.linearise().modes().frequencies
    assert frequency == pytest.approx(math.sqrt(stiffness / UPPER) / (2 * math.pi), rel=1e-8)


@pytest.mark.parametrize("exponent", [1.0, 1.3])
@pytest.mark.parametrize("rate", [-0.8, 0.6])
def test_routes_agree_to_round_off(exponent, rate):
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    arm = scene.add_rigid_body("arm", 20.0, 1.0, joint=kf.Revolute("y"), com=(0.5, 0, 0))
    leg = scene.add_rigid_body("leg", 5.0, 0.2, joint=kf.Free(), at=(0.3, 0.1, -1))
    options = {**GAS, "exponent": exponent, "extended": 1.3, "orifice": COMPRESSION, "rebound": REBOUND}
    scene.add(kf.Oleo("oleo", (arm.frame(at=(0.3, 0, 0.1)), leg.frame(at=(0, 0, 0.02))), **options))
    model = scene.freeze()
    y = np.concatenate((model.initial_coordinates, rate * np.arange(1.0, 8.0), np.zeros(2)))
    np.testing.assert_allclose(
        model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-11, atol=1e-11
    )
    assert model.route.energy(0.0, y).total == pytest.approx(model.literal.energy(0.0, y).total, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"area": 0.0}, "area of oleo 'o' must be > 0"),
        ({"orifice": -1.0}, "orifice of oleo 'o' must be >= 0"),
        ({"exponent": 0.9}, "exponent of oleo 'o'"),
        ({"pressure": "high"}, "pressure of oleo 'o'"),
    ],
)
def test_bad_input_is_named(change, message):
    ground = kf.System().ground
    with pytest.raises(kf.ModelError, match=message):
        kf.Oleo("o", (ground, ground), **{**GAS, **change})


def test_ends_without_a_way_or_gas_without_room_are_refused():
    scene = kf.System()
    with pytest.raises(kf.ModelError, match="needs two ends"):
        kf.Oleo("o", (scene.ground,), **GAS)
    ball = scene.add_point("ball", 1.0)
    scene.add(kf.Oleo("o", (scene.ground, ball), **GAS))
    with pytest.raises(kf.ModelError, match="coincide"):
        scene.freeze()
    scene = kf.System()
    far = scene.add_point("far", 1.0, at=(0, 0, 1))
    scene.add(kf.Oleo("o", (scene.ground, far), **GAS, extended=1.3))
    with pytest.raises(kf.ModelError, match="its gas has room for 0"):
        scene.freeze()
    with pytest.raises(kf.ModelError, match="orifice of an orifice"):
        kf.Oleo.orifice_coefficient(density=860.0, area=1e-3, orifice=0.0)
