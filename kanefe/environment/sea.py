"""A sea: a directional wave spectrum, and one realisation of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from kanefe.arguments import checked, plain_numbers
from kanefe.environment.checks import checked_number
from kanefe.environment.directional import DirectionalTable, of_compass
from kanefe.environment.dispersion import wave_number
from kanefe.environment.spectra import GRAVITY, Bretschneider, Jonswap, Spectrum, Tabulated
from kanefe.environment.spreading import Spreading
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers

MOST_ORDER = 3
"""Highest order of finite moments of spectra, which decrease with the fifth power of the frequency."""

STATES = {3: (0.88, 7.5), 4: (1.88, 8.8), 5: (3.25, 9.7), 6: (5.0, 12.4), 7: (7.5, 15.0)}
"""Significant height (m) and peak period (s) of sea states of the open North Atlantic, after Bales, Lee & Voelker
(1981)."""

STRATA = 16
"""Number of successive waves in frequency over which the directions are stratified."""

RANDOM_COUNT = 200
"""Default number of waves with random frequencies."""

MOST_WAVES = 100_000

STEEPEST = 1.0 / 7.0
"""Ratio of height to length of the steepest wave in deep water, by Michell 1893 (0.142): steeper waves break. In water
of depth d the limit is tanh(k d) times this (Miche 1944)."""


class Waves(NamedTuple):
    """The waves of a realisation, by increasing frequency.

    Attributes
    ----------
    frequency, number : ndarray, shape (n,)
        rad/s and rad/m.
    amplitude, phase : ndarray, shape (n,)
        m and rad: ``a cos(omega t - k s + phase)``, s the coordinate along the wave's direction.
    direction_deg : ndarray, shape (n,)
        Angle from the main direction to that of the wave, counter-clockwise as seen from above; it is added to the
        heading of a ship.
    """

    frequency: Vector
    number: Vector
    amplitude: Vector
    phase: Vector
    direction_deg: Vector


@dataclass(frozen=True, eq=False)
class Sea:
    """A stationary sea of linear waves, and one realisation of it.

    Constructed by `bretschneider`, `jonswap`, `pierson_moskowitz`, `state` or `measured`. The surface is a sum of
    cosines with random phases, each wave with a different frequency and one direction (waves with equal frequencies
    would be phase-locked; Jefferys 1987). The random numbers are those of numpy's ``SeedSequence((study, sea_state,
    seed))``: they are the same on every machine and for ships of all headings and speeds.

    Parameters
    ----------
    spectrum : Spectrum
    spreading : Spreading or DirectionalTable
    seed, sea_state, study : int
        Identify the realisation; zero or above. Runs of a study differ in `seed`, its sea states in `sea_state`.
    duration : float
        Duration without repetition, s: equal steps of frequency are at most ``2 pi / duration``.
    frequency_range : (float, float), optional
        Lowest and highest wave frequency, rad/s. None: 0.3 to 3.1 times that of the peak; for a table, its full range.
    frequencies : "equal" or "random"
        At the centres of equal steps, or random within each step, which never repeats and needs fewer waves.
    count : int, optional
        Number of waves. None: as many as the duration needs; 200 with random frequencies.
    amplitudes : "spectral" or "rayleigh"
        ``sqrt(2 S dw)``, or random ones with that mean square, for which the variance of a record varies as that of a
        finite record of a real sea.
    depth : float
        Depth of the water, m.
    gravity : float
        m/s2.

    Raises
    ------
    ModelError
        If a number is not valid, the waves are steeper than breaking waves, or waves in equal steps would repeat
        within the duration.

    Examples
    --------
    >>> import kanefe as kf
    >>> sea = kf.Sea.bretschneider(Hs=3.25, Tp=9.7, spreading=2, seed=7)
    >>> [round(100 * sea.kept(order), 1) for order in (0, 2)]  # % of the variance of elevation and of velocity
    [98.7, 86.9]
    """

    spectrum: Spectrum
    spreading: Spreading | DirectionalTable = field(default_factory=Spreading)
    seed: int = 0
    sea_state: int = 0
    study: int = 0
    duration: float = 1200.0
    frequency_range: tuple[float, float] | None = None
    frequencies: str = "equal"
    count: int | None = None
    amplitudes: str = "spectral"
    depth: float = math.inf
    gravity: float = GRAVITY

    def __post_init__(self) -> None:
        self._check_types()
        plain_numbers(self)
        low, high = self.range
        if not (0.0 < low < high and math.isfinite(high)):
            raise ModelError(f"frequency_range of a sea must be two frequencies above zero, in rad/s, not {low, high}")
        if not self.spectrum.moment(0, low, high) > 0.0:
            raise ModelError(f"there are no waves between {low:.4g} and {high:.4g} rad/s in {self.spectrum.title}")
        self._check_steepness()
        self._check_count(high - low)

    def _check_types(self) -> None:
        for what, given, kinds in (
            ("spectrum", self.spectrum, Spectrum),
            ("spreading", self.spreading, (Spreading, DirectionalTable)),
        ):
            if not isinstance(given, kinds):
                raise ModelError(
                    f"the {what} of a sea is not {given!r}. Remedy: kf.Sea.bretschneider(Hs, Tp) and others"
                )
        for name in ("seed", "sea_state", "study"):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 0:
                raise ModelError(f"{name} of a sea must be an integer, zero or above, not {value!r}")
        for name in ("duration", "gravity"):
            checked_number(getattr(self, name), f"{name} of a sea", above=0.0)
        if numbers(self.depth).shape or numbers(self.depth) != math.inf:
            checked_number(self.depth, "the depth of the water", above=0.0)
        if self.count is not None and (isinstance(self.count, bool) or not isinstance(self.count, (int, np.integer))):
            raise ModelError(f"count of a sea must be an integer, not {self.count!r}")
        if self.frequency_range is not None and numbers(self.frequency_range).shape != (2,):
            raise ModelError(
                f"frequency_range of a sea must be two frequencies, in rad/s, not {self.frequency_range!r}"
            )
        for name, known in (("frequencies", ("equal", "random")), ("amplitudes", ("spectral", "rayleigh"))):
            if getattr(self, name) not in known:
                raise ModelError(f"{name} of a sea are one of {', '.join(known)}, not {getattr(self, name)!r}")

    def _check_steepness(self) -> None:
        """Raise a ModelError if waves of the mean period would break."""
        period = self.spectrum.zero_crossing_period
        if not 0.0 < period < math.inf:
            raise ModelError(
                f"the frequencies of {self.spectrum.title} have no mean period. Remedy: check that they are in rad/s"
            )
        mean = np.array(2.0 * math.pi / period)
        number = float(wave_number(mean, self.depth, self.gravity))
        steepest = STEEPEST * 2.0 * math.pi / number * math.tanh(number * self.depth)
        if self.spectrum.significant_height > steepest:
            at = "" if math.isinf(self.depth) else f" in water of {self.depth:g} m"
            raise ModelError(
                f"{self.spectrum.title}{at} is steeper than the limit of breaking: waves of its mean period, "
                f"{period:.4g} s, are {2.0 * math.pi / number:.4g} m long and break above "
                f"{steepest:.4g} m. Remedy: check height and period, in m and s, and the depth"
            )

    def _check_count(self, band: float) -> None:
        """Raise a ModelError if waves over a band of frequencies (rad/s) would repeat, or are too many."""
        needed = math.ceil(band * self.duration / (2.0 * math.pi))
        if self.count is not None and not 1 <= self.count <= MOST_WAVES:
            raise ModelError(f"count of a sea must be 1 to {MOST_WAVES} waves, not {self.count!r}")
        if self.frequencies == "equal" and self.count is not None and self.count < needed:
            again = 2.0 * math.pi * self.count / band
            raise ModelError(
                f"{self.count} waves in equal steps of frequency repeat after {again:.4g} s, within the duration of "
                f'{self.duration:.6g} s. Remedy: {needed} waves, a shorter duration, or frequencies="random"'
            )
        if self.frequencies == "equal" and needed > MOST_WAVES:
            raise ModelError(
                f"a duration of {self.duration:.6g} s needs {needed} waves in equal steps of frequency. Remedy: a "
                'shorter one, or frequencies="random"'
            )

    @classmethod
    def _of(cls, spectrum: Spectrum, spreading: Spreading | DirectionalTable, options: dict[str, Any]) -> Sea:
        known = [one.name for one in fields(cls)][2:]
        for name, value in options.items():
            if name not in known:
                raise ModelError(f"a sea has no {name}={value!r}. Remedy: {', '.join(known)}")
        return cls(spectrum, spreading, **options)

    @classmethod
    def bretschneider(
        cls, Hs: float, Tp: float, *, spreading: float | None = None, spreading_deg: float | None = None, **options: Any
    ) -> Sea:
        """Return a sea with Bretschneider's spectrum (ITTC, ISSC).

        Parameters
        ----------
        Hs, Tp : float
            Significant height (m) and period of the peak (s).
        spreading : float, optional
            Power of the cosine of the spreading within 90 degrees; None: all waves come from one direction.
        spreading_deg : float, optional
            Alternatively, standard deviation of normally distributed directions, degrees.
        **options
            See the class.
        """
        return cls._of(Bretschneider(Hs, Tp), Spreading(spreading, spreading_deg), options)

    @classmethod
    def jonswap(
        cls,
        Hs: float,
        Tp: float,
        gamma: float = 3.3,
        *,
        spreading: float | None = None,
        spreading_deg: float | None = None,
        **options: Any,
    ) -> Sea:
        """Return a sea with a JONSWAP spectrum of variance exactly ``Hs^2 / 16``; see `bretschneider`."""
        return cls._of(Jonswap(Hs, Tp, gamma), Spreading(spreading, spreading_deg), options)

    @classmethod
    def pierson_moskowitz(
        cls, wind: float, *, spreading: float | None = None, spreading_deg: float | None = None, **options: Any
    ) -> Sea:
        """Return the fully developed sea of a wind (m/s, at 19.5 m); see `bretschneider`."""
        spectrum = Bretschneider.of_wind(wind, options.get("gravity", GRAVITY))
        return cls._of(spectrum, Spreading(spreading, spreading_deg), options)

    @classmethod
    def state(
        cls, number: int, *, spreading: float | None = None, spreading_deg: float | None = None, **options: Any
    ) -> Sea:
        """Return a sea state of the open North Atlantic, 3 to 7, by Bretschneider's spectrum; see `bretschneider`.

        The number is also the `sea_state` of the seed.
        """
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number not in STATES:
            raise ModelError(f"sea states are {', '.join(map(str, STATES))}, not {number!r}. Remedy: one of them")
        options.setdefault("sea_state", number)
        return cls._of(Bretschneider(*STATES[number]), Spreading(spreading, spreading_deg), options)

    @classmethod
    def measured(
        cls,
        frequencies: Any,
        densities: Any,
        directions_deg: Sequence[float] | Vector | None = None,
        **options: Any,
    ) -> Sea:
        """Return a sea with a measured or computed spectrum, linear between its points.

        Parameters
        ----------
        frequencies : array_like, shape (n,)
            Increasing, rad/s; in Hz they and the densities differ by ``2 pi``.
        densities : array_like, shape (n,) or (n, m)
            m2 s/rad; with directions m2 s/(rad degree).
        directions_deg : array_like, shape (m,), optional
            Compass directions from which the waves come, degrees, evenly spaced over the full circle. The main
            direction is their mean, and the heading of a `Ship` is its course minus the main direction.
        **options
            See the class; `spreading` and `spreading_deg` without directions.
        """
        power, deviation = options.pop("spreading", None), options.pop("spreading_deg", None)
        if directions_deg is None:
            return cls._of(Tabulated(frequencies, densities), Spreading(power, deviation), options)
        if power is not None or deviation is not None:
            raise ModelError("a spectrum over directions contains its spreading. Remedy: leave out spreading")
        spectrum, table = of_compass(frequencies, densities, directions_deg)
        return cls._of(spectrum, table, options)

    @classmethod
    def from_wavespectra(cls, spectrum: Any, **options: Any) -> Sea:
        """Return a sea with a directional spectrum of wavespectra, which reads files of SWAN, WW3, NDBC, ERA5.

        Parameters
        ----------
        spectrum : xarray.Dataset, xarray.DataArray, str or Path
            With coordinates ``freq`` (Hz) and ``dir`` (degrees from which waves come), and ``efth`` in m2/(Hz degree),
            for one place and time; or a file in wavespectra's netCDF or another one that it knows by its suffix.
        **options
            See the class.
        """
        from kanefe.environment._wavespectra import frequencies_densities_directions

        return cls.measured(*frequencies_densities_directions(spectrum), **options)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest wave frequency of the sum, rad/s."""
        low, high = self.spectrum.usual_range if self.frequency_range is None else self.frequency_range
        return float(low), float(high)

    @checked
    def kept(self, order: int = 0) -> float:
        """Return the share of a moment of the spectrum within the range of frequencies: 0 elevation, 2 velocity."""
        if not 0 <= order <= MOST_ORDER:
            raise ModelError(f"order of a moment must be 0 to {MOST_ORDER}, not {order!r}")
        return self.spectrum.moment(order, *self.range) / self.spectrum.moment(order)

    def __str__(self) -> str:
        low, high = self.range
        return (
            f"{self.spectrum.title}, {self.spreading.title}; {len(self.waves.frequency)} waves of {low:.4g} to "
            f"{high:.4g} rad/s keep {100 * self.kept(0):.1f} % of m0 and {100 * self.kept(2):.1f} % of m2"
        )

    @cached_property
    def waves(self) -> Waves:
        """The waves of this realisation."""
        low, high = self.range
        count = self.count
        if count is None:
            needed = math.ceil((high - low) * self.duration / (2.0 * math.pi))
            count = needed if self.frequencies == "equal" else RANDOM_COUNT
        step = (high - low) / count
        # separate streams, so that an option changes nothing else; only `random` is the same in all versions of numpy
        seeds = np.random.SeedSequence((self.study, self.sea_state, self.seed)).spawn(5)
        phases, orders, shares, sizes, places = (np.random.Generator(np.random.PCG64(s)).random(count) for s in seeds)
        omega = low + step * (np.arange(count) + (places if self.frequencies == "random" else 0.5))
        power = 2.0 * self.spectrum.density(omega) * step
        if self.amplitudes == "rayleigh":
            power = power * -np.log1p(-sizes)
        strata = [orders[i : i + STRATA] for i in range(0, count, STRATA)]
        shares = (np.concatenate([np.argsort(s) for s in strata]) + shares) / np.repeat(
            *(([len(s) for s in strata],) * 2)
        )
        direction = self.spreading.quantile_at(omega, shares)
        return Waves(
            omega, wave_number(omega, self.depth, self.gravity), np.sqrt(power), 2.0 * math.pi * phases, direction
        )

    @checked("x", "y")
    def elevation(self, times: Sequence[float] | Vector, x: float = 0.0, y: float = 0.0) -> Vector:
        """Return the surface elevation (m) at x, y (m); x is the main direction of propagation, y to its left."""
        w, t = self.waves, numbers(times)
        if not np.all(np.isfinite(t)):
            raise ModelError(f"the times of an elevation must be finite numbers, s, not {times!r}")
        x, y = checked_number(x, "x of an elevation"), checked_number(y, "y of an elevation")
        angle = np.radians(w.direction_deg)
        phase = w.phase - w.number * (x * np.cos(angle) + y * np.sin(angle))
        return np.asarray(np.cos(np.multiply.outer(t, w.frequency) + phase) @ w.amplitude)
