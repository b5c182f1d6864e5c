"""Winches: a cable that is paid out and drawn in to hold a given tension, such as a haul-down cable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Vector, numbers, shaped_numbers
from kanefe.kernels.force_elements.winch import WinchNumbers, tension_of, wanted_at, winch, winch_change, winch_watch
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import NO_STATES, End, LoadKernel
from kanefe.loads.along_line import AlongLine
from kanefe.loads.base import LoadEvent
from kanefe.loads.periodic_load import checked_history
from kanefe.loads.rope import breaks, cable_of, changed, parts_of, slack_and_taut, wound_up


@checked("name")
@dataclass(frozen=True, eq=False)
class Winch(AlongLine):
    """A cable from a winch at the first end over points to the last, which is paid out to hold a tension.

    The cable has the stiffness k. With the length l of its path and the length z paid out since the start,

        T = max(0, k (l - l0 - z)),  dz/dt = (T - tension) / D, but never faster than `speed`,

    so that for slow motion the tension deviates by D dl/dt from the given one. If the end moves away faster than the
    winch pays out, the cable stretches; if it approaches faster than the winch draws in, it becomes slack. The scene
    begins at the given tension. The work of the winch counts as work of loads. A run in which the taut cable is wound
    up to a point of its way fails there with a message. Events of the cable becoming slack and taut are located on
    request: ``simulate(..., events=["<name> slack", "<name> taut"])``.

    Parameters
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : tuple of Frame
        The winch, points that the cable runs over in order, the last end: two or more.
    tension : float or (times, tensions)
        Tension to be held, N; or a table, linear between times (s), and constant before and after.
    stiffness : float
        k, N/m.
    speed : float
        Largest speed of paying out and drawing in, m/s.
    damping : float
        D, increase of the tension for each m/s that is paid out, N s/m: the accuracy of the tension.
    breaking_load : float, optional
        Tension at which the cable breaks, N: the event ``"<name> breaks"`` of the result.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    A block that is drawn down against a spring:

    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> spring = kf.CoordinateForce(stiffness=1e4, damping=300.0)
    >>> block = scene.add_point("block", 50.0, at=(0, 0, 2), joint=kf.Prismatic("z", forces=spring))
    >>> cable = {"stiffness": 1e6, "damping": 500.0, "speed": 1.0}
    >>> scene.add(kf.Winch("haul-down", (scene.ground, block), tension=2000.0, **cable))
    >>> result = scene.simulate((0.0, 3.0))
    >>> float(result.position("block")[-1, 2].round(3))  # m: 2000 N over 1e4 N/m down
    1.8
    """

    name: str
    ends: tuple[Any, ...]
    tension: Any = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    speed: float = field(kw_only=True)
    damping: float = field(kw_only=True)
    breaking_load: float | None = field(default=None, kw_only=True)
    length: float = field(default=math.nan, init=False, repr=False)
    is_settled: bool = field(default=False, init=False, repr=False)
    looks_for_slack: bool = field(default=False, init=False, repr=False)
    parts: tuple[float, ...] = field(default=(), init=False, repr=False)

    kind = "winch"
    columns = ("length [m]", "paid out [m]", "rate [m/s]", "tension [N]", "slack [1]")
    needs_rotation = False
    runs_over_ends = True

    def __post_init__(self) -> None:
        label = f"winch {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) < 2:
            raise ModelError(f"{label} needs two ends or more: the winch, points on the way, the last")
        object.__setattr__(self, "ends", tuple(self.ends))
        for what in ("stiffness", "speed", "damping", "breaking_load"):
            value = getattr(self, what)
            is_given = value is not None or what != "breaking_load"
            if is_given and shaped_numbers(value, (), f"{what} of {label}") <= 0.0:
                raise ModelError(f"{what} of {label} must be > 0, not {value!r}")
        if numbers(self.tension).shape == () and np.isfinite(numbers(self.tension)):
            table = np.array((0.0, 1.0)), np.full(2, float(self.tension))
        else:
            table = checked_history(self.tension, f"tension of {label}")
        if np.any(table[1] < 0.0):
            raise ModelError(f"tension of {label} must be >= 0 N: a cable transmits no compression")
        object.__setattr__(self, "tension", table)

    @property
    def initial_states(self) -> Vector:
        """Length paid out, m; and 1 while it holds, if it can break."""
        if self.is_settled:
            return NO_STATES
        return np.zeros(1) if self.breaking_load is None else np.array((0.0, 1.0))

    def state_scales(self, acceleration: float) -> Vector:
        """Return the elongation of the cable under the highest tension."""
        return np.array((max(float(self.tension[1].max()) / self.stiffness, 1e-6), 1.0))[: len(self.initial_states)]

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """That it is wound up, its break, if it can break, and on request its becoming slack and taut."""
        if self.is_settled:
            return ()
        found = (wound_up(self, winch_watch), *(slack_and_taut(self, winch_watch, 1) if self.looks_for_slack else ()))
        if self.breaking_load is None:
            return found
        return (*found, breaks(self, winch_watch, winch_change, len(found)))

    def in_detail(self) -> Winch:
        """Return the winch with its slack and taut events."""
        return self._with(looks_for_slack=True)

    def wanted(self, t: float) -> float:
        """Return the tension to be held at time t (s), N."""
        return float(wanted_at(t, WinchNumbers(self.kernel.numbers)))

    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension, N."""
        return tension_of(t, WinchNumbers(self.kernel.numbers), length, states)

    def started(self, t: float, ends: Sequence[End]) -> Winch:
        """Return the winch with the length of cable for its tension."""
        try:
            way = self.path(t, ends).length
        except SimulationError as error:
            raise ModelError(str(error)) from None
        return self._with(length=way - self.wanted(t) / self.stiffness, parts=parts_of(ends))

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Winch:
        """Return a cable with the given tension at any length."""
        return self._with(is_settled=True)

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the length paid out at the given tension."""
        out = self.path(0.0, ends).length - self.length - self.wanted(0.0) / self.stiffness
        return np.append(out, states[1:])

    def _with(self, **changes: Any) -> Winch:
        return changed(self, ("length", "is_settled", "looks_for_slack", "parts"), changes)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return length of the path (m), length paid out (m), rate (m/s), tension (N), and whether it is slack (1)."""
        length, rate, _ = self.path(t, ends)
        out = 0.0 if self.is_settled else float(states[0])
        pull = self.pull(t, length, rate, states)
        return np.array((length, out, rate, pull, float(pull == 0.0)))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        table = np.concatenate((*self.tension, self.parts or np.zeros(len(self.ends) - 1)))
        cable, size = cable_of(self, winds=True), len(self.tension[0])
        given = filled_from(self, WinchNumbers, cable=cable, table_size=size, table=table)
        watch = None if self.is_settled else winch_watch
        return LoadKernel(winch, given, winch, watch, None if self.breaking_load is None else winch_change)
