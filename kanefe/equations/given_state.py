"""A state given by the user: a vector, or the state of a scene at one time; checked, and transferred by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeGuard

import numpy as np

from kanefe.bodies.transfer import transferred
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData


class AtOneTime(Protocol):
    """The state of a scene at one time: a `SceneState`, an `Equilibrium`, or ``result.at(t)``."""

    model: ModelData
    time: float
    q: Vector
    u: Vector
    z: Vector


def is_at_one_time(start: object) -> TypeGuard[AtOneTime]:
    """Return whether a state keeps that protocol: by its attributes, which takes less time than `isinstance`."""
    return all(hasattr(start, name) for name in AtOneTime.__annotations__)


Start = object
"""A state: an `AtOneTime`, or a vector (q, u) or (q, u, z) in the order of `Model.state_names`."""


def time_of(start: object, default: float = 0.0) -> float:
    """Return the time of a state, s; for a vector the default."""
    return float(start.time) if is_at_one_time(start) else default


def slack_time(start: object, t: float) -> float:
    """Return the time at whose start springs without a rest length are slack: that of the scene of a given state."""
    return start.model.slack_time if is_at_one_time(start) else t


def knows_states(model: Model, start: object) -> bool:
    """Return whether a state contains all internal states of a model, so that none is taken from the model's start."""
    if is_at_one_time(start):
        return set(model.internal_names()) <= set(start.model.internal_names())
    return numbers(start).shape == model.initial_state.shape


def given_state(model: Model, t: object, start: object, what: str) -> tuple[float, Vector]:
    """Return time (s) and state y = (q, u, z) of a model from a given state; None: its own start.

    A state of another scene is used body by body, by name, for joints with the same coordinates, driven or not;
    deformations of bodies with other modes or a finer mesh are transferred. Bodies that are not in it have the start of
    the model.

    Raises
    ------
    ModelError
        If time or state are not finite or of another shape, if a body has other coordinates, or a loop is open.
    """
    time = numbers(t)
    if time.shape != () or not np.isfinite(time):
        raise ModelError(f"t of {what} must be a finite time in s, not {t!r}")
    y = _vector(model, start, what)
    if not np.all(np.isfinite(y)):
        worst = int(np.flatnonzero(~np.isfinite(y))[0])
        raise ModelError(f"start of {what} is not finite: {model.state_names[worst]} is {y[worst]}")
    q, u, z = model.parts(y)
    rotations = [(body.coordinates, body.joint.rotation_at) for body in model.bodies]
    if not all(np.any(q[at[first : first + 4]]) for at, first in rotations if first is not None):
        raise ModelError(f"the state of {what} has Euler parameters of no length. Remedy: (1, 0, 0, 0)")
    q = model.advance(q, np.zeros(model.free_count))  # of unit length
    _check_closed(model, float(time), q, u, z, what)
    return float(time), np.concatenate((q, u, z))


def _vector(model: Model, start: object, what: str) -> Vector:
    if start is None:
        return model.initial_state
    if is_at_one_time(start):
        return _by_name(model, start, what)
    y = numbers(start).astype(float)
    if not y.shape:
        raise ModelError(
            f"start of {what} must be a state at one time, not a {type(start).__name__}. Remedy: result.at(t), "
            "an Equilibrium, or a vector as model.initial_state"
        )
    if y.shape == (model.coordinate_count + model.free_count,):
        return np.concatenate((y, model.initial_states))
    if y.shape != model.initial_state.shape:
        names = model.state_names
        raise ModelError(
            f"start of {what} has shape {y.shape}, and this model has {len(names)} entries: "
            f"{', '.join(names[:4])}{' ...' if len(names) > 4 else ''}. Remedy: model.initial_state, an Equilibrium, "
            "or result.at(t)"
        )
    return y


