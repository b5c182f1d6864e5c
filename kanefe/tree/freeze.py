"""From the user's bodies to the immutable model: numbering, and the terms that the scene needs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.slopes import SlopeMeasure
from kanefe.errors import ModelError
from kanefe.scene.scene import BodyEntry
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms, is_unreduced
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.constraints.rows import Constraint
    from kanefe.contact.surface import Surface
    from kanefe.loads.controller import Controller

_fixed_of_bodies: WeakKeyDictionary[FlexibleBody, dict[str, np.ndarray]] = WeakKeyDictionary()
"""Results of `_fixed_motions` by body: scenes are frozen more often than bodies are made."""


def build_model(
    entries: Sequence[BodyEntry],
    gravity: np.ndarray,
    slopes: SlopeMeasure,
    constraints: Sequence[Constraint] = (),
    controllers: Sequence[Controller] = (),
    surfaces: Sequence[Surface] = (),
) -> ModelData:
    """Number coordinates and speeds, and compute the terms of each body that the scene needs.

    Raises
    ------
    ModelError
        If there are no bodies.
    """
    if not entries:
        raise ModelError("the scene has no bodies. Remedy: add_rigid_body or add_flexible_body")
    driven = sum(motion is not None for e in entries for motion in e.joint.motions)
    free = sum(len(e.joint.motions) + (e.flexible.free_count if e.flexible else 0) for e in entries) - driven
    q: list[np.ndarray] = []
    u: list[np.ndarray] = []
    coordinate = speed = 0
    driven_speed, fixed_speed = free, free + driven
    bodies = []
    for entry in entries:
        starts = entry.joint.initial_coordinates(), entry.joint.initial_speeds()
        is_driven = np.array([motion is not None for motion in entry.joint.motions], dtype=bool)
        if not is_driven.any():
            coordinates = np.arange(coordinate, coordinate + len(starts[0]))
            speeds = np.arange(speed, speed + len(starts[1]))
        else:
            coordinates = np.where(is_driven, -1, coordinate + np.cumsum(~is_driven) - 1)
            speeds = np.where(is_driven, driven_speed + np.cumsum(is_driven) - 1, speed + np.cumsum(~is_driven) - 1)
            starts = starts[0][~is_driven], starts[1][~is_driven]
        coordinate, speed = coordinate + len(starts[0]), speed + len(starts[1])
        driven_speed += int(is_driven.sum())
        q.append(starts[0])
        u.append(starts[1])
        terms = None
        if entry.flexible is not None:
            body = entry.flexible
            k = body.free_count
            centred = body.centred if is_unreduced(body) else np.asarray
            eta, deta = (None if start is None else centred(start) for start in (entry.eta, entry.deta))
            terms = FlexibleTerms(
                body=body,
                free_moments=body.moments.leading(k),
                all_moments=body.moments,
                damping=_transferred_damping(body),
                eta=slice(coordinate, coordinate + k),
                speeds=slice(speed, speed + k),
                fixed=slice(fixed_speed, fixed_speed + body.fixed_count),
                given_eta=eta,
                given_deta=deta,
                **_fixed_motions(body),
            )
            coordinate, speed, fixed_speed = terms.eta.stop, terms.speeds.stop, terms.fixed.stop
            q.append(np.zeros(k) if eta is None else eta)
            u.append(np.zeros(k) if deta is None else deta)
        bodies.append(
            BodyTerms(
                name=entry.name,
                parent=entry.parent,
                parent_interface=entry.parent_interface,
                p_PoFo_P=entry.at,
                A_PF=entry.axes,
                joint=entry.joint,
                coordinates=coordinates,
                speeds=speeds,
                rigid=entry.rigid,
                flexible=terms,
                loads=tuple(entry.loads),
                joint_loads=tuple(entry.joint_loads),
                field_loads=tuple(entry.field_loads),
                has_gravity=entry.has_gravity,
            )
        )
    return ModelData(
        bodies=tuple(bodies),
        gravity=gravity.copy(),
        slopes=slopes,
        coordinate_count=coordinate,
        free_count=free,
        driven_count=driven,
        fixed_count=fixed_speed - free - driven,
        initial_coordinates=np.concatenate(q) if q else np.zeros(0),
        initial_speeds=np.concatenate(u) if u else np.zeros(0),
        constraints=tuple(constraints),
        controllers=tuple(controllers),
        surfaces=tuple(surfaces),
    )


def _transferred_damping(body: FlexibleBody) -> np.ndarray | None:
    """Return C over all rows of the body, (K, k), or None if undamped."""
    k = body.free_count
    if is_unreduced(body):
        return body.damping if body.is_damped else None
    if not np.any(body.damping):
        return None
    transfer = np.linalg.solve(body.stiffness[:k, :k], body.stiffness[:k, k:]).T
    return np.vstack((body.damping, transfer @ body.damping))


def _fixed_motions(body: FlexibleBody) -> dict[str, np.ndarray]:
    """Return the motion of G and of the coordinates for each fixed component: see `FlexibleTerms`."""
    from kanefe.fe_model.model import COMPONENTS, rigid_motion

    k, fixed = body.free_count, body.fixed_count
    if not fixed:
        return {"fixed_rigid": np.zeros((6, 0)), "fixed_elastic": np.zeros((k, 0))}
    if body in _fixed_of_bodies:
        return _fixed_of_bodies[body]
    held = np.zeros((fixed, 6))  # fixed components of the unit rigid motions about G's origin
    for frame in body.interfaces:
        rows = rigid_motion((frame.position @ frame.axes)[None], (0.0, 0.0, 0.0), COMPONENTS)
        rows = (rows @ np.kron(np.eye(2), frame.axes.T))[list(frame.fixed_components)]
        held[[column - k for column in frame.fixed_columns]] = rows
    rigid = np.linalg.pinv(held)
    if is_unreduced(body):  # only the rows of the fixed components, without a static solve of a large body
        elastic = np.eye(fixed) - held @ rigid
    else:
        elastic = np.zeros((k + fixed, fixed))
        elastic[k:] = np.eye(fixed) - held @ rigid
        elastic[:k] = np.linalg.solve(body.stiffness[:k, :k], body.stiffness[:k, k:] @ held @ rigid)
    _fixed_of_bodies[body] = {"fixed_rigid": rigid, "fixed_elastic": elastic}
    return _fixed_of_bodies[body]
