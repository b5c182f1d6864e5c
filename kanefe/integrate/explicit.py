"""Explicit Runge-Kutta of order 8 (Dormand & Prince, scipy's DOP853): for scenes without stiff modes."""

from __future__ import annotations

import numpy as np
from scipy.integrate import DOP853

from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics


class ExplicitStepper:
    """Steps of DOP853 with dense output.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    rtol : float
        Relative to each component of the state.
    atol : float
        Absolute, in the units of each component.
    outputs : ndarray
        Times wanted; the dense output serves them.
    """

    name = "dop853"

    def __init__(
        self, dynamics: Dynamics, start: float, stop: float, rtol: float, atol: float, outputs: np.ndarray
    ) -> None:
        self._solver = DOP853(dynamics.rate, start, dynamics.initial_state(), stop, rtol=max(rtol, 3e-14), atol=atol)
        self.rejected = 0

    @property
    def t(self) -> float:
        """Time reached in s."""
        return float(self._solver.t)

    def step(self) -> None:
        """Take one accepted step.

        Raises
        ------
        SimulationError
            If no step is small enough.
        """
        before = self._solver.nfev
        message = self._solver.step()
        # a try costs as many evaluations as the method has stages; scipy does not count the failed ones itself
        self.rejected += (self._solver.nfev - before) // self._solver.n_stages - 1
        if self._solver.status == "failed":
            raise SimulationError(
                f"the explicit method could not go on at t = {self.t:.6g} s: {message} "
                "Remedy: check loads for jumps, loosen rtol, or use method='generalised-alpha'"
            )

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        dense = self._solver.dense_output()
        return np.array([dense(t) for t in times]).reshape(len(times), -1)

    def initial_state(self) -> Vector:
        """Return the state at the start."""
        return np.array(self._solver.y)
