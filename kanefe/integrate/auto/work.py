"""What the steps of a method have cost, in products: counted, so that a choice is the same in every run."""

from __future__ import annotations

from collections.abc import Mapping

from kanefe.equations.model import Model
from kanefe.equations.routes import newton_work
from kanefe.integrate.auto.cost import (
    PRODUCTS_A_CALL,
    compiled_evaluation,
    evaluation,
    factors_of_radau,
    moving_states,
)

PRODUCTS_A_JACOBIAN_STEP = 10_000.0
"""Products in a step of a method with Jacobians beside its evaluations and factors, for its solutions: measured with 15
to 30 speeds, for which it is nearly the same."""

PRODUCTS_A_PYTHON_STEP = 400_000.0
"""Products in the time that a step takes which is looked at in Python for events: 150 us, measured."""

DIRECTIONS_OF_TREE = 20
"""Evaluations with complex numbers in a linearisation of a tree of rigid bodies."""

OF_COMPLEX = 2.0
"""Evaluations with real numbers in one with complex numbers, and in a central difference."""


class WorkCounter:
    """Counts the work of the methods of a scene.

    Parameters
    ----------
    model : Model
    by_single_steps : bool
        Whether events are looked for in Python after each step.
    calls : int
        Calls of functions in Python for a Jacobian.
    """

    def __init__(self, model: Model, by_single_steps: bool, calls: int = 0) -> None:
        size = model.free_count + moving_states(model)
        self._evaluation = evaluation(model)
        directions = model.free_count + size
        if 3.0 * newton_work(model.route) < size**3:
            directions = min(directions, DIRECTIONS_OF_TREE)
        self._jacobian = OF_COMPLEX * directions * compiled_evaluation(model) + calls * PRODUCTS_A_CALL
        self._factors = 0.5 * factors_of_radau(model)  # compiled code reuses what it has read
        self._step = PRODUCTS_A_PYTHON_STEP if by_single_steps else 0.0

    def steps_of(self, work: float, least: int) -> int:
        """Return how many steps of about a dozen evaluations have some work, and no less than the least."""
        return max(least, int(work / (12.0 * self._evaluation + self._step)))

    def work(self, counts: Mapping[str, int | float]) -> float:
        """Return the work of what a stepper has counted."""
        tried = counts["steps"] + counts["rejected"]
        found = counts["evaluations"] * self._evaluation + counts["steps"] * self._step
        if "jacobians" in counts:
            found += counts["jacobians"] * self._jacobian + counts["factorisations"] * self._factors
            found += tried * PRODUCTS_A_JACOBIAN_STEP
        return found
