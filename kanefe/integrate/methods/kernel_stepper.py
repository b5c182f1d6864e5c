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
from kanefe.integrate.breakpoints import breakpoints_of, changes_of
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.locked_speeds import locked_speeds
from kanefe.integrate.methods.elastic_speeds import elastic_speeds, is_damped
from kanefe.integrate.methods.kernel_set import Kernels
from kanefe.integrate.methods.method import LEAST_RTOL
from kanefe.integrate.methods.step_failures import step_failure
from kanefe.integrate.run_checks.bending_check import bends_in_kernels, bends_of_kernels, watched_bodies
from kanefe.integrate.run_checks.functions_of_user import asks_for_state
from kanefe.integrate.step_times import StepTimes
from kanefe.integrate.stepper import BESIDE, LEAST_STEPS, Unconverged, beyond
from kanefe.kernels.compiler.entries import LATER, Bound
from kanefe.kernels.events.kinks import step_again
from kanefe.kernels.steppers.force_scales import put_force_scales
from kanefe.kernels.steppers.settled_outputs import IS_SETTLING, NOT_SETTLED, next_command
from kanefe.kernels.steppers.step_commands import (
    AT,
    AT_SHORTEST,
    BALANCE,
    BENDS,
    BREAKPOINTS,
    CONTINUES,
    COORDINATES,
    ELASTIC,
    EVALUATIONS,
    FACTORISATIONS,
    FAILED,
    HAS_LOOPS,
    IMPLICIT,
    IS_FIXED,
    IS_LEFT_OPEN,
    JACOBIAN,
    JACOBIAN_ROW,
    JACOBIANS,
    LARGE,
    LARGEST,
    LARGEST_OF_DRIVES,
    LEAST_ALLOWED,
    LOCKED_SPEEDS,
    LONGEST_RESTART,
    LOOKS_FOR_JUMPS,
    MAP,
    MAP_SIZE,
    NEXT_OUTPUT,
    NEXT_STEP,
    OF_FORCES,
    PROJECT,
    RATES,
    REACH,
    REJECTED,
    RELATIVE,
    SCALE,
    SETTLE,
    SETTLES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SHORTEST_SHARE,
    SLOPE,
    SMALLEST,
    SPEEDS,
    STAGE,
    STATE,
    STATE_OLD,
    STEPS,
    STIFFNESS_DIRECTION,
    STOP,
    STORED,
    TIME,
    TIME_AT,
    TIME_OF_SHORTEST,
    TIME_OLD,
    TO_EVENT,
    UNIT,
    WAITING,
    WANTS_DENSE,
    WEAKEST,
    WORST,
    Run,
    begin_at,
    interpolated,
)
from kanefe.loads.valued_load import UnfitValue
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.route import MethodNeeds
from kanefe.tree.scales import coordinate_moves, displacement_scales

if TYPE_CHECKING:
    from kanefe.integrate.sampling import Sampler
    from kanefe.integrate.stepper import StepControl
    from kanefe.kernels.events.watched_run import WatchedRun
    from kanefe.tree.bending import Bent
    from kanefe.tree.route import PreparedRun

SMALLEST_STEP = 16.0 * np.finfo(float).eps
"""Smallest step relative to the largest time: below it, times lose their digits. A jump of a force or a power leaves an
error proportional to the step, so that a step across a jump may have to be this small; the loop ends runs that do not
advance."""

OF_STEPS = ("steps", "rejected", "evaluations"), [STEPS, REJECTED, EVALUATIONS]
OF_JACOBIANS = (*OF_STEPS[0], "factorisations", "jacobians"), [*OF_STEPS[1], FACTORISATIONS, JACOBIANS]
"""Names in the statistics and places among the integers of what is counted, without and with Jacobians."""

LEAST_MODE = 1e-13
"""Least error that is allowed along a mode, relative to what moves its body by its size: hundreds of round-offs."""

NO_CLUSTER = 1e-3
"""Length of a step after rejections, relative to the longest so far, below which they have clustered: across a jump a
step of any order has an error in proportion to its length, which is smaller than tolerances in use only then."""

