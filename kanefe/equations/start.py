"""The start of a frozen scene: loops closed, and loads between frames as they are then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kanefe.equations.model import Model
from kanefe.equations.routes import starting_route
from kanefe.loads.base import Load
from kanefe.tree.model_data import ModelData


def model_at_start(data: ModelData, loads: Sequence[Load], t: float) -> Model:
    """Return the model of a frozen scene with a consistent start at time t (s), and its loads between frames.

    Joints whose start is not given (all zeros) move first, then all joints, then elastic coordinates too, each only if
    the loops do not close without. Speeds are treated alike: those given are kept if the others can follow. Loads see
    that start: springs without a rest length are slack there.

    Raises
    ------
    ModelError
        If a loop cannot be closed, and the message names it and by how much it stays open; or a load cannot start.
    """
    model = Model.of(data.with_loads(()))
    if model.constraints:
        q, u, _ = model.parts(starting_route(model).start(t))
        if not (np.array_equal(q, model.initial_coordinates) and np.array_equal(u, model.initial_speeds)):
            model = replace(model, initial_coordinates=q, initial_speeds=u)
    if not loads:
        return model
    return model.with_loads(starting_route(model).started(t, loads))
