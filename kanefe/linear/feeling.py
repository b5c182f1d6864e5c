"""The way to a rest among contacts: they act from afar at first, then from less, so that the search feels them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.contact.rigid_contact import RigidContact
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.linear.balance import BalanceSearch
from kanefe.linear.state import at_rest
from kanefe.tree.scales import scene_length

SHORTEST = 3e-3
"""Of the steps of a search among contacts, in rad or scene lengths: they pass through nothing that is thicker."""

SOFTNESS = 3e-2, 3e-3, 3e-4, 3e-5, 3e-6
"""Of the length of a scene: over what distances contacts act from afar, one after the other, in a search for a rest."""


def is_put_down(model: Model) -> bool:
    """Return whether loads are as they were added, and not as a run left them; of rigid contacts nothing is asked."""
    states = zip(model.loads, model.load_states, strict=True)
    return all(
        isinstance(load, RigidContact) or np.array_equal(model.initial_states[where], load.initial_states)
        for load, where in states
    )


def felt(
    model: Model,
    t: float,
    q: Vector,
    u: Vector,
    found: np.ndarray,
    held: tuple[str, ...],
    yielding: Callable[[float], Model] | None = None,
) -> Vector:
    """Return coordinates near the balance of a scene with contacts, which act from afar at first, then from less.

    Steps are no longer than that, so that they pass through nothing. What sticks is put down anew, without tension,
    each time: in the end friction holds what it has to and no more. `yielding` gives the model in the place of one with
    rigid contacts, by how far (m) these yield.
    """
    length = scene_length(model)
    for softness in SOFTNESS:
        yields = model if yielding is None else yielding(softness * length)
        soft = at_rest(yields, t, np.concatenate((q, u, yields.initial_states)), softness * length)
        try:
            q, _ = BalanceSearch(soft, t, q, u, found, held, max(softness, SHORTEST)).run()
        except SimulationError:
            continue  # the next ones may do without
    return q
