"""What is told of a compiled method that finds no next step."""

from __future__ import annotations

from kanefe.integrate.run_checks.stiff_contacts import with_contact
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.steppers.step_commands import Reason, Step
from kanefe.tree.model_data import ModelData


def step_failure(model: ModelData, name: str, step: Step) -> StepFailure:
    """Return the failure of a method from its memory."""
    if step.reason == Reason.HELD:
        return StepFailure(
            "the mechanism is at a singular position and does not pass it",
            "check that driven joints stay within its reach",
        )
    if step.reason == Reason.NO_NUMBERS:
        return StepFailure("the motion has grown without bound", "check the loads, or take smaller steps", step.worst)
    if step.reason == Reason.NO_CONVERGENCE:
        reason = f"the Newton iteration of {name} does not converge with steps of {step.h:.3g} s"
        reason, remedy = with_contact(model, float(step.h), reason, "a smaller step")
        return StepFailure(reason, f"{remedy}, or rtol instead", step.worst)
    return StepFailure(
        f"{name} found no step of {step.smallest:.1g} s or more that keeps the error in tolerance",
        "check loads for jumps or growth without bound there, or loosen rtol",
        step.worst,
    )
