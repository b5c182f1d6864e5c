"""The door to scikit-sundae: CVODE of SUNDIALS as a method, BDF of order 1 to 5 with the exact Jacobian."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import MissingDependency
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.external import PluggedStepper, plugged_method

if TYPE_CHECKING:
    from kanefe.integrate.stepper import StepControl


class CvodeStepper(PluggedStepper):
    """CVODE: see `PluggedStepper`."""

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> None:
        try:
            from sksundae.cvode import CVODE
        except ImportError as error:
            raise MissingDependency("sksundae", f"method={name!r}", "pip install 'kanefe[sundials]'") from error
        self._class = CVODE
        super().__init__(dynamics, start, stop, control, name=name)

    def _begin(self, t: float, y: Vector, first_step: float | None) -> None:
        self._solver = self._class(
            self._write_rate,
            jacfn=self._write_jacobian,
            rtol=self._rtol,
            atol=self._atol,
            max_step=self._largest,
            first_step=first_step or 0.0,
        )
        self._solver.init_step(t, y)

    def _step(self) -> tuple[float, Vector]:
        reached = self._t
        while reached <= self._t:  # after an interpolation it first comes back to the end of its last step
            result = self._solver.step(self._bound, method="onestep", tstop=self._bound)
            if not result.success:
                raise self._no_step(str(result.message))
            reached = float(result.t)
        return reached, np.array(result.y)

    def _interpolated(self, t: float) -> Vector:
        return np.array(self._solver.step(t).y)

    def _write_rate(self, t: float, y: Vector, rates: Vector) -> None:
        rates[:] = self._rate(t, y)

    def _write_jacobian(self, t: float, y: Vector, rates: Vector, J: np.ndarray) -> None:
        J[:] = self._jacobian(t, y)


METHOD = plugged_method("sundials-cvode", "CVODE of SUNDIALS: BDF, with the exact Jacobian", CvodeStepper, 5)
