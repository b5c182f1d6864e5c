"""Simulation: a scene that is stepped from outside, with inputs that are constant over each step."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import ModelError, SimulationWarning, outside
from kanefe.frames import Vector
from kanefe.instants.instant import Instant
from kanefe.integrate.auto.choice import Choice, choose
from kanefe.integrate.clock import Clock
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.events.requested_events import with_asked_events
from kanefe.integrate.loop import RunLoop
from kanefe.integrate.pace import Limits
from kanefe.integrate.run import SilentBar, one_count
from kanefe.integrate.run_checks.convergence_check import of_fixed_steps
from kanefe.integrate.run_checks.stiff_contacts import warn_of_stiff_contacts
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.integrate.sampling import ControllerLog, Sampler
from kanefe.integrate.set_up import reported_events, watch_of
from kanefe.integrate.status import RunStatus
from kanefe.integrate.step_times import StepTimes
from kanefe.integrate.stepper import keeps_time
from kanefe.integrate.trajectory import is_finite_number
from kanefe.loads.controller import INPUTS
from kanefe.stepping.asked import Asked
from kanefe.stepping.held_values import HeldValues
from kanefe.stepping.outputs import outputs_of, readers
from kanefe.stepping.saved import SavedSimulation
from kanefe.stepping.steppable import Steppable
from kanefe.tree.bending import worst_bending

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.integrate.events.event_search import EventWatch
    from kanefe.joints.held_motion import Course
    from kanefe.scene.held_inputs import HeldInput


LITTLE = 1e-6
"""Time after which contacts and dry friction are seen under other inputs, relative to the usual step."""


def started(scene: Steppable, asked: Asked) -> Simulation:
    """Return a simulation of a scene, which stays open.

    Raises
    ------
    ModelError
        See `kanefe.System.start`.
    """
    t, _ = asked.options.span
    own = scene.copy()
    held = own._hold_inputs(asked.inputs, t, asked.every)
    model = with_asked_events(own.freeze(t, asked.start), asked.options.watched)
    if INPUTS in model.held:
        states = model.initial_states.copy()
        states[model.held[INPUTS]] = [one.start for one in held if one.course is None]
        model = replace(model, initial_states=states)
    warn_of_stiff_contacts(model)
    warn_of_structural_damping(model)
    return Simulation(scene, asked, own, model, held)


class Simulation:
    """A scene in the middle of a run, returned by `kanefe.System.start`.

    Only one thread may use it at a time.

    Attributes
    ----------
    model : Model
    input_names, output_names : tuple of str
    units : dict of str to str
        Of inputs and outputs.
    stepper : Stepper
        The method of integration.
    output_list : tuple of Output
    courses : list of Course
        Of driven coordinates that are inputs.
    scene, asked : System and Asked
        What it was started from.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    >>> sim = scene.start(inputs="motor hub", outputs="joint_coordinates hub")
    >>> for _ in range(100):
    ...     angle = sim.outputs["joint_coordinates hub"]
    ...     sim.step(0.01, {"motor hub": 4.0 * (1.0 - angle)})
    >>> round(sim.time, 12)
    1.0
    """

    def __init__(self, scene: Steppable, asked: Asked, own: Steppable, model: Model, held: list[HeldInput]) -> None:
        self.model = model
        self.scene, self.asked, self._options = scene, asked, asked.options
        self.output_list = outputs_of(own, model, asked.outputs)
        self._read = readers(model, self.output_list)
        self.input_names = tuple(one.name for one in held)
        self.output_names = tuple(output.name for output in self.output_list)
        shared = sorted({*self.input_names} & {*self.output_names})
        if shared:
            raise ModelError(f"the name {shared[0]!r} is of an input and of an output. Remedy: another one")
        both = [*((one.name, one.unit) for one in held), *((output.name, output.unit) for output in self.output_list)]
        self.units = dict(both)
        self._held = HeldValues(model, held)
        self.courses = self._held.courses
        with one_count(model, asked.options):
            self._choice: Choice = choose(model, asked.options)
            if self._choice.is_plugged:
                raise ModelError(
                    f"{self._choice.name} does not expose its memory of earlier steps, and cannot be stepped. "
                    "Remedy: method='auto', 'radau5' or 'dop853'"
                )
            self._make()

    def _make(self) -> None:
        model, options = self.model, self._options
        start, stop = options.span
        dynamics, clock = Dynamics(model), Clock()
        self.stepper = self._choice.make(dynamics)
        self._reported = reported_events(model, self._choice, options)
        self._watch = watch_of(model, self._choice, options, self._reported)
        if self._watch is not None:
            self._watch.start(self.stepper)
        is_sampled = any(controller.is_sampled for controller in model.controllers)
        self._sampler = Sampler(model, start, stop) if is_sampled else None
        none = Limits(None, None)
        self._loop = RunLoop(
            dynamics, self.stepper, np.array([stop]), self._watch, none, clock, SilentBar(), self._sampler
        )
        self._status = RunStatus("finished", start)
        self._has_begun = False
        self._reported_outputs: dict[str, float] | None = None
        self._step_times = StepTimes()
        self._may_leave = self.stepper if keeps_time(self.stepper) else None

    @property
    def time(self) -> float:
        """Present time, s."""
        return self.stepper.t if self._status.kind != "stopped" else self._status.time

    @property
    def status(self) -> RunStatus:
        """How the last step ended: as requested, or by an event that ends the run."""
        return self._status

    @property
    def statistics(self) -> dict[str, Any]:
        """Method and cost of the steps so far: the method and why, its counts, and more as in results.

        "step_seconds" is here the wall time that 99.9 % of the calls of `step` did not exceed, and the longest, s.
        """
        q = self._vector()[: self.model.coordinate_count]
        bending = worst_bending(self.model, np.array([self.time]), q[None], self.stepper.bent)
        return {
            "method": self.stepper.name,
            "reason": self._choice.reason,
            **self._choice.control,
            **self._loop.statistics,
            **self._loop.told_of_steps,
            **({"step_seconds": self._step_times.told} if self._step_times.told else {}),
            **({"bending": list(bending)} if bending is not None else {}),
        }

    @property
    def inputs(self) -> dict[str, float]:
        """The present values of the inputs, by name."""
        return dict(zip(self.input_names, self._held.values.tolist(), strict=True))

    @property
    def outputs(self) -> dict[str, float]:
        """The present outputs, by name; computed at the first request after a step."""
        if self._reported_outputs is None:
            values = self._read(self.time, self._vector())
            self._reported_outputs = dict(zip(self.output_names, values, strict=True))
        return dict(self._reported_outputs)

    def outputs_with(self, inputs: Mapping[str, float]) -> dict[str, float]:
        """Return the outputs of the present state under other inputs: accelerations and forces follow them at once.

        `outputs` are those under the inputs of the last step, or the start. Where contacts or dry friction may change
        what they do, it is the state after 1e-6 of a usual step.

        Parameters
        ----------
        inputs : mapping of str to float
            In the `units` of the simulation; other inputs keep theirs.

        Raises
        ------
        ModelError
            If there is no such input (the message names the nearest), or a number is not valid.
        SimulationError
            If the scene cannot go on with these inputs.

        Examples
        --------
        ``sim.outputs_with({"motor hub": 3.0})["angular_acceleration hub z"]``
        """
        values = self._held.with_changes(inputs)
        if np.array_equal(values, self._held.values):
            return self.outputs
        loop, saved = self._loop, self.save()
        rows, last, reported = loop.rows.stored, loop.last, self._reported_outputs
        try:
            if self._watch is None:
                y = self._vector().copy()
                self._held.put(values, self.time, y)
            else:
                self._hold(values)
                loop.go_to(self.stepper.t + LITTLE * self.asked.every).raise_if_failed()
                y = self._reached()
            return dict(zip(self.output_names, self._read(self.stepper.t, y), strict=True))
        finally:
            self.restore(saved)
            loop.rows.stored, loop.last, self._reported_outputs = rows, last, reported

    @property
    def state(self) -> Instant:
        """The present state of the scene, to view it or to start a run from it."""
        return Instant(self.model, self.time, self._vector()[: len(self.model.state_names)])

    @property
    def events(self) -> dict[str, np.ndarray]:
        """Times of the reported events, by name, s."""
        times = self._watch.times if self._watch is not None else {}
        return {event.name: np.array(times[event.name]) for event in self._reported}

    @property
    def controllers(self) -> dict[str, ControllerLog]:
        """Samples of the scene's own controllers, by name."""
        return self._sampler.logs() if self._sampler is not None else {}

    def _vector(self) -> Vector:
        last = self._loop.last
        return last[1] if self._status.kind == "stopped" and last is not None else self._reached()

    def _reached(self) -> Vector:
        """Return the state reached, as an output: with its stiff modes settled, unless something acted there."""
        rows, stepper = self._loop.rows, self.stepper
        is_output = rows.stored > 0 and rows.times[rows.stored - 1] == stepper.t
        if is_output and self._watch is None and self._sampler is None:
            return rows.states[rows.stored - 1].copy()
        return stepper.state()

    def step(self, dt: float, inputs: Mapping[str, float] | None = None) -> None:
        """Continue by `dt` with constant inputs.

        If the step fails or raises an error, the simulation stays as it was before. An event that ends the run ends the
        step too, as `time` and `status` show.

        Parameters
        ----------
        dt : float
            Above zero, s.
        inputs : mapping of str to float, optional
            New values, in the `units` of the simulation; other inputs keep theirs.

        Raises
        ------
        ModelError
            If there is no such input (the message names the nearest), or a number is not valid.
        SimulationError
            If the step cannot be taken.

        Examples
        --------
        ``sim.step(0.01, {"motor hub": 3.0})``
        """
        if not (is_finite_number(dt) and dt > 0.0):
            raise ModelError(f"dt of a step must be above zero, in s, not {dt!r}")
        values = self._held.with_changes({} if inputs is None else inputs)
        if self._status.kind == "stopped":
            raise ModelError(f"{self._status}. Remedy: restore an earlier state, or start another simulation")
        stop = self.stepper.t + float(dt)
        if stop - self.stepper.t < 0.5 * dt:
            raise ModelError(f"dt = {dt!r} s is below the resolution of the time {self.stepper.t:.6g} s")
        before, began = self.save(), time.perf_counter()
        if self._watch is not None:
            self._watch.telling.impacts.clear()  # of steps that were tried only
        try:
            self._hold(values)
            self._status = self._loop.go_to(stop)
            if self.model.rigid_contacts and self._status.kind != "failed":
                self._status = self._checked_contacts() or self._status
            self._status.raise_if_failed()
        except BaseException:
            self.restore(before)
            raise
        self._has_begun, self._reported_outputs = True, None
        self._step_times.add(time.perf_counter() - began)
        for text in self._watch.telling.impacts.warnings if self._watch is not None else ():
            warnings.warn(text, SimulationWarning, stacklevel=outside())
        if self._may_leave is not None and self._may_leave.unconverged is not None:
            self._may_leave = None  # it is told once
            for text in of_fixed_steps(self.model, self.statistics, {}):
                warnings.warn(text, SimulationWarning, stacklevel=outside())

    def _checked_contacts(self) -> RunStatus | None:
        """Return the status of a step at whose end a rigid contact violates its law; None if none does."""
        from kanefe.integrate.run_checks.contact_check import of_contacts

        rtol, at = self._choice.control.get("rtol"), np.array([self.time])
        return of_contacts(self.model, at, self._vector()[None], self._choice.name, 0, rtol)

    def _hold(self, values: Vector) -> None:
        """Set the inputs; with unchanged inputs the method continues without a restart."""
        stepper = self.stepper
        if self._has_begun and np.array_equal(values, self._held.values):
            return
        self._held.values = values
        y, t = self._reached(), stepper.t
        self._held.put(values, t, y)
        stepper.go_on_with(t, y)
        if self._watch is not None:
            self._watch.renew(t, y)

    def drive_of(self, course: Course) -> int:
        """Return the number of a course among all driven coordinates."""
        return self._held.drive_of(course)

    @property
    def event_watch(self) -> EventWatch | None:
        """What detects events, also those of contacts; None if there are none."""
        return self._watch

    def save(self) -> SavedSimulation:
        """Return the state of the simulation, for `restore`. Data that functions of the user keep are not included."""
        return SavedSimulation(
            self.stepper.t,
            self._held.values.copy(),
            tuple(course.piece.copy() for course in self.courses),
            self.stepper.snapshot(),
            None if self._watch is None else self._watch.snapshot(),
            None if self._sampler is None else self._sampler.snapshot(),
            self._status,
            self._has_begun,
        )

    def restore(self, saved: SavedSimulation) -> None:
        """Return to a saved state; what follows is the same to the bit.

        Parameters
        ----------
        saved : SavedSimulation
            Returned by `save` of this simulation or of a copy of it.

        Raises
        ------
        ModelError
            If it is from another simulation.
        """
        sizes = [len(self._held.values), len(self.courses)]
        if not isinstance(saved, SavedSimulation) or [len(saved.inputs), len(saved.pieces)] != sizes:
            raise ModelError(f"restore takes what save of this simulation has returned, not {saved!r}")
        if saved.status.kind == "stopped":
            raise ModelError("the simulation had been ended by an event when it was saved. Remedy: save it before")
        self._held.resume(saved.inputs, saved.pieces)
        self.stepper.resume(saved.stepper)
        if self._watch is not None and saved.watch is not None:
            self._watch.resume(saved.watch)
        if self._sampler is not None and saved.sampler is not None:
            self._sampler.resume(saved.sampler)
        self._loop.rows.stored, self._loop.last = 0, None
        self._status, self._has_begun, self._reported_outputs = saved.status, saved.has_begun, None

    def copy(self) -> Simulation:
        """Return a simulation that continues from here independently."""
        if self.courses:  # each simulation has its own courses
            other = started(self.scene, self.asked)
        else:
            other = object.__new__(type(self))
            other.__dict__.update(self.__dict__)
            other._make()
        other.restore(self.save())
        return other

    def __repr__(self) -> str:
        return f"Simulation(t = {self.time:.6g} s, inputs: {', '.join(self.input_names) or 'none'})"
