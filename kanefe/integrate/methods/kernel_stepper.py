"""A run by one of the kernel methods: in compiled code where the scene has no Python functions, else from Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import FileError, KanefeError, MissingDependency
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_memory import NO_CLUSTER, SMALLEST_STEP, StepMemory, new_memory
from kanefe.integrate.methods.kernel_set import Kernels
from kanefe.integrate.methods.step_failures import step_failure
from kanefe.integrate.run_checks.bending_check import bends_of_kernels, watched_bodies
from kanefe.integrate.step_times import StepTimes
from kanefe.integrate.stepper import BESIDE, Unconverged, beyond
from kanefe.kernels.compiler.entries import LATER, Bound
from kanefe.kernels.events.kinks import step_again
from kanefe.kernels.steppers.settled_outputs import Settling, next_command
from kanefe.kernels.steppers.step_commands import VECTOR, Command, Run, Step, begin_at, interpolated
from kanefe.kernels.values.records import column
from kanefe.loads.valued_load import UnfitValue
from kanefe.tree.route import MethodNeeds

if TYPE_CHECKING:
    from kanefe.integrate.sampling import Sampler
    from kanefe.integrate.stepper import StepControl
    from kanefe.kernels.events.watched_run import WatchedRun
    from kanefe.tree.bending import Bent
    from kanefe.tree.route import PreparedRun

OF_STEPS = "steps", "rejected", "evaluations"
OF_JACOBIANS = (*OF_STEPS, "factorisations", "jacobians")
"""Names in the statistics of what a step counts, without and with Jacobians."""

TIME, TIME_OLD = (column(Step, name) for name in ("time", "time_old"))
COUNTS = {names: [column(Step, name) for name in names] for names in (OF_STEPS, OF_JACOBIANS)}
"""Places among the reals and the integers of what is asked for the most."""


class KernelStepper:
    """A method in the middle of a run: see `Stepper`. Its `states` are to be had after a call for one step.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        rtol, relative to each component of the state; atol, in units of `Dynamics.scales`; or a fixed step.
    name : str
        Of the method.
    kernels : Kernels

    Attributes
    ----------
    dynamics : Dynamics
    unanswered : list of str
        What functions of the user gave no number for, and the step was tried again.
    integers, reals, vectors : ndarray
        Memory of the method.
    step : Step
        The same by names, of the method's own kind; its hooks write to it.
    """

    def __init__(
        self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str, kernels: Kernels
    ) -> None:
        self.name = name
        self.dynamics, self._kernels, self._span = dynamics, kernels, stop - start
        self._bodies = watched_bodies(dynamics.model)
        self.use(new_memory(dynamics, start, stop, control, kernels, self._bodies))
        self._no_answer: tuple[float, KanefeError] | None = None
        self.unanswered: list[str] = []
        self._step_times = StepTimes()
        if kernels.prepare is not None:
            kernels.prepare(self)
        if kernels.first_step is not None and control.step is None:
            self.step.next_step = kernels.first_step(self)

    def use(self, memory: StepMemory) -> None:
        """Go on in other arrays, which have what its own have."""
        for name in ("_run", "_compiled_run", "_interpolated", "_differentiate"):
            vars(self).pop(name, None)
        self.integers, self.reals, self.vectors = memory
        self.step: Any = memory.step(self._kernels)

    @property
    def t(self) -> float:
        """Time reached in s."""
        return float(self.reals[TIME])

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return float(self.reals[TIME_OLD])

    @property
    def worst(self) -> int:
        """Component of the state whose error was the largest at the last step, or try of one."""
        return int(self.step.worst)

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most."""
        return bends_of_kernels(self._bodies, self.step.bends, self.reals) if self._bodies else []

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Time and state where rejected steps have clustered the most."""
        step = self.step
        return None if step.shortest_share >= NO_CLUSTER else (float(step.time_of_shortest), step.at_shortest.copy())

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far."""
        return int(self.integers[COUNTS[OF_STEPS][0]])

    @property
    def statistics(self) -> dict[str, int | float]:
        """Steps, rejected steps and evaluations; factorisations and Jacobians of methods that make them."""
        names = OF_JACOBIANS if self._kernels.has_jacobian else OF_STEPS
        return dict(zip(names, self.integers[COUNTS[names]].tolist(), strict=True))

    @property
    def step_seconds(self) -> list[float]:
        """Wall time that 99.9 % of fixed steps did not exceed, and the longest, s; empty where steps are free."""
        return self._step_times.told

    @property
    def unconverged(self) -> Unconverged | None:
        """Fixed steps whose iteration was left early."""
        return None if self._kernels.unconverged is None else self._kernels.unconverged(self)

    def state(self) -> Vector:
        """Return the state at t, its loops closed."""
        return self._closed(self.t, self.vectors[VECTOR.state]).copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        found = np.empty((len(times), self.vectors.shape[1]))
        if self.t_old == self.t:
            found[:] = self.vectors[VECTOR.state]
            return found
        for t, row in zip(times, found, strict=True):
            if self.step.stage and t < self.t:
                self._interpolated(t, row)
            else:
                row[:] = self.vectors[VECTOR.state]
            row[:] = self._closed(float(t), row)
        return found

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        step = self.step
        step.stop, step.smallest = stop, max(float(step.smallest), SMALLEST_STEP * abs(stop))

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        step, is_same = self.step, t == self.t and self.step_count > 0
        step.state[:], step.to_event = y, math.inf
        begin_at(step, t)
        step.continues = is_same

    def step_again(self, t: float) -> bool:
        """Take the last step again, to just behind a time within it (s); return whether that is of use."""
        return bool(step_again(self.step, t))

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state, with a fraction of the step where it is not fixed."""
        step = self.step
        self.go_on_with(t, y)
        step.continues = False
        if not step.is_fixed:
            step.next_step = min(step.next_step * self._kernels.restart_share, step.longest_restart)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return copies of the memory of the method."""
        return {"integers": self.integers.copy(), "reals": self.reals.copy(), "vectors": self.vectors.copy()}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot with its breakpoints: functions may have been corrected since."""
        self._no_answer = None
        self._step_times.places[:] = 0
        if len(snapshot["reals"]) != len(self.reals):
            self.use(StepMemory(self.integers, np.empty_like(snapshot["reals"]), self.vectors))
        for name, array in (("integers", self.integers), ("reals", self.reals), ("vectors", self.vectors)):
            array[:] = snapshot[name]

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int, is_cut: bool = False) -> int:
        """Continue until all times are passed or so many steps are taken: see `Stepper.integrate_through`.

        Of a call that is one step because a longer one is cut, no `states` are wanted, which may take evaluations.
        """
        return self._integrate(times, states, 0, most_steps, wants_dense=most_steps == 1 and not is_cut)[0]

    def prepared(self, times: np.ndarray, states: np.ndarray, watched: WatchedRun | None = None) -> Any:
        """Return the run through some times as calls of kernels: see `CompiledRun.prepared`; of an autonomous scene."""
        run = self._run._replace(times=times, states=states, clock=np.zeros(1, dtype=np.int64))
        return self._compiled_run.prepared(run, watched, self._kernels.restart_share)

    @property
    def full_unknowns(self) -> int:
        """Number of unknowns of the full systems that it factorises, 0 where there are none."""
        kernels = self._kernels
        is_full = kernels.has_jacobian and not (kernels.takes_directions or kernels.differentiate)
        return self.dynamics.model.free_count if is_full else 0

    @property
    def looks_at_start(self) -> bool:
        """Whether its memory at the start of a run depends on more of the start than the state."""
        kernels = self._kernels
        return kernels.is_implicit or kernels.has_jacobian or kernels.first_step is not None

    @property
    def wants_rates_alone(self) -> bool:
        """Whether it asks for nothing but rates, and so can be evaluated beside others in a scene without loops."""
        kernels = self._kernels
        return not (kernels.is_implicit or kernels.has_jacobian or kernels.keeps_balance or kernels.settles_outputs)

    @property
    def can_look_out(self) -> bool:
        """Whether it passes over quiet steps by itself: see `LooksOut`."""
        return self.dynamics.is_autonomous and self.dynamics.route.watching is not None

    def integrate_over_events(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, watched: WatchedRun
    ) -> tuple[int, bool]:
        """Continue in the same way over events: see `LooksOut.integrate_over_events`."""
        return self._integrate(times, states, passed, most_steps, over=watched, wants_dense=True)

    def integrate_over_samples(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, sampler: Sampler
    ) -> int:
        """Continue in the same way over samples: see `PassesSamples`."""
        return self._integrate(times, states, passed, most_steps, over=sampler)[0]

    @property
    def has_values(self) -> bool:
        """Whether `values_at` is available: there are no loops to be closed."""
        return self.can_look_out and not self.dynamics.model.constraints

    def values_at(self, t: float) -> Vector:
        """Return the event values of loads at a time of the last step."""
        return self._compiled_run.values_at(self._run, t)

    def _integrate(
        self,
        times: np.ndarray,
        states: np.ndarray,
        passed: int,
        most_steps: int,
        *,
        over: WatchedRun | Sampler | None = None,
        wants_dense: bool = False,
    ) -> tuple[int, bool]:
        """Continue; return how many times were passed and, where there are events, whether the last step is done."""
        step, dynamics, is_compiled = self.step, self.dynamics, self.dynamics.is_autonomous
        self.begin_outputs(times, passed, wants_dense)
        before, evaluations = step.evaluations, dynamics.evaluations
        run = self._run._replace(times=times, states=states, most_steps=step.steps + min(most_steps, 2**40))
        if step.is_fixed:
            self._step_times.start_clock()
        is_done = self._answered(run, over)
        if is_compiled:
            dynamics.evaluations = evaluations + step.evaluations - before
        if dynamics.model.is_constrained and (step.is_left_open or not is_compiled):
            for i in range(passed, step.stored):
                states[i] = self._closed(float(times[i]), states[i])
        return step.stored, is_done

    def begin_outputs(self, times: np.ndarray, passed: int, wants_dense: bool = False) -> None:
        """Let the steps that follow write states at some times, of which so many are passed."""
        step = self.step
        step.stored, step.is_left_open, step.waiting, step.wants_dense = passed, False, 0, wants_dense
        step.settles = min(step.settles, Settling.SOME)
        step.next_output = times[passed] if passed < len(times) else math.inf

    def _following(self, run: Run, over: WatchedRun | Sampler | None) -> Callable[[], tuple[int, bool]]:
        """Return what gives the next command, and whether the step is done."""
        if over is None:
            is_compiled = self.dynamics.is_autonomous
            go_on = partial(self._compiled_run.go_on, run) if is_compiled else next_command.bound(run).prepared()
            return lambda: (go_on(), False)
        if isinstance(over, tuple):
            return partial(self._compiled_run.go_over_events, run, over, self._kernels.restart_share)
        return lambda: (self._compiled_run.go_over_samples(run, over), False)

    def _answered(self, run: Run, over: WatchedRun | Sampler | None) -> bool:
        """Do what the method wants until it is through; return whether the last step is done."""
        following, is_compiled = self._following(run, over), self.dynamics.is_autonomous
        while True:
            try:
                # of states too far ahead, which are not kept; compiled code does not warn of them
                with nullcontext() if is_compiled else np.errstate(over="ignore", invalid="ignore"):
                    command, is_done = following()
                    while self._evaluate(run, command):
                        command, is_done = following()
            except (FileError, MissingDependency):
                raise  # there is no code to go on with: a smaller step is no remedy
            except KanefeError as error:
                if getattr(over, "is_asking", False):
                    raise  # it is of the function of a controller
                self._answer_nothing(error)
                continue
            if command == Command.PROJECT:
                self._project()
            elif command == Command.JACOBIAN:
                self._differentiate(float(self.step.time_at), self.vectors[VECTOR.at])
            elif command == Command.FAILED:
                raise self._failure()
            else:
                return is_done

    @cached_property
    def _differentiate(self) -> Callable[[float, Vector], None]:
        """What writes the derivatives that the method asks for."""
        own = self._kernels.differentiate
        return self._put_jacobian if own is None else own(self)

    def _put_jacobian(self, t: float, y: Vector) -> None:
        found, first = self.dynamics.tangent_derivatives(t, y), self.step.jacobian_row
        self.vectors[first : first + len(found), : found.shape[1]] = found

    def _evaluate(self, run: Run, command: int) -> bool:
        """Do what the method wants if it is an evaluation, or the closing of outputs; return whether it is."""
        step, dynamics, vectors = self.step, self.dynamics, self.vectors
        if command == Command.RATES:
            vectors[VECTOR.slope] = dynamics.rate(float(step.time_at), vectors[VECTOR.at])
            step.weakest = dynamics.weakest
        elif command == Command.IMPLICIT:
            shares = float(step.share_damping), float(step.share_stiffness), float(step.share_of_rates)
            dynamics.implicit_rate(float(step.time_at), vectors[: VECTOR.stiffness_direction + 1], *shares)
        elif command == Command.BALANCE:
            dynamics.balance(run)
        elif command == Command.SETTLE:
            for i in range(step.stored - step.waiting, step.stored):
                run.states[i] = self._closed(float(run.times[i]), run.states[i])
        else:
            return False
        return True

    def _closed(self, t: float, y: Vector) -> Vector:
        """Return the nearest state at a time (s) with its loops closed, in the metric of the method."""
        return self.dynamics.projected(t, y, share=float(self.step.share_stiffness))

    def _project(self) -> None:
        step = self.step
        try:
            step.state[:] = self._closed(self.t, step.state)
        except KanefeError as error:
            # what there is ends with the last state whose loops are closed
            step.state[:], step.time = step.state_old, step.time_old
            if step.is_fixed:
                raise beyond(error) from error
            raise

    @cached_property
    def _interpolated(self) -> Bound:
        return interpolated.bound(self._run, LATER, LATER)

    @cached_property
    def _run(self) -> Run:
        kernels, none = self._kernels, np.zeros((0, self.vectors.shape[1]))
        memory = self.integers, self.reals, self.vectors, kernels.table
        return Run(kernels.advance, kernels.interpolate, *memory, np.zeros(0), none, 0, self._step_times.places)

    @cached_property
    def _compiled_run(self) -> PreparedRun:
        kernels = self._kernels
        has_derivatives = kernels.has_jacobian and not (kernels.takes_directions or kernels.differentiate)
        is_implicit = kernels.is_implicit or self.step.settles != Settling.NOT
        needs = MethodNeeds(is_implicit, kernels.keeps_balance, has_derivatives, kernels.takes_directions)
        return self.dynamics.route.compiled_run(self.integers, self.reals, self.vectors, needs)

    def _answer_nothing(self, error: KanefeError) -> None:
        """Have the step tried again with a smaller one: up to where the equations hold there are such."""
        if self.step.is_fixed:
            if self.step.time_at > self.t:
                raise beyond(error) from error
            raise error
        if self._no_answer is None or self._no_answer[0] != self.t:
            self._no_answer = self.t, error
        if isinstance(error, UnfitValue):
            self.unanswered.append(str(error))
        self.vectors[VECTOR.slope] = np.nan

    def _failure(self) -> KanefeError:
        if self.dynamics.is_autonomous:  # in compiled code nothing was said of functions that give no numbers
            self.dynamics.name_what_is_not_finite(float(self.step.time_at), self.vectors[VECTOR.at])
            self.dynamics.name_what_is_not_finite(self.t, self.vectors[VECTOR.state])
        if self._no_answer is not None and self.t - self._no_answer[0] < BESIDE * self._span:
            return self._no_answer[1]
        return step_failure(self.dynamics.model, self.name, self.step)
