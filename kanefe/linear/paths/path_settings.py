"""The range, the step and the number of points of a path, checked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers

WHAT = "equilibrium_path"

SMALLEST = 1e-30
"""Smallest factor of loads to which a path leads, relative to the loads as given (1)."""


class Settings(NamedTuple):
    """Factors at which a path ends, its longest step, and its largest number of points."""

    to: float
    down_to: float
    longest: float
    points: int

    @property
    def bounds(self) -> tuple[float, float]:
        """Of the factor, ascending."""
        return min(self.to, self.down_to), max(self.to, self.down_to)


def settings_of(to: float, down_to: float | None, longest: float, points: int) -> Settings:
    """Return the settings of a path; a ModelError names what is not valid."""
    end = numbers(to)
    if end.shape != () or not SMALLEST <= abs(end) <= 1.0 / SMALLEST:
        raise ModelError(
            f"{WHAT}: to must be a factor other than zero, of {SMALLEST:g} to {1.0 / SMALLEST:g} in size, not {to!r}"
        )
    other = -end if down_to is None else numbers(down_to)
    if other.shape != () or not np.isfinite(other) or other * end > 0.0:
        raise ModelError(f"{WHAT}: down_to must be zero or of the other sign than to = {to!r}, not {down_to!r}")
    step = numbers(longest)
    if step.shape != () or not 0.0 < step <= 1.0:
        raise ModelError(f"{WHAT}: longest must be above 0 and at most 1 rad or scene length, not {longest!r}")
    if isinstance(points, bool) or points < 2:
        raise ModelError(f"{WHAT}: points must be a whole number of at least 2, not {points!r}")
    return Settings(float(end), float(other), float(step), int(points))
