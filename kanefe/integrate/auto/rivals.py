"""The methods that a run tries beside the one that was foreseen: all that are right for the scene."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.integrate.methods.table import serving

FEWER_STAGES = "dopri5"
"""The explicit method with fewer stages: less work where steps are short for other reasons than errors. Where a method
that is not explicit is foreseen, those are rates that are stiff for both."""

EXPLICIT = "dop853", FEWER_STAGES
"""The explicit methods, which have the same compiled code."""


def rivals_of(model: Model, names: tuple[str, ...], taken: str) -> tuple[str, ...]:
    """Return the methods that are tried beside the one taken, of those that a run has compiled.

    Generalised-alpha is none: its error is not bounded by its tolerance.
    """
    unfit = {taken, "generalised-alpha"}
    if taken not in EXPLICIT:
        unfit.add(FEWER_STAGES)
    if not steps_over_safely(model):
        unfit.add("extrapolation")
    return tuple(serving(model, *(name for name in names if name not in unfit)))


def steps_over_safely(model: Model) -> bool:
    """Return whether the extrapolation may be tried: what begins at once in contacts and stops it may miss."""
    rigid = model.rigid_contacts
    return not model.has_stops and not any(
        load.acts_at_once for number, load in enumerate(model.loads) if number not in rigid
    )
