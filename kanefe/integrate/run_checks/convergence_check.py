"""Fixed steps that were too long: for their iteration, or for a contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kanefe.integrate.run_checks.stiff_contacts import STEPS_OF_PERIOD, stiffest_contact, with_contact
from kanefe.integrate.stepper import Unconverged
from kanefe.tree.model_data import ModelData

NEVER = np.zeros(0)


def of_fixed_steps(model: ModelData, statistics: Mapping[str, Any], events: Mapping[str, np.ndarray]) -> list[str]:
    """Return a sentence with a remedy for each thing for which the fixed steps of a run were too long."""
    if "step" not in statistics:
        return []
    return [text for text in (_of_iteration(model, statistics), _of_touch(model, statistics["step"], events)) if text]


def _of_touch(model: ModelData, step: float, events: Mapping[str, np.ndarray]) -> str:
    """Return what is told of steps of which a bounce, half a vibration on a contact, has less than two; else empty."""
    contact = stiffest_contact(model)
    if (
        contact is None
        or 4.0 * step <= contact.period
        or not len(touches := events.get(f"{contact.name} touch", NEVER))
    ):
        return ""
    return (
        f"steps of {step:.3g} s do not follow what touches at t = {touches[0]:.6g} s: on {contact}, "
        f"{contact.mass:.3g} kg vibrates with a period of {contact.period:.2g} s, so that its depth and its bounce are "
        f"wrong. Remedy: a step of {contact.period / STEPS_OF_PERIOD:.1g} s, a lower stiffness, or rtol instead"
    )


def _of_iteration(model: ModelData, statistics: Mapping[str, Any]) -> str:
    """Return what is told of steps whose iteration was left before it had converged; empty if there were none."""
    if "unconverged" not in statistics:
        return ""
    left, step = Unconverged(*statistics["unconverged"]), statistics["step"]
    reason = (
        f"the iteration of {statistics['method']} was left before it had converged in {left.steps:.0f} of "
        f"{statistics['steps']} steps of {step:.3g} s, from t = {left.first:.6g} s to {left.last:.6g} s, where "
        f"displacements were changing by up to {left.largest:.1g} of the size of the bodies"
    )
    reason, remedy = with_contact(model, step, reason, "a smaller step")
    return f"{reason}. Remedy: {remedy}, or rtol instead"
