"""What a scene of the benchmark is: a model, a span of time, what is measured, and which run makes its reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.trajectory import Trajectory


@dataclass(frozen=True)
class Setting:
    """How a run is made: a method, and either a tolerance or a fixed step.

    Parameters
    ----------
    method : str
        Name of a method, or "auto".
    rtol : float, optional
        Relative error of a step.
    step : float, optional
        s.
    """

    method: str
    rtol: float | None = None
    step: float | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The options of a run."""
        given = {"rtol": self.rtol} if self.step is None else {"step": self.step}
        return {"method": self.method, **given}

    @property
    def finer(self) -> Setting:
        """The same with a tenth of the tolerance, or half the step."""
        if self.rtol is not None and self.step is None:
            return replace(self, rtol=0.1 * self.rtol)
        return replace(self, step=None if self.step is None else 0.5 * self.step)

    @property
    def size(self) -> str:
        """Tolerance or step as a short text."""
        return f"rtol {self.rtol:.2g}" if self.step is None else f"h {self.step:.3g} s"

    @property
    def text(self) -> str:
        """Method and tolerance or step."""
        return f"{self.method}, {self.size}"


Measure = Callable[[Model, float, np.ndarray], np.ndarray]
"""Function of model, time (s) and coordinates that returns the compared quantity, in the unit of the scene."""


@dataclass(frozen=True, eq=False)
class BenchScene:
    """A scene of the benchmark.

    Parameters
    ----------
    name : str
        As on the command line.
    title : str
        For tables and pictures.
    build : callable
        () -> Model, frozen.
    measure : callable
        See `Measure`.
    quantity, unit : str
        What is measured, and in which unit.
    end : float
        The scene runs from 0 to this time, s.
    reference : Setting
        The coarsest run of the reference, which is refined until it changes no more.
    agreement : float
        Largest change by the last refinement, in the unit of the scene.
    outputs : int
        At the ends of so many equal parts of the span the quantity is measured; the error is the largest one.
    largest_step : float
        Where fixed steps begin, s.
    parameters : dict
        Numbers that the scene is made from: the reference is kept under them.
    needs : str
        A package without which the scene cannot be made.
    """

    name: str
    title: str
    build: Callable[[], Model]
    measure: Measure
    quantity: str
    end: float
    reference: Setting
    agreement: float
    unit: str = "m"
    outputs: int = 1
    largest_step: float = 0.05
    parameters: Mapping[str, Any] = field(default_factory=dict)
    needs: str = ""

    @property
    def times(self) -> np.ndarray:
        """Times at which the quantity is measured, s."""
        return np.linspace(0.0, self.end, self.outputs + 1)[1:]

    def measured(self, model: Model, run: Trajectory) -> np.ndarray:
        """Return the quantity at the output times of a run, (outputs, components)."""
        states = zip(run.times[1:], run.coordinates[1:], strict=True)
        return np.array([self.measure(model, float(t), q) for t, q in states])

    def error(self, found: np.ndarray, exact: np.ndarray) -> float:
        """Return the largest distance of a measured quantity from another."""
        return float(np.linalg.norm(found - exact, axis=1).max())
