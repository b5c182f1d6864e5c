"""Stops along a joint coordinate that give back a share of the speed at which they are hit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Vector
from kanefe.loads.base import Action, End, Load, LoadEvent, LoadKernel, Tangent

FORCE = 0

FAR = 1e300
"""Of a limit that is none, in compiled code."""


@dataclass(frozen=True, eq=False)
class CoordinateStop(Load):
    """Limits of a coordinate, with stops that push back by ``k d max(0, 1 + lambda dd/dt)``, d beyond a limit.

    Its state is lambda (s/m), set at each touch by the speed v of the impact: ``lambda v = impact`` leaves a given
    share of it, whatever k and the masses (Hunt & Crossley 1975; `kanefe.contact.laws.normal_laws.impact_number`).

    Attributes
    ----------
    name : str
    ends : tuple of CoordinateMarker
        One.
    coordinate : str
        Of what its events are told: the body, and the coordinate where its joint has several.
    unit : str
        Of the coordinate: m or rad.
    lower, upper : float
        Infinite where there is no limit.
    stiffness : float
        k, N/m or N m/rad.
    impact : float
        lambda v.
    least_speed : float
        Impacts that are slower take lambda as of that speed, m/s or rad/s.
    first_damping : float
        lambda at the start.
    """

    name: str
    ends: tuple[CoordinateMarker, ...]
    coordinate: str = field(kw_only=True)
    unit: str = field(kw_only=True)
    lower: float = field(kw_only=True)
    upper: float = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    impact: float = field(kw_only=True)
    least_speed: float = field(kw_only=True)
    first_damping: float = field(default=0.0, kw_only=True)

    kind = "stop"
    acts_at_once = True

    @property
    def columns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Force on the body along the coordinate, and how far it is beyond a limit."""
        return "torque [N m]" if self.unit == "rad" else "force [N]", f"beyond [{self.unit}]"

    @property
    def subject(self) -> str:
        """The coordinate."""
        return self.coordinate

    @property
    def initial_states(self) -> Vector:
        """Lambda at the start."""
        return np.array((self.first_damping,))

    @property
    def has_rates(self) -> bool:
        """Lambda changes at impacts alone."""
        return False

    def started(self, t: float, ends: Sequence[End]) -> Self:
        """Return the stop with lambda as of an impact at the speed of the start, where it starts beyond a limit."""
        return replace(self, first_damping=self._damping(ends))

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return the force along the coordinate (Eq. 11)."""
        d, way, rate = self._beyond(ends), self._way(ends), self._rate(ends)
        wrench = np.zeros((1, 6))
        if d <= 0.0:
            return Action(wrench, rates=np.zeros(1))
        elastic = self.stiffness * d
        push = elastic * max(0.0, 1.0 + float(states[0]) * rate)
        wrench[0, FORCE] = -way * push
        return Action(wrench, 0.5 * elastic * d, (push - elastic) * rate, rates=np.zeros(1))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the force on the body, and how far it is beyond a limit, below zero within them."""
        return np.array((self.action(t, ends, states).wrenches[0, FORCE], self._beyond(ends)))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping beyond a limit."""
        d, rate, damping = self._beyond(ends), self._rate(ends), float(states[0])
        if d <= 0.0 or 1.0 + damping * rate <= 0.0:
            return None
        row = np.zeros((1, 6))
        row[0, FORCE] = 1.0
        k = self.stiffness
        return Tangent(row, np.array((k * (1.0 + damping * rate),)), np.array((k * d * damping,)))

    @property
    def kernel(self) -> LoadKernel:
        """Numbers: see `kanefe.kernels.force_elements.coordinate_stop`."""
        from kanefe.kernels.force_elements.coordinate_stop import coordinate_stop, coordinate_stop_watch

        numbers = np.array((*np.clip((self.lower, self.upper), -FAR, FAR), self.stiffness))
        return LoadKernel(coordinate_stop, numbers, coordinate_stop, coordinate_stop_watch)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """When it touches and lets go."""
        return LoadEvent("touch", self._depth, 1, self._touch), LoadEvent("lift", self._depth, -1)

    def _depth(self, t: float, ends: Sequence[End], states: Vector) -> float:
        return self._beyond(ends)

    def _touch(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        return np.array((self._damping(ends),))

    def _damping(self, ends: Sequence[End]) -> float:
        return self.impact / max(self._rate(ends), self.least_speed)

    def _beyond(self, ends: Sequence[End]) -> float:
        q = float(ends[0].p[0])
        return max(q - self.upper, self.lower - q)

    def _way(self, ends: Sequence[End]) -> float:
        q = float(ends[0].p[0])
        return 1.0 if q - self.upper > self.lower - q else -1.0

    def _rate(self, ends: Sequence[End]) -> float:
        """Return the speed outward."""
        return self._way(ends) * float(ends[0].v[0])
