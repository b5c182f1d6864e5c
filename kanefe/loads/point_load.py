"""Forces and torques on a frame of a body: known nodal forces where the frame is an interface or node (Eq. 30)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.frames import Vector, cross
from kanefe.loads.functions import Moving, SceneView
from kanefe.loads.valued_load import ValuedLoad


@dataclass(frozen=True, eq=False)
class PointLoad(ValuedLoad):
    """A force or torque at a point fixed in a frame.

    Attributes
    ----------
    label : str
        Name in messages and results.
    function : callable
        t, or (t, state), -> (3,) N or N m.
    is_torque : bool
    point : ndarray, shape (3,)
        Position from the frame's origin in its components, m.
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
    def turns(self) -> bool:
        """Whether it follows its frame, or is a torque."""
        return self.follows or self.is_torque

    def unit(self, of_joint: Sequence[str]) -> str:
        """Return N m for a torque, else N."""
        return "N m" if self.is_torque else "N"

    def advice(self, value: np.ndarray) -> str:
        """Return the remedy for a torque of one number: a motor."""
        return ". Remedy: add_motor for one number along a joint" if self.is_torque and value.shape == () else ""

    def wrench(self, t: float, frame: Moving, state: SceneView | None = None) -> tuple[Vector, Vector]:
        """Return force and moment about the frame's origin, in components of the frame."""
        value = self.value(t, state)
        if not self.follows:
            value = frame.A_NF.T @ value
        if self.is_torque:
            return np.zeros(3), value
        return value, cross(self.point, value)
