"""Torque of a motor about the axis of a joint (or force along it): acts on the child and, reversed, on the parent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError


@dataclass(frozen=True, eq=False)
class JointLoad:
    """A generalised force on the one speed of a joint.

    Attributes
    ----------
    label : str
        For messages and results.
    function : callable
        t -> N m (revolute) or N (prismatic).
    """

    label: str
    function: Callable[[float], float]

    def value(self, t: float) -> float:
        """Return the generalised force at time t."""
        value = np.asarray(self.function(t), dtype=float)
        if value.shape != () or not np.isfinite(value):
            raise ModelError(f"{self.label} must give one finite number; at t = {t:.6g} s it gave {value!r}")
        return float(value)
