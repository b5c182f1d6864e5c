"""Runs that are alike in one call of compiled code: several evaluated at once, or in turn in one memory."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np

from kanefe.equations.model import Model, is_for_many
from kanefe.errors import KanefeError, SimulationWarning, outside
from kanefe.integrate.auto.choice import Choice, choose
from kanefe.integrate.auto.tried_methods import TriedMethods
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_memory import StepMemory
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.options import RunOptions
from kanefe.integrate.pace import SMALLEST_STEP
from kanefe.integrate.run_checks.bushing_turns import of_bushings
from kanefe.integrate.run_checks.convergence_check import of_fixed_steps
from kanefe.integrate.run_checks.energy_check import account
from kanefe.integrate.run_checks.functions_of_user import across_jump
from kanefe.integrate.set_up import check_motions, reported_events, watch_of, with_trials
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.steppers.lanes import Lanes, Slots, run_lanes, run_lanes_at_once
from kanefe.kernels.steppers.step_commands import VECTOR, Command, Step
from kanefe.kernels.values.records import column
from kanefe.order_n.lanes import are_alike, for_some, numbers_of, slots_for, why_alone, with_numbers
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scales import length_of_parts

TURN = 2000
"""Number of steps of a lane in one call: Ctrl-C waits for the end of a call."""

STORED, LEFT_OPEN, STEPS, TIME = (column(Step, name) for name in ("stored", "is_left_open", "steps", "time"))


@dataclass(eq=False)
class Planned:
    """A run that may be a lane.

    Attributes
    ----------
    model : Model
    options : RunOptions
    choice : Choice
        Of its method.
    method : str
        That it takes: the one of the choice, or one that the choice would try.
    tries : bool
        Whether it tries others on its way, as it does alone.
    """

    model: Model
    options: RunOptions
    choice: Choice
    method: str
    tries: bool = False

    def new_stepper(self) -> KernelStepper:
        """Return its method at the start of the run."""
        return cast(KernelStepper, cast(Any, self.choice.maker_of(self.method))(Dynamics(self.model)))

    @cached_property
    def stepper(self) -> KernelStepper:
        """The same, which is used once."""
        return self.new_stepper()

    @cached_property
    def trials(self) -> TriedMethods:
        """The same, as it tries other methods."""
        found = with_trials(self.choice, self.stepper.dynamics, self.stepper, None, self.options)
        return cast(TriedMethods, found)

    @property
    def told(self) -> dict[str, Any]:
        """What its statistics say of the choice."""
        choice, route = self.choice, self.model.route
        found: dict[str, Any] = {"method": self.method, "reason": choice.reason}
        found |= {"route": route.name, "route_reason": route.reason, **choice.control}
        found |= {"left_out": choice.left_out} if choice.left_out else {}
        return found | ({"tried": self.trials.told, "tried_share": self.trials.tried_share} if self.tries else {})


def why_in_python(model: Model, options: RunOptions) -> str:
    """Return why a run is looked at in Python on its way, or nothing."""
    for reason, holds in (
        ("limits of the run", options.most_steps is not None or options.most_seconds is not None),
        ("events", bool(options.watched)),
        ("controllers", bool(model.controllers)),
        ("functions of the user", not model.route.is_autonomous or not is_for_many(model)),
    ):
        if holds:
            return reason
    return ""


def planned(model: Model, options: RunOptions, method: str | None = None) -> Planned | None:
    """Return what a lane takes of a model; None where its run needs Python: functions, controllers, events, limits.

    `method`: that the run is to take; by default its own choice, and what it tries on its way.
    """
    if why_in_python(model, options):
        return None
    choice = choose(model, options)
    found = Planned(model, options, choice, method or choice.name, method is None and bool(choice.rivals))
    if choice.maker_of(found.method) is None:
        return None
    if watch_of(model, choice, options, reported_events(model, choice, options)) is not None:
        return None
    return found if type(found.stepper) is KernelStepper else None


def planned_beside(
    first: Planned | None, model: Model, options: RunOptions, method: str | None = None
) -> Planned | None:
    """Return the same of a model that is evaluated at once with others of its kind; None where it is not.

    Raises
    ------
    ModelError, SimulationError
        If the run cannot begin.
    """
    check_motions(model, *options.span)
    one = planned(model, options, method)
    if one is None or why_not_at_once(one) or (first is not None and not _are_alike(first, one)):
        return None
    return one


def planned_alike(models: Sequence[Model], options: RunOptions, method: str | None = None) -> list[Planned | None]:
    """Return the same of models of several scenes, of those that are alike; None of others, and of those that fail."""
    found: list[Planned | None] = []
    first: Planned | None = None
    for model in models:
        try:
            one = planned_beside(first, model, options, method)
        except KanefeError:  # told by the run alone
            one = None
        first = first or one
        found.append(one)
        if first is None:
            return [None] * len(models)
    return found


def _are_alike(one: Planned, other: Planned) -> bool:
    same = one.method == other.method and one.choice.control == other.choice.control
    return same and are_alike(one.model.route, other.model.route)  # type: ignore[arg-type]  # of order n


def why_not_at_once(one: Planned) -> str:
    """Return why a run is not evaluated beside others, or nothing."""
    route: Any = one.model.route
    return why_alone(route) or ("" if one.stepper.wants_rates_alone else f"{one.method} wants more than rates")


def lanes_of_scene(models: Sequence[Model], options: RunOptions, first: Trajectory) -> SharedMemory | None:
    """Return what runs models that differ in their starts, by the method with which their first run has ended.

    None where they differ in more, or a run needs Python.
    """
    if not all(other.of_scene is models[0].of_scene for other in models):
        return None
    one = planned(models[0], options, first.statistics["method"])
    return None if one is None else SharedMemory(one, options)


def begins_alike(model: Model, stepper: KernelStepper) -> bool:
    """Return whether runs from all starts begin with the same memory, but for the state.

    Not of methods that look at the start before the first step, nor where tolerances follow from the energy there, nor
    the size of the scene.
    """
    own = stepper.looks_at_start or model.is_constrained or any(load.acts_at_once for load in model.loads)
    return not own and length_of_parts(model) > 0.0


class SharedMemory:
    """Runs models that are alike.

    Parameters
    ----------
    first : Planned
        One of them.
    options : RunOptions

    Attributes
    ----------
    reason : str
        Why they are not evaluated at once, or nothing.
    """

    def __init__(self, first: Planned, options: RunOptions) -> None:
        self._first, self._options, self.reason = first, options, why_not_at_once(first)
        self._unused: list[_Turns] = []

    def run(self, models: Sequence[Model]) -> list[Trajectory | None]:
        """Return the runs of models of one scene; None for those that have to be run alone. Threads may call it."""
        first = self._first
        return self.run_all(
            [Planned(model, self._options, first.choice, first.method) for model in models], is_one_scene=True
        )

    def run_all(self, runs: Sequence[Planned], is_one_scene: bool = False) -> list[Trajectory | None]:
        """Return the same of models of several scenes."""
        return list(self.each(runs, is_one_scene))

    def each(self, runs: Sequence[Planned], is_one_scene: bool = False) -> Iterator[Trajectory | None]:
        """Yield them one by one: what is told of a run is told when it is asked for."""
        turns = self._unused.pop() if self._unused else _Turns(self._first, self._options, self.reason)
        yield from turns.run(runs, is_one_scene)
        self._unused.append(turns)


class _Turns:
    """The memory of one method, which lanes use: of one thread at a time."""

    def __init__(self, first: Planned, options: RunOptions, reason: str) -> None:
        (start, stop), wanted = options.span, options.times
        self._wanted, self._start, self._stop, self._reason = wanted, start, stop, reason
        self._times = wanted if wanted[-1] == stop else np.append(wanted, stop)
        self._stepper = stepper = first.new_stepper()
        self._begin(stepper)
        self._begun, self._is_alike = stepper.snapshot(), begins_alike(first.model, stepper)
        self._states = np.zeros((len(self._times), stepper.vectors.shape[1]))
        self._going, _, _ = stepper.prepared(self._times, self._states)
        self._run = self._going.arguments[-1]
        given = self._going.for_kernels(), self._going.signature.number_count
        self._in_turn = run_lanes.bound(*given, LATER, LATER)
        self._slots: Slots | None = None
        if not reason:
            self._slots = slots_for(cast(Any, first.model.route), self._states.shape[1])
            self._at_once = run_lanes_at_once.bound(self._going.arguments[0], LATER, LATER, LATER)

    def _begin(self, stepper: KernelStepper) -> None:
        stepper.begin_outputs(self._times, int(self._times[0] == self._start))

    def run(self, runs: Sequence[Planned], is_one_scene: bool) -> Iterator[Trajectory | None]:
        """Yield the runs; None for those that have to be run alone."""
        began, lanes, left = time.perf_counter(), self._lanes(runs, is_one_scene), np.arange(len(runs))
        if self._slots is not None:
            routes: list[Any] = [one.model.route for one in runs]
            numbers = [] if is_one_scene else [numbers_of(route) for route in routes]
            values = [route.inputs.constants for route in (routes[:1] if is_one_scene else routes)]
            self._slots = with_numbers(self._slots, numbers, values)
        is_done = np.zeros(len(runs), dtype=bool)
        while len(left):
            self._let_go_on(lanes, runs, left)
            times, steps = lanes.reals[left, TIME], lanes.integers[left, STEPS]
            self._call(lanes, left)
            is_done[left] = lanes.integers[left, STORED] == len(self._times)
            taken = lanes.integers[left, STEPS] - steps
            moved = lanes.reals[left, TIME] - times > SMALLEST_STEP * taken * (self._stop - self._start)
            goes_on = (lanes.commands[left] == Command.ACCEPTED) & [self._keeps(runs[lane]) for lane in left]
            left = left[~is_done[left] & moved & goes_on]
        is_done &= (lanes.integers[:, LEFT_OPEN] == 0) & np.isfinite(lanes.states).all(axis=(1, 2))
        seconds = (time.perf_counter() - began) / len(runs)
        for lane, one in enumerate(runs):
            yield self._trajectory(lanes, lane, one, seconds) if is_done[lane] and self._keeps(one) else None

    def _let_go_on(self, lanes: Lanes, runs: Sequence[Planned], left: np.ndarray) -> None:
        """Say how many steps lanes may take: up to the next look at other methods."""
        lanes.most[left] = lanes.integers[left, STEPS] + TURN
        for lane in left:
            if runs[lane].tries:
                lanes.most[lane] = lanes.integers[lane, STEPS] + min(TURN, runs[lane].trials.steps_to_look())
        self._run = self._run._replace(most_steps=int(lanes.most[left].max()))

    @staticmethod
    def _keeps(one: Planned) -> bool:
        """Return whether a run keeps the method that it has begun with."""
        return not one.tries or one.trials.goes_on_with_first

    def _lanes(self, runs: Sequence[Planned], is_one_scene: bool) -> Lanes:
        """Return the lanes at their starts; in their memory are the steppers of runs that try other methods."""
        is_alike, count = self._is_alike and is_one_scene, len(runs)
        integers, reals, vectors = (
            np.repeat(self._begun[name][None], count, axis=0) for name in ("integers", "reals", "vectors")
        )
        for lane, one in enumerate(runs if not is_alike else ()):
            stepper, memory = one.stepper, StepMemory(integers[lane], reals[lane], vectors[lane])
            for own, array in zip((stepper.integers, stepper.reals, stepper.vectors), memory, strict=True):
                array[:] = own
            stepper.use(memory)
            self._begin(stepper)
        if is_alike:
            vectors[:, VECTOR.state, :-QUADRATURES] = [one.model.initial_state for one in runs]
        states = np.zeros((count, *self._states.shape))
        states[:, 0] = vectors[:, VECTOR.state]
        return Lanes(integers, reals, vectors, states, *(np.zeros(count, dtype=np.int64) for _ in range(2)))

    def _call(self, lanes: Lanes, left: np.ndarray) -> None:
        """Continue with some lanes."""
        is_all = len(left) == len(lanes.commands)
        some = lanes if is_all else Lanes(*(array[left] for array in lanes))
        if self._slots is None:
            self._going.give(self._run)
            self._in_turn(self._run, some)
        else:
            self._at_once(self._run, some, self._slots if is_all else for_some(self._slots, left))
        if not is_all:
            for array, part in zip(lanes, some, strict=True):
                array[left] = part

    def _trajectory(self, lanes: Lanes, lane: int, one: Planned, seconds: float) -> Trajectory:
        stepper, model = self._stepper, one.model
        memory = {name: getattr(lanes, name)[lane] for name in ("integers", "reals", "vectors")}
        stepper.resume(memory)
        states = lanes.states[lane, : len(self._wanted)]
        counts = one.trials.statistics if one.tries else stepper.statistics
        statistics = one.told | {"jacobians": 0, "factorisations": 0} | counts
        if stepper.unconverged:
            statistics["unconverged"] = [*stepper.unconverged]
        statistics |= {"seconds": seconds, "seconds_by_part": {"steps": seconds}}
        statistics["lanes"] = 1 if self._slots is None else len(self._slots.lanes)
        if self._reason:
            statistics["lanes_reason"] = self._reason
        status = of_bushings(model, self._wanted, states) or RunStatus("finished", self._stop)
        found = Trajectory.of_states(
            model, self._wanted, states, status=status, statistics=statistics, bent=stepper.bent
        )
        jumped = across_jump(model, stepper.hardest)
        for text in (*([jumped] if jumped else ()), *of_fixed_steps(model, statistics, {})):
            warnings.warn(text, SimulationWarning, stacklevel=outside())
        account(model, found)
        return found
