"""The state of a scene as functions of the user see it, at any time of a run."""

from __future__ import annotations

from kanefe.frames import Vector
from kanefe.kane.assemble import all_speeds
from kanefe.kane.kinematics import sweep_outward
from kanefe.loads.state import SceneState
from kanefe.model import Model


def scene_state(model: Model, t: float, y: Vector) -> SceneState:
    """Return what a function ``f(t, state)`` is given at time t (s) and a state that begins with q and u."""
    n, m = model.coordinate_count, model.free_count
    q, u = y[:n], y[n : n + m]
    if model.unreduced is not None:
        twin = model.unreduced.complete
        q, u, model = twin.coordinates(q), twin.speeds(u), twin.small
    full = all_speeds(model, t, u)
    if model.order_n is not None:
        return SceneState(model, t, q, full, model.order_n.frames(t, q, u))
    return SceneState(model, t, q, full, sweep_outward(model, t, q, full))
