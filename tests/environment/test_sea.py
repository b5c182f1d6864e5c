"""Seas: spectra against closed forms, directions, dispersion, and realisations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import kanefe as kf
from kanefe.environment.dispersion import encounter_frequency, wave_number
from kanefe.environment.spectra import Bretschneider, Jonswap, Tabulated
from kanefe.environment.spreading import Spreading
from kanefe.errors import MissingDependency, ModelError


@pytest.mark.parametrize("spectrum", [Bretschneider(4.0, 10.0), Jonswap(4.0, 10.0), Jonswap(4.0, 10.0, 7.0)])
@pytest.mark.parametrize("order", [-1, 0, 1, 2, 3])
def test_moments_are_integrals_of_the_density(spectrum: Any, order: int) -> None:
    low, high = 0.5, 1.4
    parts = [(0.5, spectrum.peak), (spectrum.peak, 1.4)]
    wanted = sum(quad(lambda w: w**order * spectrum.density(w), *part, epsrel=1e-12)[0] for part in parts)
    # both to 1e-12
    assert spectrum.moment(order, low, high) == pytest.approx(wanted, rel=1e-10)
    assert spectrum.moment(order) > wanted


def test_the_height_is_what_was_asked_for() -> None:
    for spectrum in (Bretschneider(3.0, 8.0), Jonswap(3.0, 8.0, 5.0)):
        assert spectrum.significant_height == pytest.approx(3.0, rel=1e-10)
        assert spectrum.density(np.array((0.0, -1.0))).tolist() == [0.0, 0.0]
    flat = Tabulated((0.5, 1.0, 2.0), (1.0, 1.0, 1.0))
    assert flat.moment(0) == pytest.approx(1.5, rel=1e-14)
    assert flat.moment(2, 0.75, 1.5) == pytest.approx((1.5**3 - 0.75**3) / 3.0, rel=1e-13)


def test_the_sea_of_a_wind_is_pierson_and_moskowitz_formula() -> None:
    """``alpha g^2 w^-5 exp(-beta (g / (U w))^4)`` with the constants of their paper."""
    w, U, g = np.array((0.4, 0.7, 1.5)), 15.0, 9.7
    wanted = 8.1e-3 * g**2 * w**-5 * np.exp(-0.74 * (g / (U * w)) ** 4)
    np.testing.assert_allclose(Bretschneider.of_wind(U, g).density(w), wanted, rtol=1e-13)


def test_the_fourth_moment_is_infinite_until_it_is_cut() -> None:
    with pytest.raises(ModelError, match="order 4 of a wave spectrum is infinite"):
        Bretschneider(4.0, 10.0).moment(4)
    assert Bretschneider(4.0, 10.0).moment(4, 0.0, 3.0) > 0.0


def test_waves_of_finite_depth() -> None:
    omega = np.array((0.01, 0.3, 0.6, 1.2, 3.0))
    k = wave_number(omega, 20.0)
    np.testing.assert_allclose(9.81 * k * np.tanh(20.0 * k), omega**2, rtol=1e-13)
    assert k[0] == pytest.approx(0.01 / math.sqrt(9.81 * 20.0), rel=1e-4)  # shallow
    np.testing.assert_allclose(wave_number(omega), omega**2 / 9.81, rtol=1e-15)
    np.testing.assert_allclose(wave_number(omega, 1e6)[1:], omega[1:] ** 2 / 9.81, rtol=1e-12)
    with pytest.raises(ModelError, match="depth of the water must be a finite number above 0"):
        wave_number(omega, 0.0)


def test_encounter_folds_in_following_seas() -> None:
    omega = np.linspace(0.1, 2.0, 400)
    met = encounter_frequency(omega, wave_number(omega), 180.0, 10.0)
    assert met.max() == pytest.approx(9.81 / 40.0, rel=1e-4)
    assert omega[np.argmax(met)] == pytest.approx(9.81 / 20.0, abs=0.005)
    assert met[-1] < 0.0  # the ship overtakes short waves
    np.testing.assert_allclose(encounter_frequency(omega, wave_number(omega), 90.0, 10.0), omega, rtol=1e-14)


def test_quantiles_of_directions_are_those_of_the_distributions() -> None:
    shares = np.array((0.0, 0.1, 0.5, 0.8, 1.0))
    angles = Spreading(2.0).quantile_at(shares, shares)
    r = np.radians(angles)
    np.testing.assert_allclose(0.5 + (r + np.sin(r) * np.cos(r)) / np.pi, shares, atol=1e-6)  # a twentieth of a degree
    assert Spreading(deviation_deg=20.0).quantile_at(1, 0.841344746) == pytest.approx(20.0, abs=1e-2)
    assert Spreading().quantile_at(shares, shares).tolist() == [0.0] * 5
    for wrong in ({"power": 2.0, "deviation_deg": 20.0}, {"power": 0.0}, {"deviation_deg": math.inf}):
        with pytest.raises(ModelError, match="spread"):
            Spreading(**wrong)


def test_a_realisation_has_the_variance_of_its_spectrum() -> None:
    sea = kf.Sea.bretschneider(3.25, 9.7, spreading=2, seed=3)
    times = np.arange(0.0, 1200.0, 0.5)
    low, high = sea.range
    for place in ((0.0, 0.0), (300.0, -200.0)):
        # equal steps of frequency: over one whole period the variance is the sum, whatever the phases
        found = sea.elevation(times, *place).var()
        assert found == pytest.approx(sea.spectrum.moment(0, low, high), rel=2e-3)
    assert len(sea.waves.frequency) == math.ceil((high - low) * 1200.0 / (2.0 * math.pi))
    # by strata: the mean direction is that of the spectrum, its spread too; four standard deviations among seeds
    assert abs(np.mean(sea.waves.direction_deg)) < 1.0
    assert np.std(sea.waves.direction_deg) == pytest.approx(np.degrees(math.sqrt(np.pi**2 / 12.0 - 0.5)), abs=1.4)


def test_waves_repeat_after_the_duration_and_not_before() -> None:
    sea = kf.Sea.bretschneider(3.25, 9.7, duration=200.0, frequency_range=(0.2, 2.0))
    step = np.diff(sea.waves.frequency)[0]
    assert 2.0 * math.pi / step >= 200.0
    with pytest.raises(ModelError, match=r"50 waves .* repeat after 174.5 s.*Remedy: 58 waves"):
        kf.Sea.bretschneider(3.25, 9.7, duration=200.0, frequency_range=(0.2, 2.0), count=50)
    random = kf.Sea.bretschneider(3.25, 9.7, duration=1e6, frequencies="random", count=50)
    assert np.std(np.diff(random.waves.frequency)) > 0.1 * np.mean(np.diff(random.waves.frequency))
    assert random.waves.frequency[0] > random.range[0]


def test_a_seed_is_a_sea() -> None:
    one, same = (kf.Sea.state(5, seed=4, study=2).waves for _ in range(2))
    for a, b in zip(one, same, strict=True):
        np.testing.assert_array_equal(a, b)
    others = [kf.Sea.state(5, seed=4, study=1), kf.Sea.state(5, seed=5, study=2), kf.Sea.state(4, seed=4, study=2)]
    assert all(abs(other.waves.phase[:9] - one.phase[:9]).max() > 0.1 for other in others)
    rayleigh = kf.Sea.state(5, seed=4, study=2, amplitudes="rayleigh").waves
    np.testing.assert_array_equal(rayleigh.phase, one.phase)
    # the mean square of some hundred exponential numbers
    assert np.mean(rayleigh.amplitude**2) == pytest.approx(np.mean(one.amplitude**2), rel=0.3)
    # numpy promises these for all versions: the sea is the same everywhere
    words = np.random.SeedSequence((2, 5, 4)).spawn(5)[0]
    assert one.phase[0] == 2.0 * math.pi * np.random.Generator(np.random.PCG64(words)).random()


def test_what_the_cut_keeps_is_told() -> None:
    sea = kf.Sea.bretschneider(3.25, 9.7, frequency_range=(0.2, 2.0))
    assert (sea.kept(0), sea.kept(2)) == pytest.approx((0.986, 0.868), abs=5e-4)
    assert "344 waves of 0.2 to 2 rad/s keep 98.6 % of m0 and 86.8 % of m2" in str(sea)


def test_a_measured_spectrum_over_directions() -> None:
    omega, directions = np.linspace(0.3, 2.0, 60), np.arange(0.0, 360.0, 5.0)
    shape = np.maximum(0.0, np.cos(np.radians(directions - 350.0))) ** 2 / 90.0  # m2/degree of 1
    table = np.outer(Bretschneider(3.0, 9.0).density(omega), shape)
    sea = kf.Sea.measured(omega, table, directions)
    assert sea.spreading.main_deg == pytest.approx(350.0, abs=1e-9)
    assert sea.spectrum.moment(0) == pytest.approx(Bretschneider(3.0, 9.0).moment(0, 0.3, 2.0), rel=5e-3)
    # more energy from the right of the main direction by the compass is on its negative side, against the clock
    two = (2.0 * (directions == 20.0) + (directions == 50.0)) / 15.0
    wave = np.outer(Bretschneider(3.0, 9.0).density(omega), two)
    found = kf.Sea.measured(omega, wave, directions)
    main = found.spreading.main_deg
    sides = found.waves.direction_deg
    assert np.mean(abs(sides - (main - 20.0)) <= 2.5) == pytest.approx(2.0 / 3.0, abs=0.02)
    assert np.mean(abs(sides - (main - 50.0)) <= 2.5) == pytest.approx(1.0 / 3.0, abs=0.02)
    line = kf.Sea.measured(omega, table.sum(axis=1) * 5.0, spreading=2)
    assert line.spectrum.moment(0) == pytest.approx(sea.spectrum.moment(0), rel=1e-12)


class Labelled:
    """An array with names, as far as a spectrum needs them."""

    def __init__(self, values: Any, **axes: Any) -> None:
        self.values, self.axes = np.asarray(values), axes
        self.dims, self.sizes = tuple(axes), {name: len(axis) for name, axis in axes.items()}

    def __getitem__(self, name: str) -> Any:
        return self.axes[name]

    def __array__(self, dtype: Any = None) -> np.ndarray:
        return self.values.astype(dtype)

    def squeeze(self) -> Labelled:
        return self

    def transpose(self, *names: str) -> Labelled:
        return Labelled(self.values.transpose([self.dims.index(n) for n in names]), **{n: self.axes[n] for n in names})


def test_spectra_of_wavespectra_are_in_hertz_and_per_degree(tmp_path: Any) -> None:
    omega, directions = np.linspace(0.3, 2.0, 40), np.arange(0.0, 360.0, 10.0)
    shape = np.maximum(0.0, np.cos(np.radians(directions - 100.0))) ** 2
    table = np.outer(Bretschneider(3.0, 9.0).density(omega), shape / (10.0 * shape.sum()))
    given = Labelled(2.0 * np.pi * table.T, dir=directions, freq=omega / (2.0 * np.pi))
    found, wanted = kf.Sea.from_wavespectra(given), kf.Sea.measured(omega, table, directions)
    assert found.spectrum.moment(0) == pytest.approx(wanted.spectrum.moment(0), rel=1e-12)
    np.testing.assert_allclose(found.waves.direction_deg, wanted.waves.direction_deg, atol=1e-9)
    with pytest.raises(ModelError, match=r"for one place and time.*isel\(time=0\)"):
        kf.Sea.from_wavespectra(Labelled(np.ones((2, 3, 4)), time=[0, 1], freq=[1, 2, 3], dir=[0, 1, 2, 3]))
    with pytest.raises(kf.FileError, match="there is no file"):
        kf.Sea.from_wavespectra(tmp_path / "none.spc")
    (tmp_path / "a.odd").write_text("1")
    with pytest.raises(kf.FileError, match="end in"):
        kf.Sea.from_wavespectra(tmp_path / "a.odd")


def test_files_of_spectra_need_wavespectra(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "wavespectra", None)
    (tmp_path / "a.spc").write_text("SWAN")
    with pytest.raises(MissingDependency, match="wavespectra, which is not installed"):
        kf.Sea.from_wavespectra(tmp_path / "a.spc")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: kf.Sea.bretschneider(0.0, 9.0), "Hs of a wave spectrum"),
        (lambda: kf.Sea.bretschneider(3.0, math.nan), "Tp of a wave spectrum"),
        (lambda: kf.Sea.bretschneider("3", 9.0), "Hs of a wave spectrum must be a finite number above 0, not '3'"),
        (lambda: kf.Sea.bretschneider(3.0, 9.0, spreading="wide"), "the spreading of waves must be a finite number"),
        (lambda: kf.Sea.state(5, duration="long"), "duration of a sea must be a finite number"),
        (lambda: kf.Sea.state(5, frequency_range=3.0), "frequency_range of a sea must be two frequencies"),
        (lambda: kf.Sea.state(5, count=2.5, frequencies="random"), "count of a sea must be an integer"),
        (lambda: kf.Sea.jonswap(3.0, 9.0, 0.5), "gamma of a JONSWAP spectrum must be 1 or more"),
        (lambda: kf.Sea.pierson_moskowitz(-1.0), "wind of a Pierson-Moskowitz"),
        (lambda: kf.Sea.state(9), "sea states are 3, 4, 5, 6, 7"),
        (lambda: kf.Sea.state(5, seed=-1), "seed of a sea must be an integer"),
        (lambda: kf.Sea.state(5, seed=1.5), "seed of a sea must be an integer"),
        (lambda: kf.Sea.state(5, duration=0.0), "duration of a sea"),
        (lambda: kf.Sea.state(5, depth=-3.0), "depth of the water"),
        (lambda: kf.Sea.state(5, frequencies="some"), "frequencies of a sea are one of equal, random"),
        (lambda: kf.Sea.state(5, amplitudes="all"), "amplitudes of a sea"),
        (lambda: kf.Sea.state(5, frequency_range=(2.0, 1.0)), "frequency_range of a sea"),
        (lambda: kf.Sea.state(5, frequency_range=(0.01, 0.02)), "there are no waves between"),
        (lambda: kf.Sea.state(5, duration=1e9), "needs .* waves in equal steps"),
        (lambda: kf.Sea.state(5, count=0), "count of a sea must be 1 to"),
        (lambda: kf.Sea.measured((1.0, 2.0), (1.0, -0.1)), "cannot be negative, but it is -0.1"),
        (lambda: kf.Sea.measured((1.0, 2.0), (0.0, 0.0)), "zero everywhere"),
        (lambda: kf.Sea.measured((2.0, 1.0), (1.0, 1.0)), "must increase"),
        (lambda: kf.Sea.measured((1.0, 2.0), (1.0,)), "as many finite densities"),
        (lambda: kf.Sea.measured((1.0, 2.0), np.ones((2, 4)), (0, 90, 180, 270)), "no main direction"),
        (lambda: kf.Sea.measured((1.0, 2.0), np.ones((2, 3)), (0, 90, 180)), "even over the whole circle"),
        (lambda: kf.Sea.measured((1.0, 2.0), -np.ones((2, 4)), (0, 90, 180, 270)), "cannot be negative"),
        (lambda: kf.Sea.measured((1.0, 2.0), np.ones((2, 2)), (0, 90, 180)), "densities of shape"),
        (lambda: kf.Sea.measured((1.0, 2.0), np.full((2, 4), np.nan), (0, 90, 180, 270)), "not a finite number"),
        (lambda: kf.Sea.measured((1.0, 2.0), np.ones((2, 4)), (0, 90, 180, 270), spreading=2), "its spreading"),
    ],
)
def test_what_makes_no_sea_is_refused(make: Any, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        make()
