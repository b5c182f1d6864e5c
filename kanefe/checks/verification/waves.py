"""Cases of seas and ships: spectra against closed forms, and the motions of a ship whose data are public."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.environment import Sea, Ship, read_rao
from kanefe.environment.dispersion import wave_number
from kanefe.environment.spectra import Bretschneider, Jonswap, Spectrum
from kanefe.errors import MissingDependency

WHERE = "KANEFE_S175"
"""Variable of the environment that names the file: the data are of others, and are not part of kanefe."""


def of_spectrum(spectrum: Spectrum, values: dict[str, Any], name: str) -> Iterator[Check]:
    """Compare moments, periods and the peak."""
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
    """S175: the motions of a container ship in four seas."""
    path = os.environ.get(WHERE)
    if not path:
        raise MissingDependency(
            "HYDRO/vessels_shipx/s175/input.re1 of the Marine Systems Simulator (MSS, MIT licence)",
            "the case S175",
            f"save it as s175.re1 and set {WHERE} to its path",
        )
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
            yield Check.absolute(f"{where}: what does not move [m, degrees]", found[~moves], wanted[~moves], 5e-4)
    slope = float(wave_number(rao.frequencies[:1])[0])
    head, beam = rao.at(rao.frequencies[:1], 0.0, 0.0)[0], rao.at(rao.frequencies[:1], 90.0, 0.0)[0]
    found = np.abs((head[2], head[0], head[4] / slope, beam[2]))
    long_waves = list(reference.values["long waves"].values())
    yield Check.absolute("long waves: heave, surge, pitch per slope; heave in beam seas", found, long_waves, 5e-4)


CASES = (Case("F03a", two_spectra), Case("F03b", steep_and_old_seas), Case("S175", container_ship))
