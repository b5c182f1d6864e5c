"""Which small motions at a balance grow: eigenvalues of stiffness and damping in coordinates of unit mass."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.frames import Matrix, Vector

GROWS = 1e-9
"""Growth of a mode, relative to its eigenvalue, above which it counts: less may be round-off."""

ROUNDED = 1e-13
"""Eigenvalue relative to the largest that is round-off, and whose growth is meaningless."""

EQUAL = 1e-7
"""Imaginary part of an eigenvalue relative to its size that may be round-off of two equal ones: the root of round-off.
"""

LARGEST = 700.0
"""Largest logarithm of a number that does not overflow."""


@dataclass(frozen=True, eq=False)
class MotionSpectrum:
    """The motions of ``p'' + D p' + H p = 0``; D is None without damping.

    Attributes
    ----------
    H : ndarray, shape (n, n)
        1/s2.
    D : ndarray, shape (n, n), or None
        1/s.
    along : ndarray, shape (free, n)
        Free tangents of the coordinates p.
    """

    H: Matrix
    D: Matrix | None
    along: Matrix

    def between(self, other: MotionSpectrum, share: float) -> MotionSpectrum:
        """Return what is linear between this spectrum (share 0) and another one (1)."""
        # the coordinates of each are any of unit mass: those of the other one in terms of these
        Q = np.linalg.lstsq(other.along, self.along, rcond=None)[0]

        def mixed(one: Matrix, another: Matrix) -> Matrix:
            return np.asarray((1.0 - share) * one + share * np.linalg.solve(Q, another @ Q))

        D = None if self.D is None or other.D is None else mixed(self.D, other.D)
        return MotionSpectrum(mixed(self.H, other.H), D, self.along)

    @cached_property
    def rates(self) -> Vector:
        """Eigenvalues of the motions, 1/s; those without damping come in pairs of both signs."""
        if self.D is not None:
            n, none = len(self.H), np.zeros_like(self.H)
            return np.asarray(np.linalg.eigvals(np.block([[none, np.eye(n)], [-self.H, -self.D]])))
        rates = np.sqrt(-np.linalg.eigvals(self.H).astype(complex))
        return np.concatenate((rates, -rates))

    @cached_property
    def growths(self) -> Vector:
        """Growth of each motion, less what may be round-off, 1/s."""
        sizes = np.abs(self.rates)
        return np.asarray(self.rates.real - np.maximum(GROWS * sizes, ROUNDED * sizes.max(initial=0.0)))

    @cached_property
    def unstable(self) -> int:
        """Number of growing motions."""
        return int((self.growths > 0.0).sum())

    @cached_property
    def is_inverted(self) -> bool:
        """Whether the determinant of the stiffness is negative."""
        return bool(np.linalg.slogdet(self.H)[0] < 0.0)

    def determinant(self, unit: MotionSpectrum) -> float:
        """Return the determinant of the stiffness relative to the size of that of another one."""
        (sign, size), (_, one) = np.linalg.slogdet(self.H), np.linalg.slogdet(unit.H)
        return float(sign * np.exp(min(size - one, LARGEST)))

    def smallest(self, count: int) -> float:
        """Return the sum of the smallest stiffnesses, 1/s2."""
        values = np.linalg.eigvals(self.H)
        return float(values[np.abs(values).argsort()[:count]].sum().real)

    @cached_property
    def oscillating(self) -> int:
        """Number of growing motions that oscillate."""
        return int(((self.growths > 0.0) & (np.abs(self.rates.imag) > EQUAL * np.abs(self.rates))).sum())

    def flutters(self, number: int, near: complex) -> tuple[float, complex]:
        """Return a measure of whether more than a number of motions grow, smooth where that begins; and an eigenvalue.

        It is positive where they do. With damping it is the growth of the next motion. Without, two stiffnesses meet
        and become complex there, and it is the square of half their difference, with its sign changed: of the pair
        that grows least, else of the one nearest to `near`, the stiffness that was returned where they grew.
        """
        at = self.growths.argsort()[::-1][number]
        if self.D is not None:
            return float(self.growths[at]), near
        if self.growths[at] > 0.0:
            stiffness = complex(-(self.rates[at] ** 2))
            return stiffness.imag**2 or abs(stiffness) ** 2, stiffness
        values = np.linalg.eigvals(self.H)
        real = np.sort(values.real[values.imag == 0.0])
        if len(real) < 2:
            return -(abs(near) ** 2), near
        pair = np.abs(0.5 * (real[1:] + real[:-1]) - near.real).argmin()
        return -float(0.25 * (real[pair + 1] - real[pair]) ** 2), near
