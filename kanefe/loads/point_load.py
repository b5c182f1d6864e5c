"""Forces and torques on a frame of a body: known nodal forces where the frame is an interface or node (Eq. 30)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, cross
from kanefe.loads.functions import Constant, Moving, SceneView


@dataclass(frozen=True, eq=False)
class PointLoad:
    """A force or torque at a point fixed in a frame.

    Attributes
    ----------
    label : str
        For messages and results.
    function : callable
        t, or (t, state), -> (3,) N or N m.
    is_torque : bool
    point : ndarray, shape (3,)
        From the frame's origin in its components, m.
    follows : bool
        True: components of the frame itself (a following load); False: components of N.
    takes_state : bool
        Whether the function takes the state besides the time.
    """

    label: str
    function: Callable[..., Any]
    is_torque: bool
    point: np.ndarray
    follows: bool
    takes_state: bool = False

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same at all times."""
        return isinstance(self.function, Constant)

    def value(self, t: float, state: SceneView | None = None) -> Vector:
        """Return the three numbers of the load at time t, N or N m."""
        value = np.asarray(self.function(t, state) if self.takes_state else self.function(t), dtype=float)
        if value.shape != (3,) or not np.all(np.isfinite(value)):
            raise ModelError(f"{self.label} must give three finite numbers; at t = {t:.6g} s it gave {value!r}")
        return value

    def wrench(self, t: float, frame: Moving, state: SceneView | None = None) -> tuple[Vector, Vector]:
        """Return force and moment about the frame's origin, in components of the frame."""
        value = self.value(t, state)
        if not self.follows:
            value = frame.A_NF.T @ value
        if self.is_torque:
            return np.zeros(3), value
        return value, cross(self.point, value)
