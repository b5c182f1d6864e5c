"""Springs and bushings of a frozen scene: what they take from its start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.kane.assemble import all_speeds
from kanefe.kane.interactions import marker_ends
from kanefe.kane.kinematics import sweep_outward
from kanefe.kane.loop_closure import consistent_start
from kanefe.loads import Bushing, SpringDamper
from kanefe.tree.model_data import ModelData


def connected(model: Model, springs: Sequence[SpringDamper], bushings: Sequence[Bushing], t: float) -> Model:
    """Return the model with springs and bushings; springs without a rest length are slack at the start, time t (s).

    Raises
    ------
    ModelError
        If a spring has no length at the start.
    """
    if not springs and not bushings:
        return model
    seen: ModelData = model
    seen_springs = tuple(springs)
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


def assembled(model: Model, t: float = 0.0) -> Model:
    """Return the model with a consistent start at time t (s): the same model if its start is consistent.

    Joints whose start is not given (all zeros) move first, then all joints, then elastic coordinates too, each only if
    the loops do not close without. Speeds are treated alike: those given are kept if the others can follow.

    Raises
    ------
    ModelError
        If a loop cannot be closed; the message names it and by how much it stays open.
    """
    if not model.constraints:
        return model
    q, u = start_of(model, t)
    if q is model.initial_coordinates and u is model.initial_speeds:
        return model
    return replace(model, initial_coordinates=q, initial_speeds=u)


def start_of(model: ModelData, t: float) -> tuple[Vector, Vector]:
    """Return q and u at the start, consistent with the loops at time t (s): see `assembled`."""
    if model.has_unreduced and model.constraints:
        from kanefe.unreduced.closing import closed_start

        return closed_start(model, t)
    return consistent_start(model, t)
