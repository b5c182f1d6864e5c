"""Finding events in a run: sign changes between samples of the dense output, then roots by bracketing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from kanefe.equations.forces_at import seen
from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.events.contact_changes import CODES, ChangeReports, ContactChange, ReportedContactEvent, begun
from kanefe.integrate.events.event import Event, MarginEvent
from kanefe.integrate.events.kinds import ends_step_alone, kind_for_kernels
from kanefe.integrate.events.load_events import EventOfLoad
from kanefe.integrate.events.storms import without_end
from kanefe.integrate.stepper import Stepper, looks_out
from kanefe.kernels.events.event_search import (
    Sought,
    StepSamples,
    Within,
    is_known,
    is_over,
    is_still,
    noise_after,
    passes_at,
    time_tolerance,
    zeros_of,
)
from kanefe.kernels.events.watched_run import (
    STORM,
    STORM_SHARE,
    Does,
    WatchedRun,
)
from kanefe.kernels.impacts.contact_questions import report_count
from kanefe.kernels.loads.watching import ALL
from kanefe.tree.looks import first_look_shares, look_shares
from kanefe.tree.model_data import QUADRATURES

LEAST_RECORDS = 256
"""Least number of events that compiled code records before Python takes them."""

QuickLook = Callable[[float], Vector]


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
    watched : WatchedRun or None
        The events for compiled code, where all are compiled.
    telling : Telling
        Of rigid contacts.
    """

    def __init__(self, model: Model, events: Sequence[Event], span: float) -> None:
        self._model, self.events = model, tuple(events)
        self._span = span
        self._watching = model.route.watching
        columns = (self._column(event) for event in self.events)
        self._compiled = {i: column for i, column in enumerate(columns) if column is not None}
        self._is_bound = np.array([isinstance(event, MarginEvent) for event in self.events], dtype=bool)
        self._values = np.zeros(len(self.events))
        self._noise, self._known = np.zeros(len(self.events)), np.ones(len(self.events))
        self._last = np.full(len(self.events), -np.inf)
        self._with_states: tuple[str, ...] = ()
        self._ways = np.zeros(len(self.events))
        self._actions = np.full(STORM, -np.inf)
        self._regime, self._usual = np.array([-1.0, 0.0, 0.0]), np.zeros(len(self.events))
        self.acting: float | None = None
        self.is_again = False
        self.times: dict[str, list[float]] = {event.name: [] for event in self.events}
        self._kept = {"values": self._values, "known": self._known, "noise": self._noise, "ways": self._ways}
        self._kept |= {"acted": self._actions, "regime": self._regime, "usual": self._usual}
        self.telling = ChangeReports(self.times, span)
        self.watched = self._watched() if len(self._compiled) == len(self.events) else None

    def start(self, stepper: Stepper) -> None:
        """Begin a run at its start, where slips of rigid contacts get their directions."""
        t, y = stepper.t, stepper.state()
        if (first := begun(self.events, t, y[:-QUADRATURES])) is not None:
            stepper.restart(t, np.concatenate((first, y[-QUADRATURES:])))
        self.begin(t, stepper.state())

    def begin(self, t: float, y: np.ndarray, happened: Sequence[Event] = ()) -> None:
        """Set the state from which the run continues, and the events that just happened there."""
        self._regime[0] = -1.0
        self._values[:], self._known[:] = self._values_of(np.array([t]), y[None])[0], 1.0
        for i, event in enumerate(self.events):
            if isinstance(event, MarginEvent):
                self._noise[i] = event.blur(t, seen(self._model, t, y))
            elif event not in happened or abs(self._values[i]) > self._noise[i]:
                self._noise[i] = 0.0
        for i in (i for i, event in enumerate(self.events) if event in happened and not self._is_bound[i]):
            # as `kanefe.kernels.events.steps_with_events`: two events can be ways through one zero
            is_one = (self._values == self._values[i]) & ~self._is_bound
            np.maximum(self._noise, self._noise[i], out=self._noise, where=is_one)

    def renew(self, t: float, y: np.ndarray) -> None:
        """Account for a jump of forces at the present time: margins that must not be below zero are evaluated again."""
        if not self._is_bound.any():
            return
        state = seen(self._model, t, y)
        for i, event in enumerate(self.events):
            if isinstance(event, MarginEvent):
                self._values[i], self._noise[i] = event.value(t, state), event.blur(t, state)

    def _column(self, event: Event) -> int | None:
        """Return where compiled code has the value of an event; None: it does not."""
        if self._watching is None:
            return None
        if isinstance(event, EventOfLoad) and event.number in self._watching.columns:
            return self._watching.columns[event.number].start + event.index
        if isinstance(event, (ContactChange, ReportedContactEvent)):
            return self._watching.contact_columns.get(event.kind)
        return None

    def _change(self, event: Event) -> tuple[int, int, int, int]:
        """Return how compiled code does the action of an event: see `WatchedRun.changes`."""
        if isinstance(event, ContactChange):
            return CODES[event.kind], 0, 0, 0
        if self._watching is None or not isinstance(event, EventOfLoad) or event.number not in self._watching.rows:
            return -1, 0, 0, 0
        return self._watching.rows[event.number], event.index, event.where.start, event.where.stop - event.where.start

    def _load(self, event: Event) -> int:
        """Return the number in the tables of the load of an event; the number of loads there where it is of none."""
        rows = {} if self._watching is None else self._watching.rows
        return rows.get(event.number, len(rows)) if isinstance(event, EventOfLoad) else len(rows)

    def _watched(self) -> WatchedRun:
        count = len(self.events)
        kinds = [kind_for_kernels(event) for event in self.events]
        model = self._model
        looks = len(first_look_shares(model))
        most = looks * count
        first = model.coordinate_count + model.free_count + model.state_count
        changes = [event for event in self.events if isinstance(event, ContactChange)]
        if any(event.terminal and isinstance(event, ReportedContactEvent) for event in self.events):
            # Python looks at what they lead to
            kinds = [Does.BOUND if kind == Does.BOUND_CHANGES else kind for kind in kinds]
        of_run = (changes[0].stop, changes[0].rtol, changes[0].look.length) if changes else (np.inf, 0.0, 1.0)
        reports = report_count(sum(len(model.rigid_contact(k).probes) for k in range(len(model.rigid_contacts))))
        return WatchedRun(
            columns=np.array(list(self._compiled.values()), dtype=np.int64),
            directions=np.array([event.direction for event in self.events], dtype=np.int64),
            kinds=np.array(kinds, dtype=np.int64),
            loads=np.array([self._load(event) for event in self.events], dtype=np.int64),
            known=self._known,
            values=self._values,
            noise=self._noise,
            last=self._last,
            records=np.empty((2 * (most + reports) + LEAST_RECORDS, 2)),
            counts=np.zeros(2, dtype=np.int64),
            before=np.empty((0, first + QUADRATURES)),
            times=np.empty(looks + 1),
            samples=np.empty(looks + 1),
            brackets=np.empty((2 * looks + 2, 2)),
            found=np.empty((most, 2)),
            changes=np.array([self._change(event) for event in self.events], dtype=np.int64).reshape(-1, 4),
            actions=self._actions,
            regime=self._regime,
            usual=self._usual,
            first_quadrature=first,
            after=np.empty(first + QUADRATURES),
            span=self._span,
            stop=of_run[0],
            rtol=of_run[1],
            length=of_run[2],
        )

    def keep_states(self, names: tuple[str, ...]) -> None:
        """Let `take_records` have the states before events of these names."""
        is_same, self._with_states = self._with_states == names, names
        if self.watched is not None and not is_same:
            rows = len(self.watched.records) if names else 0
            self.watched = self.watched._replace(before=np.empty((rows, len(self.watched.after))))

    def take_records(self, happened: Callable[[str, float, Vector], None]) -> None:
        """Take in what happened in steps of compiled code; `happened` is told of events with their states before."""
        if self.watched is None:
            return
        at = 0
        for row, (t, event) in enumerate(self.watched.records[: self.watched.counts[0]].tolist()):
            counts = [len(self.times[name]) for name in self._with_states]
            if event < 0.0:
                self.telling.take_code(self._model, t, int(-1.0 - event))
            else:
                at = row  # what follows from it at that time has no row of its own
                self.times[self.events[int(event)].name].append(t)
            for name, count in zip(self._with_states, counts, strict=True):
                if len(self.times[name]) > count:
                    happened(name, t, self.watched.before[at].copy())
        self.watched.counts[0] = 0

    @property
    def _is_at_zero(self) -> bool:
        """Whether a function is at a zero, so that its sign is not known."""
        return bool(self._noise.any()) or not self._values.all()

    def scan(self, stepper: Stepper, check_time: Callable[[], None]) -> list[tuple[float, Event]]:
        """Return what happened in the last step, in order of time, up to and with the first that acts.

        Events that act at the same moment are all returned. Nothing is where the step is taken again, up to where a law
        changes: then `is_again` is true. The search for a moment looks at the clock on its way.
        """
        t0, h = stepper.t_old, stepper.t - stepper.t_old
        times = t0 + h * (first_look_shares if self._is_at_zero else look_shares)(self._model)
        times = np.append(np.unique(times[(times > t0) & (times < stepper.t)]), stepper.t)
        quick = _quick_look(stepper) if self._compiled else None
        if not self._known.all():  # compiled code had estimates
            self._values[:] = np.where(
                self._known > 0.0, self._values, self._looked_at(stepper, quick, np.array([t0]))[0]
            )
        table = np.vstack((self._values, self._looked_at(stepper, quick, times)))
        times = np.append(t0, times)
        self._check_short_ways(table)
        found: list[tuple[float, Event]] = []
        for i, event in enumerate(self.events):
            found += [(t, event) for t in self._roots(stepper, quick, i, times, table[:, i], check_time)]
        found.sort(key=lambda entry: entry[0])
        acting = next((t for t, event in found if event.acts and not self._has_acted(t, event)), None)
        self.is_again = acting is not None and self._is_kink(found, acting) and stepper.step_again(acting)
        self.acting = acting = None if self.is_again else acting
        if self.is_again:
            return []
        if acting is not None:
            until = acting + 2 * time_tolerance(self._span, acting)
            late = [event for t, event in found if t > until and self._passes_at(stepper, quick, event, acting, t)]
            found = [entry for entry in found if entry[0] <= until] + [(acting, event) for event in late]
        for i, event in enumerate(self.events):
            roots = [t for t, other in found if other is event]
            self.times[event.name] += roots
            self._last[i] = max(roots, default=self._last[i])
            if acting is not None and roots:
                function, largest = self._along(stepper, quick, i), float(np.abs(table[:, i]).max())
                self._noise[i] = noise_after(_called, function, roots[-1], Within(t0, stepper.t, self._span), largest)
                before = table[np.searchsorted(times, roots[-1]) - 1, i]
                self._ways[i] = -np.sign(before)
            elif np.abs(table[1:, i]).max() > self._noise[i]:
                self._noise[i] = 0.0  # also where a step ends by chance just before the next zero
        self._values[:], self._known[:] = table[-1], 1.0
        return found

    def _passes_at(self, stepper: Stepper, quick: QuickLook | None, event: Event, t: float, root: float) -> bool:
        """Return whether an event with a root behind a time (s) happens at that time: see `passes_at`."""
        number = self.events.index(event)
        function = self._along(stepper, quick, number)
        within = Within(stepper.t_old, stepper.t, self._span)
        return not self._is_bound[number] and passes_at(_called, function, t, root, within)

    def _is_kink(self, found: Sequence[tuple[float, Event]], acting: float) -> bool:
        """Return whether what happens at a time is that a law changes there, see `kanefe.kernels.events.kinks`."""
        events = [event for t, event in found if t == acting]
        return all(isinstance(event, EventOfLoad) and (event.of.ends_step or event.of.action) for event in events)

    def _roots(
        self,
        stepper: Stepper,
        quick: QuickLook | None,
        number: int,
        times: np.ndarray,
        values: np.ndarray,
        check_time: Callable[[], None],
    ) -> list[float]:
        """Return when an event happened in the last step, from its values at some times of it."""
        event, noise, is_bound = self.events[number], float(self._noise[number]), bool(self._is_bound[number])
        of = StepSamples(times, values, len(times), 0)
        if is_still(of, is_bound):
            return []
        zeros = np.empty((2 * len(times), 2))
        function = _timed(self._along(stepper, quick, number), check_time)
        is_beyond = is_bound or isinstance(event, EventOfLoad)  # see `kanefe.kernels.events.roots_of_step`
        wanted = Sought(event.direction, noise, is_bound, is_beyond, self._span)
        found = zeros_of(_called, function, partial(_above, noise, function), of, wanted, zeros)
        # one without action may have been reported at this time, at which another ended the step
        roots = zeros[:found, 0].tolist()
        return [t for t in roots if event.acts or not is_known(t, self._last[number], self._span)]

    def _has_acted(self, t: float, event: Event) -> bool:
        """Return whether an event that only ends steps has just done so."""
        return ends_step_alone(event) and is_over(t, self._last[self.events.index(event)], self._span)

    def check_storm(self, t: float, happened: Sequence[Event]) -> None:
        """Take in the time of an action; raise a StepFailure if they follow each other without end."""
        happened = [event for event in happened if not ends_step_alone(event)]
        if not happened:
            return
        self._actions[:-1], self._actions[-1] = self._actions[1:].copy(), t
        width = t - self._actions[0]
        if width <= STORM_SHARE * self._span:
            raise without_end(happened[0], f"acted {STORM} times within {width:.2g} s")

    def _check_short_ways(self, table: np.ndarray) -> None:
        """Raise a StepFailure if a function that is sent back repeatedly passed zero before it could be evaluated."""
        for i, event in enumerate(self.events):
            times = self.times[event.name]
            if event.action is None or not self._noise[i] or len(times) < 2:
                continue
            seen = table[1:, i][np.abs(table[1:, i]) > self._noise[i]]
            if len(seen) and seen[0] * self._ways[i] > 0.0 and times[-1] - times[-2] <= STORM_SHARE * self._span:
                raise without_end(event, f"acted again after {times[-1] - times[-2]:.2g} s, and again after less")

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what is needed to continue."""
        arrays = {f"times {i}": np.array(self.times[event.name]) for i, event in enumerate(self.events)}
        return {**{name: array.copy() for name, array in self._kept.items()}, **arrays}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot, of which nothing has been told yet."""
        self.telling = ChangeReports(self.times, self._span)
        self.telling.forget(self.events)
        for name, array in self._kept.items():
            array[:] = snapshot[name]
        for i, event in enumerate(self.events):
            self.times[event.name] = snapshot[f"times {i}"].tolist()
            self._last[i] = max(self.times[event.name], default=-np.inf)

    def _values_of(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the values of all functions at times and states, shape (times, events)."""
        found = np.empty((len(times), len(self.events)))
        if self._compiled and self._watching is not None:
            values = self._watching.values(times, states, ALL)
            found[:, list(self._compiled)] = values[:, list(self._compiled.values())]
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


def _quick_look(stepper: Stepper) -> QuickLook | None:
    """Return a function of all event values of loads at a time of the last step, if a stepper provides it."""
    return stepper.values_at if looks_out(stepper) and stepper.has_values else None


def _timed(function: Callable[[float], float], check_time: Callable[[], None]) -> Callable[[float], float]:
    """Return a function that checks the time limit before each evaluation."""

    def timed(t: float) -> float:
        check_time()
        return function(t)

    return timed


def _called(function: Callable[[float], float], t: float) -> float:
    return function(t)


def _above(level: float, function: Callable[[float], float], t: float) -> float:
    return function(t) + level
