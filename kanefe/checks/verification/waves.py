"""Cases of seas and ships: spectra against closed forms, a ship with published data, a block on a deck."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.resources import as_file, files
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import whole_run
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane
from kanefe.environment import Sea, Ship, example_rao, read_rao
from kanefe.environment.dispersion import wave_number
from kanefe.environment.rao.rao import at_point
from kanefe.environment.spectra import Bretschneider, Jonswap, Spectrum
from kanefe.joints import Free
from kanefe.result import Result
from kanefe.system import System

S175 = "s175.re1"
"""File of the Marine Systems Simulator with three of its five speeds and five of its nineteen headings, otherwise
unchanged."""


def of_spectrum(spectrum: Spectrum, values: dict[str, Any], name: str) -> Iterator[Check]:
    """Compare the moments, periods and peak of a spectrum."""
    orders = values["moments"]
    found = [spectrum.moment(int(order)) for order in orders]
    yield Check.relative(f"{name}: moments {', '.join(orders)}", found, list(orders.values()), 1e-6)
    periods = spectrum.mean_period, spectrum.zero_crossing_period, spectrum.energy_period
    yield Check.relative(f"{name}: T1, Tz, Te [s]", periods, [values[key] for key in ("T1", "Tz", "Te")], 1e-6)
    highest = float(spectrum.density(np.array(spectrum.peak)))
    yield Check.relative(f"{name}: density at the peak [m2 s/rad]", highest, values["S_peak"], 1e-6)


def of_jonswap(values: dict[str, Any]) -> Iterator[Check]:
    """Compare a JONSWAP spectrum with its normalisation."""
    spectrum = Jonswap(values["Hs"], values["Tp"], values["gamma"])
    name = f"JONSWAP, gamma {values['gamma']:g}"
    yield from of_spectrum(spectrum, values, name)
    yield Check.relative(f"{name}: factor that keeps Hs", spectrum.factor, values["norm_factor"], 1e-6)
    alpha = 5.0 / 16.0 * spectrum.Hs**2 * spectrum.peak**4 / 9.81**2 * spectrum.factor
    yield Check.relative(f"{name}: alpha", alpha, values["alpha_g2form"], 1e-6)


def two_spectra(reference: Reference) -> Iterator[Check]:
    """F03a: Bretschneider's spectrum, and JONSWAP's with gamma 3.3 and 1."""
    values = reference.values
    yield from of_spectrum(Bretschneider(values["bret"]["Hs"], values["bret"]["Tp"]), values["bret"], "Bretschneider")
    for each in values["jonswap"]:
        yield from of_jonswap(each)


def steep_and_old_seas(reference: Reference) -> Iterator[Check]:
    """F03b: JONSWAP's spectrum with gamma 5, and that of Pierson and Moskowitz."""
    yield from of_jonswap(reference.values["jonswap"])
    values = reference.values["pm"]
    spectrum = Bretschneider.of_wind(values["U19_5"])
    found = spectrum.moment(0), spectrum.moment(2), spectrum.significant_height, spectrum.peak
    wanted = [values[key] for key in ("m0", "m2", "Hs", "wp")]
    yield Check.relative("Pierson-Moskowitz: m0, m2, Hs, peak", found, wanted, 1e-6)


def container_ship(reference: Reference) -> Iterator[Check]:
    """S175: the motions of a container ship in irregular waves."""
    with as_file(files("kanefe.checks.verification") / S175) as path:
        rao = read_rao(path)
    sea = Sea.bretschneider(Hs=3.25, Tp=9.7)
    for row in reference.values["rows"]:
        ship = Ship(rao, sea, row["speed"], row["heading"], slowest_hz=0.0)
        found = np.array(list(ship.motions_std().values())) * np.where(np.arange(6) < 3, 1.0, 180.0 / math.pi)
        wanted = np.array(row["std"])
        where = f"heading {row['heading']}, {row['speed']:g} m/s"
        moves = wanted > 0.0
        yield Check.relative(f"{where}: standard deviations [m, degrees]", found[moves], wanted[moves], 5e-3)
        if not moves.all():
            yield Check.absolute(f"{where}: motions that vanish [m, degrees]", found[~moves], wanted[~moves], 5e-4)
    slope = float(wave_number(rao.frequencies[:1])[0])
    head, beam = rao.at(rao.frequencies[:1], 0.0, 0.0)[0], rao.at(rao.frequencies[:1], 90.0, 0.0)[0]
    found = np.abs((head[2], head[0], head[4] / slope, beam[2]))
    long_waves = list(reference.values["long waves"].values())
    yield Check.absolute("long waves: heave, surge, pitch per slope; heave in beam seas", found, long_waves, 5e-4)


POINT = np.array((-30.0, 0.0, 5.0))
"""Point of the deck, relative to the reference point, m."""

BEAM = 90.0
GRAVITY = 9.81
DOWN = np.array((0.0, 0.0, -GRAVITY))
RAMP = 30.0
STIFFNESS = 1e5
"""Contact stiffness of the block, N/m."""

DURATION = 600.0
SAMPLES = 4096
"""Number of samples of a record: about seventy per wave period."""

CLEAR = 0.02
"""Relative excess over the limit from which the time of an exceedance is compared."""


