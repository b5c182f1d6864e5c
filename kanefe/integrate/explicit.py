"""Explicit Runge-Kutta of order 8 (Dormand & Prince, scipy's DOP853): for scenes without stiff modes."""

from __future__ import annotations

import numpy as np
from scipy.integrate import DOP853, DenseOutput

from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics

SINGULAR = 1e-3
"""Share of the usual `Dynamics.weakest` below which a step that falls to a tenth creeps up to a singular position."""

SMALLEST_CREEP = 1e-5
"""Share of the usual step below which a mechanism is held for good: at a dead centre its speeds grow without bound."""

LARGEST_RTOL = 1e-6
"""To which the tolerance may grow there: the error of one step."""


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
        self._dynamics, self._outputs = dynamics, outputs
        y = dynamics.initial_state(start)
        self._tolerances, self._looser = (max(rtol, 3e-14), atol), 1.0
        self._solver = DOP853(dynamics.rate, start, y, stop, rtol=self._tolerances[0], atol=atol)
        self._dense: DenseOutput | None = None
        self._usual_step, self._usual_weakest = 0.0, 0.0
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
            self._refuse_dead_centre(0.0)
            raise SimulationError(
                f"the explicit method could not go on at t = {self.t:.6g} s: {message} "
                "Remedy: check loads for jumps, loosen rtol, or use method='generalised-alpha'"
            )
        self._dense = None
        if self._dynamics.model.constraints:
            self._close_loops()

    def _close_loops(self) -> None:
        """Take the drift out of the state, so that it stays at tolerance for any length of run."""
        solver = self._solver
        if np.any((self._outputs > solver.t_old) & (self._outputs <= solver.t)):
            self._dense = solver.dense_output()  # of the step as it was taken: it leans on the state at both ends
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
            self._looser = min(10.0 * self._looser, LARGEST_RTOL / self._tolerances[0])
        else:
            self._looser = 1.0
        self._solver.rtol, self._solver.atol = (max(self._looser, 1.0) * size for size in self._tolerances)

    @property
    def _is_near_singular(self) -> bool:
        return self._dynamics.weakest < SINGULAR * self._usual_weakest

    def _refuse_dead_centre(self, step: float) -> None:
        if self._is_near_singular and step <= SMALLEST_CREEP * self._usual_step:
            raise SimulationError(
                f"the mechanism is at a singular position at t = {self.t:.6g} s and does not pass it. "
                "Remedy: check that driven joints stay within its reach"
            )

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        dense = self._solver.dense_output() if self._dense is None else self._dense
        return np.array([self._dynamics.projected(t, dense(t)) for t in times]).reshape(len(times), -1)

    def initial_state(self) -> Vector:
        """Return the state at the start."""
        return np.array(self._solver.y)
