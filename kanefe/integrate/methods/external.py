"""Solvers of other packages as steppers, and those of scipy: BDF, Radau IIA and LSODA, with the exact Jacobian."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import KanefeError, SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.integrate.breakpoints import changes_of
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.method import MakesSteppers, Method
from kanefe.integrate.methods.python_stepper import PythonStepper
from kanefe.integrate.stepper import StepFailure

if TYPE_CHECKING:
    from scipy.integrate import DenseOutput

    from kanefe.integrate.stepper import StepControl


LEAST_STEPS = 100
"""Least number of steps of a run with functions as loads or drives, so that these are sampled often enough."""


SMALLEST_STEP = 1e-12
"""Step relative to the span below which the run cannot continue."""


SHORTER = 0.1
"""Factor on a step in which the equations have no solution."""


LARGEST_DRIFT = 100.0
"""Largest drift of loops, in multiples of the permitted error of a step, before a solver is restarted at a low order.
"""


class PluggedStepper(PythonStepper):
    """A solver of another package in the middle of a run.

    It is begun anew after an event, where a function of the time jumps, where the equations have no answer for what it
    tries, and where loops have drifted apart; the states that it gives are those with the loops closed.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        rtol, relative to each component of the state; atol, in units of `Dynamics.scales`.
    name : str
        Of the method.
    """

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> None:
        super().__init__(name, dynamics)
        self._stop = stop
        y = dynamics.initial_state(start)
        self._rtol, self._atol = control.rtol, control.atol * dynamics.scales(start, y, control.looseness)
        self._smallest = SMALLEST_STEP * (stop - start)
        self._largest = (stop - start) / LEAST_STEPS if dynamics.calls_functions else stop - start
        self._jacobians = 0
        changes = changes_of(dynamics, start, stop)
        dynamics.seconds_looking = changes.seconds
        both = zip(changes.before, changes.ends, strict=True)
        self._jumps = [(before, after) for before, after in both if before < after]
        self.restart(start, y)

    def state(self) -> Vector:
        """Return the state at t."""
        return self._y.copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        found = np.tile(self._y, (len(times), 1))
        for i in (times < self.t).nonzero()[0]:
            found[i] = self._closed(float(times[i]), self._interpolated(float(times[i])))
        return found

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state."""
        self._t = self._t_old = t
        self._y = y.copy()
        self._is_begun = False

    def snapshot(self) -> dict[str, np.ndarray]:
        """Refuse: what such a solver remembers of earlier steps is not to be had."""
        raise StepFailure(f"{self.name} cannot be interrupted and resumed", "method='radau5'")

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Refuse: see `snapshot`."""
        self.snapshot()

    def _counted(self) -> dict[str, int | float]:
        return {"jacobians": self._jacobians}

    def _advance(self, target: float) -> None:
        """Take one accepted step, whose size does not depend on the outputs; a restarted step counts as rejected."""
        first: float | None = None
        while True:
            try:
                if not self._is_begun:
                    self._begin(self._t, self._y, first)
                    self._is_begun = True
                t, y = self._step()
                break
            except StepFailure:
                raise
            except KanefeError:  # too far ahead: up to where the equations hold there are smaller steps
                tried = first if first is not None else self._last_step()
                first = SHORTER * tried
                self._is_begun = False
                self._rejected += 1
                if first < self._smallest:
                    raise
        self._t_old, self._t, self._y = self._t, t, y
        for before, after in self._jumps:
            if t == before:  # on with the value from there on
                self._t, self._is_begun = after, False
        self._steps += 1
        closed = self._closed(t, y)
        if closed is not y:
            allowed = self._atol + self._rtol * np.abs(y)
            self._is_begun = bool(np.all(np.abs(closed - y) <= LARGEST_DRIFT * allowed))
            self._y = closed

    @property
    def _bound(self) -> float:
        """Time that no step passes, s: the next at which a function of the time has its value from before a jump."""
        return min((before for before, _ in self._jumps if before > self._t), default=self._stop)

    def _closed(self, t: float, y: Vector) -> Vector:
        """Return the nearest state with its loops closed: in a metric of masses alone they would push stiff modes."""
        return self._dynamics.projected(t, y, share=(self._t - self._t_old) ** 2)

    def _last_step(self) -> float:
        return self._t - self._t_old if self._t > self._t_old else 1e-3 * (self._stop - self._t)

    def _rate(self, t: float, y: Vector) -> Vector:
        rates = self._dynamics.rate(min(t, self._bound), np.array(y))  # a stage may be beside it by round-off
        if not np.all(np.isfinite(rates)):
            raise SimulationError(f"the motion has grown without bound at t = {t:.6g} s. Remedy: check the loads")
        return rates

    def _jacobian(self, t: float, y: Vector) -> Matrix:
        self._jacobians += 1
        return self._dynamics.jacobian(t, np.array(y))

    def _no_step(self, said: str) -> StepFailure:
        """Return the failure of a solver, with what it says about it."""
        return StepFailure(
            f"{self.name} found no next step ({said.strip().rstrip('.')})",
            "check loads for jumps or growth without bound there, loosen rtol, or use method='radau5'",
        )

    @abstractmethod
    def _begin(self, t: float, y: Vector, first_step: float | None) -> None:
        """Make a solver at a state, with a first step if one is given."""

    @abstractmethod
    def _step(self) -> tuple[float, Vector]:
        """Take a step; return time and state after it. What it raises are errors of the equations, or a StepFailure."""

    @abstractmethod
    def _interpolated(self, t: float) -> Vector:
        """Return the state at a time of the last step."""


class ScipyStepper(PluggedStepper):
    """A solver of `scipy.integrate`, by the name of its class: see `PluggedStepper`."""

    def __init__(
        self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str, solver: str
    ) -> None:
        from scipy import integrate

        self._class = getattr(integrate, solver)
        self._dense: DenseOutput | None = None
        super().__init__(dynamics, start, stop, control, name=name)

    def _begin(self, t: float, y: Vector, first_step: float | None) -> None:
        self._solver = self._class(
            self._rate,
            t,
            y,
            self._bound,
            rtol=self._rtol,
            atol=self._atol,
            jac=self._jacobian,
            max_step=self._largest,
            first_step=first_step,
        )

    def _step(self) -> tuple[float, Vector]:
        solver = self._solver
        said = solver.step()
        if solver.status == "failed":
            raise self._no_step(said)
        self._dense = None
        return float(solver.t), solver.y.copy()

    def _interpolated(self, t: float) -> Vector:
        if self._dense is None:
            self._dense = self._solver.dense_output()
        return self._dense(t)  # type: ignore[no-any-return]


def plugged_method(name: str, about: str, stepper: MakesSteppers, order: int) -> Method:
    """Return the row of a solver of another package."""
    return Method(
        name=name, about=about, stepper=stepper, order=order, takes_atol=True, least_rtol=1e-12, is_plugged=True
    )


METHODS = (
    plugged_method("scipy-bdf", "BDF of scipy, with the exact Jacobian", partial(ScipyStepper, solver="BDF"), 5),
    plugged_method("scipy-radau", "Radau of scipy, with the exact Jacobian", partial(ScipyStepper, solver="Radau"), 5),
    plugged_method("scipy-lsoda", "LSODA of scipy, Adams or BDF", partial(ScipyStepper, solver="LSODA"), 12),
)
