"""Loads of joints for friction, from the joints' reactions."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.assemble import accelerations
from kanefe.kane.reactions import joint_reactions
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData

MOST_ROUNDS = 60

SETTLED = 1e-13
"""Change of a load, relative to the largest, below which it equals that of the reaction."""


def add_load_rates(state: State, rates: Vector) -> None:
    """Write the rates of the loads that follow reactions to those of all internal states."""
    model = state.model
    if not model.bearings:
        return
    reactions = joint_reactions(state, accelerations(state))
    for number, body in model.bearings.items():
        load, where = model.following(number), model.load_states[number]
        own = state.load_ends(number), state.load_states(number)
        rates[where.start + load.load_state : where.stop] = load.load_rates(reactions[body], *own)


def with_consistent_loads(model: ModelData, t: float, q: Vector, u: Vector, z: Vector) -> Vector:
    """Return internal states whose loads of joints are those of the reactions under the friction that they make.

    Where a joint jams there may be none: what the last round found is the start then, and a run follows from it.
    """
    if not model.bearings:
        return z
    for _ in range(MOST_ROUNDS):
        state, after = State(model, t, q, u, z), z.copy()
        reactions = joint_reactions(state, accelerations(state))
        for number, body in model.bearings.items():
            load, where = model.following(number), model.load_states[number]
            own = state.load_ends(number), state.load_states(number)
            after[where.start + load.load_state : where.stop] = load.load(reactions[body], *own), 0.0
        change, z = float(np.abs(after - z).max()), after
        if not change > SETTLED * float(np.abs(after).max()):
            break
    return z
