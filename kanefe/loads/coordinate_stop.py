"""Stops along a joint coordinate with a coefficient of restitution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Vector
from kanefe.kernels.force_elements.coordinate_stop import (
    StopNumbers,
    beyond,
    coordinate_stop,
    coordinate_stop_change,
    coordinate_stop_watch,
    push_of,
)
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent
from kanefe.loads.by_kernel import ActionByKernel, EventByKernel, numbers_of, slopes

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
        touch = ActionByKernel(self, coordinate_stop_change, 0)
        return replace(self, first_damping=float(touch(t, ends, self.initial_states)[0]))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the force on the body, and the penetration of a limit, negative between the limits."""
        force = self.action(t, ends, states).wrenches[0, FORCE]
        return np.array((force, beyond(StopNumbers(self.kernel.numbers), numbers_of(ends))[0]))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping beyond a limit."""
        d, way = beyond(StopNumbers(self.kernel.numbers), numbers_of(ends))
        if d <= 0.0:
            return None
        k, c = slopes(lambda x, v: push_of(self.stiffness * x, v, states[0]), d, way * ends[0].v[0])
        row = np.zeros((1, 6))
        row[0, FORCE] = 1.0
        return Tangent(row, np.array((k,)), np.array((c,))) if k > 0.0 else None

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled functions and numbers."""
        limits = max(self.lower, -FAR), min(self.upper, FAR)
        given = filled_from(self, StopNumbers, lower=limits[0], upper=limits[1])
        watch = coordinate_stop_watch, coordinate_stop_change
        return LoadKernel(coordinate_stop, given, coordinate_stop, *watch)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Its events of touch and lift."""
        depth = EventByKernel(self, coordinate_stop_watch, 0)
        touch = ActionByKernel(self, coordinate_stop_change, 0)
        return LoadEvent("touch", depth, 1, touch), LoadEvent("lift", depth, -1)