ITERATED = 1e-10, 1e-12
"""Relative and absolute tolerance of the iterations with fixed steps."""


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
        Memory of the method, as `kanefe.kernels.steppers.step_commands` names its places; its hooks write to it.
    """

    def __init__(
        self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str, kernels: Kernels
    ) -> None:
        self.name = name
        self.dynamics, self._kernels = dynamics, kernels
        model = dynamics.model
        n, m = model.coordinate_count, model.free_count
        moves = coordinate_moves(model)
        self._bodies = watched_bodies(model)
        bent, bends = bends_in_kernels(self._bodies, kernels.reals)
        self.integers = np.concatenate((np.zeros(MAP + 3 * len(moves), dtype=np.int64), bent))
        y, breakpoints, locked = dynamics.initial_state(start), np.zeros(0), np.zeros(0)
        base = kernels.reals + len(bends)
        if control.step is None:
            if kernels.is_implicit or self._has_jacobian:
                # the extrapolation lets grow what nothing damps, beside methods that solve with Jacobians
                locked = locked_speeds(dynamics, start, y[:-QUADRATURES], base, self._has_jacobian)
            changes = changes_of(dynamics, start, stop) if control.changes is None else control.changes
            dynamics.seconds_looking = changes.seconds
            breakpoints = breakpoints_of(dynamics, base + len(locked), changes)
        self.reals = np.concatenate((np.zeros(kernels.reals), bends, locked, breakpoints))
        rows = kernels.rows + kernels.rows_per_speed * m + kernels.rows_per_state * model.state_count
        self.vectors = np.zeros((rows, n + m + model.state_count + QUADRATURES))
        integers, reals = self.integers, self.reals
        self.vectors[ELASTIC, n + self._elastic] = 1.0
        integers[SETTLES] = IS_SETTLING if len(self._elastic) else NOT_SETTLED
        integers[COORDINATES], integers[SPEEDS], integers[MAP_SIZE] = n, m, len(moves)
        integers[MAP : MAP + 3 * len(moves)] = np.array(moves, dtype=np.int64).ravel()
        integers[BENDS] = MAP + 3 * len(moves) if len(bent) else 0
        integers[HAS_LOOPS] = model.is_constrained
        integers[LOOKS_FOR_JUMPS] = control.step is None and asks_for_state(model)
        for place, value in kernels.integers.items():
            integers[place] = value
        if len(locked):
            integers[LOCKED_SPEEDS] = base
        if len(breakpoints):
            integers[BREAKPOINTS] = base + len(locked)
        reals[TIME] = reals[TIME_OLD] = start
        self._span = stop - start
        reals[STOP], reals[SMALLEST] = stop, SMALLEST_STEP * max(abs(start), abs(stop))
        # what happens between the substeps of a step is not seen: functions of the user are looked at often enough
        reals[LARGEST] = (stop - start) / LEAST_STEPS if dynamics.calls_functions else math.inf
        reals[SHORTEST_SHARE] = NO_CLUSTER
        reals[LARGEST_OF_DRIVES] = reals[TO_EVENT] = reals[LONGEST_RESTART] = math.inf
        reals[REACH] = kernels.reach
        rtol = max(kernels.of_tolerance(control.rtol), LEAST_RTOL)
        atol = max(rtol * (control.atol / control.rtol), 1e-300)
        if control.step is not None:
            integers[IS_FIXED], reals[NEXT_STEP] = 1, control.step
            rtol, atol = ITERATED
        self._no_answer: tuple[float, KanefeError] | None = None
        self.unanswered: list[str] = []
        self._step_times = StepTimes()
        self.vectors[STATE] = y
        reals[RELATIVE], self.vectors[SCALE] = (
            rtol,
            atol * dynamics.scales(start, self.vectors[STATE], control.looseness),
        )
        self._scale_modes(control.rtol)
        if kernels.prepare is not None:
            kernels.prepare(self)
        if kernels.first_step is not None and control.step is None:
            reals[NEXT_STEP] = kernels.first_step(self)

    def _scale_modes(self, rtol: float) -> None:
        """Let modes be followed relative to the forces of their bodies, where the method does so.

        Not of bodies whose vibrations hardly fade, which all would be followed to the end of the run, nor where
        controllers sample, each of whose jumps would have them followed anew.
        """
        model, vectors, n = self.dynamics.model, self.vectors, self.dynamics.model.coordinate_count
        vectors[LARGE] = vectors[SCALE]
        if self.integers[IS_FIXED] or model.controllers or not self._kernels.scales_with_forces:
            return
        displacements = displacement_scales(model)
        bodies = [body.flexible.speeds for body in model.bodies if body.flexible and is_damped(body.flexible.body)]
        of_speeds = {speed: k + 1 for k, speeds in enumerate(bodies) for speed in range(speeds.start, speeds.stop)}
        for turns, at, speed in coordinate_moves(model):
            if not turns and speed in of_speeds:
                vectors[UNIT, at], vectors[UNIT, n + speed] = 1.0 / displacements[speed], of_speeds[speed]
                least = min(LEAST_MODE * displacements[speed] / vectors[LARGE, at], 1.0)
                vectors[SCALE, [at, n + speed]] = least * vectors[LARGE, [at, n + speed]]
        self.reals[[OF_FORCES, LEAST_ALLOWED]] = rtol, LEAST_MODE
        put_force_scales(self.integers, self.reals, vectors)

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
        return int(self.integers[WORST])

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most."""
        integers = self.integers
        return bends_of_kernels(self._bodies, integers[MAP + 3 * integers[MAP_SIZE] :], self.reals)

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Time and state where rejected steps have clustered the most."""
        if self.reals[SHORTEST_SHARE] >= NO_CLUSTER:
            return None
        return float(self.reals[TIME_OF_SHORTEST]), self.vectors[AT_SHORTEST].copy()

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far."""
        return int(self.integers[STEPS])

    @property
    def statistics(self) -> dict[str, int | float]:
        """Steps, rejected steps and evaluations; factorisations and Jacobians of methods that make them."""
        names, places = OF_JACOBIANS if self._has_jacobian else OF_STEPS
        return dict(zip(names, self.integers[places].tolist(), strict=True))

    @property
    def step_seconds(self) -> list[float]:
        """Wall time that 99.9 % of fixed steps did not exceed, and the longest, s; empty where steps are free."""
        return self._step_times.told

    @property
    def unconverged(self) -> Unconverged | None:
        """Fixed steps whose iteration was left early."""
        return None if self._kernels.unconverged is None else self._kernels.unconverged(self)

    @cached_property
    def _elastic(self) -> np.ndarray:
        """Speeds whose coordinates are settled in outputs; none of a method that does not step over modes."""
        return elastic_speeds(self.dynamics.model) if self._kernels.settles_outputs else np.zeros(0, dtype=np.int64)

    @property
    def _has_jacobian(self) -> bool:
        return JACOBIAN_ROW in self._kernels.integers

    def state(self) -> Vector:
        """Return the state at t, its loops closed."""
        return self._closed(self.t, self.vectors[STATE]).copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        found = np.empty((len(times), self.vectors.shape[1]))
        if self.t_old == self.t:
            found[:] = self.vectors[STATE]
            return found
        for t, row in zip(times, found, strict=True):
            if self.integers[STAGE] and t < self.t:
                self._interpolated(t, row)
            else:
                row[:] = self.vectors[STATE]
            row[:] = self._closed(float(t), row)
        return found

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        reals = self.reals
        reals[STOP], reals[SMALLEST] = stop, max(float(reals[SMALLEST]), SMALLEST_STEP * abs(stop))

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        is_same = t == self.t and self.step_count > 0
        self.vectors[STATE], self.reals[TO_EVENT] = y, math.inf
        begin_at(self.integers, self.reals, t)
        self.integers[CONTINUES] = is_same

    def step_again(self, t: float) -> bool:
        """Take the last step again, to just behind a time within it (s); return whether that is of use."""
        return bool(step_again(self.integers, self.reals, self.vectors, t))

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state, with a fraction of the step where it is not fixed."""
        integers, reals = self.integers, self.reals
        self.go_on_with(t, y)
        integers[CONTINUES] = 0
        if integers[IS_FIXED]:
            return
        reals[NEXT_STEP] = min(reals[NEXT_STEP] * self._kernels.restart_share, reals[LONGEST_RESTART])

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return copies of the memory of the method."""
        return {"integers": self.integers.copy(), "reals": self.reals.copy(), "vectors": self.vectors.copy()}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot with its breakpoints: functions may have been corrected since."""
        self._no_answer = None
        if len(snapshot["reals"]) != len(self.reals):
            self.reals = np.empty_like(snapshot["reals"])
            for name in ("_run", "_compiled_run", "_interpolated"):
                vars(self).pop(name, None)
        self._step_times.places[:] = 0
        for name, array in (("integers", self.integers), ("reals", self.reals), ("vectors", self.vectors)):
            array[:] = snapshot[name]

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int, is_cut: bool = False) -> int:
        """Continue until all times are passed or so many steps are taken: see `Stepper.integrate_through`.

        Of a call that is one step because a longer one is cut, no `states` are wanted, which may take evaluations.
        """
        return self._integrate(times, states, 0, most_steps, None, is_cut=is_cut)[0]

    def prepared(self, times: np.ndarray, states: np.ndarray, watched: WatchedRun | None = None) -> Any:
        """Return the run through some times as calls of kernels: see `CompiledRun.prepared`; of an autonomous scene."""
        run = self._run._replace(times=times, states=states, clock=np.zeros(1, dtype=np.int64))
        return self._compiled_run.prepared(run, watched, self._kernels.restart_share)

    @property
    def can_look_out(self) -> bool:
        """Whether it passes over quiet steps by itself: see `LooksOut`."""
        return self.dynamics.is_autonomous and self.dynamics.route.watching is not None

    def integrate_over_events(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, watched: WatchedRun
    ) -> tuple[int, bool]:
        """Continue in the same way over events: see `LooksOut.integrate_over_events`."""
        return self._integrate(times, states, passed, most_steps, watched)

    def integrate_over_samples(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, sampler: Sampler
    ) -> int:
        """Continue in the same way over samples: see `PassesSamples`."""
        return self._integrate(times, states, passed, most_steps, None, sampler, is_cut=True)[0]

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
        watched: WatchedRun | None,
        sampler: Sampler | None = None,
        is_cut: bool = False,
    ) -> tuple[int, bool]:
        """Continue; return how many times were passed and, where there are events, whether the last step is done."""
        integers, reals, vectors = self.integers, self.reals, self.vectors
        integers[STORED], integers[IS_LEFT_OPEN], integers[WAITING] = passed, 0, 0
        integers[SETTLES] = min(integers[SETTLES], IS_SETTLING)
        integers[WANTS_DENSE] = (most_steps == 1 and not is_cut) or watched is not None
        reals[NEXT_OUTPUT] = times[passed] if passed < len(times) else math.inf
        most = int(integers[STEPS]) + min(most_steps, 2**40)
        run = self._run._replace(times=times, states=states, most_steps=most)
        dynamics, is_done = self.dynamics, False
        is_compiled = dynamics.is_autonomous
        before, evaluations = int(integers[EVALUATIONS]), dynamics.evaluations
        if integers[IS_FIXED]:
            self._step_times.start_clock()
        while True:
            try:
                # of states too far ahead, which are not kept; compiled code does not warn of them
                with nullcontext() if is_compiled else np.errstate(over="ignore", invalid="ignore"):
                    command, is_done = self._command(run, is_compiled, watched, sampler)
            except (FileError, MissingDependency):
                raise  # there is no code to go on with: a smaller step is no remedy
            except KanefeError as error:
                if sampler is not None and sampler.is_asking:
                    raise
                self._answer_nothing(error)
                continue
            if command == PROJECT:
                self._project()
            elif command == JACOBIAN:
                found = dynamics.tangent_derivatives(float(reals[TIME_AT]), vectors[AT])
                first = integers[JACOBIAN_ROW]
                vectors[first : first + len(found), : found.shape[1]] = found
            elif command == FAILED:
                raise self._failure()
            else:
                break
        if is_compiled:
            dynamics.evaluations = evaluations + int(integers[EVALUATIONS]) - before
        stored = int(integers[STORED])
        if dynamics.model.is_constrained and (integers[IS_LEFT_OPEN] or not is_compiled):
            for i in range(passed, stored):
                states[i] = self._closed(float(times[i]), states[i])
        return stored, is_done

    def _closed(self, t: float, y: Vector) -> Vector:
        """Return the nearest state at a time (s) with its loops closed, in the metric of the method."""
        return self.dynamics.projected(t, y, share=float(self.reals[SHARE_STIFFNESS]))

    def _project(self) -> None:
        reals, vectors = self.reals, self.vectors
        try:
            vectors[STATE] = self._closed(self.t, vectors[STATE])
        except KanefeError as error:
            # what there is ends with the last state whose loops are closed
            vectors[STATE], reals[TIME] = vectors[STATE_OLD], reals[TIME_OLD]
            if self.integers[IS_FIXED]:
                raise beyond(error) from error
            raise

    def _command(
        self, run: Run, is_compiled: bool, watched: WatchedRun | None, sampler: Sampler | None
    ) -> tuple[int, bool]:
        """Return what the method wants that is no evaluation, which are done here; and whether the step is done."""
        dynamics, reals, vectors = self.dynamics, self.reals, self.vectors
        following: Callable[[], int] = (
            partial(self._compiled_run.go_on, run) if is_compiled else next_command.bound(run, vectors).prepared()
        )
        is_done = False
        while True:
            if is_compiled and watched is not None:
                command, is_done = self._compiled_run.go_over_events(run, watched, self._kernels.restart_share)
            elif sampler is not None:
                command = self._compiled_run.go_over_samples(run, sampler)
            else:
                command = following()
            if command == RATES:
                vectors[SLOPE] = dynamics.rate(float(reals[TIME_AT]), vectors[AT])
                reals[WEAKEST] = dynamics.weakest
            elif command == IMPLICIT:
                shares = float(reals[SHARE_DAMPING]), float(reals[SHARE_STIFFNESS])
                dynamics.implicit_rate(float(reals[TIME_AT]), vectors[: STIFFNESS_DIRECTION + 1], *shares)
            elif command == BALANCE:
                dynamics.balance(run, vectors)
            elif command == SETTLE:
                stored = int(self.integers[STORED])
                for i in range(stored - int(self.integers[WAITING]), stored):
                    run.states[i] = self._closed(float(run.times[i]), run.states[i])
            else:
                return command, is_done

    @cached_property
    def _interpolated(self) -> Bound:
        kernels = self._kernels
        memory = self.integers, self.reals, self.vectors, kernels.table
        return interpolated.bound(kernels.interpolate, *memory, LATER, LATER)

    @cached_property
    def _run(self) -> Run:
        kernels, none = self._kernels, np.zeros((0, self.vectors.shape[1]))
        memory = self.integers, self.reals, kernels.table
        return Run(kernels.advance, kernels.interpolate, *memory, np.zeros(0), none, 0, self._step_times.places)

    @cached_property
    def _compiled_run(self) -> PreparedRun:
        kernels = self._kernels
        has_derivatives = self._has_jacobian and not kernels.takes_directions
        needs = MethodNeeds(
            kernels.is_implicit or bool(len(self._elastic)),
            kernels.keeps_balance,
            has_derivatives,
            kernels.takes_directions,
        )
        return self.dynamics.route.compiled_run(self.integers, self.reals, self.vectors, needs)

    def _answer_nothing(self, error: KanefeError) -> None:
        """Have the step tried again with a smaller one: up to where the equations hold there are such."""
        if self.integers[IS_FIXED]:
            if self.reals[TIME_AT] > self.t:
                raise beyond(error) from error
            raise error
        if self._no_answer is None or self._no_answer[0] != self.t:
            self._no_answer = self.t, error
        if isinstance(error, UnfitValue):
            self.unanswered.append(str(error))
        self.vectors[SLOPE] = np.nan

    def _failure(self) -> KanefeError:
        if self.dynamics.is_autonomous:  # in compiled code nothing was said of functions that give no numbers
            self.dynamics.name_what_is_not_finite(float(self.reals[TIME_AT]), self.vectors[AT])
            self.dynamics.name_what_is_not_finite(self.t, self.vectors[STATE])
        if self._no_answer is not None and self.t - self._no_answer[0] < BESIDE * self._span:
            return self._no_answer[1]
        return step_failure(self.dynamics.model, self.name, self.integers, self.reals)
