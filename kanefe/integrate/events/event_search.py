"""Finding events in a run: sign changes between samples of the dense output, then roots by bracketing."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from kanefe.equations.forces_at import seen
from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.events.contact_changes import ChangeReports
from kanefe.integrate.events.crossings import crossing_between
from kanefe.integrate.events.event import Event, MarginEvent
from kanefe.integrate.events.load_events import EventOfLoad
from kanefe.integrate.events.minimise import lowest_between
from kanefe.integrate.stepper import LooksOut, StepFailure, Stepper
from kanefe.kernels.steppers.quiet_steps import LEAST_DIP, SHARES

FIRST_PLACES = 10.0 ** np.arange(-9, -1)
"""Positions in a step, relative to it, at which a function that starts at zero after an event is evaluated: they show
its sign however near its next zero is."""

ROOT_TOLERANCE = 1e-13
"""Tolerance of the time of an event relative to the span. The accuracy of the states, and so of the time itself, is
that of the run."""

NOISE = 10.0
"""Value below which the sign of a function is noise, in multiples of its value at the root found."""

ROUND_OFF = 1e-15
"""Value below which the sign of a function is noise, relative to its largest value in the step, if its value at the
root is zero by chance."""

STORM, STORM_SHARE = 32, 1e-6
"""Number of actions within this fraction of the span from which they count as an infinite sequence."""

EPSILON = float(np.finfo(float).eps)

Bracket = tuple[float, float]
QuickLook = Callable[[float], Vector]


class Samples(NamedTuple):
    """A function at times of a step.

    Attributes
    ----------
    times, values : ndarray, shape (T,)
    may_dip : ndarray of bool, shape (T - 2,)
        Of each three samples: see `_may_dip`.
    """

    times: np.ndarray
    values: np.ndarray
    may_dip: np.ndarray


class EventWatch:
    """State of all events at the last evaluated time.

    Parameters
    ----------
    model : Model
    events : sequence of Event
    span : float
        s.

    Attributes
    ----------
    times : dict of str to list of float
        Of what happened so far.
    acting : float or None
        Time of the first event of the last step that acts, s.
    telling : Telling
        Of rigid contacts.
    """

    def __init__(self, model: Model, events: Sequence[Event], span: float) -> None:
        self._model, self.events = model, tuple(events)
        self._span = span
        self._watching = model.route.watching
        columns = {} if self._watching is None else self._watching.columns
        self._compiled = {
            i: columns[event.number].start + event.index
            for i, event in enumerate(self.events)
            if isinstance(event, EventOfLoad) and event.number in columns
        }
        self._is_bound = np.array([isinstance(event, MarginEvent) for event in self.events], dtype=bool)
        self._values = np.zeros(len(self.events))
        self._noise = np.zeros(len(self.events))
        self._ways = np.zeros(len(self.events))
        self._actions: deque[float] = deque(maxlen=STORM)
        self.acting: float | None = None
        self.times: dict[str, list[float]] = {event.name: [] for event in self.events}
        self.telling = ChangeReports(self.times, span)

    def begin(self, t: float, y: np.ndarray, happened: Sequence[Event] = ()) -> None:
        """Set the state from which the run continues, and the events that just happened there."""
        self._values = self._values_of(np.array([t]), y[None])[0]
        for i, event in enumerate(self.events):
            if isinstance(event, MarginEvent):
                self._noise[i] = event.blur(t, seen(self._model, t, y))
            elif event not in happened or abs(self._values[i]) > self._noise[i]:
                self._noise[i] = 0.0

    def renew(self, t: float, y: np.ndarray) -> None:
        """Account for a jump of forces at the present time: margins that must not be below zero are evaluated again."""
        if not self._is_bound.any():
            return
        state = seen(self._model, t, y)
        for i, event in enumerate(self.events):
            if isinstance(event, MarginEvent):
                self._values[i], self._noise[i] = event.value(t, state), event.blur(t, state)

    @property
    def _is_at_zero(self) -> bool:
        """Whether a function is at a zero, so that its sign is not known."""
        return bool(self._noise.any()) or not self._values.all()

    def lookout(self) -> Vector | None:
        """Return the values from which a stepper can look out by itself; None where the next step is to be scanned."""
        if len(self._compiled) < len(self.events) or self._is_at_zero:
            return None
        values = np.empty(len(self.events))
        values[list(self._compiled.values())] = self._values
        return values

    def passed(self, values: Vector) -> None:
        """Take in values that a stepper has come to in steps that were quiet."""
        self._values = values[list(self._compiled.values())]

    def scan(self, stepper: Stepper, check_time: Callable[[], None]) -> list[tuple[float, Event]]:
        """Return what happened in the last step, in order of time, up to and with the first that acts.

        Events that act at the same moment are all returned. The search for a moment looks at the clock on its way.
        """
        t0, h = stepper.t_old, stepper.t - stepper.t_old
        places = np.append(FIRST_PLACES, SHARES) if self._is_at_zero else SHARES
        times = t0 + h * places
        times = np.append(np.unique(times[(times > t0) & (times < stepper.t)]), stepper.t)
        quick = _quick_look(stepper) if self._compiled else None
        table = np.vstack((self._values, self._looked_at(stepper, quick, times)))
        times = np.append(t0, times)
        self._check_short_ways(table)
        found: list[tuple[float, Event]] = []
        dips = _may_dip(times[:, None], table)
        is_open = ~_has_one_sign(table) | dips.any(axis=0) | (self._is_bound & (table < 0.0).any(axis=0))
        for i in np.flatnonzero(is_open).tolist():
            event, noise = self.events[i], float(self._noise[i])
            function = _timed(self._along(stepper, quick, i), check_time)
            samples = Samples(times, table[:, i], dips[:, i])
            is_bound, first = bool(self._is_bound[i]), _first_with_sign(samples.values, noise)
            if is_bound and samples.values[first] < -noise:
                function = partial(_above, -noise, function)
                brackets = [(float(times[max(first - 1, 0)]), float(times[first]))]
            else:
                brackets = _brackets(samples, event.direction, first, function)
            for bracket in brackets:
                t = self._root(function, *bracket, is_beyond=is_bound or ends_step_alone(event))
                if not self._is_told(t, event):
                    found.append((t, event))
        found.sort(key=lambda entry: entry[0])
        acting = next((t for t, event in found if event.acts and not self._is_over(t, event)), None)
        self.acting = acting
        if acting is not None:
            found = [entry for entry in found if entry[0] <= acting + 2 * self._tolerance(acting)]
        for i, event in enumerate(self.events):
            roots = [t for t, other in found if other is event]
            self.times[event.name] += roots
            if acting is not None and roots:
                function, last = self._along(stepper, quick, i), roots[-1]
                # of a function that jumps the value before it
                at_root = min(abs(function(t)) for t in (last, max(last - self._tolerance(last), t0)))
                self._noise[i] = max(NOISE * at_root, ROUND_OFF * float(np.abs(table[:, i]).max()))
                before = table[np.searchsorted(times, roots[-1]) - 1, i]
                self._ways[i] = -np.sign(before)
            elif np.abs(table[1:, i]).max() > self._noise[i]:
                self._noise[i] = 0.0  # also where a step ends by chance just before the next zero
        self._values = table[-1]
        return found

    def _is_told(self, t: float, event: Event) -> bool:
        """Return whether an event without action was reported at this time, at which another ended the step."""
        before = self.times[event.name]
        return not event.acts and bool(before) and t - before[-1] <= 2 * self._tolerance(t)

    def _is_over(self, t: float, event: Event) -> bool:
        """Return whether an event that only ends steps has just done so: what rests touches again and again."""
        before = self.times[event.name]
        return ends_step_alone(event) and bool(before) and t - before[-1] <= STORM_SHARE * self._span

    def check_storm(self, t: float, happened: Sequence[Event]) -> None:
        """Take in the time of an action; raise a StepFailure if they follow each other without end."""
        happened = [event for event in happened if not ends_step_alone(event)]
        if not happened:
            return
        self._actions.append(t)
        width = t - self._actions[0]
        if len(self._actions) == STORM and width <= STORM_SHARE * self._span:
            raise _storm(happened[0], f"acted {STORM} times within {width:.2g} s")

    def _check_short_ways(self, table: np.ndarray) -> None:
        """Raise a StepFailure if a function that is sent back repeatedly passed zero before it could be evaluated."""
        for i, event in enumerate(self.events):
            times = self.times[event.name]
            if event.action is None or not self._noise[i] or len(times) < 2:
                continue
            seen = table[1:, i][np.abs(table[1:, i]) > self._noise[i]]
            if len(seen) and seen[0] * self._ways[i] > 0.0 and times[-1] - times[-2] <= STORM_SHARE * self._span:
                raise _storm(event, f"acted again after {times[-1] - times[-2]:.2g} s, and again after less")

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what is needed to continue."""
        arrays = {f"times {i}": np.array(self.times[event.name]) for i, event in enumerate(self.events)}
        kept = {"values": self._values, "noise": self._noise, "ways": self._ways}
        return {"acted": np.array(self._actions), **{name: array.copy() for name, array in kept.items()}, **arrays}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self._values, self._noise, self._ways = (np.array(snapshot[name]) for name in ("values", "noise", "ways"))
        self._actions.clear()
        self._actions.extend(snapshot["acted"].tolist())
        for i, event in enumerate(self.events):
            self.times[event.name] = snapshot[f"times {i}"].tolist()

    def _values_of(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the values of all functions at times and states, shape (times, events)."""
        found = np.empty((len(times), len(self.events)))
        if self._compiled and self._watching is not None:
            found[:, list(self._compiled)] = self._watching.values(times, states)[:, list(self._compiled.values())]
        if len(self._compiled) < len(self.events):
            for row, t, y in zip(found, times.tolist(), states, strict=True):
                state = seen(self._model, t, y)
                for i, event in enumerate(self.events):
                    if i not in self._compiled:
                        row[i] = event.value(t, state)
        return found

    def _looked_at(self, stepper: Stepper, quick: QuickLook | None, times: np.ndarray) -> np.ndarray:
        """Return the values of all functions at times of the last step, shape (times, events)."""
        if len(self._compiled) == len(self.events) and quick is not None:
            columns = list(self._compiled.values())
            return np.array([quick(t)[columns] for t in times.tolist()])
        return self._values_of(times, stepper.states(times))

    def _along(self, stepper: Stepper, quick: QuickLook | None, number: int) -> Callable[[float], float]:
        event, column = self.events[number], self._compiled.get(number)
        if column is not None and quick is not None:
            return lambda t: float(quick(t)[column])

        def function(t: float) -> float:
            times = np.array([t])
            states = stepper.states(times)
            if column is not None and self._watching is not None:
                return float(self._watching.values(times, states)[0, column])
            return event.value(t, seen(self._model, t, states[0]))

        return function

    def _tolerance(self, t: float) -> float:
        return max(ROOT_TOLERANCE * self._span, 4 * EPSILON * abs(t))

    def _root(self, function: Callable[[float], float], a: float, b: float, is_beyond: bool) -> float:
        """Return where the function passes zero; on request where it has its new sign.

        A step from there on has a force that jumps behind it: rates that change sides within it have no solution.
        """
        ends = function(a), function(b)
        if ends[0] * ends[1] > 0.0:  # at one of the ends, but for round-off
            return a if abs(ends[0]) < abs(ends[1]) else b
        tolerance = self._tolerance(b)
        found = crossing_between(function, a, b, ends, tolerance)
        ahead = tolerance
        while is_beyond and found < b and function(found) * ends[1] <= 0.0:
            found, ahead = min(found + ahead, b), 2.0 * ahead  # where it stays at zero the way is long
        return found


def _quick_look(stepper: Stepper) -> QuickLook | None:
    """Return a function of all event values of loads at a time of the last step, if a stepper provides it."""
    return stepper.values_at if isinstance(stepper, LooksOut) and stepper.has_values else None


def _timed(function: Callable[[float], float], check_time: Callable[[], None]) -> Callable[[float], float]:
    """Return a function that checks the time limit before each evaluation."""

    def timed(t: float) -> float:
        check_time()
        return function(t)

    return timed


def ends_step_alone(event: Event) -> bool:
    """Return whether an event ends a step and changes nothing."""
    return isinstance(event, EventOfLoad) and event.ends_step_alone


def _storm(event: Event, what: str) -> StepFailure:
    return StepFailure(
        f"event {event.name!r} {what}: infinitely many events in a finite time",
        "let its action bring the scene to rest once it is slow, make the event terminal, or give the contact a "
        "stiffness (kf.CoordinateForce with limits, a spring)",
    )


def _first_with_sign(values: np.ndarray, noise: float) -> int:
    """Return the number of the first value that has a sign; that of the last one if none has."""
    beyond = np.abs(values) > noise
    return int(np.argmax(beyond)) if beyond.any() else len(values) - 1


def _brackets(samples: Samples, direction: int, first: int, function: Callable[[float], float]) -> list[Bracket]:
    """Return the intervals at whose ends the function has different signs, of those that pass zero as wanted.

    A value of zero ends an interval. After an event the values have no sign until the one with the number `first`: the
    place that was found lies before the root as often as behind it.
    """
    found: list[tuple[Bracket, float]] = []
    last: tuple[float, float] | None = None
    times, values, _ = samples
    for t, value in zip(times[first:].tolist(), values[first:].tolist(), strict=True):
        if last is not None and (value > 0.0) - (value < 0.0) != math.copysign(1.0, last[1]):
            found.append(((last[0], t), -last[1]))
        last = (t, value) if value != 0.0 else None
    for (a, lowest, b), sign in _dips(samples, first, function):
        found += [((a, lowest), -sign), ((lowest, b), sign)]
    return sorted(bracket for bracket, way in found if way * direction >= 0.0)


def _dips(
    samples: Samples, first: int, function: Callable[[float], float]
) -> list[tuple[tuple[float, float, float], float]]:
    """Return where the function goes through zero and back between samples of one sign, and that sign.

    Three samples after each other, from the first that has a sign, whose parabola comes near zero between them are
    looked at closely.
    """
    found = []
    times, values, may_dip = samples
    after = times[0]
    for k in (first + np.flatnonzero(may_dip[first:])).tolist():
        if times[k] < after:
            continue
        t, sign = times[k : k + 3], np.sign(values[k])
        below = partial(_times, float(sign), function)
        lowest, value = lowest_between(below, float(t[0]), float(t[2]), 1e-5 * float(t[2] - t[0]))
        if value < 0.0:
            found.append(((float(t[0]), lowest, float(t[2])), float(sign)))
            after = t[2]
    return found


def _above(level: float, function: Callable[[float], float], t: float) -> float:
    return function(t) - level


def _times(sign: float, function: Callable[[float], float], t: float) -> float:
    return sign * function(t)


def _has_one_sign(table: np.ndarray) -> np.ndarray:
    """Return of each column of a table whether all its samples are of one sign."""
    signs = np.sign(table)
    return np.asarray((signs[0] != 0.0) & (signs == signs[0]).all(axis=0))


def _may_dip(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return of each three samples whether they are of one sign and their parabola comes near zero between them."""
    if len(times) < 3:
        return np.zeros((0, *values.shape[1:]), dtype=bool)
    signs = np.sign(values)
    is_one = (signs[:-2] == signs[1:-1]) & (signs[1:-1] == signs[2:]) & (signs[:-2] != 0.0)
    v0, v1, v2 = (signs[:-2] * part for part in (values[:-2], values[1:-1], values[2:]))
    # the parabola is a + b x + c x^2 over -1 .. 1, with the sample in the middle at x
    x = 2.0 * (times[1:-1] - times[:-2]) / (times[2:] - times[:-2]) - 1.0
    b = 0.5 * (v2 - v0)
    c = (0.5 * (v0 + v2) + b * x - v1) / (1.0 - x * x)
    a = 0.5 * (v0 + v2) - c
    largest = np.maximum(np.maximum(v0, v1), v2)
    is_bent = is_one & (c > 0.0) & (np.abs(b) < 2.0 * c)
    lowest = a - b**2 / (4.0 * np.where(is_bent, c, 1.0))
    return np.asarray(is_bent & (lowest <= LEAST_DIP * largest))
