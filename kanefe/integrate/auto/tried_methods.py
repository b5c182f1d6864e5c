"""A run whose method is tried against others: on stretches of it another method goes from the same state.

What decides is the work that is counted, and how far both are apart at the end of the stretch: that bounds the larger
of their errors, whatever each estimates of itself. The run goes on with the method that has less work, as long as both
agree within the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.auto.trials import Stretch, Trial, apart, energies_apart, went_over
from kanefe.integrate.auto.work import WorkCounter
from kanefe.integrate.stepper import StepFailure, Stepper, looks_out
from kanefe.tree.bending import Bent
from kanefe.tree.scales import state_scales

if TYPE_CHECKING:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.methods.kernel_stepper import KernelStepper
    from kanefe.kernels.events.watched_run import WatchedRun

COUNTED = "steps", "rejected", "evaluations", "factorisations", "jacobians"

STEPS_OVER = "extrapolation"
"""The method whose steps may be longer than vibrations, which its estimate does not show then."""

SHARE = 0.08
"""Largest work of trials relative to that of the whole run: a tenth, with what is left late."""

FORESEEN = 10.0
"""Largest work of the rest of a run, as foreseen, relative to that so far."""

FIRST_STRETCH = 16
"""Steps of the first stretch."""

SETTLED = 2.0
"""Fall of the work for a second of the run, between two looks, from which on a method still begins."""

DEARER = 4.0
"""Growth of the same from which on the regime has changed, and all methods are tried again."""

FIRST_LOOK = 1e6
"""Work at which it is looked at first, in products: a third of a millisecond."""

LOOKS = 2
"""Looks at the work until the steps have doubled, about."""

WORTH = 3e6
"""Work that a trial costs in any case, in products: a millisecond to make another stepper."""

LEAST_GAIN = 0.2
"""Share of the work that another method has to save: to about this accuracy work is counted."""

FEWEST_STEPS = 3
"""Steps of another method in a stretch below which they are not typical of it, because the last one is cut."""

WINS = 2
"""Stretches, one twice as long as the other, on which a method has to be better that follows every vibration: where
those of the start fade, others will have longer steps."""

CHECKED = 2.0
"""Largest work of a trial that checks a method which steps over vibrations, relative to the work of that."""

PROMISED = 10.0
"""Largest error of a run over its tolerance, which is spread over its stretches as if their errors were independent of
each other: that of a stretch may be this times the root of its share of the span."""


class TriedMethods:
    """A stepper of the first of some methods, or of what is better: see `Stepper`.

    Parameters
    ----------
    first : Stepper
        That of the run, until another is better.
    rivals : sequence of function
        (dynamics) -> stepper of another method.
    dynamics : Dynamics
    span : (float, float)
        Start and end of the run, s.
    rtol : float
        Tolerance of the run, relative to the size of the scene and its energy.
    counter : WorkCounter

    Attributes
    ----------
    trials : list of Trial
        What was tried.
    """

    def __init__(
        self,
        first: Stepper,
        rivals: Sequence[Callable[[Dynamics], Stepper]],
        dynamics: Dynamics,
        span: tuple[float, float],
        rtol: float,
        counter: WorkCounter,
    ) -> None:
        self._rivals, self._dynamics, self._counter, self._rtol = rivals, dynamics, counter, rtol
        self._allowed = rtol * state_scales(dynamics.model)[: dynamics.model.coordinate_count]
        self._start, self._span, self._aim = span[0], span[1] - span[0], span[1]
        model = dynamics.model
        begin = model.coordinate_count + model.free_count
        self._held = slice(begin, begin + model.state_count)
        self._steppers = {0: cast("KernelStepper", first)}
        self._fresh: dict[int, Mapping[str, np.ndarray]] = {}
        self._begin()

    def _begin(self) -> None:
        self._now = self._rival = 0
        self._ran = [0]
        self._steps_before = -self._steppers[0].step_count
        self._counts: dict[str, int | float] = dict.fromkeys(COUNTED, 0)
        self._seen = dict(self._steppers[0].statistics)
        self._tried_counts: dict[str, int | float] = dict.fromkeys(COUNTED, 0)
        self._work = self._tried_work = 0.0
        self._stretch: Stretch | None = None
        self._length, self._next = FIRST_STRETCH, self._counter.steps_of(FIRST_LOOK, FIRST_STRETCH)
        self._out: set[int] = set()
        self._wins: dict[int, int] = {}
        self._price, self._afforded = math.inf, 0.0
        self._looked = self._start, 0.0, 0
        self.trials: list[Trial] = []

    def _stepper(self, number: int) -> KernelStepper:
        """Return the stepper of a method, made when it is first asked for."""
        if number not in self._steppers:
            made = self._steppers[number] = cast("KernelStepper", self._rivals[number - 1](self._dynamics))
            self._fresh[number] = made.snapshot()
        return self._steppers[number]

    @property
    def _current(self) -> KernelStepper:
        return self._steppers[self._now]

    @property
    def name(self) -> str:
        """Of the method, or of all that have run, the present one last."""
        before = [self._steppers[number].name for number in self._ran if number != self._now]
        return f"{', '.join(before)}, then {self._current.name}" if before else self._current.name

    @property
    def t(self) -> float:
        """Time reached in s."""
        return self._current.t

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return self._current.t_old

    @property
    def worst(self) -> int:
        """Component of the state whose error was the largest at the last step."""
        return int(getattr(self._current, "worst", 0))

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far, without those of trials."""
        return self._steps_before + self._current.step_count

    @property
    def statistics(self) -> dict[str, int | float]:
        """What the methods have counted, with the evaluations, factorisations and Jacobians of trials."""
        counts = self._counted()
        for name, value in self._tried_counts.items():
            if name not in ("steps", "rejected"):
                counts[name] = counts.get(name, 0) + value
        return counts

    @property
    def unanswered(self) -> list[str]:
        """What functions of the user gave no number for."""
        return [text for stepper in self._steppers.values() for text in getattr(stepper, "unanswered", ())]

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most by any of them."""
        return [bent for number in self._ran for bent in self._steppers[number].bent]

    @property
    def told(self) -> list[str]:
        """What was tried, in words: a line for each trial that was taken, and for the last one of each other method."""
        last = {trial.method: i for i, trial in enumerate(self.trials)}
        lines = []
        for i, trial in enumerate(self.trials):
            if not trial.is_taken and i != last[trial.method]:
                continue
            line = f"{self._steppers[trial.method].name} from {trial.start:.4g} to {trial.end:.4g} s: "
            line += f"{trial.work:.2g} of the work" if math.isfinite(trial.off) else f"left at {trial.work:.2g} of the work"
            if math.isfinite(trial.off):
                line += f", apart by {trial.off:.1g} of what is allowed"
            lines.append(line + (", taken" if trial.is_taken else ""))
        return lines

    @property
    def tried_share(self) -> float:
        """Work of all trials, relative to that of the run without them."""
        self._settle()
        return self._tried_work / self._work if self._work > 0.0 else 0.0

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Continue until all times are passed or so many steps are taken: see `Stepper.integrate_through`."""
        passed, end = 0, self.step_count + most_steps
        while passed < len(times) and (left := end - self.step_count) > 0:
            most = min(left, self._steps_to_look())
            try:
                passed += self._current.integrate_through(times[passed:], states[passed:], most)
            except StepFailure as failure:
                passed = self._passed(times, states, passed)
                self._fall_back(failure)
        return passed

    def _passed(self, times: np.ndarray, states: np.ndarray, passed: int) -> int:
        """Return how many times were passed before a failure, with their states closed."""
        now = int(np.searchsorted(times, self.t, side="right"))
        for i in range(passed, now):
            states[i] = self._dynamics.projected(float(times[i]), states[i])
        return now

    @property
    def can_look_out(self) -> bool:
        """Whether they pass over quiet steps by themselves: see `LooksOut`."""
        return looks_out(self._steppers[0]) and self._steppers[0].can_look_out

    @property
    def has_values(self) -> bool:
        """Whether `values_at` is available."""
        return looks_out(self._steppers[0]) and self._steppers[0].has_values

    def values_at(self, t: float) -> Vector:
        """Return the event values of loads at a time of the last step."""
        return self._current.values_at(t)

    def integrate_over_events(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, watched: WatchedRun
    ) -> tuple[int, bool]:
        """Continue in the same way over events: see `LooksOut.integrate_over_events`."""
        if most_steps > 0:
            most_steps = min(most_steps, self._steps_to_look(watched))
        try:
            return self._current.integrate_over_events(times, states, passed, most_steps, watched)
        except StepFailure as failure:
            passed = self._passed(times, states, passed)
            self._fall_back(failure)
            watched.regime[0] = -1.0
            return passed, True

    def state(self) -> Vector:
        """Return the state at t."""
        return self._current.state()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        return self._current.states(times)

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        self._aim = stop
        self._current.aim(stop)

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        if self._stretch is not None:
            self._stretch.samples.append((t, np.array(y)))
        self._current.go_on_with(t, y)

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state: a stretch that it cuts begins again."""
        self._leave_stretch()
        self._current.restart(t, y)

    def _counted(self) -> dict[str, int | float]:
        """Return what the run has counted, without trials."""
        counts = dict(self._counts)
        for name, value in self._since_seen().items():
            counts[name] = counts.get(name, 0) + value
        return counts

    def _since_seen(self) -> dict[str, int | float]:
        return {name: value - self._seen.get(name, 0) for name, value in self._current.statistics.items()}

    def _settle(self) -> None:
        """Book what the current method has done since it was looked at."""
        done = self._since_seen()
        self._work += self._counter.work(done)
        for name, value in done.items():
            self._counts[name] = self._counts.get(name, 0) + value
        self._seen = dict(self._current.statistics)

    def _steps_to_look(self, watched: WatchedRun | None = None) -> int:
        """Return how many steps are taken before the next look; look, if it is time."""
        restarts = -math.inf if watched is None or watched.regime[0] < 0.0 else float(watched.regime[1])
        if self._stretch is not None and restarts != self._stretch.restarts:
            self._leave_stretch()
        if self.step_count >= self._next and self.t < self._aim:
            self._settle()
            if self._stretch is not None:
                now = self._now
                self._compare(self._stretch)
                if watched is not None and now != self._now:
                    watched.regime[0], restarts = -1.0, -math.inf  # steps are counted anew
            self._plan(restarts)
        return max(self._next - self.step_count, 1)

    def _leave_stretch(self) -> None:
        if self._stretch is not None:
            self._stretch, self._next = None, self.step_count + 1

    def _plan(self, restarts: float) -> None:
        """Begin a stretch if it is afforded, or say when to look again."""
        t, steps = self.t, self.step_count
        since, work, before = self._looked
        self._looked = t, self._work, steps
        if steps == before:  # another method has begun
            self._next = steps + FIRST_STRETCH
            return
        price, a_step = (self._work - work) / max(t - since, 1e-300), (self._work - work) / max(steps - before, 1)
        begins = SETTLED * price < self._price  # the first steps of a method, or after an event
        if price > DEARER * self._price:
            self._out.clear()
            self._length = FIRST_STRETCH
        self._price = price
        left = self._start + self._span - t
        afforded = SHARE * (self._work + min(price * left, FORESEEN * self._work)) - self._tried_work
        rival = self._next_rival()
        cost = self._length * a_step + (WORTH if rival is not None and rival not in self._steppers else 0.0)
        if rival is None or begins or cost > min(afforded, price * left):
            self._next = steps + max(FIRST_STRETCH, steps // LOOKS)
            return
        self._rival, self._afforded, self._next = rival, afforded, steps + self._length
        self._stretch = Stretch(t, self.state(), steps, self._work, restarts)

    def _next_rival(self) -> int | None:
        """Return the next method to be tried, in turn; None if all others are out."""
        count = 1 + len(self._rivals)
        for i in range(1, count + 1):
            number = (self._rival + i) % count
            if number != self._now and number not in self._out:
                return number
        return None

    def _compare(self, stretch: Stretch) -> None:
        """Let the rival go over the stretch, and go on with it if it is better."""
        self._stretch = None
        own, number, end = self._work - stretch.work, self._rival, (self.t, self.state())
        most = max(own, min(self._afforded, CHECKED * own)) if self._is_checked(self._now) else own
        found, counts = went_over(self._stepper(number), stretch, end, self._held, most, self._counter)
        work = self._counter.work(counts)
        self._tried_work += work
        for name, value in counts.items():
            self._tried_counts[name] = self._tried_counts.get(name, 0) + value
        off = math.inf
        if found is not None:
            share = PROMISED * math.sqrt((end[0] - stretch.t) / self._span)
            lost = energies_apart(self._dynamics, end[0], found, end[1]) / (share * self._rtol)
            off = max(apart(found, end[1], share * self._allowed), lost)
        is_taken, steps = False, int(counts["steps"])
        if found is not None and off > 1.0:
            is_taken = self._is_checked(self._now)
            self._out.add(self._now if is_taken else number)
        elif found is not None and work < (1.0 - LEAST_GAIN) * own:
            self._wins[number] = self._wins.get(number, 0) + 1
            is_taken = self._wins[number] == (1 if number == 0 or self._is_checked(number) else WINS)
            if not is_taken:
                self._rival = number - 1
        else:
            self._wins[number] = 0
            if found is not None and steps < FEWEST_STEPS:
                self._rival = number - 1  # the same again: its steps are cut by the end of the stretch
        self.trials.append(Trial(number, stretch.t, end[0], work / own, off, steps, is_taken))
        self._length *= 2
        if is_taken:
            self._go_on_with_rival(number, *end)

    def _is_checked(self, number: int) -> bool:
        """Return whether a method steps over vibrations, so that its own estimate does not tell of them."""
        return self._steppers[number].name == STEPS_OVER

    def _go_on_with_rival(self, number: int, t: float, y: Vector) -> None:
        rival = self._steppers[number]
        self._settle()
        self._now, self._wins = number, {}
        if number not in self._ran:
            self._ran.append(number)
        self._seen = dict(rival.statistics)
        self._steps_before = int(self._counts["steps"]) - rival.step_count
        rival.aim(self._aim)
        rival.go_on_with(t, y)
        self._price, self._looked = math.inf, (t, self._work, self.step_count)

    def _fall_back(self, failure: StepFailure) -> None:
        """Go on with the first method where another fails."""
        if self._now == 0:
            raise failure
        self._leave_stretch()
        self._out.add(self._now)
        t, y = self.t, self.state()
        self._go_on_with_rival(0, t, y)
        self._steppers[0].restart(t, y)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the data that all of them need to continue."""
        numbers = self._now, self._rival, self._length, self._next, self._looked[2]
        reals = self._price, self._afforded, *self._looked[:2], self._work, self._tried_work
        kept = {
            "numbers": np.array(numbers, dtype=np.int64),
            "reals": np.array(reals),
            "out": np.array(sorted(self._out), dtype=np.int64),
            "wins": np.array(list(self._wins.items()), dtype=np.int64).reshape(-1, 2),
            "ran": np.array(self._ran, dtype=np.int64),
            "counts": np.array([_in_order(x) for x in (self._counts, self._seen, self._tried_counts)]),
            "trials": np.array(self.trials, dtype=float).reshape(-1, len(Trial._fields)),
        }
        if (stretch := self._stretch) is not None:
            kept["stretch"] = np.array((stretch.t, stretch.step, stretch.work, stretch.restarts))
            kept["sampled"] = np.array([stretch.t, *(t for t, _ in stretch.samples)])
            kept["states"] = np.array([stretch.y, *(y for _, y in stretch.samples)])
        for number, stepper in self._steppers.items():
            kept |= {f"{number} {name}": array for name, array in stepper.snapshot().items()}
        return kept

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        for number in {*self._steppers, *(int(name.split()[0]) for name in snapshot if name[0].isdigit())}:
            first = f"{number} "
            own = {name.removeprefix(first): x for name, x in snapshot.items() if name.startswith(first)}
            self._stepper(number).resume(own or self._fresh[number])
        self._now, self._rival, self._length, self._next, step = snapshot["numbers"].tolist()
        self._price, self._afforded, t, work, self._work, self._tried_work = snapshot["reals"].tolist()
        self._looked = t, work, step
        self._wins = dict(snapshot["wins"].tolist())
        self._out, self._ran = set(snapshot["out"].tolist()), snapshot["ran"].tolist()
        self._counts, self._seen, self._tried_counts = (dict(zip(COUNTED, x, strict=True)) for x in snapshot["counts"].tolist())
        self._steps_before = int(self._counts["steps"] - self._seen["steps"])
        self.trials = [Trial(int(m), *x, int(steps), bool(taken)) for m, *x, steps, taken in snapshot["trials"].tolist()]
        self._stretch = None
        if "stretch" in snapshot:
            t, step, work, restarts = snapshot["stretch"].tolist()
            samples = list(zip(snapshot["sampled"][1:].tolist(), snapshot["states"][1:], strict=True))
            self._stretch = Stretch(t, snapshot["states"][0], int(step), work, restarts, samples)


def _in_order(counts: Mapping[str, int | float]) -> list[int | float]:
    return [counts.get(name, 0) for name in COUNTED]
