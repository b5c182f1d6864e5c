"""The methods that a run tries beside the one that was foreseen: all that are right for the scene."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.integrate.methods.table import serving

AFTER_DOP853 = "dopri5"
"""It has the compiled code of dop853, and less work where steps are short for other reasons than errors; where another
method is foreseen, those are rates that are stiff for both."""


def rivals_of(model: Model, names: tuple[str, ...], taken: str) -> tuple[str, ...]:
    """Return the methods that are tried beside the one taken, of those that a run has compiled.

    Generalised-alpha is none: its error is not bounded by its tolerance.
    """
    beside = dict.fromkeys(names)
    if taken == "dop853":
        beside[AFTER_DOP853] = None
    elif taken != AFTER_DOP853:
        beside.pop(AFTER_DOP853, None)
    unfit = {taken, "generalised-alpha"} | (set() if steps_over_safely(model) else {"extrapolation"})
    wanted = [name for name in beside if name not in unfit]
    return tuple(serving(model, *wanted))


def steps_over_safely(model: Model) -> bool:
    """Return whether the extrapolation may be tried: what begins at once in contacts and stops it may miss."""
    rigid = model.rigid_contacts
    return not model.has_stops and not any(
        load.acts_at_once for number, load in enumerate(model.loads) if number not in rigid
    )
