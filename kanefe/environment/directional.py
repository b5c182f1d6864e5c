"""Spectra over frequency and direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.environment.spectra import Tabulated
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers

UNEVEN = 1e-3
"""Largest relative difference between the steps of the directions."""


@dataclass(frozen=True, eq=False)
class DirectionalTable:
    """Distributions of directions, one for each frequency of a table, interpolated linearly.

    Parameters
    ----------
    frequencies : ndarray, shape (n,)
        rad/s.
    edges_deg : ndarray, shape (m + 1,)
        Angles from the main direction between the bins of directions, degrees, increasing.
    below : ndarray, shape (n, m + 1)
        Share of the energy of each frequency below each edge.
    main_deg : float
        Main compass direction from which waves come, degrees.
    """

    frequencies: Vector
    edges_deg: Vector
    below: Matrix
    main_deg: float

    is_long_crested = False

    @property
    def title(self) -> str:
        """Description for messages."""
        return f"{len(self.edges_deg) - 1} directions about {self.main_deg:.4g} degrees"

    def quantile_at(self, omega: Vector, share: Vector) -> Vector:
        """Return the angles to the main direction (degrees) below which given shares of the energy are, (n,)."""
        omega, share = np.broadcast_arrays(omega, share)
        place = np.clip(np.interp(omega, self.frequencies, np.arange(len(self.frequencies))), 0, len(self.below) - 1)
        low = np.minimum(place.astype(int), len(self.below) - 2)
        rest = (place - low)[:, None]
        rows = (1.0 - rest) * self.below[low] + rest * self.below[low + 1]
        return np.array([np.interp(s, row, self.edges_deg) for s, row in zip(share, rows, strict=True)])


def of_compass(frequencies: Any, densities: Any, directions_deg: Any) -> tuple[Tabulated, DirectionalTable]:
    """Return the spectrum over frequency and the distributions of directions; see `Sea.measured`.

    Raises
    ------
    ModelError
        If shapes differ, directions are not evenly spaced over the circle, or a density is negative or not finite.
    """
    w, table, directions = numbers(frequencies), numbers(densities), numbers(directions_deg)
    if w.ndim != 1 or directions.ndim != 1 or table.shape != (len(w), len(directions)) or len(directions) < 3:
        raise ModelError(
            f"a spectrum over directions needs densities of shape (frequencies, directions) and three directions at "
            f"least; shapes {w.shape}, {directions.shape} and {table.shape} were given"
        )
    if not np.all(np.isfinite(table)) or not np.all(np.isfinite(directions)):
        raise ModelError("a spectrum over directions contains something that is not a finite number")
    if np.any(table < 0.0):
        i, j = np.unravel_index(int(np.argmin(table)), table.shape)
        raise ModelError(
            f"a wave spectrum cannot be negative, but it is {table[i, j]:.6g} m2 s/(rad degree) at {w[i]:.6g} rad/s "
            f"and {directions[j]:.6g} degrees. Remedy: check the data; where it is due to smoothing, set it to zero"
        )
    order = np.argsort(directions % 360.0)
    directions, table = directions[order] % 360.0, table[:, order]
    step = 360.0 / len(directions)
    if np.any(abs(np.diff(directions, append=directions[0] + 360.0) - step) > UNEVEN * step):
        raise ModelError(
            "the directions of a spectrum must be even over the whole circle, each once. Remedy: interpolate them; "
            "leave out 360 where there is 0"
        )
    over_frequency = np.sum(table, axis=1) * step
    widths = np.gradient(w)
    mean = np.sum(widths[:, None] * table * np.exp(1j * np.radians(directions)))
    if abs(mean) < 1e-6 * np.sum(widths * over_frequency) / step:
        raise ModelError("the waves of a spectrum come equally from all sides: there is no main direction")
    main = float(np.degrees(np.angle(mean)) % 360.0)
    # counter-clockwise from the main direction; the bin opposite of it is the first and, in part, the last
    angles = (main - directions + 180.0) % 360.0 - 180.0
    order = np.argsort(angles)
    edges = np.append(angles[order] - 0.5 * step, angles[order][-1] + 0.5 * step)
    below = np.cumsum(np.column_stack((np.zeros(len(w)), table[:, order])), axis=1)
    # frequencies without waves may have any distribution
    below[below[:, -1] == 0.0] = np.linspace(0.0, 1.0, below.shape[1])
    return (
        Tabulated(w, over_frequency, "measured"),
        DirectionalTable(w, edges, below / below[:, -1:], main),
    )
