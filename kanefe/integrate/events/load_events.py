"""Events of loads between frames: moments that a load itself looks for, such as that at which a rope breaks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kanefe.equations.forces_at import seen
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.events.event import Event
from kanefe.loads.base import LoadEvent
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState


@dataclass(frozen=True, eq=False)
class EventOfLoad(Event):
    """An event of a load: its functions see the load's ends and states, its action changes its states alone.

    Attributes
    ----------
    number : int
        Of the load in the model.
    of : LoadEvent
    where : slice
        Of the load's states in a state (q, u, z).
    index : int
        Of the event among those of its load.
    asked : Event or None
        By which the user has it end the run, or act after what the load does.
    """

    number: int = field(kw_only=True)
    of: LoadEvent = field(kw_only=True)
    where: slice = field(kw_only=True)
    index: int = field(kw_only=True)
    asked: Event | None = field(default=None, kw_only=True)

    @property
    def acts(self) -> bool:
        """Whether it changes the states of its load, ends a step, or does what the user asks for."""
        return self.of.action is not None or self.of.ends_step or self.acts_as_asked

    @property
    def acts_as_asked(self) -> bool:
        """Whether it does what the user asks for."""
        return self.asked is not None and self.asked.acts

    @property
    def ends_step_alone(self) -> bool:
        """Whether it ends a step and does nothing else."""
        return self.of.action is None and not self.acts_as_asked

    def value(self, t: float, state: SceneState) -> float:
        """Return the value of the load's function."""
        return float(self.of.function(t, state.load_ends(self.number), state.load_states(self.number)))

    def changed(self, t: float, state: SceneState, y: Vector) -> Vector | None:
        """Return the state (q, u, z) with other states of the load; a ModelError says what is wrong with them."""
        if self.of.action is None:
            return None
        given = np.asarray(self.of.action(t, state.load_ends(self.number), y[self.where]), dtype=float)
        if given.shape != y[self.where].shape or not np.all(np.isfinite(given)):
            raise ModelError(
                f"the action of event {self.name!r} must return the {y[self.where].size} internal states of its load, "
                f"finite; at t = {t:.6g} s it gave {given!r}"
            )
        after = y.copy()
        after[self.where] = given
        return after


def events_of_loads(model: ModelData, keeps_steps: bool) -> tuple[Event, ...]:
    """Return the events of all loads between frames, called by the load and by what happens.

    Where steps are kept, those that would only end one are told and no more.
    """
    first = model.coordinate_count + model.free_count
    found: list[Event] = []
    for number, (load, states) in enumerate(zip(model.loads, model.load_states, strict=True)):
        where = slice(first + states.start, first + states.stop)
        for index, given in enumerate(load.events):
            event = given._replace(ends_step=given.ends_step and not keeps_steps)
            name, function = f"{load.subject} {event.name}", _Function(number, event)
            place = EventOfLoad(name, function, event.direction, number=number, of=event, where=where, index=index)
            found.append(place)
    return tuple(found)


def torn_loose(model: Model, events: Sequence[Event], t: float, y: Vector) -> Vector:
    """Return a state (q, u, z) in which what an action of the user has torn from its anchors slips."""
    for event in events:
        if isinstance(event, EventOfLoad) and event.of.name == "slip" and event.of.action is not None:
            state = seen(model, t, y)
            if event.value(t, state) > 0.0 and (changed := event.changed(t, state, y)) is not None:
                y = changed
    return y


@dataclass(frozen=True)
class _Function:
    number: int
    event: LoadEvent

    def __call__(self, t: float, state: SceneState) -> float:
        return self.event.function(t, state.load_ends(self.number), state.load_states(self.number))
