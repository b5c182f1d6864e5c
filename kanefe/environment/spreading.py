"""Directional spreading of waves about the main direction, within 90 degrees on either side."""

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
"""Largest standard deviation, degrees: the truncation at 90 degrees dominates larger ones."""


@dataclass(frozen=True)
class Spreading:
    """A distribution of directions: ``cos^power``, or a wrapped normal one.

    Parameters
    ----------
    power : float, optional
        2 is usual for wind seas.
    deviation_deg : float, optional
        Standard deviation of the normal distribution, degrees, truncated at 90 degrees. Without both arguments all
        waves come from one direction.

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
                "waves spread by a power of the cosine or by a normal distribution, not both. "
                "Remedy: spreading= or spreading_deg="
            )
        for name in ("power", "deviation_deg"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, checked_number(value, "the spreading of waves", above=0.0))
        if self.deviation_deg is not None and self.deviation_deg > WIDEST:
            raise ModelError(
                f"waves do not spread by {self.deviation_deg:g} degrees: it is truncated at 90. Remedy: a "
                f"standard deviation of {WIDEST:g} degrees or less, or a power"
            )

    @property
    def is_long_crested(self) -> bool:
        """Whether all waves come from one direction."""
        return self.power is None and self.deviation_deg is None

    @property
    def title(self) -> str:
        """Description for messages."""
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
        """Return the angles to the main direction (degrees) below which given shares of the energy are, (n,).

        They are the same for all frequencies.
        """
        if self.is_long_crested:
            return np.zeros_like(share)
        angles, below = self._table
        return np.asarray(np.interp(share, below, angles))
