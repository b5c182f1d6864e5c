"""From the user's bodies to the immutable model: numbering, and the terms that the scene needs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.slopes import SlopeMeasure
from kanefe.errors import ModelError
from kanefe.scene.scene import BodyEntry
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms, is_unreduced, static_transfer
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.constraints.rows import Constraint
    from kanefe.contact.surface import Surface
    from kanefe.joints.base import Joint
    from kanefe.loads.controller import Controller

_fixed_of_bodies: WeakKeyDictionary[FlexibleBody, tuple[np.ndarray, np.ndarray]] = WeakKeyDictionary()
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
    numbers = _Numbers(free, driven)
    bodies = tuple(_body_terms(entry, numbers) for entry in entries)
    return ModelData(
        bodies=bodies,
        gravity=gravity.copy(),
        slopes=slopes,
        coordinate_count=numbers.coordinate,
        free_count=free,
        driven_count=driven,
        fixed_count=numbers.fixed - free - driven,
        initial_coordinates=np.concatenate(numbers.q),
        initial_speeds=np.concatenate(numbers.u),
        constraints=tuple(constraints),
        controllers=tuple(controllers),
        surfaces=tuple(surfaces),
    )


class _Numbers:
    """The numbers of the next coordinates and speeds, and the start of those before.

    Speeds are free ones first, then driven ones, then those of fixed components.
    """

    def __init__(self, free: int, driven: int) -> None:
        self.coordinate = self.speed = 0
        self.driven, self.fixed = free, free + driven
        self.q: list[np.ndarray] = []
        self.u: list[np.ndarray] = []

    def of_joint(self, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of a joint's coordinates, -1 of driven ones, and of its speeds."""
        q, u = joint.initial_coordinates(), joint.initial_speeds()
        coordinates, speeds = self.coordinate + np.arange(len(q)), self.speed + np.arange(len(u))
        if any(motion is not None for motion in joint.motions):
            is_driven = np.array([motion is not None for motion in joint.motions])
            coordinates = np.where(is_driven, -1, self.coordinate + np.cumsum(~is_driven) - 1)
            speeds = np.where(is_driven, self.driven + np.cumsum(is_driven), self.speed + np.cumsum(~is_driven)) - 1
            q, u = q[~is_driven], u[~is_driven]
            self.driven += int(is_driven.sum())
        self._go_on(q, u)
        return coordinates, speeds

    def of_modes(self, eta: np.ndarray, deta: np.ndarray, fixed: int) -> tuple[slice, slice, slice]:
        """Return the places of coordinates and speeds of modes that start so, and of so many fixed components."""
        places = (
            slice(self.coordinate, self.coordinate + len(eta)),
            slice(self.speed, self.speed + len(deta)),
            slice(self.fixed, self.fixed + fixed),
        )
        self.fixed += fixed
        self._go_on(eta, deta)
        return places

    def _go_on(self, q: np.ndarray, u: np.ndarray) -> None:
        self.coordinate, self.speed = self.coordinate + len(q), self.speed + len(u)
        self.q.append(q)
        self.u.append(u)


def _body_terms(entry: BodyEntry, numbers: _Numbers) -> BodyTerms:
    coordinates, speeds = numbers.of_joint(entry.joint)
    return BodyTerms(
        name=entry.name,
        parent=entry.parent,
        parent_interface=entry.parent_interface,
        p_PoFo_P=entry.at,
        A_PF=entry.axes,
        joint=entry.joint,
        coordinates=coordinates,
        speeds=speeds,
        rigid=entry.rigid,
        flexible=None if entry.flexible is None else _flexible_terms(entry.flexible, entry, numbers),
        loads=tuple(entry.loads),
        joint_loads=tuple(entry.joint_loads),
        field_loads=tuple(entry.field_loads),
        has_gravity=entry.has_gravity,
    )


def _flexible_terms(body: FlexibleBody, entry: BodyEntry, numbers: _Numbers) -> FlexibleTerms:
    k = body.free_count
    centred = body.centred if is_unreduced(body) else np.asarray
    given = [None if start is None else centred(start) for start in (entry.eta, entry.deta)]
    eta, deta = (np.zeros(k) if start is None else start for start in given)
    coordinates, speeds, fixed = numbers.of_modes(eta, deta, body.fixed_count)
    rigid, elastic = _fixed_motions(body)
    return FlexibleTerms(
        body=body,
        free_moments=body.moments.leading(k),
        all_moments=body.moments,
        damping=_transferred_damping(body),
        eta=coordinates,
        speeds=speeds,
        fixed=fixed,
        fixed_rigid=rigid,
        fixed_elastic=elastic,
        given_eta=given[0],
        given_deta=given[1],
    )


def _transferred_damping(body: FlexibleBody) -> np.ndarray | None:
    """Return C over all rows of the body, (K, k), or None if undamped."""
    if is_unreduced(body):
        return body.damping if body.is_damped else None
    if not np.any(body.damping):
        return None
    return np.vstack((body.damping, static_transfer(body) @ body.damping))


def _fixed_motions(body: FlexibleBody) -> tuple[np.ndarray, np.ndarray]:
    """Return the motion of G and of the coordinates for each fixed component: see `FlexibleTerms`."""
    from kanefe.fe_model.model import COMPONENTS, rigid_motion

    k, fixed = body.free_count, body.fixed_count
    if not fixed:
        return np.zeros((6, 0)), np.zeros((k, 0))
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
    _fixed_of_bodies[body] = rigid, elastic
    return rigid, elastic
