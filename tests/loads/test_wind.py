"""Wind and what it does: gusts, the variance of turbulence, tables over the angle, both routes."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe.loads.wind import REACH

TURN = np.linspace(-np.pi, np.pi, 13)
TABLE = np.column_stack([a * np.cos(TURN + i) + b * np.sin(2 * TURN) for i, (a, b) in enumerate([(-2, 0.3)] * 6)])
SIDES = {"angles": TURN, "areas": TABLE}


def blown(wind, **table):
    scene = kf.System(gravity=(0, 0, -9.81))
    hull = scene.add_rigid_body("hull", 50.0, (4.0, 6.0, 7.0), joint=kf.Free(position=(1, 2, 3)))
    scene.add(kf.Aerodynamics("wind", hull.frame(at=(0.3, -0.1, 0.2)), wind, flat_area=1.5, **table))
    return scene


WINDS = {
    "steady": kf.Wind((-7, 4, 1)),
    "gusts": kf.Wind((-7, 4, 1), gusts=[kf.Gust((2, 5, -1), 0.1, 0.9), kf.Gust((1, 0, 0), 5.0, 1.0)]),
    "turbulent": kf.Wind((0, 12, 0), turbulence=kf.Turbulence((1.5, 1.2, 0.8), (60, 40, 20), seed=3, count=20)),
}


@pytest.mark.parametrize("wind", WINDS.values(), ids=WINDS)
def test_routes_agree_to_round_off(wind):
    model = blown(wind, **SIDES).freeze()
    random = np.random.default_rng(5)
    for t in (0.0, 0.37, 2.1):
        q = np.append(random.normal(size=3), random.normal(size=4))
        q[3:] /= np.linalg.norm(q[3:])
        y = np.concatenate((q, 4.0 * random.normal(size=6), np.zeros(2)))
        np.testing.assert_allclose(
            model.route.evaluate(t, y).rates, model.literal.evaluate(t, y).rates, rtol=1e-11, atol=1e-11
        )


def test_exact_slopes_are_those_of_differences():
    """The kernel for complex numbers, across the angle where atan2 jumps as well."""
    for wind in (kf.Wind((5, 1e-3, 0)), kf.Wind((-3, 6, 2))):
        model = blown(wind, **SIDES).freeze()
        y = np.concatenate((model.initial_coordinates, 0.3 * np.arange(6.0)))
        exact = model.jacobian(0.0, y)
        columns = []
        for i in range(len(y)):
            step = np.zeros(len(y))
            step[i] = 1e-5
            columns.append((model.rhs(0.0, y + step) - model.rhs(0.0, y - step)) / 2e-5)
        wanted = np.column_stack(columns)[: exact.shape[0], : exact.shape[1]]
        # differences of second order with a step of 1e-5, of forces whose third slopes are some hundreds
        np.testing.assert_allclose(exact[7:13], wanted[7:13], rtol=1e-5, atol=1e-6)


def test_forces_at_the_points_of_a_symmetric_table():
    """From port and from starboard, by hand."""
    angles = np.radians((0, 45, 90, 180))
    areas = np.array(((-1.0, 0, 0.2, 0, 3, 0), (-1, -3, 0, 1, 0, 2), (0, -5, 0, 4, 0, 1), (1.5, 0, 0, 0, -2, 0)))
    for side in (1.0, -1.0):
        wind = kf.Wind((0, -10 * side, 0))
        scene = blown(wind, angles=angles, areas=areas, is_symmetric=True)
        told = scene.simulate((0.0, 1e-3)).load("wind")[0]
        assert told[:2] == pytest.approx((10.0, side * math.pi / 2))
        wanted = 0.5 * 1.225 * 100.0 * areas[2] * (1, side, 1, side, 1, side)
        np.testing.assert_allclose(told[2:], wanted, rtol=1e-12, atol=1e-12)


def test_between_its_points_a_table_stays_between_their_values():
    scene_load = kf.Aerodynamics("w", kf.System().ground, kf.Wind((1, 0, 0)), **SIDES)
    fine = np.array([scene_load.coefficients(a) for a in np.linspace(-np.pi, np.pi, 400)])
    assert np.all(fine.max(0) <= TABLE.max(0) + 1e-12)
    assert np.all(fine.min(0) >= TABLE.min(0) - 1e-12)
    np.testing.assert_allclose(scene_load.coefficients(np.pi - 1e-9), TABLE[0], atol=1e-7)


def test_a_flat_plate_falls_as_the_closed_form():
    """``v = V tanh(g t / V)`` with ``V^2 = 2 m g / (rho A)``."""
    scene = kf.System(gravity=(0, 0, -9.81))
    plate = scene.add_point("plate", 50.0, joint=kf.Prismatic("z"))
    scene.add(kf.Aerodynamics("air", plate, kf.Wind((0, 0, 0)), flat_area=1.5, angles=TURN, areas=TABLE))
    result = scene.simulate((0.0, 4.0), rtol=1e-9)
    top = math.sqrt(2 * 50.0 * 9.81 / (1.225 * 1.5))
    np.testing.assert_allclose(
        result.velocity("plate")[:, 2], -top * np.tanh(9.81 * result.times / top), rtol=1e-7, atol=1e-9
    )


def test_what_the_wind_does_is_in_the_balance():
    result = blown(WINDS["turbulent"], **SIDES).simulate((0.0, 5.0), rtol=1e-8)
    assert abs(result.energy.balance_error).max() < 1e-8 * result.energy.kinetic.max()
    assert result.statistics["route"] != "literal"


def test_turbulence_has_the_variance_and_spectrum_that_are_declared():
    sigma, length, mean = np.array((1.5, 1.2, 0.8)), 50.0, 10.0
    turbulence = kf.Turbulence(sigma, length, seed=11, count=200)
    wind = kf.Wind((0, -mean, 0), turbulence=turbulence)
    parts = wind.harmonics
    # along the wind is -y, across it x
    power = 0.5 * (parts[:, 1:4] ** 2 + parts[:, 4:] ** 2)
    kept = 2 / np.pi * np.arctan(REACH)
    across = kept - REACH / (np.pi * (1 + REACH**2))
    np.testing.assert_allclose(power.sum(0), sigma[[1, 0, 2]] ** 2 * (across, kept, across), rtol=1e-12)
    # between two frequencies: the integral of the printed density
    w = np.linspace(0.1, 0.6, 4001)
    x = length * w / mean
    density = sigma[0] ** 2 * 2 * length / (np.pi * mean) / (1 + x**2)
    within = (parts[:, 0] > 0.1) & (parts[:, 0] < 0.6)
    assert power[within, 1].sum() == pytest.approx(density.mean() * 0.5, rel=0.05)
    assert np.all(wind.at(3.0) == kf.Wind((0, -mean, 0), turbulence=turbulence).at(3.0))
    assert not np.allclose(
        wind.at(3.0), kf.Wind((0, -mean, 0), turbulence=kf.Turbulence(sigma, length, seed=12)).at(3.0)
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.Gust((1, 2), 0, 1), "velocity of a gust"),
        (lambda: kf.Gust((1, 2, 3), 0, 0), "duration of a gust"),
        (lambda: kf.Turbulence(-1.0, 50.0), "intensity of turbulence"),
        (lambda: kf.Turbulence(1.0, 0.0), "length of turbulence"),
        (lambda: kf.Turbulence(1.0, 50.0, seed=-1), "seed of turbulence"),
        (lambda: kf.Wind((0, 0, 0), turbulence=kf.Turbulence(1.0, 50.0)), "Remedy: give velocity"),
        (lambda: kf.Wind((1, 0, 0), gusts=[3.0]), "gusts of a wind"),
        (lambda: kf.Wind((1, 0, 0), turbulence=3.0), "turbulence of a wind"),
    ],
)
def test_bad_wind_is_named(make, message):
    with pytest.raises(kf.ModelError, match=message):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wind": (1, 0, 0)}, "kanefe.Wind"),
        ({"density": -1.0}, "density"),
        ({"angles": TURN[::-1]}, "that rise"),
        ({"areas": TABLE[:4]}, "areas of aerodynamics"),
        ({"angles": 10 * TURN}, "more than one turn"),
        ({"is_symmetric": True}, "from 0 to pi"),
        ({"areas": TABLE + np.linspace(0, 1, 13)[:, None]}, "which are one"),
    ],
)
def test_bad_tables_are_named(change, message):
    options = {"wind": kf.Wind((1, 0, 0)), **SIDES, **change}
    with pytest.raises(kf.ModelError, match=message):
        kf.Aerodynamics("w", kf.System().ground, **options)
