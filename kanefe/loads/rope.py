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
from kanefe.frames import Vector, numbers
from kanefe.kernels.force_elements.blocks import flat
from kanefe.kernels.force_elements.rope import RopeNumbers, rope, rope_change, rope_watch, tensions
from kanefe.loads.action import NO_STATES, End, LoadKernel
from kanefe.loads.along_line import AlongLine
from kanefe.loads.base import LoadEvent
from kanefe.loads.by_kernel import ActionByKernel, EventByKernel


@checked("name")
@dataclass(frozen=True, eq=False)
class Rope(AlongLine):
    """A rope without mass from the first end over points on which it slides without friction to the last.

    One tension T acts along the whole of it: with the way l along its points and the unstretched length l0,

        T = max(0, EA (l - l0) / l0 + C dl/dt / l0) where l > l0, and 0 where it is slack,

    so that it never pushes. Each point feels T times the sum of the directions to its neighbours (Eq. 11).

    A run that asks for them tells when l falls below l0 and rises above it:
    ``simulate(..., events=["<name> slack", "<name> taut"])``. Its steps then end there.

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
        Unstretched, m. Longer than the way at the start: the rope begins slack.
    preload : float, optional
        Tension at the start, N, in place of the length; neither: taut without tension.
    breaking_load : float, optional
        Tension at which it breaks, N: it is gone from then on, and its energy counts as dissipated. The moment is the
        event ``"<name> breaks"`` of the result.

    Raises
    ------
    ModelError
        Naming what is wrong with the rope.

    Examples
    --------
    A weight on a rope over a beam, and another that draws it up:

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
        for what, value, least in (
            ("axial_stiffness", self.axial_stiffness, ">"),
            ("damping", self.damping, ">="),
            ("length", self.length, ">"),
            ("preload", self.preload, ">="),
            ("breaking_load", self.breaking_load, ">"),
        ):
            if value is None and what not in {"axial_stiffness", "damping"}:
                continue
            number = numbers(value)
            if not (number.shape == () and np.isfinite(number) and (number > 0 or (number == 0 and least == ">="))):
                raise ModelError(f"{what} of {label} must be one number, finite and {least} 0, not {value!r}")
        if self.length is not None and self.preload is not None:
            raise ModelError(f"{label} has a length and a preload. Remedy: one of them, the other follows")

    @property
    def slack_length(self) -> float:
        """Length without tension, m; NaN: known where a scene starts."""
        return math.nan if self.length is None else self.length

    @property
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene."""
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
        """It breaks at once."""
        return False

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Its end, where it can break; where a run asks for it, that it becomes slack and taut."""
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
        """Its kernel."""
        l0 = self.slack_length
        law = self.axial_stiffness / l0, self.damping / l0, l0, self.breaking_load or 0.0, self.looks_for_slack
        looks = line_watch(self.breaking_load is not None, self.looks_for_slack, rope_watch, rope_change)
        return LoadKernel(rope, flat(RopeNumbers(len(self.ends), *law)), rope, *looks)


def slack_and_taut(load: AlongLine, watch: Callable[..., None]) -> tuple[LoadEvent, LoadEvent]:
    """Return the events of a stretch that passes zero; a force begins or ends there, and so does a step."""
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
