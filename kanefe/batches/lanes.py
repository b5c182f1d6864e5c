"""Runs of one scene that take turns in the memory of one method, in one call of compiled code."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np

from kanefe.equations.model import Model, is_for_many
from kanefe.errors import SimulationWarning, outside
from kanefe.integrate.auto.choice import choose
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.options import RunOptions
from kanefe.integrate.pace import SMALLEST_STEP
from kanefe.integrate.run_checks.bushing_turns import of_bushings
from kanefe.integrate.run_checks.convergence_check import of_fixed_steps
from kanefe.integrate.run_checks.energy_check import account
from kanefe.integrate.run_checks.functions_of_user import across_jump
from kanefe.integrate.set_up import reported_events, watch_of
from kanefe.integrate.status import RunStatus
from kanefe.integrate.stepper import Stepper
from kanefe.integrate.trajectory import Trajectory
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.steppers.lanes import Lanes, run_lanes
from kanefe.kernels.steppers.step_commands import VECTOR, Command, Step
from kanefe.kernels.values.records import column
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scales import length_of_parts

TURN = 2000
"""Number of steps of a lane in one call: Ctrl-C waits for the end of a call."""

BLOCKS = 4
"""Number of blocks of lanes for each thread, so that none waits long for the last one."""

STORED, LEFT_OPEN, TIME = (column(Step, name) for name in ("stored", "is_left_open", "time"))


def blocks_of(models: Sequence[Model], threads: int) -> list[Sequence[Model]]:
    """Return models in blocks, for so many threads."""
    size = max(1, math.ceil(len(models) / (BLOCKS * threads)))
    return [models[i : i + size] for i in range(0, len(models), size)]


def lanes_in_one_memory(models: Sequence[Model], options: RunOptions, first: Trajectory) -> SharedMemory | None:
    """Return what runs models that differ in their starts, by the method with which their first run has ended.

    None where they differ in more, or a run needs Python: functions of the user, controllers, events, limits.
    """
    model = models[0]
    is_limited = options.most_steps is not None or options.most_seconds is not None
    is_one = all(other.of_scene is model.of_scene for other in models)
    if not is_one or is_limited or options.watched or model.controllers or not is_for_many(model):
        return None
    if not model.route.is_autonomous:
        return None
    choice = choose(model, options)
    make = choice.maker_of(first.statistics["method"])
    if make is None or watch_of(model, choice, options, reported_events(model, choice, options)) is not None:
        return None
    return SharedMemory(model, make, options, first) if type(make(Dynamics(model))) is KernelStepper else None


def begins_alike(model: Model, stepper: KernelStepper) -> bool:
    """Return whether runs from all starts begin with the same memory, but for the state.

    Not of methods that look at the start before the first step, nor where tolerances follow from the energy there, nor
    the size of the scene.
    """
    own = stepper.looks_at_start or model.is_constrained or any(load.acts_at_once for load in model.loads)
    return not own and length_of_parts(model) > 0.0


class SharedMemory:
    """Runs models that differ in their starts alone.

    Parameters
    ----------
    model : Model
        One of them.
    make : callable
        (dynamics) -> stepper at the start of the run.
    options : RunOptions
    first : Trajectory
        A run of another, by the same method.
    """

    def __init__(
        self, model: Model, make: Callable[[Dynamics], Stepper], options: RunOptions, first: Trajectory
    ) -> None:
        self._model, self._make, self._options, self._first = model, make, options, first
        self._unused: list[_Turns] = []

    def run(self, models: Sequence[Model]) -> list[Trajectory | None]:
        """Return the runs of models; None for those that have to be run alone. Threads may call it at once."""
        turns = self._unused.pop() if self._unused else _Turns(self._make, self._model, self._options, self._first)
        found = list(turns.run(models))
        self._unused.append(turns)
        return found


class _Turns:
    """The memory of one method, which one lane after another uses: of one thread at a time."""

    def __init__(
        self, make: Callable[[Dynamics], Stepper], model: Model, options: RunOptions, first: Trajectory
    ) -> None:
        (start, stop), wanted = options.span, options.times
        self._wanted, self._start, self._stop, self._make, self._first = wanted, start, stop, make, first
        self._times = wanted if wanted[-1] == stop else np.append(wanted, stop)
        self._stepper = stepper = self._new(model)
        self._begun, self._is_alike = stepper.snapshot(), begins_alike(model, stepper)
        self._states = np.zeros((len(self._times), stepper.vectors.shape[1]))
        self._going, _, _ = stepper.prepared(self._times, self._states)
        self._run = self._going.arguments[-1]
        given = self._going.for_kernels(), self._going.signature.number_count, self._run
        self._take_turns = run_lanes.bound(*given, LATER)

    def _new(self, model: Model) -> KernelStepper:
        stepper = cast(KernelStepper, self._make(Dynamics(model)))
        stepper.begin_outputs(self._times, int(self._times[0] == self._start))
        return stepper

    def run(self, models: Sequence[Model]) -> Iterator[Trajectory | None]:
        """Yield the runs of models; None for those that have to be run alone."""
        began, lanes, left = time.perf_counter(), self._lanes(models), np.arange(len(models))
        is_done = np.zeros(len(models), dtype=bool)
        most = 0
        while len(left):
            most += TURN
            self._going.give(self._run._replace(most_steps=most))
            before = lanes.reals[left, TIME]
            self._call(lanes, left)
            is_done[left] = lanes.integers[left, STORED] == len(self._times)
            moved = lanes.reals[left, TIME] - before > SMALLEST_STEP * TURN * (self._stop - self._start)
            left = left[~is_done[left] & moved & (lanes.commands[left] == Command.ACCEPTED)]
        is_done &= (lanes.integers[:, LEFT_OPEN] == 0) & np.isfinite(lanes.states).all(axis=1)
        seconds = (time.perf_counter() - began) / len(models)
        for lane, model in enumerate(models):
            yield self._trajectory(lanes, lane, model, seconds) if is_done[lane] else None

    def _lanes(self, models: Sequence[Model]) -> Lanes:
        """Return the lanes at their starts."""
        width = self._states.shape[1]
        if self._is_alike:
            begun = [self._begun] * len(models)
        else:
            begun = [self._new(model).snapshot() for model in models]
        integers, reals = (np.array([memory[name] for memory in begun]) for name in ("integers", "reals"))
        vectors = np.array([memory["vectors"].ravel() for memory in begun])
        starts = vectors[:, VECTOR.state * width : (VECTOR.state + 1) * width]
        if self._is_alike:
            starts[:, :-QUADRATURES] = [model.initial_state for model in models]
        states = np.zeros((len(models), self._states.size))
        states[:, :width] = starts
        return Lanes(integers, reals, vectors, states, np.zeros(len(models), dtype=np.int64))

    def _call(self, lanes: Lanes, left: np.ndarray) -> None:
        """Continue with some lanes."""
        if len(left) == len(lanes.commands):
            self._take_turns(lanes)
            return
        some = Lanes(*(array[left] for array in lanes))
        self._take_turns(some)
        for array, part in zip(lanes, some, strict=True):
            array[left] = part

    def _trajectory(self, lanes: Lanes, lane: int, model: Model, seconds: float) -> Trajectory:
        stepper = self._stepper
        memory = {name: getattr(lanes, name)[lane] for name in ("integers", "reals")}
        stepper.resume({**memory, "vectors": lanes.vectors[lane].reshape(stepper.vectors.shape)})
        states = lanes.states[lane].reshape(self._states.shape)[: len(self._wanted)]
        kept = ("method", "reason", "route", "route_reason", "rtol", "step", "left_out")
        statistics = {name: value for name, value in self._first.statistics.items() if name in kept}
        statistics |= {"jacobians": 0, "factorisations": 0} | stepper.statistics
        if stepper.unconverged:
            statistics["unconverged"] = [*stepper.unconverged]
        statistics |= {"seconds": seconds, "seconds_by_part": {"steps": seconds}}
        status = of_bushings(model, self._wanted, states) or RunStatus("finished", self._stop)
        found = Trajectory.of_states(
            model, self._wanted, states, status=status, statistics=statistics, bent=stepper.bent
        )
        jumped = across_jump(model, stepper.hardest)
        for text in (*([jumped] if jumped else ()), *of_fixed_steps(model, statistics, {})):
            warnings.warn(text, SimulationWarning, stacklevel=outside())
        account(model, found)
        return found
