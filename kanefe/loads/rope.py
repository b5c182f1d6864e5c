"""Ropes: tension over any number of points, without compression."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Vector
from kanefe.joints.motion import Motion, polyline
from kanefe.kernels.force_elements.places import WRENCH
from kanefe.kernels.force_elements.rope import (
    WOUND_UP,
    Cable,
    RopeNumbers,
    rope,
    rope_change,
    rope_watch,
    tensions,
    unstretched,
)
from kanefe.kernels.links.polynomials import POWERS
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import NO_STATES, End, LoadKernel
from kanefe.loads.along_line import AlongLine
from kanefe.loads.base import LoadEvent
from kanefe.loads.by_kernel import ActionByKernel, EventByKernel
from kanefe.loads.checks import check_number
from kanefe.loads.periodic_load import checked_history
from kanefe.loads.screened import ScreenedLoad

LOOKS = 1000
"""Number of times of a run at which the length of a rope is looked at, besides those of its table."""


@checked("name")
@dataclass(frozen=True, eq=False)
class Rope(AlongLine):
    """A massless rope from the first end to the last, over points on which it slides without friction.

    It has one tension T along its whole length. With the length l of its path and the unstretched length l0, it has the
    strain ``e = (l - l0) / l0``, and

        T = max(0, EA e + C de/dt) if e > 0, and 0 if it is slack,

    so that it never pushes. The force on each point is T times the sum of the directions to its neighbours (Eq. 11).

    A winch that pays out and draws in a rope as commanded, whatever the tension, gives l0 over time; one that holds a
    tension is `kanefe.Winch`. Its rate counts in ``de/dt = (dl/dt - (1 + e) dl0/dt) / l0``. The work of the winch
    counts as work of loads: ``-T (1 + e) dl0``, less the strain energy ``EA e**2 / 2`` of each metre that it takes in.
    What is on the winch has no mass, as the rope itself.

    A run in which a taut rope is wound up to a sheave, or to one of its ends, fails there with a message: a part of its
    way that shrinks to nothing has no direction. Events of l falling below l0 and rising above it are located on
    request, and steps then end there: ``simulate(..., events=["<name> slack", "<name> taut"])``.

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
    length : float, (times, lengths) or Motion, optional
        Unstretched length l0, m. If it is longer than the path at the start, the rope begins slack. Or l0 over time: a
        table, linear between times (s), and constant before and after, or a `kanefe.Motion`. Tables and steady motions
        stay in compiled code, and functions if they are compiled: see `Motion.compiled`.
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

    A weight that hangs on a winch is hoisted by 3 m in 6 s:

    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> weight = scene.add_point("weight", 100.0, at=(0, 0, -5), joint=kf.Prismatic("z"))
    >>> drawn_in = (1.0, 7.0), (5.0, 2.0)
    >>> scene.add(kf.Rope("hoist", (scene.ground, weight), axial_stiffness=1e6, damping=1e5, length=drawn_in))
    >>> result = scene.simulate((0.0, 8.0))
    >>> float(result.position("weight")[-1, 2].round(3)), float(result.load("hoist")[-1, 2].round(0))  # m, N
    (-2.002, 981.0)
    """

    name: str
    ends: tuple[Any, ...]
    axial_stiffness: float
    damping: float = 0.0
    length: Any = None
    preload: float | None = None
    breaking_load: float | None = None
    looks_for_slack: bool = field(default=False, init=False, repr=False)
    parts: tuple[float, ...] = field(default=(), init=False, repr=False)

    kind = "rope"
    columns = ("length [m]", "rate [m/s]", "tension [N]", "slack [1]")
    needs_rotation = False
    runs_over_ends = True

    def __post_init__(self) -> None:
        label = f"rope {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) < 2:
            raise ModelError(f"{label} needs two ends or more: the first, points on its way, the last")
        object.__setattr__(self, "ends", tuple(self.ends))
        for what in ("axial_stiffness", "damping", "preload", "breaking_load"):
            value = getattr(self, what)
            if value is not None or what in {"axial_stiffness", "damping"}:
                check_number(value, f"{what} of {label}", may_be_zero=what in {"damping", "preload"})
        if self.length is not None and self.preload is not None:
            raise ModelError(f"{label} has a length and a preload. Remedy: one of them, the other follows")
        what = f"length of rope {self.name!r}"
        if isinstance(self.length, Motion):
            self.length.check(what)
        elif isinstance(self.length, (tuple, list)) or (isinstance(self.length, np.ndarray) and self.length.ndim):
            object.__setattr__(self, "length", checked_history(self.length, what))
            self.check_during(-math.inf, math.inf)
        elif self.length is not None:
            check_number(self.length, what, may_be_zero=False)

    @cached_property
    def motions(self) -> tuple[tuple[Motion, str], ...]:
        """Its unstretched length, if it is commanded."""
        if not isinstance(self.length, (Motion, tuple)):
            return ()
        motion = self.length if isinstance(self.length, Motion) else polyline(*self.length)
        return ((motion, f"the length of rope {self.name!r}"),)

    def check_during(self, start: float, stop: float) -> None:
        """Raise a ModelError if its length is not above zero between two times (s), as far as it is known there."""
        for motion, what in self.motions:
            first, last = np.clip((start, stop), *motion.span)
            knots = np.zeros(0) if motion.pieces is None else motion.pieces[:, 0]
            knots = knots[(knots > first) & (knots < last)]
            if math.isfinite(last - first):
                knots = np.concatenate((knots, np.linspace(first, last, LOOKS)))
            times = np.unique(np.append(knots, [t for t in (first, last) if math.isfinite(t)]))
            lengths = motion.over(times, what)[:, 0]
            if np.any(lengths <= 0.0):
                i = int(np.argmax(lengths <= 0.0))
                raise ModelError(
                    f"{what} must be > 0 m, but is {lengths[i]:.6g} m at t = {times[i]:.6g} s. Remedy: all of the rope "
                    "between its ends, or a shorter run"
                )

    @property
    def exchanges_energy(self) -> bool:
        """Whether it dissipates energy, or a winch does work on it."""
        return bool(self.damping or self.breaking_load is not None or self.motions)

    @property
    def screened(self) -> ScreenedLoad:  # type: ignore[override]
        """Its tension, up to the breaking load; a commanded length is not followed."""
        refused = "lengths that are commanded" if self.motions else ""
        return ScreenedLoad(refused, "tension [N]", math.inf if self.breaking_load is None else self.breaking_load)

    @property
    def input_count(self) -> int:
        """Two with a length by functions: it, and its rate."""
        return 2 * sum(motion.pieces is None for motion, _ in self.motions)

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return unstretched length (m) and its rate (m/s) of functions."""
        return np.array(
            [motion.at(name, t, what) for motion, what in self.motions for name in ("position", "velocity")]
        )

    @property
    def input_functions(self) -> tuple[Callable[[float], float], ...]:
        """The functions of both, if they are compiled."""
        return tuple(
            function
            for motion, _ in self.motions
            for function in (motion.position, motion.velocity)
            if motion.is_compiled and function is not None
        )

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return zeros: nothing of its inputs depends on the state."""
        return np.zeros((self.input_count, len(ends), WRENCH))

    @property
    def initial_states(self) -> Vector:
        """State of a rope that can break: 1 while it holds, then 0."""
        return NO_STATES if self.breaking_load is None else np.ones(1)

    @property
    def has_rates(self) -> bool:
        """False: its state changes only at the break."""
        return False

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """That it is wound up, if it can be, its break, and on request its becoming slack and taut."""
        found: tuple[LoadEvent, ...] = (wound_up(self, rope_watch),) if self._winds else ()
        if self.looks_for_slack:
            found += slack_and_taut(self, rope_watch, len(found))
        if self.breaking_load is None:
            return found
        event = breaks(self, rope_watch, rope_change, len(found))
        # what changes states in compiled code has no inputs
        return (*found, event._replace(action=_broken) if self.input_count else event)

    @property
    def _winds(self) -> bool:
        """Whether a part of its way can shrink to nothing; one between two ends is taut at the length of the rope."""
        return len(self.ends) > 2 or bool(self.motions or self.input_count)

    def in_detail(self) -> Rope:
        """Return the rope with its slack and taut events."""
        return self._with(looks_for_slack=True)

    def _with(self, **changes: Any) -> Rope:
        return changed(self, ("looks_for_slack", "parts"), changes)

    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension, N."""
        return self._tensions(t, length, rate, states)[1]

    def _tensions(self, t: float, length: Any, rate: Any, states: Vector) -> tuple[Any, Any]:
        given = RopeNumbers(self.kernel.numbers)
        inputs = self.inputs(t, (), states) if self.input_count else NO_STATES
        return tensions(given, unstretched(t, given, inputs), length, rate, states)

    def started(self, t: float, ends: Sequence[End]) -> Rope:
        """Return the rope with its unstretched length."""
        try:
            way = self.path(t, ends).length
        except SimulationError as error:
            raise ModelError(str(error)) from None
        started = self._with(parts=parts_of(ends))
        if self.length is not None:
            self.check_at(t)
            return started
        strain = (self.preload or 0.0) / self.axial_stiffness
        return started._with(length=way / (1.0 + strain), preload=None)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return length (m), rate (m/s), tension (N) and whether it is slack (1) or not (0)."""
        length, rate, _ = self.path(t, ends)
        elastic, tension = self._tensions(t, length, rate, states)
        return np.array((length, rate, tension, float(elastic == 0.0)))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        if self.motions:
            motion, _ = self.motions[0]
            pieces, known = np.zeros((0, 1)) if motion.pieces is None else motion.pieces, motion.known
        else:
            pieces, known = np.array(((0.0, math.nan if self.length is None else self.length),)), (-math.inf, math.inf)
        powers = np.zeros((len(pieces), POWERS))
        powers[:, : pieces.shape[1] - 1] = pieces[:, 1:]
        first, last = np.nan_to_num(known)  # of what is known at all times the largest numbers: a kernel's are finite
        given = filled_from(
            self,
            RopeNumbers,
            cable=cable_of(self, self._winds),
            stiffness=self.axial_stiffness,
            inputs=self.input_count,
            first=first,
            last=last,
            pieces=len(pieces),
            table=np.concatenate((pieces[:, 0], powers.ravel(), self.parts or np.zeros(len(self.ends) - 1))),
        )
        watch = rope_watch if self.events else None
        return LoadKernel(rope, given, rope, watch, None if self.breaking_load is None else rope_change)


def _broken(t: float, ends: Sequence[End], states: Vector) -> Vector:
    """Return the state of a rope that has broken."""
    return np.zeros(1)


def slack_and_taut(load: AlongLine, watch: Callable[..., None], first: int) -> tuple[LoadEvent, LoadEvent]:
    """Return the events of a stretch that crosses zero, `first` and next among those of the load.

    Steps end there, since the force has a kink.
    """
    slack, taut = (EventByKernel(load, watch, i) for i in (first, first + 1))
    return LoadEvent("slack", slack, -1, ends_step=True), LoadEvent("taut", taut, 1, ends_step=True)


def wound_up(load: Any, watch: Callable[..., None]) -> LoadEvent:
    """Return the event of a part of its way that has shrunk to nothing, which ends the run."""

    def end(t: float, ends: Sequence[End], states: Vector) -> Vector:
        now = parts_of(ends)
        i = min(range(len(now)), key=lambda i: now[i] / load.parts[i])
        raise SimulationError(
            f"{load.kind} {load.name!r} is wound up at t = {t:.6g} s: the part of its way between its ends {i} and "
            f"{i + 1} has shrunk from {load.parts[i]:.6g} m to {WOUND_UP:g} of that, and would turn ever faster. "
            "Remedy: a stop before the sheave, such as a contact, or a shorter run"
        )

    return LoadEvent("is wound up", EventByKernel(load, watch, 0), -1, end)


def cable_of(load: Any, winds: bool) -> Vector:
    """Return what the events of a line look at: see `kanefe.kernels.force_elements.rope.Cable`."""
    return filled_from(load, Cable, ends=len(load.ends), winds=winds)


def parts_of(ends: Sequence[End]) -> tuple[float, ...]:
    """Return the lengths of the parts of a way over its ends, m."""
    return tuple(float(np.linalg.norm(b.p - a.p)) for a, b in pairwise(ends))


def changed(load: Any, kept: Sequence[str], changes: dict[str, Any]) -> Any:
    """Return a copy of a load with changes; `kept` are its fields that are not given."""
    given = {name: value for name, value in changes.items() if name not in kept}
    other = replace(load, **given)
    for name in kept:
        object.__setattr__(other, name, changes.get(name, getattr(load, name)))
    return other


def breaks(load: AlongLine, watch: Callable[..., None], change: Callable[..., None], number: int) -> LoadEvent:
    """Return the event of a tension that reaches the breaking load, by its number among those of the load."""
    return LoadEvent("breaks", EventByKernel(load, watch, number), -1, ActionByKernel(load, change, number))
