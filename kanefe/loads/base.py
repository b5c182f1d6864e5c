"""Interface of loads between frames, also for loads of users."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Vector
from kanefe.loads.action import NO_STATES, Action, End, LoadKernel, Tangent
from kanefe.loads.by_kernel import numbers_of, resistances, written_by

if TYPE_CHECKING:
    from kanefe.loads.anchors import Anchor
    from kanefe.loads.reach import LoadReach
    from kanefe.loads.reaction_load import ReactionLoad


class HeldCoordinates(NamedTuple):
    """What a load along joint coordinates is at most, while it holds them.

    Attributes
    ----------
    stiffness, damping : tuple of float
        Along each, N/m or N m/rad; N s/m or N m s/rad.
    rate : float
        The fastest that its internal states follow, 1/s.
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
    """A moment at which a function of a load passes zero.

    Attributes
    ----------
    name : str
        Told in the result after the name of the load.
    function : callable
        (t, ends, states) -> number.
    direction : -1, 0 or 1
        Only where it falls, wherever it passes zero, or only where it rises.
    action : callable or None
        (t, ends, states) -> the internal states to go on with.
    ends_step : bool
        Whether a step ends there also without an action, as at a jump of a force; not again and again at one moment.
    """

    name: str
    function: Callable[[float, Sequence[End], Vector], float]
    direction: int = 0
    action: Callable[[float, Sequence[End], Vector], Vector] | None = None
    ends_step: bool = False


