"""Contact continuation towards a rest: contacts act at a distance, which is reduced step by step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.state import at_rest
from kanefe.linear.tangents import contact_depths
from kanefe.tree.scales import scene_length

SHORTEST = 3e-3
"""Largest steps of a search among contacts, rad or scene lengths: they cannot pass through thicker bodies."""

SOFTEST, HARDEST, HARDER = 3e-2, 3e-6, 0.3
"""Softest and hardest distance of contact continuation, relative to the length of a scene, and the factor between
successive ones: no stiffness is lost in round-off relative to others."""

FAR = 20.0
"""Largest initial distance of a contact from its opposite surface, in multiples of the continuation distance: it
still has a force there."""

ON_THE_WAY = 1e-3
"""Imbalance, relative to the forces that act, at which the next distance follows: a step is only the start of the next
search."""

ENOUGH_UNMOVED = 2
"""Number of successive distances whose search begins in balance after which the others are skipped."""

MOST_FAILURES = 3
"""Number of successive failed searches after which the others are skipped."""


def continued(
    model: Model,
    t: float,
    q: Vector,
    u: Vector,
    found: np.ndarray,
    held: tuple[str, ...],
    yielding: Callable[[float], Model] | None = None,
) -> Vector:
    """Return coordinates near the balance of a scene with contacts, by continuation in the distance at which they act.

    Steps are no longer than that distance, so that they pass through nothing. Sticking contacts are reset without
    tension each time, so that in the end friction carries no more than it has to. `yielding` returns, for a model with
    rigid contacts, one with compliant contacts of a given deflection (m).
    """
    length = scene_length(model)

    def yields(depth: float) -> Model:
        return model if yielding is None else yielding(depth)

    depths = contact_depths(yields(SOFTEST * length).literal.at(t, q, u))
    farthest = max((-max(probes) for probes in depths), default=0.0)
    softness = max(SOFTEST, farthest / FAR / length)
    failures, unmoved = 0, 0
    while softness >= HARDEST and failures < MOST_FAILURES and unmoved < ENOUGH_UNMOVED:
        soft = yields(softness * length)
        soft = at_rest(soft, t, np.concatenate((q, u, soft.initial_states)), softness * length)
        try:
            search = BalanceSearch(soft, t, q, u, found, held, max(softness, SHORTEST), enough=ON_THE_WAY)
            q, _ = search.run()
            failures, unmoved = 0, 0 if search.iterations else unmoved + 1
        except SimulationError:
            failures += 1  # the next ones may still succeed
        softness *= HARDER
    return q
