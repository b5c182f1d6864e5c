"""Wind: a mean, gusts and turbulence, uniform in space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, shaped_numbers
from kanefe.kernels.force_elements.aerodynamics import WindNumbers, wind_at
from kanefe.kernels.values.filled import filled

MOST_HARMONICS = 100_000
"""Largest number of harmonics of turbulence: their sum is computed in every evaluation."""

REACH = 30.0
"""Largest ``L w / U`` of the turbulence: 97.9 % of the variance along the wind, and 95.8 % across."""

LOWEST = 0.03
"""Value of ``L w / U`` below which one harmonic represents all."""


@dataclass(frozen=True)
class Gust:
    """``velocity (1 - cos(2 pi (t - start) / duration)) / 2`` from `start` on, once.

    Parameters
    ----------
    velocity : (float, float, float)
        Velocity at its peak, added to the wind, in components of N, m/s.
    start, duration : float
        s.

    Raises
    ------
    ModelError
        If a number is not valid; the message names it.
    """

    velocity: Any
    start: float
    duration: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", shaped_numbers(self.velocity, (3,), "velocity of a gust"))
        object.__setattr__(self, "start", float(shaped_numbers(self.start, (), "start of a gust")))
        if shaped_numbers(self.duration, (), "duration of a gust") <= 0.0:
            raise ModelError(f"duration of a gust must be above 0 s, not {self.duration!r}")
        object.__setattr__(self, "duration", float(self.duration))

    def at(self, t: float) -> Vector:
        """Return its velocity at time t (s), m/s."""
        return Wind(np.zeros(3), (self,)).at(t)


@dataclass(frozen=True)
class Turbulence:
    """Turbulence with Dryden's spectra, convected by the mean wind U, as a sum of harmonics with random phases.

    With ``x = L w / U`` the one-sided spectra are ``2 s^2 L / (pi U) / (1 + x^2)`` along the wind and
    ``s^2 L / (pi U) (1 + 3 x^2) / (1 + x^2)^2`` across it (MIL-F-8785C, 3.7.1.2). Each harmonic has the variance of the
    spectrum in its band, by the integral in closed form, and a random frequency in it, so that the sum is not periodic.
    The widths of bands are proportional to frequency, up to x = 30. Random numbers are from numpy's `SeedSequence`.

    Parameters
    ----------
    intensity : float or (float, float, float)
        Standard deviation s along the wind, across it and upwards, m/s.
    length : float or (float, float, float)
        L of the three components, m.
    seed : int
        Number of the realisation, zero or above.
    count : int
        Number of harmonics.

    Raises
    ------
    ModelError
        If a number is not valid; the message names it.
    """

    intensity: Any
    length: Any
    seed: int = 0
    count: int = 60

    def __post_init__(self) -> None:
        for name, least in (("intensity", ">= 0 m/s"), ("length", "> 0 m")):
            given = getattr(self, name)
            one = numbers(given)
            is_one = one.shape == () and not np.isnan(one)
            values = shaped_numbers(np.full(3, one) if is_one else given, (3,), f"{name} of turbulence")
            if np.any(values < 0.0) or (name == "length" and np.any(values == 0.0)):
                raise ModelError(f"{name} of turbulence must be {least}, not {given!r}")
            object.__setattr__(self, name, values)
        for name, lowest, most in (("seed", 0, math.inf), ("count", 1, MOST_HARMONICS)):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or not lowest <= value <= most:
                limit = f"{lowest} or above" if most == math.inf else f"{lowest} to {most}"
                raise ModelError(f"{name} of turbulence must be an integer, {limit}, not {value!r}")

    def harmonics(self, wind: Vector) -> np.ndarray:
        """Return frequency (rad/s), three parts with the cosine and three with the sine (m/s), shape (count, 7).

        Parameters
        ----------
        wind : ndarray, shape (3,)
            Mean wind, in components of N, m/s.
        """
        speed = float(np.linalg.norm(wind))
        random = np.random.default_rng(np.random.SeedSequence(self.seed))
        rates = speed / self.length  # rad/s at x = 1, of each part
        edges = np.append(0.0, np.geomspace(LOWEST * rates.min(), REACH * rates.max(), self.count))
        frequencies = edges[:-1] + np.diff(edges) * random.random(self.count)
        phases = 2.0 * math.pi * random.random((self.count, 3))
        below = np.column_stack([_share(edges / rate, i == 0) for i, rate in enumerate(rates)])
        amplitudes = self.intensity * np.sqrt(2.0 * np.diff(below, axis=0))
        axes = _axes_along(wind / speed)
        return np.column_stack(
            (frequencies, (amplitudes * np.cos(phases)) @ axes, (amplitudes * np.sin(phases)) @ axes)
        )


@dataclass(frozen=True)
class Wind:
    """Wind that is uniform in space: a mean, gusts, and turbulence.

    On a deck whose motion does not include the speed of the ship, such as `Ship.at`, give the wind relative to the
    ship.

    Parameters
    ----------
    velocity : (float, float, float)
        Mean velocity of the air, in components of N, m/s.
    gusts : sequence of Gust
    turbulence : Turbulence, optional

    Raises
    ------
    ModelError
        If an argument is not valid; turbulence needs a mean wind that convects it.

    Examples
    --------
    >>> import kanefe as kf
    >>> wind = kf.Wind((0, -10, 0), gusts=[kf.Gust((0, -6, 0), start=2, duration=4)])
    >>> [float(wind.at(t)[1]) for t in (0.0, 3.0, 4.0, 7.0)]
    [-10.0, -13.0, -16.0, -10.0]
    """

    velocity: Any
    gusts: Sequence[Gust] = field(default=())
    turbulence: Turbulence | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", shaped_numbers(self.velocity, (3,), "velocity of a wind"))
        gusts = self.gusts
        if not isinstance(gusts, (list, tuple)) or not all(isinstance(gust, Gust) for gust in gusts):
            raise ModelError(f"gusts of a wind must be a list of kanefe.Gust, not {gusts!r}")
        object.__setattr__(self, "gusts", tuple(gusts))
        if self.turbulence is None:
            return
        if not isinstance(self.turbulence, Turbulence):
            raise ModelError(f"turbulence of a wind must be a kanefe.Turbulence, not {self.turbulence!r}")
        if not np.any(self.velocity):
            raise ModelError("turbulence is carried past by the mean wind, which is zero. Remedy: give velocity")

    @cached_property
    def harmonics(self) -> np.ndarray:
        """Harmonics of its turbulence, if any: see `Turbulence.harmonics`."""
        return np.zeros((0, 7)) if self.turbulence is None else self.turbulence.harmonics(self.velocity)

    def at(self, t: float) -> Vector:
        """Return its velocity at time t (s) in components of N, shape (3,), m/s."""
        return np.array((*wind_at(t, WindNumbers(self.numbers)),))

    @property
    def numbers(self) -> Vector:
        """Its numbers for the kernel."""
        gusts = [np.array((gust.start, gust.duration, *gust.velocity)) for gust in self.gusts]
        rest = np.concatenate((*gusts, self.harmonics.ravel()))
        counts = {"gust_count": len(gusts), "harmonic_count": len(self.harmonics)}
        return filled(WindNumbers, mean=self.velocity, gusts=rest, **counts)


def _share(x: np.ndarray, is_along: bool) -> np.ndarray:
    """Return the share of the variance below ``x = L w / U``."""
    turn = 2.0 * np.arctan(x) / math.pi
    return turn if is_along else turn - x / (math.pi * (1.0 + x**2))


def _axes_along(direction: Vector) -> np.ndarray:
    """Return unit vectors along the wind, across it, and upwards for a horizontal wind, (3, 3)."""
    up = np.array((0.0, 0.0, 1.0)) if abs(direction[2]) < 0.9 else np.array((1.0, 0.0, 0.0))
    across = np.cross(up, direction)
    across /= np.linalg.norm(across)
    return np.array((direction, across, np.cross(direction, across)))
