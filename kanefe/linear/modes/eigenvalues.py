"""Properties of modes from eigenvalues: frequencies, damping, and which of them grow."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector

GROWTH, ROUND_OFF = 1e-9, 1e-13
"""Growth or decay below which it counts as zero: relative to the eigenvalue, and relative to the largest eigenvalue."""


def growth_noise(values: np.ndarray, of_all: np.ndarray) -> np.ndarray:
    """Return the growth or decay (1/s) of each eigenvalue that is round-off, given all eigenvalues."""
    return np.asarray(np.maximum(GROWTH * np.abs(values), ROUND_OFF * np.abs(of_all).max(initial=0.0)))


class OfEigenvalues:
    """Modes that vibrate with ``exp(lambda t)``.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (modes,)
        1/s.
    is_rigid : ndarray of bool, shape (modes,)
        Whether there is no restoring force.
    """

    eigenvalues: np.ndarray
    is_rigid: np.ndarray

    @property
    def frequencies(self) -> Vector:
        """Damped frequencies, abs(Im lambda) / 2 pi, Hz; zero for modes without oscillation."""
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    @property
    def damping_ratios(self) -> Vector:
        """``-Re lambda / |lambda|``, 1 for critical damping; negative: the mode grows. Zero for rigid motions."""
        size = np.abs(self.eigenvalues)
        return np.asarray(np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=~self.is_rigid))

    @property
    def grows(self) -> np.ndarray:
        """Whether each mode grows with time."""
        return np.asarray(~self.is_rigid & (self.eigenvalues.real > self._noise))

    @property
    def _noise(self) -> np.ndarray:
        return growth_noise(self.eigenvalues, self.eigenvalues)

    @property
    def is_stable(self) -> bool:
        """Whether no mode grows; rigid motions do not count."""
        return not bool(self.grows.any())
