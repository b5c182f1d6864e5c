"""The one loop that drives all methods: chunks of steps, events, limits, checkpoints, and how it ends."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import KanefeError, SimulationError
from kanefe.frames import Vector
from kanefe.integrate.clock import CONTROLLERS, Clock
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.events.actions import acted
from kanefe.integrate.events.event import Event
from kanefe.integrate.events.event_search import EventWatch
from kanefe.integrate.kept_progress import Checkpoints
from kanefe.integrate.pace import Limits, OutOfTime, Pace, Poles, large_systems
from kanefe.integrate.sampled_steps import SampledSteps
from kanefe.integrate.sampling import Sampler
from kanefe.integrate.state_rows import StateRows, TakesStates
from kanefe.integrate.status import RunStatus, raised_by_user
from kanefe.integrate.stepper import StepFailure, Stepper, gives_accelerations, keeps_time, looks_out, passes_samples
from kanefe.kernels.events.watched_run import IS_CUT
from kanefe.tree.bent import bent_too_far

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kanefe.integrate.checkpoint import CheckpointFile, Progress

FIRST_CHUNK, CHUNK, LEAST_CHUNK = 16, 2000, 2
"""Number of steps in the first batch of a scene, whose duration is not known, and largest and least number in one."""

CHUNK_SECONDS = 0.1
"""Target duration of a batch, s: limits, the progress bar, Ctrl-C and checkpoints wait for its end."""

SOME_SHARE = 0.3
"""Fraction of the time of a run above which functions of the user dominate it."""

COUNTED = ("steps", "rejected", "evaluations", "factorisations", "jacobians")
"""Counts in the statistics of every run, zero if they do not apply to a method."""

QUADRATURE_NAMES = ("dissipated energy", "work of the loads")


class RunLoop:
    """A run on its way.

    Parameters
    ----------
    dynamics : Dynamics
    stepper : Stepper
        At the start, with the watch.
    times : ndarray, shape (T,)
        Times wanted; the last one is the end of the run.
    watch : EventWatch or None
    limits : Limits
    clock : Clock
    bar : progress bar
        In seconds of the run.
    sampler : Sampler or None
        Of a scene with controllers.
    poles : callable, optional
        Tells of those of its sampled loop.
    chunk : int
        Number of steps in the first batch.
    taker : TakesStates, optional
        Takes the states as the run goes on.

    Attributes
    ----------
    chunk : int
        Number of steps in the next batch.
    rows : StateRows
        The states at the times wanted.
    last : (float, ndarray) or None
        Time and state where the run ended, if it did before its end.
    last_accelerations : ndarray, shape (1, free), or None
    is_interrupted : bool
        Whether Ctrl-C ended the run.
    """

    def __init__(
        self,
        dynamics: Dynamics,
        stepper: Stepper,
        times: np.ndarray,
        watch: EventWatch | None,
        limits: Limits,
        clock: Clock,
        bar: Any,
        sampler: Sampler | None = None,
        poles: Poles | None = None,
        chunk: int = FIRST_CHUNK,
        taker: TakesStates | None = None,
    ) -> None:
        self._dynamics, self._model, self._stepper = dynamics, dynamics.model, stepper
        self._watch, self._limits, self._clock, self._bar = watch, limits, clock, bar
        self._sampler = sampler
        self._start, self._pace = stepper.t, Pace(dynamics.model, stepper, float(times[-1]), limits, sampler, poles)
        self.is_interrupted = False
        self._looking = stepper if watch and sampler is None and looks_out(stepper) else None
        # over events it goes step by step
        is_passing = sampler is not None and watch is None and dynamics.is_autonomous
        self._passing = stepper if is_passing and passes_samples(stepper) else None
        chunk = LEAST_CHUNK if large_systems(stepper) else chunk
        is_compiled = watch is None or (self._looking is not None and self._looking.can_look_out)
        self.chunk = chunk if is_compiled and not gives_accelerations(stepper) else 1
        if watch is not None:
            watch.keep_states(() if taker is None else tuple(taker.events))
        self._is_done = False
        self._checkpoints: Checkpoints | None = None
        self._before: dict[str, int | float] = {}
        y = stepper.state()
        self.rows = StateRows(times, len(y), self._model.free_count, stepper, taker)
        self._first = stepper.t, y
        self.last: tuple[float, Vector] | None = None
        self.last_accelerations: np.ndarray | None = None
        if times[0] == stepper.t:
            self.rows.states[0] = y
            self.rows.store_accelerations(0, 1)
            self.rows.stored = 1

    @property
    def statistics(self) -> dict[str, int | float]:
        """What the method has counted, with what was counted before the run was resumed."""
        now = dict.fromkeys(COUNTED, 0) | self._stepper.statistics
        return {name: value + self._before.get(name, 0) for name, value in now.items()}

    @property
    def told_of_steps(self) -> dict[str, list[float]]:
        """Of fixed steps "step_seconds", and "unconverged", where their iterations were left early."""
        stepper = self._stepper
        if not keeps_time(stepper):
            return {}
        found = {"step_seconds": stepper.step_seconds, "unconverged": [*(stepper.unconverged or ())]}
        return {name: numbers for name, numbers in found.items() if numbers}

    def resume(self, progress: Progress) -> None:
        """Continue from a checkpoint."""
        self._stepper.resume(progress.stepper)
        if self._watch:
            self._watch.resume(progress.watch)
        rows = self.rows
        rows.stored = len(progress.states)
        rows.states[: rows.stored] = progress.states
        if rows.accelerations is not None and progress.accelerations is not None:
            rows.accelerations[: rows.stored] = progress.accelerations
        now = self._stepper.statistics
        self._before = {name: value - now.get(name, 0) for name, value in progress.statistics.items()}
        self._clock.seconds = dict(progress.seconds)
        self._pace.resume()
        self._bar.update(self._stepper.t - self._start)

    def go_to(self, stop: float) -> RunStatus:
        """Continue to a later time (s), whose state is the only one that is stored; return how that ended."""
        self.last = None
        self.rows.aim(stop)
        self._pace.aim(stop)
        if self._sampler is not None:
            self._sampler.aim(stop)
        self._stepper.aim(stop if self._sampler is None else self._sampler.next)
        return self._run()

    def go(self, file: CheckpointFile | None = None) -> RunStatus:
        """Run to the end, and return how it ended.

        Whatever ends it, a checkpoint is written before: of the end, or where something went wrong or a terminal event
        ended it, of a moment before. Ctrl-C, and what a function of the user raises, stop the run with what there is.
        """
        self._checkpoints = kept = Checkpoints(file, self._progress, self._clock, self._stepper)
        kept.begin()
        try:
            status = self._run()
        except KeyboardInterrupt:  # a step may be half done: the checkpoint is of a moment before
            kept.write()
            return self._interrupted()
        except Exception as error:
            told = None if self._stepper.step_count == 0 else raised_by_user(self._stepper.t, error)
            if told is None:
                kept.write()
                raise
            status = self._ended(told)
        except BaseException:
            kept.write()
            raise
        is_at_end = status.kind != "failed" and (self.last is None or self.last[0] == self._stepper.t)
        kept.end(is_at_end)
        return status

    def _run(self) -> RunStatus:
        first, stepper, rows = self._stepper.step_count, self._stepper, self.rows
        while rows.has_room():
            steps = stepper.step_count - first
            if (limit := self._pace.limit(steps)) is not None:
                return self._ended(self._pace.with_growth(limit))
            most = self.chunk if self._limits.steps is None else min(self.chunk, self._limits.steps - steps)
            try:
                stored = rows.stored
                with self._clock.part("steps"):
                    self._integrate(most)
                    rows.cover(stepper)
                if rows.accelerations is not None:
                    with self._clock.part("outputs"):
                        rows.store_accelerations(stored, rows.stored)
                self._pace.check_progress()
                self._pace.check_pace()
                if self._watch and not self._is_done and (stopped := self._events(self._watch)) is not None:
                    return stopped
            except StepFailure as failure:
                return self._ended(self._failed(failure))
            except (KanefeError, np.linalg.LinAlgError) as error:
                if stepper.step_count == 0:
                    raise  # a scene that cannot start is refused, not run in part
                return self._ended(RunStatus.of_error(stepper.t, error))
            if self._checkpoints is not None:
                self._checkpoints.keep(CHUNK_SECONDS)
            # the ends of the steps are finite; between them powers of large numbers need not be
            if rows.is_ready and (finite := rows.count_finite()) < rows.stored:
                at, what = float(rows.times[finite]), "states within a step are beyond all numbers"
                return self._ended(RunStatus("failed", at, what, "a smaller rtol"))
        return RunStatus("finished", stepper.t)

    def _interrupted(self) -> RunStatus:
        self.is_interrupted = True
        remedy = "start= the last state, result.at(result.times[-1]), to go on"
        share = self._clock.share_of_user
        if share > SOME_SHARE or not self._dynamics.is_autonomous:
            remedy = (
                f"{share:.0%} of the time went to Python functions, and a run that calls them leaves compiled code in "
                "each evaluation: sample them with add_controller, or compile them with numba.njit"
            )
        return self._ended(RunStatus("stopped", self._stepper.t, "by Ctrl-C", remedy))

    def _integrate(self, most: int) -> None:
        stepper, begun = self._stepper, time.perf_counter()
        rows, steps = self.rows, stepper.step_count
        first = rows.stored
        self._is_done = False
        try:
            if self._sampler is None and self._watch and self.chunk > 1:
                self._integrate_over_events(self._watch, most)
            elif self._sampler is None:
                rows.stored += stepper.integrate_through(rows.times[first:], rows.states[first:], most)
            else:
                self._integrate_sampled(self._sampler, most)
        except (Exception, KeyboardInterrupt):
            # what was passed before the failure is stored all the same
            rows.stored = max(first, int(np.searchsorted(rows.times, stepper.t, side="right")))
            raise
        finally:
            if self._sampler is not None:
                self._clock.set_aside(CONTROLLERS, self._sampler.taken_seconds())
            self._bar.update(stepper.t - self._start - self._bar.n)
        if self.chunk > 1:
            done = max(stepper.step_count - steps, 1)
            wanted = done * CHUNK_SECONDS / max(time.perf_counter() - begun, 1e-9)
            self.chunk = int(max(LEAST_CHUNK, min(wanted, CHUNK, 4 * self.chunk)))

    def _integrate_over_events(self, watch: EventWatch, most: int) -> None:
        """Continue to a step in which an event needs Python; by single steps where one is a function of the user."""
        rows, first = self.rows, self.rows.stored
        if watch.watched is None or self._looking is None:
            rows.stored += self._stepper.integrate_through(rows.times[first:], rows.states[first:], 1)
            return
        while True:
            times, states, passed = rows.times[first:], rows.states[first:], rows.stored - first
            try:
                found, self._is_done = self._looking.integrate_over_events(times, states, passed, most, watch.watched)
            finally:
                watch.take_records(rows.happened)  # also of what happened before a step that failed
            rows.stored = first + found
            if not watch.watched.counts[IS_CUT]:
                return
            rows.cover(self._stepper)
            most = 0  # the events of this step alone

    def _integrate_sampled(self, sampler: Sampler, most: int) -> None:
        """Continue from sample to sample, for so many steps or so long as a go takes; steps end at samples."""
        rows = self.rows
        if self._passing is not None:
            rows.stored = self._passing.integrate_over_samples(rows.times, rows.states, rows.stored, most, sampler)
            if sampler.has_alarm:
                self._pace.check_drives()
        else:
            steps = SampledSteps(self._stepper, sampler, self._watch, self._pace)
            steps.go(rows, most, time.perf_counter() + CHUNK_SECONDS)

    def _events(self, watch: EventWatch) -> RunStatus | None:
        """Look for events in the last step, and do what they ask for; return a status if one ends the run."""
        with self._clock.part("events"):
            found = self._scanned(watch)
            if isinstance(found, RunStatus):
                return found
            if watch.is_again:
                self.rows.store_to(self._stepper.t)
                return None
            self._tell_of(found)
            if watch.acting is None:
                return None
            at_once = [event for t, event in found if t >= watch.acting]
            return self._act(watch, watch.acting, [event for event in watch.events if event in at_once])

    def _scanned(self, watch: EventWatch) -> RunStatus | Sequence[tuple[float, Event]]:
        try:
            return watch.scan(self._stepper, self._pace.check_time)
        except (StepFailure, OutOfTime) as end:  # what the step went past is not known: it does not count
            t = self._stepper.t_old
            self.rows.store_to(t)
            self._stand_at(t, self._stepper.states(np.array([t]))[0])
            if isinstance(end, OutOfTime):
                return self._pace.out_of_time(t)
            return RunStatus("failed", t, end.reason, end.remedy)

    def _act(self, watch: EventWatch, t: float, happened: Sequence[Event]) -> RunStatus | None:
        """Do what events ask for that happened at a time (s), in the order given, and go on from there."""
        rows, before = self.rows, self._stepper.states(np.array([t]))[0]
        rows.store_to(t)
        terminal = next((event for event in happened if event.terminal), None)
        if terminal is not None:
            self._stand_at(t, before)
            return terminal.status(t)
        try:
            y = acted(self._dynamics, watch.events, happened, t, before)
        except SimulationError as refusal:
            self._stand_at(t, before)
            if isinstance(refusal, StepFailure):
                return RunStatus("failed", t, refusal.reason, refusal.remedy)
            return RunStatus.of_error(t, refusal)
        told = watch.telling.take(happened)
        for name in rows.events:
            if name in told:
                rows.happened(name, t, before)
        terminal = next((event for event in watch.events if event.terminal and event.name in told), None)
        if terminal is not None:
            self._stand_at(t, y)
            return terminal.status(t)
        if self._sampler is not None and t == self._stepper.t_old and t == rows.times[rows.stored - 1]:
            rows.states[rows.stored - 1] = y  # what drives that jump let go at once is not told as held
        self._stepper.restart(t, y)
        watch.begin(t, y, happened)
        self._pace.mark(t)
        watch.check_storm(t, [event for event in happened if event.acts])
        return None

    def _tell_of(self, found: Sequence[tuple[float, Event]]) -> None:
        """Tell of events of the last step and the states before them."""
        for t, event in found if self.rows.events else ():
            if event.name in self.rows.events:
                self.rows.happened(event.name, t, self._stepper.states(np.array([t]))[0])

    def _failed(self, failure: StepFailure) -> RunStatus:
        named = f"; the worst is {self._name(failure.component)}" if failure.component is not None else ""
        return RunStatus("failed", self._stepper.t, f"{failure.reason}{named}", failure.remedy)

    def _name(self, component: int) -> str:
        names = (*self._model.state_names, *QUADRATURE_NAMES)
        return f"'{names[component]}'"

    def _ended(self, status: RunStatus) -> RunStatus:
        """Keep what is finite, and the state at which the run ended, where it is one."""
        rows = self.rows
        rows.stored = rows.count_finite()
        state = self._stepper.state()
        if np.all(np.isfinite(state)):
            self._stand_at(self._stepper.t, state)
        elif rows.is_empty:
            self.last = self._first
        if status.kind == "failed" and self.last is not None:
            t, y = self.last
            q, u, _ = self._model.parts(y)
            bent = bent_too_far(self._model.route, t, q, u)
            if bent:
                return RunStatus.of_error(status.time, SimulationError(bent))
        return self._pace.with_growth(status) if status.kind == "failed" else status

    def _stand_at(self, t: float, y: Vector) -> None:
        self.last = t, y
        self.last_accelerations = self.rows.accelerations_at(np.array([t]))

    def _progress(self) -> Progress:
        from kanefe.integrate.checkpoint import Progress

        rows = self.rows
        return Progress(
            states=rows.states[: rows.stored],
            accelerations=None if rows.accelerations is None else rows.accelerations[: rows.stored],
            stepper=self._stepper.snapshot(),
            watch=self._watch.snapshot() if self._watch else {},
            statistics=self.statistics,
            seconds=dict(self._clock.seconds),
        )
