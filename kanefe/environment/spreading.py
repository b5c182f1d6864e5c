"""How the energy of waves spreads over directions about the main one, within 90 degrees to either side."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.environment.checks import checked_number
from kanefe.errors import ModelError
from kanefe.frames import Vector

POINTS = 3601
"""Number of points in the table of the distribution: a spacing of a twentieth of a degree."""


WIDEST = 90.0
"""Standard deviation above which hardly more than the truncation of a normal distribution is left, degrees."""


@dataclass(frozen=True)
class Spreading:
    """A distribution of directions: ``cos^power``, or a wrapped normal one.

    Parameters
    ----------
    power : float, optional
        2 is usual for wind seas.
    deviation_deg : float, optional
        Standard deviation of the normal distribution, degrees; what lies beyond 90 degrees is left out.
        Neither: all waves come from one direction.

    Raises
    ------
    ModelError
        If both are given, one is not above zero, or the deviation is above 90 degrees.
    """

    power: float | None = None
    deviation_deg: float | None = None

    def __post_init__(self) -> None:
        if self.power is not None and self.deviation_deg is not None:
            raise ModelError(
                "waves spread by a power of the cosine or by a normal distribution, not by both. "
                "Remedy: spreading= or spreading_deg="
            )
        for value in (self.power, self.deviation_deg):
            if value is not None:
                checked_number(value, "the spreading of waves", above=0.0)
        if self.deviation_deg is not None and self.deviation_deg > WIDEST:
            raise ModelError(
                f"waves do not spread by {self.deviation_deg:g} degrees: what lies beyond 90 is left out. Remedy: a "
                f"standard deviation of {WIDEST:g} degrees or less, or a power"
            )

    @property
    def is_long_crested(self) -> bool:
        """Whether all waves come from one direction."""
        return self.power is None and self.deviation_deg is None

    @property
    def title(self) -> str:
        """What it is."""
        if self.power is not None:
            return f"spread by cos^{self.power:g}"
        return "long-crested" if self.deviation_deg is None else f"spread by {self.deviation_deg:g} degrees"

    @cached_property
    def _table(self) -> tuple[Vector, Vector]:
        """Angles in degrees, and the share of the energy below them."""
        angles = np.linspace(-90.0, 90.0, POINTS)
        if self.power is not None:
            density = np.cos(np.radians(angles[1:-1])) ** self.power
            density = np.concatenate(((0.0,), density, (0.0,)))
        else:
            density = np.exp(-0.5 * (angles / (self.deviation_deg or 1.0)) ** 2)
        share = np.concatenate(((0.0,), np.cumsum(0.5 * (density[1:] + density[:-1]))))
        return angles, share / share[-1]

    def quantile_at(self, omega: Vector, share: Vector) -> Vector:
        """Return angles to the main direction (degrees) below which shares of the energy come from, (n,).

        Those of all frequencies are the same here.
        """
        if self.is_long_crested:
            return np.zeros_like(share)
        angles, below = self._table
        return np.asarray(np.interp(share, below, angles))
