"""Springs and bushings of a frozen scene: what they take from its start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kanefe.errors import ModelError
from kanefe.kane.assemble import all_speeds
from kanefe.kane.interactions import marker_ends
from kanefe.kane.kinematics import sweep_outward
from kanefe.loads import Bushing, SpringDamper
from kanefe.model import Model


def connected(model: Model, springs: Sequence[SpringDamper], bushings: Sequence[Bushing], t: float) -> Model:
    """Return the model with springs and bushings; springs without a rest length are slack at the start, time t (s).

    Raises
    ------
    ModelError
        If a spring has no length at the start.
    """
    if not springs and not bushings:
        return model
    seen, seen_springs = model, tuple(springs)
    if model.has_unreduced:
        from kanefe.unreduced.condensed import Condensed

        seen = Condensed(replace(model, springs=tuple(springs))).small
        seen_springs = seen.springs
    q, u = seen.initial_coordinates, all_speeds(seen, t, seen.initial_speeds)
    motions = sweep_outward(seen, t, q, u)
    ready = []
    for spring, own in zip(springs, seen_springs, strict=True):
        a, b = marker_ends(seen, own, motions, q, u, seen.free_count + seen.driven_count)
        length = float(np.linalg.norm(b.p_NoFo_N - a.p_NoFo_N))
        if length <= 1e-12 * max(1.0, float(abs(a.p_NoFo_N).max())):
            raise ModelError(
                f"spring {spring.name!r} has no length at the start: {spring.a.label} and {spring.b.label} are at one "
                "place, and it has no direction. Remedy: move an end, or use a bushing"
            )
        ready.append(replace(spring, rest_length=length) if np.isnan(spring.rest_length) else spring)
    return replace(model, springs=tuple(ready), bushings=tuple(bushings))
