"""Spectra of the wave elevation at a point, over wave frequency, with exact moments."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from kanefe.environment.checks import checked_number
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers

SIZES = {"Hs": (1e-6, 1e3), "Tp": (0.1, 1e5)}
"""Range of significant height (m) and peak period (s) of gravity waves: shorter ones are capillary waves, longer ones
are tides."""

GRAVITY = 9.81
"""Default gravity, m/s2."""

NARROW, WIDE = 0.07, 0.09
"""Widths of the peak of a JONSWAP spectrum below and above its frequency, dimensionless (Hasselmann et al. 1973)."""

STEEPNESS, DECAY = 8.10e-3, 0.74
"""Constants of Pierson & Moskowitz (1964), dimensionless."""


class Spectrum(ABC):
    """Base of the spectra: one-sided density S(omega), m2 s/rad, and derived quantities."""

    @abstractmethod
    def density(self, omega: Vector) -> Vector:
        """Return S at wave frequencies in rad/s, m2 s/rad."""

    @property
    @abstractmethod
    def peak(self) -> float:
        """Wave frequency of the highest density, rad/s."""

    @property
    @abstractmethod
    def title(self) -> str:
        """Name with parameters, for messages."""

    @property
    def usual_range(self) -> tuple[float, float]:
        """Default range of wave frequencies of a sum of waves, rad/s."""
        return 0.3 * self.peak, 3.1 * self.peak

    def moment(self, order: float, low: float = 0.0, high: float = math.inf) -> float:
        """Return the integral of ``omega^order S`` between two frequencies (rad/s), m2 (rad/s)^order.

        Raises
        ------
        ModelError
            If it is infinite: spectra of wind seas decrease with the fifth power of the frequency.
        """
        if order >= 4.0 and math.isinf(high):
            raise ModelError(
                f"the moment of order {order:g} of a wave spectrum is infinite. Remedy: an upper frequency"
            )
        return integral(self.density, order, self.peak, low, high)

    @property
    def significant_height(self) -> float:
        """``Hs = 4 sqrt(m0)``, m."""
        return 4.0 * math.sqrt(self.moment(0))

    @property
    def mean_period(self) -> float:
        """``T1 = 2 pi m0 / m1``, s."""
        return 2.0 * math.pi * self.moment(0) / self.moment(1)

    @property
    def zero_crossing_period(self) -> float:
        """``Tz = 2 pi sqrt(m0 / m2)``, s."""
        return 2.0 * math.pi * math.sqrt(self.moment(0) / self.moment(2))

    @property
    def energy_period(self) -> float:
        """``Te = 2 pi m-1 / m0``, s."""
        return 2.0 * math.pi * self.moment(-1) / self.moment(0)


@dataclass(frozen=True)
class Bretschneider(Spectrum):
    """The spectrum ``5/16 Hs^2 wp^4 w^-5 exp(-5/4 (wp/w)^4)`` with two parameters, also called ITTC or ISSC spectrum.

    Parameters
    ----------
    Hs : float
        Significant height, m.
    Tp : float
        Period of the peak, s.
    """

    Hs: float
    Tp: float

    def __post_init__(self) -> None:
        for name in ("Hs", "Tp"):
            given = checked_number(getattr(self, name), f"{name} of a wave spectrum", above=0.0)
            object.__setattr__(self, name, given)
        _check_sizes(self)

    @classmethod
    def of_wind(cls, speed: float, gravity: float = GRAVITY) -> Bretschneider:
        """Return the spectrum of Pierson & Moskowitz (1964), by the wind at a height of 19.5 m, m/s."""
        speed = checked_number(speed, "the wind of a Pierson-Moskowitz spectrum", above=0.0)
        gravity = checked_number(gravity, "gravity of a sea", above=0.0)
        peak = (0.8 * DECAY) ** 0.25 * gravity / speed
        height = 2.0 * math.sqrt(STEEPNESS / DECAY) * speed * speed / gravity
        try:
            return cls(height, 2.0 * math.pi / peak)
        except (ModelError, ZeroDivisionError) as error:
            raise ModelError(
                f"a wind of {speed:g} m/s with gravity of {gravity:g} m/s2 makes no sea: its significant height would "
                f"be {height:.4g} m. Remedy: check both"
            ) from error

    @property
    def peak(self) -> float:
        return 2.0 * math.pi / self.Tp

    @property
    def title(self) -> str:
        return f"Bretschneider, Hs {self.Hs:.4g} m, Tp {self.Tp:.4g} s"

    def density(self, omega: Vector) -> Vector:
        return wind_sea(self.Hs, self.peak, omega)

    def moment(self, order: float, low: float = 0.0, high: float = math.inf) -> float:
        """Return the integral in closed form: with ``x = 5/4 (wp/w)^4`` it is an incomplete gamma function.

        See `Spectrum.moment`.
        """
        from scipy.special import gamma, gammaincc

        if order >= 4.0:
            return super().moment(order, low, high)

        def above(omega: float) -> float:  # share below a frequency
            return 0.0 if omega <= 0.0 else float(gammaincc(1.0 - order / 4.0, 1.25 * (self.peak / omega) ** 4))

        whole = self.Hs**2 / 16.0 * 1.25 ** (order / 4.0) * float(gamma(1.0 - order / 4.0)) * self.peak**order
        return whole * ((1.0 if math.isinf(high) else above(high)) - above(low))


@dataclass(frozen=True)
class Jonswap(Spectrum):
    """Bretschneider's spectrum with a higher peak, scaled to the significant height by its exact integral.

    Parameters
    ----------
    Hs, Tp : float
        Significant height (m) and period of the peak (s).
    gamma : float
        Peak enhancement factor: 1 is Bretschneider's spectrum, 3.3 the mean of the North Sea (Hasselmann et al. 1973).
    """

    Hs: float
    Tp: float
    gamma: float = 3.3

    def __post_init__(self) -> None:
        for name in ("Hs", "Tp", "gamma"):
            given = checked_number(getattr(self, name), f"{name} of a wave spectrum", above=0.0)
            object.__setattr__(self, name, given)
        _check_sizes(self)
        if self.gamma < 1.0:
            raise ModelError(f"gamma of a JONSWAP spectrum must be 1 or more, not {self.gamma!r}")

    @property
    def peak(self) -> float:
        return 2.0 * math.pi / self.Tp

    @property
    def title(self) -> str:
        return f"JONSWAP, Hs {self.Hs:.4g} m, Tp {self.Tp:.4g} s, gamma {self.gamma:.4g}"

    @cached_property
    def factor(self) -> float:
        """Factor on the spectrum that keeps Hs."""
        return self.Hs**2 / 16.0 / integral(self._raised, 0, self.peak)

    def density(self, omega: Vector) -> Vector:
        return self.factor * self._raised(omega)

    def _raised(self, omega: Vector) -> Vector:
        omega = np.asarray(omega, dtype=float)
        width = np.where(omega > self.peak, WIDE, NARROW)
        bump = np.exp(-0.5 * ((omega / self.peak - 1.0) / width) ** 2)
        return wind_sea(self.Hs, self.peak, omega) * self.gamma**bump


@dataclass(frozen=True, eq=False)
class Tabulated(Spectrum):
    """A measured or computed spectrum through points, linear between them and zero outside.

    Parameters
    ----------
    frequencies : array_like, shape (n,)
        Increasing, above zero, rad/s.
    densities : array_like, shape (n,)
        m2 s/rad.
    """

    frequencies: Any
    densities: Any
    origin: str = "measured"
    _table: tuple[Vector, Vector] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        w, s = numbers(self.frequencies), numbers(self.densities)
        if w.ndim != 1 or len(w) < 2 or s.shape != w.shape or not (np.isfinite(w).all() and np.isfinite(s).all()):
            raise ModelError(
                "a wave spectrum by a table needs as many finite densities as frequencies, two at least; shapes "
                f"{w.shape} and {s.shape} were given, or a number is not finite"
            )
        if w[0] <= 0.0 or np.any(np.diff(w) <= 0.0):
            raise ModelError("the frequencies of a wave spectrum must increase, from above zero, in rad/s")
        if np.any(s < 0.0):
            at = int(np.argmin(s))
            raise ModelError(
                f"the densities of a wave spectrum cannot be negative, but it is {s[at]:.6g} m2 s/rad at {w[at]:.6g} "
                "rad/s. Remedy: check the data; where it is due to smoothing, set it to zero"
            )
        if not np.any(s > 0.0):
            raise ModelError("the densities of a wave spectrum are zero everywhere: there are no waves")
        object.__setattr__(self, "_table", (w, s))

    @property
    def peak(self) -> float:
        w, s = self._table
        return float(w[np.argmax(s)])

    @property
    def title(self) -> str:
        return f"{self.origin}, Hs {self.significant_height:.4g} m, Tp {2.0 * math.pi / self.peak:.4g} s"

    @property
    def usual_range(self) -> tuple[float, float]:
        w, _ = self._table
        return float(w[0]), float(w[-1])

    def density(self, omega: Vector) -> Vector:
        w, s = self._table
        return np.asarray(np.interp(omega, w, s, left=0.0, right=0.0))

    def moment(self, order: float, low: float = 0.0, high: float = math.inf) -> float:
        """Return the integral by Gauss quadrature in each interval; see `Spectrum.moment`."""
        w, _ = self._table
        ends = np.unique(np.clip(w, max(low, w[0]), min(high, w[-1])))
        points, weights = gauss(ends, 8)
        return float(np.sum(weights * points**order * self.density(points)))


def _check_sizes(spectrum: Spectrum) -> None:
    for name, (least, most) in SIZES.items():
        value = getattr(spectrum, name)
        if not least <= value <= most:
            raise ModelError(f"{name} of a wave spectrum must be {least:g} to {most:g}, in m and s, not {value!r}")


def integral(
    density: Callable[[Vector], Vector], order: float, peak: float, low: float = 0.0, high: float = math.inf
) -> float:
    """Return the integral of ``omega^order S`` by quadrature, to 1e-12; S is smooth except at its peak."""
    from scipy.integrate import quad

    ends = [low, *(at for at in (peak, 4.0 * peak) if low < at < high), high]
    parts = (
        quad(lambda w: w**order * float(density(np.array(w))), *pair, epsabs=0.0, epsrel=1e-12, limit=200)[0]
        for pair in pairwise(ends)
    )
    return float(sum(parts))


def wind_sea(height: float, peak: float, omega: Vector) -> Vector:
    """Return Bretschneider's density, m2 s/rad, of a significant height (m) and a peak (rad/s); zero for omega <= 0."""
    omega = np.asarray(omega, dtype=float)
    x = np.where(omega > 0.0, peak / np.where(omega > 0.0, omega, 1.0), 0.0)
    with np.errstate(under="ignore"):
        return np.asarray(0.3125 * height**2 / peak * x**5 * np.exp(-1.25 * np.minimum(x, 30.0) ** 4))


def gauss(ends: Sequence[float] | Vector, order: int) -> tuple[Vector, Vector]:
    """Return points and weights of Gauss-Legendre quadrature in each interval between successive ends."""
    x, weight = np.polynomial.legendre.leggauss(order)
    ends = np.asarray(ends, dtype=float)
    half, middle = 0.5 * np.diff(ends)[:, None], 0.5 * (ends[1:] + ends[:-1])[:, None]
    return (middle + half * x).ravel(), (half * weight).ravel()
