"""Interface of loads between frames, also for loads of users."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Vector
from kanefe.loads.action import NO_STATES, Action, End, LoadKernel, Tangent
from kanefe.loads.by_kernel import numbers_of, resistances, written_by
from kanefe.loads.screened import ScreenedLoad

if TYPE_CHECKING:
    from kanefe.joints.motion import Motion
    from kanefe.loads.anchors import Anchor
    from kanefe.loads.reach import LoadReach


JUST_AFTER = 1e-9
"""Time relative to that of a failure (s, or 1 s) up to which its cause is looked for."""


class HeldCoordinates(NamedTuple):
    """Upper bounds for a load along joint coordinates while it holds them.

    Attributes
    ----------
    stiffness, damping : tuple of float
        Along each coordinate, N/m or N m/rad; N s/m or N m s/rad.
    rate : float
        Fastest rate of its internal states, 1/s.
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    rate: float


CONTACT_KINDS = "contact", "rigid contact", "rigid contacts"
"""Kinds of loads that are contacts."""


def has_contacts(loads: Iterable[Load]) -> bool:
    """Return whether there may be contacts among loads; scenes without them do not import what they are."""
    return any(load.kind in CONTACT_KINDS for load in loads)


class LoadEvent(NamedTuple):
    """An event of a load: its function crosses zero.

    Attributes
    ----------
    name : str
        Follows the name of the load in the result.
    function : callable
        (t, ends, states) -> number.
    direction : -1, 0 or 1
        Only falling crossings, all, or only rising ones.
    action : callable or None
        (t, ends, states) -> the internal states after the event.
    ends_step : bool
        Whether a step ends there also without an action, as at a jump of a force; not repeatedly at the same time.
    """

    name: str
    function: Callable[[float, Sequence[End], Vector], float]
    direction: int = 0
    action: Callable[[float, Sequence[End], Vector], Vector] | None = None
    ends_step: bool = False