def loads_across(ship: Ship, omega: np.ndarray, mu: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lateral load on a block minus mu times the change of its normal load, to both sides, m/s2.

    For waves of unit amplitude in beam seas, linearised; the block slips where it exceeds ``mu g``.
    """
    response = at_point(ship.rao.at(omega, BEAM, 0.0), POINT)
    across = -(omega**2) * response[:, 1] + GRAVITY * response[:, 3]
    lighter = mu * omega**2 * response[:, 2]
    return across + lighter, lighter - across


def rice_rate(ship: Ship, mu: float) -> float:
    """Return the mean number of slips of a block per second, by Rice's formula for both directions."""
    omega = np.linspace(*ship.sea.range, 4001)
    energy = ship.sea.spectrum.density(omega) * (omega[1] - omega[0])
    rate = 0.0
    for load in loads_across(ship, omega, mu):
        m0, m2 = (float(np.sum(omega**order * energy * abs(load) ** 2)) for order in (0, 2))
        rate += math.sqrt(m2 / m0) / (2.0 * math.pi) * math.exp(-((mu * GRAVITY) ** 2) / (2.0 * m0))
    return rate


def passes(over: np.ndarray, times: np.ndarray) -> list[tuple[float, float]]:
    """Return the times (s) at which a quantity becomes positive, each with the following peak."""
    begins = np.flatnonzero((over[1:] > 0.0) & (over[:-1] <= 0.0))
    ends = np.append(np.flatnonzero((over[1:] <= 0.0) & (over[:-1] > 0.0)), len(over) - 1)
    shares = over[begins] / (over[begins] - over[begins + 1])
    peaks = [float(over[i : ends[ends > i][0] + 1].max()) for i in begins]
    return list(zip((times[begins] + shares * np.diff(times)[begins]).tolist(), peaks, strict=True))


def linear_count(ship: Ship, mu: float, duration: float) -> int:
    """Return how often the linearised lateral loads exceed the friction limit; wave frequencies are in equal steps."""
    waves = ship.sea.waves
    period = 2.0 * math.pi / (waves.frequency[1] - waves.frequency[0])
    times = period / SAMPLES * np.arange(SAMPLES)
    first = np.exp(1j * waves.frequency[0] * times)
    count = 0
    for load in loads_across(ship, waves.frequency, mu):
        sums = SAMPLES * np.fft.ifft(load * waves.amplitude * np.exp(1j * waves.phase), SAMPLES)
        over = (sums * first).real - mu * GRAVITY
        count += len(passes(over[times < duration], times[times < duration]))
    return count


def exact_passes(ship: Ship, mu: float, times: np.ndarray) -> list[tuple[float, float]]:
    """Return the times (s) at which the lateral load exceeds the friction limit, each with the relative peak excess.

    The load per mass on a point of the rigid deck with the acceleration a is ``A^T (a - g)`` in axes of the deck.
    """
    deck = ship.at(POINT, ramp=RAMP)
    found = [deck.at(float(t)) for t in times]
    load = np.array([(rates.acceleration - DOWN) @ rates.axes for rates in found])
    return passes(np.hypot(load[:, 0], load[:, 1]) / (mu * load[:, 2]) - 1.0, times)


def in_state_five(seed: int, duration: float) -> Ship:
    """Return the example ship at zero speed in beam seas, with all frequencies of its motion."""
    return Ship(example_rao(), Sea.state(5, seed=seed, duration=duration), 0.0, BEAM, slowest_hz=0.0)


def slips_of_a_block(ship: Ship, mu: float, end: float) -> np.ndarray:
    """Return the times (s) at which a block on the deck begins to slip, after the ramp of the sea."""
    scene = System(gravity=DOWN.tolist())
    deck = scene.add_frame("deck", joint=Free(motion=ship.at(POINT, ramp=RAMP)))
    top = scene.add_surface("top", deck, Plane("z"))
    start = Free(position=(POINT + DOWN / STIFFNESS).tolist())
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    friction = Coulomb(mu, damping=2.0 * math.sqrt(STIFFNESS))  # critical damping: no oscillation while it sticks
    scene.add_contact("c", block, top, normal=HuntCrossley(STIFFNESS, 0.3), friction=friction)
    model = scene.freeze()
    result = Result(model, whole_run(model, (0.0, end), 1e-5, output_step=10.0))
    slips = result.events["c slip"]
    return np.asarray(slips[slips > RAMP])


def block_on_a_deck(reference: Reference) -> Iterator[Check]:
    """K25: how often a block slips on the deck of a ship in sea state 5."""
    values, mu = reference.values, reference.values["mu"]
    ships = [in_state_five(seed, DURATION) for seed in range(values["seeds"])]
    count = np.mean([linear_count(ship, mu, DURATION) for ship in ships])
    expected = DURATION * rice_rate(ships[0], mu)
    yield Check.relative("exceedances in 10 min, mean of 200 seas, against Rice's formula", count, expected, 3e-2)
    ship, end = ships[values["seed"]], values["end"]
    slips = slips_of_a_block(ship, mu, end)
    passed = [each for each in exact_passes(ship, mu, np.arange(0.0, end, 0.05)) if each[0] > RAMP]
    clear = [t for t, peak in passed if peak > CLEAR]
    late = max(float(np.min(abs(slips - t))) for t in clear)
    yield Check.absolute(f"block: {len(clear)} loads that pass the limit, worst time to a slip [s]", late, 0.0, 2e-2)
    early = max(float(np.min(abs(np.array([t for t, _ in passed]) - t))) for t in slips)
    yield Check.absolute(f"block: {len(slips)} slips, worst time to a load that passes [s]", early, 0.0, 2e-2)


CASES = (
    Case("F03a", two_spectra),
    Case("F03b", steep_and_old_seas),
    Case("S175", container_ship),
    Case("K25", block_on_a_deck),
)
