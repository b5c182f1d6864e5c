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
from kanefe.integrate.auto.in_turn import SteppersInTurn
from kanefe.integrate.auto.trial_plan import FIRST_LOOK, FIRST_STRETCH, TrialPlan
from kanefe.integrate.auto.trials import Stretch, Trial, apart, energies_apart, went_over
from kanefe.integrate.auto.work import WorkCounter
from kanefe.integrate.stepper import StepFailure, Stepper, looks_out
from kanefe.tree.bending import Bent
from kanefe.tree.scales import state_scales

if TYPE_CHECKING:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.methods.kernel_stepper import KernelStepper
    from kanefe.integrate.sampling import Sampler
    from kanefe.kernels.events.watched_run import WatchedRun

COUNTED = "steps", "rejected", "evaluations", "factorisations", "jacobians"

STEPS_OVER = "extrapolation"
"""The method whose steps may be longer than vibrations, which its estimate does not show then."""

PROMISED = 10.0
"""Largest error of a run, relative to its tolerance. Those of phases add up, so that a stretch may have this times its
share of the span."""


class TriedMethods(SteppersInTurn):
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
        super().__init__(dynamics)
        self._rivals, self._counter, self._rtol = rivals, counter, rtol
        self._allowed = rtol * state_scales(dynamics.model)[: dynamics.model.coordinate_count]
        self._span, self._aim = span[1] - span[0], span[1]
        model = dynamics.model
        begin = model.coordinate_count + model.free_count
        self._held = slice(begin, begin + model.state_count)
        self._steppers = {0: cast("KernelStepper", first)}
        self._fresh: dict[int, Mapping[str, np.ndarray]] = {}
        self._plan = TrialPlan(1 + len(rivals), *span, counter.steps_of(FIRST_LOOK, FIRST_STRETCH))
        self._number, self._ran = 0, [0]
        self._steps_before = -self._steppers[0].step_count
        self._counts: dict[str, int | float] = dict.fromkeys(COUNTED, 0)
        self._seen = dict(self._steppers[0].statistics)
        self._tried_counts: dict[str, int | float] = dict.fromkeys(COUNTED, 0)
        self._stretch: Stretch | None = None
        self.trials: list[Trial] = []

    def _stepper(self, number: int) -> KernelStepper:
        """Return the stepper of a method, made when it is first asked for."""
        if number not in self._steppers:
            made = self._steppers[number] = cast("KernelStepper", self._rivals[number - 1](self._dynamics))
            self._fresh[number] = made.snapshot()
        return self._steppers[number]

    @property
    def _now(self) -> KernelStepper:
        return self._steppers[self._number]

    @property
    def name(self) -> str:
        """Of the method, or of all that have run, the present one last."""
        before = [self._steppers[number].name for number in self._ran if number != self._number]
        return f"{', '.join(before)}, then {self._now.name}" if before else self._now.name

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far, without those of trials."""
        return self._steps_before + self._now.step_count

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
        return [text for stepper in self._steppers.values() for text in stepper.unanswered]

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most by any of them."""
        return [bent for number in self._ran for bent in self._steppers[number].bent]

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Time and state where rejected steps of one that has run have clustered the most."""
        found = (self._steppers[number].hardest for number in self._ran)
        return next((one for one in found if one is not None), None)

    @property
    def told(self) -> list[str]:
        """What was tried, in words: a line for each trial that was taken, and for the last one of each other method."""
        last = {trial.method: i for i, trial in enumerate(self.trials)}
        lines = []
        for i, trial in enumerate(self.trials):
            if not trial.is_taken and i != last[trial.method]:
                continue
            line = f"{self._steppers[trial.method].name} from {trial.start:.4g} to {trial.end:.4g} s: "
            line += (
                f"{trial.work:.2g} of the work" if math.isfinite(trial.off) else f"left at {trial.work:.2g} of the work"
            )
            if math.isfinite(trial.off):
                line += f", apart by {trial.off:.1g} of what is allowed"
            lines.append(line + (", taken" if trial.is_taken else ""))
        return lines

    @property
    def tried_share(self) -> float:
        """Work of all trials, relative to that of the run without them."""
        self._settle()
        return self._plan.tried_work / self._plan.work if self._plan.work > 0.0 else 0.0

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Continue until all times are passed or so many steps are taken: see `Stepper.integrate_through`."""
        passed, end = 0, self.step_count + most_steps
        while passed < len(times) and (left := end - self.step_count) > 0:
            most = min(left, self.steps_to_look())
            try:
                passed += self._now.integrate_through(times[passed:], states[passed:], most, most_steps != 1)
            except StepFailure as failure:
                passed = self._passed_by_failing(times, states, passed)
                self._fall_back(failure)
        return passed

    @property
    def goes_on_with_first(self) -> bool:
        """Whether no other method has been taken so far."""
        return self._ran == [0]

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
        return self._now.values_at(t)

    def integrate_over_events(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, watched: WatchedRun
    ) -> tuple[int, bool]:
        """Continue in the same way over events: see `LooksOut.integrate_over_events`."""
        if most_steps > 0:
            most_steps = min(most_steps, self.steps_to_look(watched))
        try:
            return self._now.integrate_over_events(times, states, passed, most_steps, watched)
        except StepFailure as failure:
            passed = self._passed_by_failing(times, states, passed)
            self._fall_back(failure)
            watched.regime[0] = -1.0
            return passed, True

    def integrate_over_samples(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, sampler: Sampler
    ) -> int:
        """Continue in the same way over samples: see `PassesSamples`."""
        end = self.step_count + most_steps
        while passed < len(times) and (left := end - self.step_count) > 0 and not sampler.has_alarm:
            most = min(left, self.steps_to_look())
            sampler.keeps_instants = self._stretch is not None
            try:
                passed = self._now.integrate_over_samples(times, states, passed, most, sampler)
            except StepFailure as failure:
                passed = self._passed_by_failing(times, states, passed)
                self._fall_back(failure)
            if self._stretch is None:
                continue
            for instant in sampler.taken_instants():
                if instant[0] >= self._stretch.t:  # the log has those from before as well
                    y = self._stretch.y.copy()
                    y[self._held] = instant[1:]
                    self._stretch.samples.append((float(instant[0]), y))
        return passed

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        self._aim = stop
        self._now.aim(stop)

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        if self._stretch is not None:
            self._stretch.samples.append((t, np.array(y)))
        super().go_on_with(t, y)

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state: a stretch that it cuts begins again."""
        self._leave_stretch()
        super().restart(t, y)

    def _counted(self) -> dict[str, int | float]:
        """Return what the run has counted, without trials."""
        counts = dict(self._counts)
        for name, value in self._since_seen().items():
            counts[name] = counts.get(name, 0) + value
        return counts

    def _since_seen(self) -> dict[str, int | float]:
        return {name: value - self._seen.get(name, 0) for name, value in self._now.statistics.items()}

    def _settle(self) -> None:
        """Book what the current method has done since it was looked at."""
        done = self._since_seen()
        self._plan.work += self._counter.work(done)
        for name, value in done.items():
            self._counts[name] = self._counts.get(name, 0) + value
        self._seen = dict(self._now.statistics)

    def steps_to_look(self, watched: WatchedRun | None = None) -> int:
        """Return how many steps are taken before the next look; look, if it is time."""
        restarts = -math.inf if watched is None or watched.regime[0] < 0.0 else float(watched.regime[1])
        if self._stretch is not None and restarts != self._stretch.restarts:
            self._leave_stretch()
        plan = self._plan
        if self.step_count >= plan.next_look and self.t < self._aim:
            self._settle()
            now = self._number
            if self._stretch is not None:
                self._compare(self._stretch)
            if now != self._number:
                plan.went_on_with_another(self.t, self.step_count)
                if watched is not None:
                    watched.regime[0] = -1.0  # steps are counted anew
            elif plan.begins_stretch(self.t, self.step_count, now):
                self._stretch = Stretch(self.t, self.state(), plan.work, restarts)
        return max(plan.next_look - self.step_count, 1)

    def _leave_stretch(self) -> None:
        if self._stretch is not None:
            self._stretch, self._plan.next_look = None, self.step_count + 1

    def _compare(self, stretch: Stretch) -> None:
        """Let the rival go over the stretch, and go on with it if it is better."""
        self._stretch = None
        plan, number, end = self._plan, self._plan.rival, (self.t, self.state())
        own, is_checked = plan.work - stretch.work, self._is_checked(self._number)
        rival, most = self._stepper(number), plan.most_work(own, is_checked)
        found, counts = went_over(rival, stretch, end, self._held, most, self._counter)
        work = self._counter.work(counts)
        plan.tried_work += work
        for name, value in counts.items():
            self._tried_counts[name] = self._tried_counts.get(name, 0) + value
        off = math.inf
        if found is not None:
            allowed = PROMISED * (end[0] - stretch.t) / self._span
            lost = energies_apart(self._dynamics, end[0], found, end[1]) / (allowed * self._rtol)
            off = max(apart(found, end[1], allowed * self._allowed), lost)
        trial = Trial(number, stretch.t, end[0], work / own, off, int(counts["steps"]))
        is_taken = plan.takes(trial, self._number, is_checked, self._is_checked(number))
        self.trials.append(trial._replace(is_taken=is_taken))
        if is_taken:
            self._go_on_with_rival(number, *end)

    def _is_checked(self, number: int) -> bool:
        """Return whether a method steps over vibrations, so that its own estimate does not tell of them."""
        return self._steppers[number].name == STEPS_OVER

    def _go_on_with_rival(self, number: int, t: float, y: Vector) -> None:
        rival = self._steppers[number]
        self._settle()
        self._number = number
        if number not in self._ran:
            self._ran.append(number)
        self._seen = dict(rival.statistics)
        self._steps_before = int(self._counts["steps"]) - rival.step_count
        rival.aim(self._aim)
        rival.go_on_with(t, y)

    def _fall_back(self, failure: StepFailure) -> None:
        """Go on with the first method where another fails."""
        if self._number == 0:
            raise failure
        self._leave_stretch()
        self._plan.leave_out(self._number)
        t, y = self.t, self.state()
        self._go_on_with_rival(0, t, y)
        self._steppers[0].restart(t, y)
        self._plan.went_on_with_another(t, self.step_count)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the data that all of them need to continue."""
        kept = self._plan.snapshot() | {
            "ran": np.array((self._number, *self._ran), dtype=np.int64),
            "counts": np.array([_in_order(x) for x in (self._counts, self._seen, self._tried_counts)]),
            "trials": np.array(self.trials, dtype=float).reshape(-1, len(Trial._fields)),
        }
        if (stretch := self._stretch) is not None:
            kept["stretch"] = np.array((stretch.t, stretch.work, stretch.restarts))
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
        self._plan.resume(snapshot)
        self._number, *self._ran = snapshot["ran"].tolist()
        self._counts, self._seen, self._tried_counts = (
            dict(zip(COUNTED, x, strict=True)) for x in snapshot["counts"].tolist()
        )
        self._steps_before = int(self._counts["steps"] - self._seen["steps"])
        self.trials = [
            Trial(int(number), start, end, work, off, int(steps), bool(taken))
            for number, start, end, work, off, steps, taken in snapshot["trials"].tolist()
        ]
        self._stretch = None
        if "stretch" in snapshot:
            t, work, restarts = snapshot["stretch"].tolist()
            samples = list(zip(snapshot["sampled"][1:].tolist(), snapshot["states"][1:], strict=True))
            self._stretch = Stretch(t, snapshot["states"][0], work, restarts, samples)


def _in_order(counts: Mapping[str, int | float]) -> list[int | float]:
    return [counts.get(name, 0) for name in COUNTED]
