"""Explicit Runge-Kutta of order 8 (Dormand & Prince, scipy's DOP853): for scenes without stiff modes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853, DenseOutput

from kanefe.equations_of_motion import WORKS
from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.scales import state_scales
from kanefe.integrate.stepper import StepFailure

if TYPE_CHECKING:
    from kanefe.integrate.methods import StepControl

SINGULAR = 1e-3
"""Share of the usual `Dynamics.weakest` below which a step that falls to a tenth creeps up to a singular position."""

SMALLEST_CREEP = 1e-5
"""Share of the usual step below which a mechanism is held for good: at a dead centre its speeds grow without bound."""

SMALLEST_STEP = 1e-12
"""Of the span: a smaller step is none."""

BESIDE = 1e-6
"""Of the span: how near the place at which the equations had no answer a run that ends is ended by that."""

SHORTER = 0.1
"""Share of a step that is tried after one in which the equations have no answer."""

LARGEST_RTOL = 1e-6
"""To which the tolerance may grow there: the error of one step."""


class ExplicitStepper:
    """Steps of DOP853 with dense output.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        rtol, relative to each component of the state; atol, in units of `state_scales`.
    """

    name = "dop853"

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl) -> None:
        self._dynamics, self._start, self._stop = dynamics, start, stop
        self._rtol, self._atol = max(control.rtol, 3e-14), control.atol * state_scales(dynamics.model)
        self._looser = 1.0
        self._smallest = SMALLEST_STEP * (stop - start)
        self._usual_step, self._usual_weakest = 0.0, 0.0
        self._no_answer: tuple[float, KanefeError] | None = None
        self._steps = self._rejected = 0
        self.restart(start, dynamics.initial_state(start))

    @property
    def t(self) -> float:
        """Time reached in s."""
        return float(self._solver.t)

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return float(self._solver.t if self._solver.t_old is None else self._solver.t_old)

    @property
    def statistics(self) -> dict[str, int | float]:
        """Steps, rejected steps and evaluations."""
        return {"steps": self._steps, "rejected": self._rejected, "evaluations": self._dynamics.evaluations}

    def march(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Go on until all times are passed or so many steps are taken: see `Stepper.march`."""
        passed = 0
        while passed < len(times) and most_steps > 0:
            self._advance()
            most_steps -= 1
            reached = passed + int(np.searchsorted(times[passed:], self.t, side="right"))
            if reached > passed:
                states[passed:reached] = self.states(times[passed:reached])
                passed = reached
        return passed

    def state(self) -> Vector:
        """Return the state at t."""
        return np.array(self._solver.y)

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        if self.t_old == self.t:
            return np.tile(self._solver.y, (len(times), 1))
        dense = self._dense_output()
        return np.array([self._dynamics.projected(t, dense(t)) for t in times]).reshape(len(times), -1)

    def restart(self, t: float, y: Vector) -> None:
        """Go on from another state with a step of its own."""
        self._solver = DOP853(self._dynamics.rate, t, y, self._stop, rtol=self._rtol, atol=self._atol)
        self._as_stepped: tuple[Vector, Vector] = self._solver.y, self._solver.f
        self._dense: DenseOutput | None = None
        self._looser = 1.0

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what is needed to go on."""
        solver = self._solver
        numbers = (solver.t, solver.h_abs, self._looser, self._usual_step, self._usual_weakest)
        return {"y": np.array(solver.y), "f": np.array(solver.f), "numbers": np.array(numbers)}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Go on from a snapshot."""
        t, h_abs, looser, self._usual_step, self._usual_weakest = snapshot["numbers"].tolist()
        self.restart(t, np.array(snapshot["y"]))
        self._solver.f, self._solver.h_abs, self._looser = np.array(snapshot["f"]), h_abs, looser
        self._set_tolerances()

    def _advance(self) -> None:
        """Take one accepted step."""
        solver = self._solver
        before, t = solver.nfev, solver.t
        while True:
            try:
                solver.step()
                break
            except KanefeError as error:  # a stage too far ahead: up to where the equations hold there are smaller ones
                self._no_answer = t, error
                self._rejected += 1
                before = solver.nfev
                if solver.h_abs < self._smallest:
                    raise
                solver.h_abs *= SHORTER
        # a try costs as many evaluations as the method has stages; scipy does not count the failed ones itself
        self._rejected += (solver.nfev - before) // solver.n_stages - 1
        is_too_small = solver.t - t < self._smallest and solver.t < self._stop
        if solver.status == "failed" or is_too_small:
            self._refuse_dead_centre(0.0)
            if self._no_answer is not None and solver.t - self._no_answer[0] < BESIDE * (self._stop - self._start):
                raise self._no_answer[1]
            raise StepFailure(
                f"the explicit method found no step of {self._smallest:.1g} s or more",
                "check loads for jumps or growth without bound there, loosen rtol, or use method='generalised-alpha'",
                self._worst_component(),
            )
        self._steps += 1
        self._dense, self._as_stepped = None, (solver.y, solver.f)
        if self._dynamics.model.constraints:
            self._close_loops()

    def _worst_component(self) -> int:
        """Return which coordinate or speed had the largest error in the last try."""
        solver = self._solver
        with np.errstate(invalid="ignore", over="ignore"):
            errors = np.abs(solver.E5 @ solver.K) / (solver.atol + solver.rtol * np.abs(solver.y))
        return int(np.argmax(np.where(np.isfinite(errors), errors, np.inf)[:-WORKS]))

    def _dense_output(self) -> DenseOutput:
        """Return the dense output of the step as it was taken: it leans on the state at both ends."""
        if self._dense is None:
            solver = self._solver
            closed = solver.y, solver.f
            solver.y, solver.f = self._as_stepped
            self._dense = solver.dense_output()
            solver.y, solver.f = closed
        return self._dense

    def _close_loops(self) -> None:
        """Take the drift out of the state, so that it stays at tolerance for any length of run."""
        solver = self._solver
        closed = self._dynamics.projected(solver.t, solver.y)
        if closed is not solver.y:
            solver.y, solver.f = closed, self._dynamics.rate(solver.t, closed)
        self._pass_singular_position(solver.t - solver.t_old)

    def _pass_singular_position(self, step: float) -> None:
        """Let the error grow tenfold with every step that creeps up to a singular position; take it back behind.

        Beside such a position the rates have an error of round-off divided by the square of the distance, which no
        step is small enough for. The position itself is passed by the momentum of the step.
        """
        self._refuse_dead_centre(step)
        self._usual_weakest = max(self._usual_weakest, self._dynamics.weakest)
        if not self._is_near_singular:
            self._usual_step = step
        if self._is_near_singular and step < 0.1 * self._usual_step:
            self._looser = min(10.0 * self._looser, LARGEST_RTOL / self._rtol)
        else:
            self._looser = 1.0
        self._set_tolerances()

    def _set_tolerances(self) -> None:
        factor = max(self._looser, 1.0)
        self._solver.rtol, self._solver.atol = factor * self._rtol, factor * self._atol

    @property
    def _is_near_singular(self) -> bool:
        return self._dynamics.weakest < SINGULAR * self._usual_weakest

    def _refuse_dead_centre(self, step: float) -> None:
        if self._is_near_singular and step <= SMALLEST_CREEP * self._usual_step:
            raise StepFailure(
                "the mechanism is at a singular position and does not pass it",
                "check that driven joints stay within its reach",
            )
