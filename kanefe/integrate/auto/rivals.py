"""The methods that a run tries beside the one that was foreseen: all that are right for the scene."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.integrate.methods.table import METHODS, own_methods, serving

FEWER_STAGES = "dopri5"
"""The explicit method with fewer stages: less work where steps are short for other reasons than errors. Where a method
that is not explicit is foreseen, those are rates that are stiff for both."""

EXPLICIT = "dop853", FEWER_STAGES
"""The explicit methods, which have the same compiled code."""

FORESEEN = *EXPLICIT, "extrapolation", "radau5", "generalised-alpha"
"""The methods that rules foresee, in one scene or another."""

BY_HAND = "it is taken by hand only"
"""Said of a method that no rule foresees."""


def rivals_of(model: Model, names: tuple[str, ...], taken: str) -> tuple[str, ...]:
    """Return the methods that are tried beside the one taken, of those that a run has compiled."""
    return tuple(serving(model, *(name for name in names if name != taken and not why_unfit(model, name, taken))))


def why_left_out(model: Model, others: str, taken: str, beside: tuple[str, ...]) -> dict[str, str]:
    """Return why methods with error control are neither taken nor tried, by their names.

    Parameters
    ----------
    model : Model
    others : str
        Why a run has not compiled others than those that may be right.
    taken : str
    beside : tuple of str
        Those that are tried, or take over.
    """
    why = {}
    for name in own_methods():
        row = METHODS[name]
        if name in (taken, *beside) or not row.has_error_control:
            continue
        why[name] = row.refuses(model) or why_unfit(model, name, taken) or (others if name in FORESEEN else BY_HAND)
    return why


def why_unfit(model: Model, name: str, taken: str) -> str:
    """Return why a method that serves a scene is not right beside the one taken; nothing if it is."""
    if name == "generalised-alpha":
        return "its error is not bounded by its tolerance"
    if name == FEWER_STAGES and taken not in EXPLICIT:
        return f"what is stiff is so for {EXPLICIT[0]} as well"
    return _stepped_over(model) if name == "extrapolation" else ""


def _stepped_over(model: Model) -> str:
    """Return what begins at once, so that the extrapolation may step over it."""
    if model.has_stops:
        return "it may step over stops of joints"
    rigid = model.rigid_contacts
    at_once = (load for number, load in enumerate(model.loads) if load.acts_at_once and number not in rigid)
    return next((f"it may step over what {load.kind} {load.name!r} begins at once" for load in at_once), "")