class Load(ABC):
    """A force between frames: springs, bushings, ropes, and what a user writes; added by ``System.add``.

    A subclass has to have a name and ends, and to say what it does: in `action`, or by a `kernel`, from which `action`
    comes by itself. All else has a default. None of it knows the tree. The literal route calls `action`; the compiled
    one a kernel, where the load brings one, and else `action` too, from Python.

    Attributes
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : tuple of Frame
        What it acts on, any number: bodies, interfaces, nodes, frames of them, the ground. A scene
        takes markers for them.
    kind : str
        Such as "spring", for messages.
    columns : tuple of str
        Names of what `tell` returns, with units in brackets.
    needs_rotation : bool
        Whether it looks at the axes of its ends or gives moments: a scene refuses nodes of a mesh that have no rotation
        of their own then.
    acts_at_once : bool
        Whether it may become stiff in the middle of a run, as a contact does: its tangent at the start does not tell.
    may_part : bool
        Whether it acts only where its ends meet, so that a search for a balance has to bring them together.
    runs_over_ends : bool
        Whether it is a line from end to end in their order, as a rope is: views draw it. A load of two ends they draw
        as a line anyway.
    pull_column : str
        Which of `columns` is a pull that may vanish, and be too much for it, as that of a rope; empty: none. Screened
        runs look out for both.
    strongest_pull : float
        Pull at which it gives way, N.
    highest_forcing : float
        Highest frequency at which it acts by itself, rad/s, as a rotor does.
    slip_damping : float
        Pull beyond what friction holds over the speed of its slip, N s/m, of a load whose first state is the path that
        it slips; 0: it has none.
    turns_by_half_at_most : bool
        Whether it jumps where its second end turns beyond half a turn, seen from the first.

    Examples
    --------
    A magnet that pulls with ``c / distance^2``:

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
    may_part: ClassVar[bool] = False
    runs_over_ends: ClassVar[bool] = False
    pull_column: ClassVar[str] = ""
    strongest_pull: float = math.inf
    highest_forcing: float = 0.0
    slip_damping: float = 0.0
    turns_by_half_at_most: bool = False

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return what the load does at time t (s), with its ends and its internal states (states,) there (Eq. 11).

        That is what its kernel writes; a load without a kernel has to say it itself.
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
        """Subject of its events, before their own names: the load itself."""
        return self.name

    @property
    def exchanges_energy(self) -> bool:
        """Whether it may take energy from the scene for good, or give it beyond its potential."""
        return True

    @property
    def initial_states(self) -> Vector:
        """Internal states at the start, (states,): none, unless a subclass has some."""
        return NO_STATES

    @property
    def has_rates(self) -> bool:
        """Whether its internal states move between events."""
        return len(self.initial_states) > 0

    def state_scales(self, acceleration: float) -> Vector:
        """Return what counts as a large value of each internal state, in a scene of an acceleration (m/s2)."""
        return np.ones(len(self.initial_states))

    @property
    def reaction_load(self) -> ReactionLoad | None:
        """The load, if some of its states follow the reaction of a joint; None: none does."""
        return None

    @property
    def held_coordinates(self) -> HeldCoordinates | None:
        """What it is at most, if it acts along joint coordinates that it holds and lets slip; None: it does not."""
        return None

    def slipping(self, ends: Sequence[End], states: Vector) -> tuple[float, str] | None:
        """Return what it holds of one joint coordinate that slips, and its unit; None: it holds, or none such."""
        return None

    def stuck(self, factor: float) -> Self:
        """Return the load with friction between surfaces that holds so many times as much."""
        return self

    @property
    def not_screened(self) -> str:
        """What of it screened runs do not offer; empty: they take it."""
        return "loads whose internal states move by themselves" if self.has_rates else ""

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Moments that are looked for in a run, such as that at which a rope breaks."""
        return ()

    @property
    def told(self) -> tuple[str, ...]:
        """Names of reported events, after the name of the load."""
        return tuple(event.name for event in self.events)

    def in_detail(self) -> Self | None:
        """Return the load with events that are looked for only where a run asks for them by name; None: it has none."""
        return None

    @property
    def reach(self) -> LoadReach | None:
        """Where it acts at all; None: it may always act."""
        return None

    @property
    def kernel(self) -> LoadKernel | None:
        """What compiled code evaluates it by; None: `action` is called from Python."""
        return None

    @property
    def input_count(self) -> int:
        """How many numbers Python gives the kernel in each evaluation; of a load without a kernel all that it does."""
        return 0 if self.kernel is not None else 3 + 6 * len(self.ends) + len(self.initial_states)

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return what Python gives the kernel at a state, (`input_count`,)."""
        done = self.action(t, ends, states)
        return np.concatenate(((done.potential, done.taken, done.given), done.wrenches.ravel(), done.rates))

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return the wrenches that a unit of each input adds, shape (inputs, ends, 6): for linear analysis."""
        count = 6 * len(self.ends)
        return np.eye(self.input_count, count, k=-3).reshape(-1, len(self.ends), 6)

    def started(self, t: float, ends: Sequence[End]) -> Self:
        """Return the load as a scene starts with it at time t (s): with a length at which it is slack, say.

        Raises
        ------
        ModelError
            If it cannot start there.
        """
        return self

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return its stiffness and damping; None: not known, which iterations take longer for.

        Of a load with a kernel for complex numbers they are the exact derivatives of it, as far as these resist.
        """
        kernel = self.kernel
        inputs = self.inputs(t, ends, states) if self.input_count else NO_STATES
        return None if kernel is None else resistances(kernel, t, inputs, ends, states)

    def anchors(self, ends: Sequence[End], states: Vector) -> list[Anchor]:
        """Return the anchors of its friction that act, for the start of a run."""
        return []

    def anchored(
        self, ends: Sequence[End], states: Vector, friction_forces: Sequence[Vector], slips: Sequence[bool]
    ) -> Vector:
        """Return the internal states with which its `anchors` give such friction, and of each whether it slips."""
        return states

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Self | None:
        """Return a load without moving states that acts as this one does about a rest with its ends there, or None.

        Linear analysis and the search for a balance take it where internal states move. `softness` (m) is over what
        distance a contact acts from afar, while such a search feels its way.
        """
        return None

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states, (states,), of the load itself at the rest that its `resting` form has come to."""
        return states

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the outputs, one number for each of `columns`."""
        return np.zeros(len(self.columns))

    def with_ends(self, ends: tuple[Marker, ...]) -> Self:
        """Return the same load between other frames."""
        other = _copy(self)
        object.__setattr__(other, "ends", ends)
        return other


def _copy(load: Any) -> Any:
    if hasattr(load, "__dataclass_fields__"):
        return replace(load)
    other = load.__class__.__new__(load.__class__)
    other.__dict__.update(load.__dict__)
    return other