def _by_name(model: Model, start: AtOneTime, what: str) -> Vector:
    old = start.model
    if old.bodies is model.bodies:  # of the same scene
        return np.concatenate((start.q, start.u, start.z))
    y = model.initial_state.copy()
    q, u, z = model.parts(y)
    full = old.all_speeds(start.time, start.u)
    known = {body.name: body for body in old.bodies}
    if not any(body.name in known for body in model.bodies):
        raise ModelError(
            f"start of {what}: the state has the bodies {', '.join(known)}, and none of them is in this scene. "
            "Remedy: a state of a scene with bodies of the same names"
        )
    for body in model.bodies:
        before = known.get(body.name)
        if before is None:
            continue
        _check_alike(body, before, what)
        is_free = body.coordinates >= 0
        q[body.coordinates[is_free]] = before.joint_coordinates(start.time, start.q)[is_free]
        moves = body.speeds < model.free_count
        u[body.speeds[moves]] = full[before.speeds[moves]]
        if body.flexible is not None and before.flexible is not None:
            modal = start.q[before.flexible.eta], full[before.flexible.speeds]
            q[body.flexible.eta], u[body.flexible.speeds] = _of_modes(body, before, modal)
    inner = dict(zip(old.internal_names(), start.z.tolist(), strict=True))
    z[:] = [inner.get(name, value) for name, value in zip(model.internal_names(), z.tolist(), strict=True)]
    return y


def _check_alike(body: BodyTerms, before: BodyTerms, what: str) -> None:
    """Raise a ModelError if a body has other coordinates than the body of the same name in another scene."""
    if body.joint.coordinate_names != before.joint.coordinate_names:
        raise ModelError(
            f"start of {what}: {body.name!r} is on a {body.joint.kind} joint, on a {before.joint.kind} joint in the "
            "scene of the state. Remedy: joints with the same coordinates, or a vector"
        )
    ours, theirs = (None if part.flexible is None else part.flexible.body for part in (body, before))
    if ours is theirs:
        return
    if ours is None or theirs is None:
        raise ModelError(
            f"start of {what}: {body.name!r} is flexible here or in the scene of the state, and rigid in the other. "
            "Remedy: the same body, or a vector"
        )


def _of_modes(body: BodyTerms, before: BodyTerms, modal: tuple[Vector, Vector]) -> Sequence[Vector]:
    """Return coordinates and rates of a body that move it as these moved that of the same name."""
    ours, theirs = (part.flexible.body for part in (body, before) if part.flexible is not None)
    if ours is theirs or _same_modes(ours.basis, theirs.basis):
        return modal
    return [found for one in modal if (found := transferred(theirs, ours, one, body.name)) is not None]


def _same_modes(ours: Any, theirs: Any) -> bool:
    if type(ours) is not type(theirs) or ours.shape != theirs.shape:
        return False
    return not isinstance(ours, np.ndarray) or np.array_equal(ours, theirs)


def _check_closed(model: Model, t: float, q: Vector, u: Vector, z: Vector, what: str) -> None:
    if not model.constraints or model.has_unreduced:  # with unreduced bodies the run closes loops, or names open ones
        return
    from kanefe.states.constraints import constraint_rates, constraint_residuals, held_rows
    from kanefe.states.state import State

    state = State(model, t, q, u, z)
    full = state.full
    opened, rates = constraint_residuals(state), constraint_rates(state)
    slipping = rates.J @ full[: rates.J.shape[1]]
    sizes = np.abs(rates.J) @ np.abs(full[: rates.J.shape[1]])
    labels = [f"{constraint.title} ({row.label})" for constraint, row in held_rows(state)]
    # the projection of a run leaves 1e-12, its dense output between steps up to the tolerance of the run
    bad = (np.abs(opened) > 1e3 * CLOSING.largest_opening) | (np.abs(slipping) > 1e-4 * np.maximum(sizes, 1e-3))
    if bad.any():
        worst = int(np.flatnonzero(bad)[0])
        raise ModelError(
            f"the state of {what} leaves {labels[worst]} open: by {opened[worst]:.3g} m or rad, at a rate of "
            f"{slipping[worst]:.3g}. Remedy: model.initial_state, a state of a run, or kanefe.equilibrium"
        )
