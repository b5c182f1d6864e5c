"""The loads of a scene that are raised together by one factor, and the scene under them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.loads.functions import Constant
from kanefe.tree.load_names import named_loads

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

GRAVITY = "gravity"


def chosen_loads(
    model: Model, t: float, loads: str | Sequence[str] | None, what: str
) -> tuple[dict[str, SceneLoad | None], tuple[str, ...]]:
    """Return the loads that are raised by name (None: gravity), and the names of those that are kept."""
    there: dict[str, SceneLoad | None] = {**named_loads(model)}
    if model.gravity.any() and any(body.has_gravity for body in model.bodies):
        there[GRAVITY] = None
    laws = [name for name, load in there.items() if load is not None and load.takes_state and not load.is_constant]
    if loads is None:
        names = [name for name in there if name not in laws]
    else:
        given = (loads,) if isinstance(loads, str) else tuple(loads)
        names = [str(name).strip().removeprefix("load ") for name in given]
    for name in names:
        if name not in there:
            raise ModelError(f"{what}: the scene has no load {name!r}. It has: {', '.join(there) or 'none'}")
        if name in laws:
            raise ModelError(
                f"{what}: {name} is a function of the state, and part of the stiffness. Remedy: leave it out of loads="
            )
    raised = {name: there[name] for name in names if _size(model, t, there[name]) > 0.0}
    if not raised:
        raise ModelError(
            f"{what}: no load is raised. Remedy: add_force, add_traction or gravity, with values that are not zero at "
            f"t = {t:g} s"
        )
    return raised, tuple(name for name in there if name not in raised)


def _size(model: Model, t: float, load: SceneLoad | None) -> float:
    return float(np.abs(model.gravity if load is None else load.value(t)).max())


def scaled_model(model: Model, t: float, raised: dict[str, SceneLoad | None], factor: float) -> Model:
    """Return the model with the raised loads at time t (s) times a factor, and constant."""
    changed: dict[int, Any] = {
        id(load): replace(load, function=Constant(factor * load.value(t)))
        for load in raised.values()
        if load is not None
    }
    bodies = tuple(
        replace(
            body,
            loads=tuple((changed.get(id(load), load), frame) for load, frame in body.loads),
            joint_loads=tuple(changed.get(id(load), load) for load in body.joint_loads),
            field_loads=tuple(changed.get(id(load), load) for load in body.field_loads),
        )
        for body in model.bodies
    )
    gravity = factor * model.gravity if GRAVITY in raised else model.gravity
    return replace(model, bodies=bodies, gravity=gravity)
