"""Torque of a motor about the axis of a joint (or force along it): acts on the child and, reversed, on the parent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.loads.functions import Constant, SceneView


@dataclass(frozen=True, eq=False)
class JointLoad:
    """A generalised force on one speed of a joint.

    Attributes
    ----------
    label : str
        For messages and results.
    function : callable
        t, or (t, state), -> N m along an angle, N along a distance.
    coordinate : int
        Which coordinate of the joint it acts along.
    takes_state : bool
        Whether the function takes the state besides the time.
    """

    label: str
    function: Callable[..., Any]
    coordinate: int = 0
    takes_state: bool = False

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same at all times."""
        return isinstance(self.function, Constant)

    def value(self, t: float, state: SceneView | None = None) -> float:
        """Return the generalised force at time t."""
        value = np.asarray(self.function(t, state) if self.takes_state else self.function(t), dtype=float)
        if value.shape != () or not np.isfinite(value):
            raise ModelError(f"{self.label} must give one finite number; at t = {t:.6g} s it gave {value!r}")
        return float(value)
