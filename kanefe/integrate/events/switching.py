"""Constraints switched on in a run: they must be closed where they are."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.stepper import StepFailure

LARGEST_GAP = 1e-3
"""Largest gap of a constraint when it is switched on, relative to the scene's length or in rad. A larger gap would
close by a jump. An event is located to round-off, but its function may neglect small parts of the gap."""


def check_switched(model: Model, t: float, before: Vector, after: Vector) -> None:
    """Raise a StepFailure if a constraint that holds after an action at time t (s), but not before it, is open then."""
    (_, _, was), (q, _, z) = model.parts(before), model.parts(after)
    if not any(c.holds(z) and not c.holds(was) for c in model.constraints):
        return
    worst, names = model.literal.open_loops(t, q, z)
    if worst > LARGEST_GAP:
        raise StepFailure(
            f"a constraint is switched on where it is not closed: {names}",
            "an event whose function is its gap",
        )
