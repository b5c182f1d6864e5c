"""Springs and dampers along the line between two markers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.errors import ModelError


@dataclass(frozen=True, eq=False)
class SpringDamper:
    """A force along the line of two markers; its tension pulls them together.

    ``k (length - rest_length) + c rate``, or instead of the first term a table or a function of the user.

    Attributes
    ----------
    name : str
    a, b : Marker
    stiffness, damping : float
        N/m and N s/m.
    rest_length : float
        m.
    lengths, forces : ndarray, shape (n,)
        Table of the tension, m and N, straight between its points and beyond its ends; empty: none.
    function : callable or None
        (length, rate) -> tension, in m, m/s and N.
    """

    name: str
    a: Marker
    b: Marker
    stiffness: float
    damping: float
    rest_length: float
    lengths: np.ndarray
    forces: np.ndarray
    function: Callable[[float, float], Any] | None

    @property
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene or gives it."""
        return bool(self.damping or len(self.lengths) or self.function is not None)

    def tension(self, t: float, length: float, rate: float) -> float:
        """Return the tension in N at a length (m) and its rate (m/s)."""
        return self.stiffness * (length - self.rest_length) + self.damping * rate + self.given(t, length, rate)

    def given(self, t: float, length: float, rate: float) -> float:
        """Return the part of the tension that the table or the user's function gives, N."""
        if self.function is not None:
            value = np.asarray(self.function(length, rate), dtype=float)
            if value.shape != () or not np.isfinite(value):
                raise ModelError(
                    f"the force of spring {self.name!r} must be one finite number; at t = {t:.6g} s, length "
                    f"{length:.6g} m and rate {rate:.6g} m/s it was {value!r}"
                )
            return float(value)
        if not len(self.lengths):
            return 0.0
        i = min(max(int(np.searchsorted(self.lengths, length)), 1), len(self.lengths) - 1)
        slope = (self.forces[i] - self.forces[i - 1]) / (self.lengths[i] - self.lengths[i - 1])
        return float(self.forces[i - 1] + slope * (length - self.lengths[i - 1]))

    def slope(self, length: float) -> float:
        """Return the stiffness at a length, N/m; none is known of a user's function."""
        if not len(self.lengths):
            return self.stiffness
        i = min(max(int(np.searchsorted(self.lengths, length)), 1), len(self.lengths) - 1)
        return float((self.forces[i] - self.forces[i - 1]) / (self.lengths[i] - self.lengths[i - 1]))

    def potential(self, length: float) -> float:
        """Return the energy of the linear spring at a length (m), J."""
        return 0.5 * self.stiffness * (length - self.rest_length) ** 2

    def dissipation(self, rate: float) -> float:
        """Return the power that the damper takes, W."""
        return self.damping * rate * rate
