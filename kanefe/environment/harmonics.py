"""Sums of harmonics of the six motions of a ship, with their exact rates, and the ramp at their start."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector

MOST_NUMBERS = 2_000_000
"""Largest product of the numbers of times and harmonics whose cosines are in memory together."""


@dataclass(frozen=True, eq=False)
class Harmonics:
    """``Re sum c_n exp(i w_n t)`` of six motions.

    Attributes
    ----------
    frequencies : ndarray, shape (n,)
        Frequencies of encounter, rad/s, with sign.
    amplitudes : ndarray, shape (n, 6)
        Complex, m and rad.
    """

    frequencies: Vector
    amplitudes: np.ndarray

    @cached_property
    def with_rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Real and imaginary parts of the amplitudes of motions, rates and accelerations, (n, 18) each."""
        found = np.concatenate([self.amplitudes * (1j * self.frequencies[:, None]) ** k for k in range(3)], axis=1)
        return found.real.copy(), found.imag.copy()

    def at(self, times: Vector) -> np.ndarray:
        """Return motions, rates and accelerations at some times, by cosines and sines, shape (times, 3, 6)."""
        times = np.asarray(times, dtype=float)
        if times.ndim != 1:
            raise ModelError(f"times must be numbers in s, shape (n,), not of shape {times.shape}")
        found = np.empty((len(times), 3, 6))
        several = max(1, MOST_NUMBERS // max(1, len(self.frequencies)))
        real, imaginary = self.with_rates
        for i in range(0, len(times), several):
            phases = np.multiply.outer(times[i : i + several], self.frequencies)
            sums = np.cos(phases) @ real - np.sin(phases) @ imaginary
            found[i : i + several] = sums.reshape(-1, 3, 6)
        return found


@dataclass(frozen=True)
class Ramp:
    """The factor ``10 x^3 - 15 x^4 + 6 x^5`` from rest to a motion, with continuous accelerations.

    Attributes
    ----------
    start, duration : float
        s; with zero duration the motion is complete from the start on.
    """

    start: float
    duration: float

    def at(self, times: Vector | float) -> tuple[Vector, Vector, Vector]:
        """Return the factor and its two time derivatives at a time, or at some (T,)."""
        if self.duration == 0.0:
            none = np.zeros(np.shape(times))
            return np.where(np.less(times, self.start), 0.0, 1.0), none, none
        per = 1.0 / self.duration
        x = np.clip((times - self.start) * per, 0.0, 1.0)
        return (
            x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
            30.0 * x**2 * (1.0 - x) ** 2 * per,
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) * per**2,
        )

    def of(self, sums: np.ndarray, times: Vector) -> np.ndarray:
        """Return motions, rates and accelerations (T, 3, 6) multiplied by the ramp."""
        r, dr, ddr = (factor[:, None] for factor in self.at(times))
        x, v, a = sums.swapaxes(0, 1)
        return np.array((r * x, r * v + dr * x, r * a + 2.0 * dr * v + ddr * x)).swapaxes(0, 1)