class Load(ABC):
    """A force between frames: springs, bushings, ropes, and loads written by users; added by ``System.add``.

    A subclass needs a name, ends, and either `action` or a `kernel`, from which `action` follows. Everything else has a
    default. A load is independent of the tree. The literal route calls `action`; the compiled one the kernel, or
    `action` from Python if there is none.

    Attributes
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : tuple of Frame
        Frames on which it acts, any number: bodies, interfaces, nodes, frames of them, the ground. In a scene they are
        replaced by markers.
    kind : str
        Such as "spring", for messages.
    columns : tuple of str
        Names of the values that `tell` returns, with units in brackets.
    needs_rotation : bool
        Whether it uses the axes of its ends or has moments; then a scene refuses nodes of a mesh without rotations.
    acts_at_once : bool
        Whether it may become stiff during a run, as a contact does, so that its tangent at the start is no measure.
    unbooked : str
        Where it does work that it has no name for, neither stored nor dissipated, as the end of a sentence; or "".
    may_part : bool
        Whether it acts only when its ends meet, so that a search for equilibrium has to bring them together.
    runs_over_ends : bool
        Whether it is a line from end to end in their order, such as a rope, for views. Loads with two ends are always
        drawn as lines.
    screened : ScreenedLoad
        What screened runs have to know of it.

    Examples
    --------
    A magnet with the attraction ``c / distance^2``:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> class Magnet(kf.Load):
    ...     def __init__(self, name, a, b, c):
    ...         self.name, self.ends, self.c = name, (a, b), c
    ...     def action(self, t, ends, states):
    ...         line = ends[1].p - ends[0].p
    ...         r = np.linalg.norm(line)
    ...         pull = np.append(self.c / r**3 * line, np.zeros(3))
    ...         return kf.Action(np.array((pull, -pull)), potential=-self.c / r)
    >>> scene = kf.System()
    >>> ball = scene.add_point("ball", 0.1, at=(1, 0, 0))
    >>> scene.add(Magnet("magnet", scene.ground, ball, 0.01))
    >>> result = scene.simulate((0.0, 0.5))
    >>> bool(abs(result.energy.balance_error).max() < 1e-6)
    True
    """

    name: str
    ends: tuple[Any, ...]
    kind: ClassVar[str] = "load"
    columns: ClassVar[tuple[str, ...]] = ()
    needs_rotation: ClassVar[bool] = True
    acts_at_once: ClassVar[bool] = False
    unbooked: ClassVar[str] = ""
    may_part: ClassVar[bool] = False
    runs_over_ends: ClassVar[bool] = False
    screened: ScreenedLoad = ScreenedLoad()

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return forces, energy and powers at time t (s) from the ends and the internal states (states,) (Eq. 11).

        They are the output of its kernel; a load without a kernel must override this method.
        """
        kernel = self.kernel
        if kernel is None:
            raise NotImplementedError(f"{self.kind} {self.name!r} has no kernel and no action of its own")
        inputs = self.inputs(t, ends, states) if self.input_count else NO_STATES
        last = 3 + 6 * len(ends)
        motion, count = numbers_of(ends), last + len(states)
        out = np.array(written_by(kernel.real, t, kernel.numbers, inputs, motion, states, count))
        potential, taken, given = out[:3].tolist()
        return Action(out[3:last].reshape(-1, 6), potential, taken, given, out[last:])

    @property
    def subject(self) -> str:
        """Name that precedes the names of its events: that of the load."""
        return self.name

    @property
    def exchanges_energy(self) -> bool:
        """Whether it may dissipate energy, or supply energy other than from its potential."""
        return True

    @property
    def initial_states(self) -> Vector:
        """Internal states at the start, (states,); none by default."""
        return NO_STATES

    @property
    def has_rates(self) -> bool:
        """Whether its internal states change between events."""
        return len(self.initial_states) > 0

    def state_scales(self, acceleration: float) -> Vector:
        """Return a large value of each internal state, for a scene with this acceleration (m/s2)."""
        return np.ones(len(self.initial_states))

    @property
    def held_coordinates(self) -> HeldCoordinates | None:
        """Upper bounds, if it acts along joint coordinates that it holds and lets slip; otherwise None."""
        return None

    @property
    def input_functions(self) -> tuple[Callable[[float], float], ...]:
        """Functions of time, compiled by numba, that give its `inputs`, one each; none: these are asked for."""
        return ()

    @property
    def motions(self) -> tuple[tuple[Motion, str], ...]:
        """Its given functions of time, such as the length of a rope on a winch, each with its name for messages."""
        return ()

    def check_during(self, start: float, stop: float) -> None:
        """Raise a ModelError if its `motions` give it values that are not possible, between two times (s)."""
        return

    def check_at(self, t: float) -> None:
        """Raise a ModelError if its `motions` are not known at a time (s), or not possible."""
        for motion, what in self.motions:
            motion.check_known(t, what)
        # a force that grows without bound ends a run just before it
        self.check_during(t, t + JUST_AFTER * max(1.0, abs(t)))

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Events that are located in every run, such as the break of a rope."""
        return ()

    @property
    def told(self) -> tuple[str, ...]:
        """Names of reported events, after the name of the load."""
        return tuple(event.name for event in self.events)

    def in_detail(self) -> Self | None:
        """Return the load with events that are located only on request by name; None: it has none."""
        return None

    @property
    def reach(self) -> LoadReach | None:
        """Region in which it can act; None: everywhere."""
        return None

    @property
    def kernel(self) -> LoadKernel | None:
        """Its compiled function and numbers; None: `action` is called from Python."""
        return None

    @property
    def input_count(self) -> int:
        """Number of inputs from Python to compiled code in each evaluation; without a kernel, that of the action."""
        return 0 if self.kernel is not None else 3 + 6 * len(self.ends) + len(self.initial_states)

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the inputs from Python to compiled code at a state, (`input_count`,)."""
        done = self.action(t, ends, states)
        return np.concatenate(((done.potential, done.taken, done.given), done.wrenches.ravel(), done.rates))

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return the wrenches per unit of each input, shape (inputs, ends, 6), for linear analysis."""
        count = 6 * len(self.ends)
        return np.eye(self.input_count, count, k=-3).reshape(-1, len(self.ends), 6)

    def started(self, t: float, ends: Sequence[End]) -> Self:
        """Return the load in its state at the start of a scene, time t (s): for example with its slack length.

        Raises
        ------
        ModelError
            If this start is not possible.
        """
        return self

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return its stiffness and damping; None: not known, so that iterations converge more slowly.

        With a kernel for complex numbers they are its exact derivatives, as far as these are resistances.
        """
        kernel = self.kernel
        inputs = self.inputs(t, ends, states) if self.input_count else NO_STATES
        return None if kernel is None else resistances(kernel, t, inputs, ends, states)

    def anchors(self, ends: Sequence[End], states: Vector) -> list[Anchor]:
        """Return the active anchors of its friction, for the start of a run."""
        return []

    def anchored(
        self, ends: Sequence[End], states: Vector, friction_forces: Sequence[Vector], slips: Sequence[bool]
    ) -> Vector:
        """Return the internal states for which its `anchors` have these friction forces, and slip or stick."""
        return states

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Self | None:
        """Return a load without state rates that is equivalent to this one about a rest with its ends there, or None.

        Linear analysis and the search for equilibrium use it if internal states have rates. `softness` (m) is a
        distance over which a contact acts before it touches, for contact continuation in such a search.
        """
        return None

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states, (states,), of the load itself at the equilibrium of its `resting` form."""
        return states

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the outputs, one number for each of `columns`."""
        return np.zeros(len(self.columns))

    def with_ends(self, ends: tuple[Marker, ...]) -> Self:
        """Return a copy of the load between other frames."""
        other = _copy(self)
        object.__setattr__(other, "ends", ends)
        return other


def _copy(load: Any) -> Any:
    """Return a copy with all that a load knows, but what it has computed on request."""
    kind: Any = type(load)
    other = kind.__new__(kind)
    known = {k: v for k, v in load.__dict__.items() if not isinstance(getattr(kind, k, None), cached_property)}
    other.__dict__.update(known)
    return other
