"""Ropes: tension over any number of points, without compression."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Vector
from kanefe.kernels.force_elements.blocks import flat
from kanefe.kernels.force_elements.rope import RopeNumbers, rope, rope_change, rope_watch, tensions
from kanefe.loads.action import NO_STATES, End, LoadKernel
from kanefe.loads.along_line import AlongLine
from kanefe.loads.base import LoadEvent
from kanefe.loads.by_kernel import ActionByKernel, EventByKernel
from kanefe.loads.checks import check_number


@checked("name")
@dataclass(frozen=True, eq=False)
class Rope(AlongLine):
    """A massless rope from the first end to the last, over points on which it slides without friction.

    It has one tension T along its whole length. With the length l of its path and the unstretched length l0,

        T = max(0, EA (l - l0) / l0 + C dl/dt / l0) if l > l0, and 0 if it is slack,

    so that it never pushes. The force on each point is T times the sum of the directions to its neighbours (Eq. 11).

    Events of l falling below l0 and rising above it are located on request, and steps then end there:
    ``simulate(..., events=["<name> slack", "<name> taut"])``.

    Attributes
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : tuple of Frame
        The first end, the points that it runs over in order, the last end: two or more.
    axial_stiffness : float
        EA, N.
    damping : float
        C, N s: tension for a rate of strain of 1/s.
    length : float, optional
        Unstretched length, m. If it is longer than the path at the start, the rope begins slack.
    preload : float, optional
        Tension at the start, N, instead of the length; neither: taut without tension.
    breaking_load : float, optional
        Tension at which it breaks, N: then it has no force, and its energy counts as dissipated. The time is that of
        the event ``"<name> breaks"`` in the result.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    Two weights on a rope over a beam; the heavier one lifts the other:

    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> light = scene.add_point("light", 1.0, joint=kf.Prismatic("z", position=-1.0))
    >>> heavy = scene.add_point("heavy", 2.0, joint=kf.Prismatic("z", position=-1.0), at=(1, 0, 0))
    >>> beam = [scene.ground.frame(at=(x, 0, 0)) for x in (0.0, 1.0)]
    >>> scene.add(kf.Rope("rope", (light, *beam, heavy), axial_stiffness=1e6, damping=2e3))
    >>> result = scene.simulate((0.0, 0.4))
    >>> float(result.load("rope")[-1, 2].round(1))  # N: 2 m1 m2 g / (m1 + m2)
    13.1
    """

    name: str
    ends: tuple[Any, ...]
    axial_stiffness: float
    damping: float = 0.0
    length: float | None = None
    preload: float | None = None
    breaking_load: float | None = None
    looks_for_slack: bool = field(default=False, init=False, repr=False)

    kind = "rope"
    columns = ("length [m]", "rate [m/s]", "tension [N]", "slack [1]")
    needs_rotation = False
    runs_over_ends = True
    pull_column = "tension [N]"

    def __post_init__(self) -> None:
        label = f"rope {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) < 2:
            raise ModelError(f"{label} needs two ends or more: the first, points on its way, the last")
        object.__setattr__(self, "ends", tuple(self.ends))
        for what in ("axial_stiffness", "damping", "length", "preload", "breaking_load"):
            value = getattr(self, what)
            if value is not None or what in {"axial_stiffness", "damping"}:
                check_number(value, f"{what} of {label}", may_be_zero=what in {"damping", "preload"})
        if self.length is not None and self.preload is not None:
            raise ModelError(f"{label} has a length and a preload. Remedy: one of them, the other follows")

    @property
    def slack_length(self) -> float:
        """Length without tension, m; NaN: determined at the start of a scene."""
        return math.nan if self.length is None else self.length

    @property
    def exchanges_energy(self) -> bool:
        """Whether it dissipates energy."""
        return bool(self.damping or self.breaking_load is not None)

    @property
    def initial_states(self) -> Vector:
        """State of a rope that can break: 1 while it holds, then 0."""
        return NO_STATES if self.breaking_load is None else np.ones(1)

    @property
    def strongest_pull(self) -> float:  # type: ignore[override]
        """The breaking load, if there is one."""
        return math.inf if self.breaking_load is None else self.breaking_load

    @property
    def has_rates(self) -> bool:
        """False: its state changes only at the break."""
        return False

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Its break, if it can break, and on request its becoming slack and taut."""
        found: tuple[LoadEvent, ...] = slack_and_taut(self, rope_watch) if self.looks_for_slack else ()
        if self.breaking_load is None:
            return found
        return (*found, breaks(self, rope_watch, rope_change, len(found)))

    def in_detail(self) -> Rope:
        """Return the rope with its slack and taut events."""
        other = replace(self)
        object.__setattr__(other, "looks_for_slack", True)
        return other

    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension, N."""
        return tensions(self.kernel.numbers, length, rate, states)[1]

    def started(self, t: float, ends: Sequence[End]) -> Rope:
        """Return the rope with its unstretched length."""
        try:
            way = self.path(t, ends).length
        except SimulationError as error:
            raise ModelError(str(error)) from None
        if self.length is not None:
            return self
        strain = (self.preload or 0.0) / self.axial_stiffness
        return replace(self, length=way / (1.0 + strain), preload=None)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return length (m), rate (m/s), tension (N) and whether it is slack (1) or not (0)."""
        length, rate, _ = self.path(t, ends)
        elastic, tension = tensions(self.kernel.numbers, length, rate, states)
        return np.array((length, rate, tension, float(elastic == 0.0)))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        l0 = self.slack_length
        law = self.axial_stiffness / l0, self.damping / l0, l0, self.breaking_load or 0.0, self.looks_for_slack
        looks = line_watch(self.breaking_load is not None, self.looks_for_slack, rope_watch, rope_change)
        return LoadKernel(rope, flat(RopeNumbers(len(self.ends), *law)), rope, *looks)


def slack_and_taut(load: AlongLine, watch: Callable[..., None]) -> tuple[LoadEvent, LoadEvent]:
    """Return the events of a stretch that crosses zero; steps end there, since the force has a kink."""
    slack, taut = (EventByKernel(load, watch, i) for i in (0, 1))
    return LoadEvent("slack", slack, -1, ends_step=True), LoadEvent("taut", taut, 1, ends_step=True)


def line_watch(
    breaks: bool, looks_for_slack: bool, watch: Callable[..., None], change: Callable[..., None]
) -> tuple[Callable[..., None] | None, Callable[..., None] | None]:
    """Return the functions of a line for its events, as far as it has any: see `LoadKernel`."""
    return watch if breaks or looks_for_slack else None, change if breaks else None


def breaks(load: AlongLine, watch: Callable[..., None], change: Callable[..., None], number: int) -> LoadEvent:
    """Return the event of a tension that reaches the breaking load, by its number among those of the load."""
    return LoadEvent("breaks", EventByKernel(load, watch, number), -1, ActionByKernel(load, change, number))
