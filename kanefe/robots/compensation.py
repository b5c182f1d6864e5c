"""Compensation of gravity: a part of a link's weight that is lifted, and what joints hand of it to their actuators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector, cross

if TYPE_CHECKING:
    from kanefe.system import System
    from kanefe.tree.scene_state import SceneState

Lifted = tuple[str, tuple[float, float, float], float]
"""A body, its centre of mass in its frame, m, and the mass that is compensated, kg."""


@dataclass(frozen=True)
class Handed:
    """Compensation that a hinge or a slide hands to its actuators.

    They clamp its moment or force to their range, which is zero where there are none.

    Attributes
    ----------
    joint : str
    axis : ndarray, shape (3,)
        Unit vector in the joint's moving frame M.
    turns : bool
        Whether it is a hinge.
    smallest, largest : float
        Range of the actuators, N m or N.
    lifted : tuple of Lifted
        What the joint carries.
    """

    joint: str
    axis: Vector
    turns: bool
    smallest: float
    largest: float
    lifted: tuple[Lifted, ...]

    def put_on(self, scene: System, child: str) -> None:
        """Take off, along the joint of a child, what its actuators do not exert."""
        scene.add_motor(scene.body(child), _Missing(self, child, scene.gravity.copy()))


@dataclass(frozen=True)
class _Missing:
    """What a clamp leaves of a whole compensation, less that: a function of the state."""

    handed: Handed
    child: str
    gravity: Vector

    def __call__(self, t: float, state: SceneState) -> float:
        of = self.handed
        axis, anchor = state.rotation(self.child) @ of.axis, state.position(self.child)
        whole = 0.0
        for body, center, mass in of.lifted:
            force = -mass * self.gravity
            arm = state.position(body, point=center) - anchor
            whole += float(axis @ (cross(arm, force) if of.turns else force))
        return float(np.clip(whole, of.smallest, of.largest)) - whole
