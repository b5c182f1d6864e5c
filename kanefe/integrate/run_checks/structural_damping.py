"""Structural damping, which runs have not: it is defined for harmonic motions."""

from __future__ import annotations

import warnings

from kanefe.equations.model import Model
from kanefe.errors import SimulationWarning, outside


def warn_of_structural_damping(model: Model, what: str = "this run") -> None:
    """Warn of bodies with a loss factor, which a run, or `what` else is named, leaves undamped by it."""
    names = [
        repr(body.name)
        for body in model.bodies
        if body.flexible is not None and body.flexible.body.structural is not None
    ]
    if names:
        warnings.warn(
            f"the loss factor of materials of {', '.join(names)} acts in frequency responses and modes only: {what} "
            "goes without. Remedy: material.viscoelastic(band=(lowest, highest frequency in Hz)), whose Prony series "
            "has that loss factor in the band",
            SimulationWarning,
            stacklevel=outside(),
        )
