"""The helicopter on wheels: rest on its struts, tyres that hold, chocks, a drop test; rotors, wind, a cable."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.sramss import add_haul_down, add_rotors, add_wind, wheeled_scene
from kanefe_fem.sramss import aircraft_loads as loads
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.planar import by_names
from kanefe_fem.sramss.wheeled import EXPONENT, LEGS, PISTON_MASS, PRESSURE, STROKE, WHEEL_MASS

MASS = given.AIRFRAME_MASS + 3 * (PISTON_MASS + WHEEL_MASS)
WEIGHT = MASS * given.GRAVITY


def tilting(angle, axis="y", span=4.0):
    """A deck that tilts by an angle in degrees within the span, and comes back by half."""
    times = np.linspace(0.0, span, 81)
    x = np.clip(times / (0.75 * span), 0.0, 1.0)
    grown = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    return kf.PoseTable(times, None, [kf.rotation_about(axis, math.radians(angle) * g) for g in grown])


@pytest.fixture(scope="module")
def rest():
    return kf.equilibrium(wheeled_scene())


def test_it_rests_on_its_gas(rest):
    """Weight on the tyres, moments about the nose wheel, and each stroke by the law of the gas."""
    normal = {name: float(rest.contact(f"{name} tyre").normal) for name in LEGS}
    assert sum(normal.values()) == pytest.approx(WEIGHT, rel=1e-8)
    back = LEGS["nose"].x - LEGS["port"].x
    mains = given.AIRFRAME_MASS * LEGS["nose"].x / back + 2 * (PISTON_MASS + WHEEL_MASS)
    # it pitches by 8 mrad, as tyres and struts of the nose give way less: the centre of mass goes 10 of 1900 mm aft
    assert normal["port"] + normal["starboard"] == pytest.approx(mains * given.GRAVITY, rel=8e-3)
    for name, leg in LEGS.items():
        stroke, rate, gas, oil = rest.load(f"{name} oleo")
        assert (rate, oil) == (0.0, 0.0)
        assert 0.0 < stroke < STROKE
        wanted = leg.area * (PRESSURE * (1.0 - stroke * leg.area / leg.volume) ** -EXPONENT - 101325.0)
        assert gas == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("mu", [0.6, 0.05], ids=["dry", "ice"])
def test_braked_tyres_hold_at_rest_what_friction_can(mu, rest):
    """On a deck that tilts by 6 degrees: no creep of the braked wheels at all, or a slide."""
    scene = wheeled_scene(tilting(6.0), mu=mu)
    result = scene.simulate((0.0, 4.0), start=by_names(scene, rest), rtol=1e-5)
    slip = result.contact("port tyre").slip[-1]
    assert slip == 0.0 if mu == 0.6 else slip > 0.05
    assert result.statistics["route"].startswith("order n")


def test_chocks_hold_without_brakes(rest):
    moved = {}
    for chocks in (True, False):
        scene = wheeled_scene(tilting(6.0), brakes=False, chocks=chocks)
        result = scene.simulate((0.0, 4.0), start=by_names(scene, rest), rtol=1e-5)
        moved[chocks] = float(np.ptp(result.joint_coordinates("port wheel"))) * 0.22
    assert moved[False] > 1.0
    assert moved[True] < 0.02


def test_drop_with_lift_of_two_thirds_of_the_weight():
    """14 CFR 27.725 on struts: the energy of the drop goes into oil, tyres and seals, and the books close."""
    sink = math.sqrt(2.0 * given.GRAVITY * 0.33)
    scene = wheeled_scene(sink=sink, lift=2.0 / 3.0 * WEIGHT)
    result = scene.simulate((0.0, 0.6), rtol=1e-7, output_step=2e-3)
    ground = sum(result.contact(f"{name} tyre").force[:, 2] for name in LEGS)
    factor = ground.max() / WEIGHT
    assert 1.0 < factor < 4.0
    fallen = result.position("airframe")[0, 2] - result.position("airframe")[:, 2].min()
    # what came down has been stopped: force times way is at least the energy
    assert ground.max() * fallen > 0.5 * MASS * sink**2
    assert abs(result.energy.balance_error).max() < 1e-6 * 0.5 * MASS * sink**2
    assert max(result.load(f"{name} oleo")[:, 0].max() for name in LEGS) < STROKE


def test_rotors_hold_against_each_other_and_the_haul_down_presses():
    scene = wheeled_scene()
    add_rotors(scene, 5000.0)
    add_haul_down(scene, 3000.0)
    add_wind(scene, kf.Wind((0.0, -12.0, 0.0)))
    rest = kf.equilibrium(scene, steady=False)
    held = sum(float(rest.contact(f"{name} tyre").normal) for name in LEGS)
    shakes = 5000.0 * (1.0 + loads.BLADE_SHARE)  # at t = 0 both harmonics are at their peak
    lift = 0.5 * 1.225 * 12.0**2 * loads.LIFT
    assert held == pytest.approx(WEIGHT - shakes - lift + 3000.0, rel=1e-3)
    told = rest.load("fuselage")
    assert told[:2] == pytest.approx((12.0, math.pi / 2.0), abs=0.01)
    assert told[3] == pytest.approx(-0.5 * 1.225 * 12.0**2 * loads.SIDE, rel=1e-3)
    main, tail = rest.load("main rotor"), rest.load("tail rotor")
    assert main[5] + loads.TAIL_HUB[0] * tail[1] / (1.0 + loads.BLADE_SHARE) == pytest.approx(0.0, abs=1e-9)
    result = scene.simulate((0.0, 0.2), start=rest.state, rtol=1e-4)
    assert result.statistics["route"].startswith("order n")
