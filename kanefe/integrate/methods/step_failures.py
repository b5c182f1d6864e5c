"""What is told of a compiled method that finds no next step."""

from __future__ import annotations

import numpy as np

from kanefe.integrate.run_checks.stiff_contacts import with_contact
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.steppers.step_commands import HELD, NO_CONVERGENCE, NO_NUMBERS, REASON, SMALLEST, STEP, WORST
from kanefe.tree.model_data import ModelData


def step_failure(model: ModelData, name: str, integers: np.ndarray, reals: np.ndarray) -> StepFailure:
    """Return the failure of a method from its memory."""
    worst = int(integers[WORST])
    if integers[REASON] == HELD:
        return StepFailure(
            "the mechanism is at a singular position and does not pass it",
            "check that driven joints stay within its reach",
        )
    if integers[REASON] == NO_NUMBERS:
        return StepFailure("the motion has grown without bound", "check the loads, or take smaller steps", worst)
    if integers[REASON] == NO_CONVERGENCE:
        step = float(reals[STEP])
        reason = f"the Newton iteration of {name} does not converge with steps of {step:.3g} s"
        reason, remedy = with_contact(model, step, reason, "a smaller step")
        return StepFailure(reason, f"{remedy}, or rtol instead", worst)
    return StepFailure(
        f"{name} found no step of {reals[SMALLEST]:.1g} s or more that keeps the error in tolerance",
        "check loads for jumps or growth without bound there, or loosen rtol",
        worst,
    )
