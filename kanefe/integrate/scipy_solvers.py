"""scipy's solvers as methods: BDF, Radau IIA and LSODA, with the exact Jacobian."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scipy.integrate import BDF, LSODA, DenseOutput, OdeSolver, Radau

from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.plugged import PluggedStepper

if TYPE_CHECKING:
    from kanefe.integrate.methods import StepControl

SOLVERS: dict[str, type[OdeSolver]] = {"scipy-bdf": BDF, "scipy-radau": Radau, "scipy-lsoda": LSODA}


class ScipyStepper(PluggedStepper):
    """A solver of `scipy.integrate`: see `PluggedStepper`."""

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> None:
        self._dense: DenseOutput | None = None
        super().__init__(dynamics, start, stop, control, name=name)

    def _begin(self, t: float, y: Vector, first_step: float | None) -> None:
        self._solver = SOLVERS[self.name](
            self._rate,
            t,
            y,
            self._stop,
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
