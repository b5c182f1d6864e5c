"""Stops along a joint coordinate with a coefficient of restitution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Vector
from kanefe.kernels.force_elements.blocks import flat
from kanefe.kernels.force_elements.coordinate_stop import (
    StopNumbers,
    beyond,
    coordinate_stop,
    coordinate_stop_watch,
    push_of,
)
from kanefe.kernels.force_elements.places import V
from kanefe.loads.action import End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent
from kanefe.loads.by_kernel import EventByKernel, numbers_of, slopes

FORCE = 0

FAR = 1e300
"""Value of a limit that does not exist, in compiled code."""


@dataclass(frozen=True, eq=False)
class CoordinateStop(Load):
    """Limits of a coordinate, with stop forces ``k d max(0, 1 + lambda dd/dt)``, d beyond a limit.

    Its state is lambda (s/m), set at each touch by the speed v of the impact: ``lambda v = impact`` gives the same
    coefficient of restitution for any k and masses (Hunt & Crossley 1975; `impact_number` of
    `kanefe.kernels.contact.laws.power_laws`).

    Attributes
    ----------
    name : str
    ends : tuple of CoordinateMarker
        One marker.
    coordinate : str
        Name in its events: the body, and the coordinate if its joint has several.
    unit : str
        Unit of the coordinate: m or rad.
    lower, upper : float
        Infinite where there is no limit.
    stiffness : float
        k, N/m or N m/rad.
    impact : float
        lambda v.
    least_speed : float
        Speed for lambda at slower impacts, m/s or rad/s.
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
        """Force on the body along the coordinate, and penetration of a limit."""
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
        """False: lambda changes only at impacts."""
        return False

    def started(self, t: float, ends: Sequence[End]) -> Self:
        """Return the stop with lambda of an impact at the initial speed, for a start beyond a limit."""
        return replace(self, first_damping=self._damping(ends))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the force on the body, and the penetration of a limit, negative between the limits."""
        force = self.action(t, ends, states).wrenches[0, FORCE]
        return np.array((force, beyond(self.kernel.numbers, numbers_of(ends))[0]))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping beyond a limit."""
        at = numbers_of(ends)
        d, way = beyond(self.kernel.numbers, at)
        if d <= 0.0:
            return None
        k, c = slopes(lambda x, v: push_of(self.stiffness * x, v, states[0]), d, way * at[V])
        row = np.zeros((1, 6))
        row[0, FORCE] = 1.0
        return Tangent(row, np.array((k,)), np.array((c,))) if k > 0.0 else None

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        given = StopNumbers(max(self.lower, -FAR), min(self.upper, FAR), self.stiffness)
        return LoadKernel(coordinate_stop, flat(given), coordinate_stop, coordinate_stop_watch)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Its events of touch and lift."""
        depth = EventByKernel(self, coordinate_stop_watch, 0)
        return LoadEvent("touch", depth, 1, self._touch), LoadEvent("lift", depth, -1)

    def _touch(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        return np.array((self._damping(ends),))

    def _damping(self, ends: Sequence[End]) -> float:
        at = numbers_of(ends)
        outward = beyond(self.kernel.numbers, at)[1] * at[V]
        return self.impact / max(float(outward), self.least_speed)
