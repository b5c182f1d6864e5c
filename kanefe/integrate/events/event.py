"""Events: moments at which a function of the state passes zero, and what is done there."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.integrate.status import RunStatus
from kanefe.tree.scene_state import SceneState

DIRECTIONS = (-1, 0, 1)


@checked("direction", "terminal")
@dataclass(frozen=True, eq=False)
class Event:
    """A moment at which a function of the state passes zero.

    Parameters
    ----------
    name : str
        Unique in a run.
    function : callable, optional
        ``f(t, state)`` -> number, with t in s and the `state` that functions of loads are given, which here also tells
        forces: ``state.joint_reaction("arm")``, `driving_force` and `loop_force`. Without one, the name is that of an
        event of a load or contact, such as ``"hoist breaks"``; ``*`` in it stands for anything. Some of these are
        looked for only then: ``"hoist slack"`` and ``"hoist taut"`` of ropes and winches, and what single points of
        contacts do, ``"feet lift of point 2"``.
    direction : -1, 0 or 1
        Only where the function falls, wherever it passes zero, or only where it rises.
    terminal : bool
        Whether the run ends there.
    action : callable, optional
        ``f(t, state)`` -> the state ``(q, u, z)`` to go on with, such as a changed copy of ``state.vector``; or None to
        go on with the same, after a load that looks at a switch was switched. The speeds of loops are then made
        consistent. Energy that the change gives counts as work, energy that it takes as dissipated. An action stops a
        body, but does not hold it: that takes a force.

    Raises
    ------
    ModelError
        Naming what is wrong.

    Examples
    --------
    A ball that bounces, losing a fifth of its speed:

    >>> import kanefe as kf
    >>> def height(t, state):
    ...     return state.position("ball")[2]
    >>> def bounce(t, state):
    ...     y = state.vector
    ...     y[1] *= -0.8
    ...     return y
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> ball = scene.add_point("ball", 0.1, joint=kf.Prismatic("z", position=1.0))
    >>> result = scene.simulate((0.0, 1.0), events=[kf.Event("floor", height, direction=-1, action=bounce)])
    >>> result.events["floor"].round(6)
    array([0.451524])

    A weight that is thrown up, until its rope is taut again; ``events=["hoist taut"]`` would go on:

    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> weight = scene.add_point("weight", 1.0, joint=kf.Prismatic("z", position=-1.0, speed=2.0))
    >>> scene.add(kf.Rope("hoist", (scene.ground, weight), axial_stiffness=1e6, length=1.0))
    >>> result = scene.simulate((0.0, 1.0), events=kf.Event("hoist taut", terminal=True))
    >>> result.times[-1].round(6)  # s: 2 v / g
    0.407747
    """

    name: str
    function: Callable[[float, SceneState], float] | None = None
    direction: int = 0
    terminal: bool = False
    action: Callable[[float, SceneState], Any] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise ModelError(f"the name of an event must be a text, not {self.name!r}")
        if self.function is not None and not callable(self.function):
            raise ModelError(f"event {self.name!r} needs a function f(t, state) -> number, not {self.function!r}")
        if self.direction not in DIRECTIONS:
            raise ModelError(f"direction of event {self.name!r} must be -1, 0 or 1, not {self.direction!r}")
        if self.function is None and self.direction != 0:
            raise ModelError(
                f"event {self.name!r} is one of a load or contact, which has its direction. Remedy: leave out "
                "direction, or give a function f(t, state) -> number"
            )
        if self.action is not None and not callable(self.action):
            raise ModelError(f"action of event {self.name!r} must be a function f(t, state), not {self.action!r}")
        if self.terminal and self.action is not None:
            raise ModelError(
                f"event {self.name!r} ends the run, so its action has nothing to act on. Remedy: one of the two"
            )

    @property
    def acts(self) -> bool:
        """Whether the run does more than continue."""
        return self.terminal or self.action is not None

    def status(self, t: float) -> RunStatus:
        """Return how a run ended that it has ended at time t (s)."""
        return RunStatus("stopped", t, f"by the event {self.name!r}")

    def value(self, t: float, state: SceneState) -> float:
        """Return the value of the function; a ModelError names the event if it is not one finite number."""
        if self.function is None:
            raise TypeError("an event of a load has the function of the load")
        try:
            value = self.function(t, state)
        except Exception as error:
            error.add_note(f"the function of event {self.name!r} at t = {t:.6g} s")
            raise
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise ModelError(
                f"the function of event {self.name!r} must give one finite number; at t = {t:.6g} s it gave {value!r}"
            )
        return number

    def changed(self, t: float, state: SceneState, y: Vector) -> Vector | None:
        """Return the state after the action, None if it leaves y (size,) as it is; a ModelError names what is wrong."""
        if self.action is None:
            return None
        try:
            given = self.action(t, state)
        except Exception as error:
            error.add_note(f"the action of event {self.name!r} at t = {t:.6g} s")
            raise
        if given is None:
            return None
        after = numbers(given)
        if after.shape != y.shape or not np.all(np.isfinite(after)):
            what = f"shape {after.shape}" if np.shape(given) else repr(given)
            raise ModelError(
                f"the action of event {self.name!r} must return {y.size} finite numbers, the coordinates, the free "
                f"speeds and the states of loads, or None; at t = {t:.6g} s it gave {what}. Remedy: a changed copy of "
                "state.vector"
            )
        return after


class MarginEvent(Event):
    """An event whose function must not be below zero: it happens where it is, also where it has not passed zero."""

    @abstractmethod
    def blur(self, t: float, state: SceneState) -> float:
        """Return the value of the function below which it has no sign at the start or continuation of a run."""


def checked_events(events: Sequence[Event | str] | Event | str, of_loads: Sequence[Event] = ()) -> tuple[Event, ...]:
    """Return the events of loads and those of a call, names for events; a ModelError says what is wrong with them."""
    if not isinstance(events, (tuple, Event, str, Sequence)):  # the default first, which takes no time
        raise ModelError(f"events must be a list of kanefe.Event, not {type(events).__name__}")
    given = (events,) if isinstance(events, (Event, str)) else events
    found = (*of_loads, *(Event(one) if isinstance(one, str) else one for one in given))
    for event in found:
        if not isinstance(event, Event):
            raise ModelError(
                f"events must be a list of kanefe.Event or of names of events of loads, not of {type(event).__name__}"
            )
    for name, count in Counter(event.name for event in found).items():
        if count > 1:
            raise ModelError(f"two events are called {name!r}. Remedy: another name for one of them")
    return found
