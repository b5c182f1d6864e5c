"""The classical Runge-Kutta method of order 4 with fixed steps: for comparisons, and where the step is given."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics


class RungeKuttaStepper:
    """Fixed steps, from one stored state to the next; in compiled code where no Python function is in the scene.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    step : float
        s.
    outputs : ndarray
        Times wanted, each a whole number of steps from the start.

    Raises
    ------
    ModelError
        If the outputs are not on whole steps.
    """

    name = "rk4"

    def __init__(self, dynamics: Dynamics, start: float, stop: float, step: float, outputs: np.ndarray) -> None:
        counts = np.rint((outputs - start) / step).astype(int)
        if np.abs(counts * step - (outputs - start)).max() > 1e-9 * (stop - start):
            raise ModelError(
                f"the steps of {step:g} s do not meet the stored times from {start:g} to {stop:g} s. Remedy: a step "
                "that divides the span, and output_step a multiple of it"
            )
        self._dynamics, self._step, self._counts = dynamics, step, np.diff(counts)
        self._outputs = outputs
        self._state = dynamics.initial_state(start)
        self._reached = 0
        self.rejected = 0

    @property
    def t(self) -> float:
        """Time reached in s."""
        return float(self._outputs[self._reached])

    def initial_state(self) -> Vector:
        """Return the state at the start."""
        return self._state.copy()

    def step(self) -> None:
        """Go on to the next stored time."""
        dynamics, h, t, count = self._dynamics, self._step, self.t, int(self._counts[self._reached])
        if dynamics.is_autonomous:
            self._state = dynamics.steps(t, self._state, h, count)
        else:
            for i in range(count):
                self._state = self._one(t + i * h, self._state)
        self._reached += 1

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state): the end of the step, where they lie."""
        return np.tile(self._state, (len(times), 1))

    def _one(self, t: float, y: Vector) -> Vector:
        rate, h = self._dynamics.rate, self._step
        a = rate(t, y)
        b = rate(t + 0.5 * h, y + 0.5 * h * a)
        c = rate(t + 0.5 * h, y + 0.5 * h * b)
        d = rate(t + h, y + h * c)
        return self._dynamics.projected(t + h, y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d))
