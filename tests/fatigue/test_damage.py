"""Cycles and damage of histories: the example of ASTM E1049, closed forms, and the kernel against the library."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fatigue.miner import law_of
from kanefe.kernels.fatigue.cycle_damage import damage_of_stresses

STEEL = kf.fatigue.SNCurve(amplitude=160e6, cycles=1e6, slope=5, slope_below=9)
CORRECTIONS = [None, kf.fatigue.Goodman(900e6), kf.fatigue.Gerber(900e6), kf.fatigue.Walker(), kf.fatigue.Walker(0.8)]


def test_the_worked_example_of_the_standard():
    """ASTM E1049-85, Fig. 6: counts of the history A to I, as the standard prints them."""
    cycles = kf.fatigue.count_cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert cycles.table() == [(3.0, 0.5), (4.0, 1.5), (6.0, 0.5), (8.0, 1.0), (9.0, 0.5)]
    counts, edges = cycles.histogram(9)
    assert counts.sum() == cycles.counts.sum() == 4.0
    assert edges[-1] == 9.0


@pytest.mark.parametrize("amplitude", [100e6, 160e6, 400e6])
def test_a_sine_uses_up_its_cycles_over_its_life(amplitude):
    t = np.arange(0.0, 50.0 + 1e-9, 0.25)  # peaks and valleys are samples
    found = kf.fatigue.damage(amplitude * np.sin(2 * np.pi * t), STEEL)
    slope = 5 if amplitude >= 160e6 else 9
    # 49.5 cycles between the first peak and the last valley, and a quarter at each end with half of the range
    ends = 2 * 0.5 / (1e6 * (0.5 * amplitude / 160e6) ** -(5 if amplitude >= 320e6 else 9))
    assert found.total == pytest.approx(49.5 / (1e6 * (amplitude / 160e6) ** -slope) + ends, rel=1e-12)
    assert found.repeats == pytest.approx(1 / found.total)
    assert STEEL.life(amplitude) == pytest.approx(1e6 * (amplitude / 160e6) ** -slope)


def test_below_the_endurance_limit_nothing_is_damaged():
    curve = kf.fatigue.SNCurve(160e6, 1e6, 5)
    found = kf.fatigue.damage(159e6 * np.cos(np.arange(20) * np.pi), curve)
    assert found.total == 0.0
    assert found.repeats == math.inf
    assert "below the endurance limit" in str(found)
    assert curve.life(159e6) == math.inf


@pytest.mark.parametrize(
    ("correction", "equivalent"),
    [
        (None, 200e6),
        (kf.fatigue.Goodman(800e6), 200e6 / (1 - 100 / 800)),
        (kf.fatigue.Gerber(800e6), 200e6 / (1 - (100 / 800) ** 2)),
        (kf.fatigue.Walker(), math.sqrt(300e6 * 200e6)),
        (kf.fatigue.Walker(0.7), 300e6**0.3 * 200e6**0.7),
        (kf.fatigue.Walker(0.0), 300e6),
    ],
)
def test_mean_stress_by_the_formulas(correction, equivalent):
    pulses = 100e6 + 200e6 * np.cos(np.arange(21) * np.pi)  # ten cycles from -100 to 300 MPa
    found = kf.fatigue.damage(pulses, STEEL, mean_stress=correction)
    assert found.total == pytest.approx(10 / STEEL.life(equivalent), rel=1e-12)
    under = kf.fatigue.damage(-100e6 + 200e6 * np.cos(np.arange(21) * np.pi), STEEL, mean_stress=correction)
    assert under.total <= found.total


@pytest.mark.parametrize("correction", CORRECTIONS)
def test_the_kernel_counts_as_the_library(correction):
    rng = np.random.default_rng(3)
    histories = [rng.normal(size=n).cumsum() * 2e7 for n in (2, 3, 10, 400)]
    histories.append(np.repeat(rng.normal(size=60), rng.integers(1, 4, 60)) * 1e8)  # plateaus
    histories.append(np.round(rng.normal(size=300)) * 1e8)  # equal ranges
    histories.append(np.full(5, 2e8))
    for history in histories:
        stresses = np.zeros((2, 6, len(history)))
        stresses[:, 1] = history
        found = np.empty(2)
        memory = np.empty(2 * len(history) + 1)
        damage_of_stresses(stresses, 1, law_of(STEEL, correction), memory, found)
        wanted = kf.fatigue.damage(history, STEEL, mean_stress=correction).total
        assert found == pytest.approx([wanted, wanted], rel=1e-12, abs=0.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kf.fatigue.SNCurve(160.0, 1e6, 5), "cannot be 160 Pa. Remedy: give it in Pa"),
        (lambda: kf.fatigue.SNCurve(160e6, 0.5, 5), "at least 1"),
        (lambda: kf.fatigue.SNCurve(160e6, 1e6, -5), "positive exponents"),
        (lambda: kf.fatigue.SNCurve(160e6, 1e6, 5, 3), "below the knee at least as above"),
        (lambda: kf.fatigue.Goodman(500.0), "500e6 for 500 MPa"),
        (lambda: kf.fatigue.Walker(1.05), "between 0 and 1"),
        (lambda: kf.fatigue.Walker(-0.05), "between 0 and 1"),
        (lambda: kf.fatigue.damage([0.0, 1e-3, -1e-3], STEEL), "a strain rather than a stress"),
        (lambda: kf.fatigue.damage(np.ones((3, 2)), STEEL), "one column"),
        (lambda: kf.fatigue.damage([0.0, np.nan], STEEL), "finite"),
        (lambda: kf.fatigue.damage([0.0, 1e8], None), "curve"),
        (lambda: kf.fatigue.damage([0, 9e8, 8e8], STEEL, mean_stress=kf.fatigue.Goodman(4e8)), "breaks the material"),
    ],
)
def test_what_cannot_be_is_named(call, message):
    with pytest.raises(ModelError, match=message):
        call()


def test_a_curve_by_ranges():
    assert kf.fatigue.SNCurve.from_range(71e6, 2e6, 3) == kf.fatigue.SNCurve(35.5e6, 2e6, 3)


def test_a_range_is_a_number():
    with pytest.raises(kf.ModelError, match="stress_range= of from_range must be a finite number"):
        kf.fatigue.SNCurve.from_range({}, 2e6, 3)
