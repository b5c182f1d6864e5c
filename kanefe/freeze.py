"""From what the user said of each body to the immutable model: numbering, and what the scene needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.finite_element_model import COMPONENTS, rigid_motion
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.frames import rotation_matrix
from kanefe.joints import Joint
from kanefe.loads import JointLoad, PointLoad
from kanefe.model import BodyTerms, FlexibleTerms, Model
from kanefe.rigid import RigidMass
from kanefe.slopes import SlopeMeasure


@dataclass(eq=False)
class BodyEntry:
    """What the user said of one body; `parent` is its number, -1 for the inertial frame N."""

    name: str
    parent: int
    parent_interface: InterfaceFrame | None
    at: np.ndarray
    orientation: np.ndarray
    joint: Joint
    rigid: RigidMass | None
    flexible: FlexibleBody | None
    eta: np.ndarray
    deta: np.ndarray
    loads: list[tuple[PointLoad, InterfaceFrame | None]]
    joint_loads: list[JointLoad]


def build_model(entries: Sequence[BodyEntry], gravity: np.ndarray, slopes: SlopeMeasure) -> Model:
    """Number coordinates and speeds, and decide per body which terms the scene needs.

    Raises
    ------
    ModelError
        If there are no bodies.
    """
    if not entries:
        raise ModelError("the scene has no bodies. Remedy: add_rigid_body or add_flexible_body")
    free = sum(_free_joint_speeds(e) + (e.flexible.free_count if e.flexible else 0) for e in entries)
    driven = sum(1 for e in entries if e.joint.motion is not None)
    q: list[np.ndarray] = []
    u: list[np.ndarray] = []
    coordinate = speed = 0
    driven_speed, fixed_speed = free, free + driven
    bodies = []
    for entry in entries:
        if entry.joint.motion is None:
            start = entry.joint.initial_coordinates()
            coordinates = slice(coordinate, coordinate + len(start))
            speeds = slice(speed, speed + len(entry.joint.speed_names))
            coordinate, speed = coordinates.stop, speeds.stop
            q.append(start)
            u.append(entry.joint.initial_speeds())
        else:
            coordinates = slice(coordinate, coordinate)
            speeds = slice(driven_speed, driven_speed + 1)
            driven_speed += 1
        terms = None
        if entry.flexible is not None:
            body = entry.flexible
            k = body.free_count
            terms = FlexibleTerms(
                body=body,
                free_moments=body.moments.leading(k),
                all_moments=body.moments,
                damping=_transferred_damping(body),
                eta=slice(coordinate, coordinate + k),
                speeds=slice(speed, speed + k),
                fixed=slice(fixed_speed, fixed_speed + body.fixed_count),
                **_fixed_motions(body),
            )
            coordinate, speed, fixed_speed = terms.eta.stop, terms.speeds.stop, terms.fixed.stop
            q.append(entry.eta)
            u.append(entry.deta)
        bodies.append(
            BodyTerms(
                name=entry.name,
                parent=entry.parent,
                parent_interface=entry.parent_interface,
                p_PoFo_P=entry.at,
                A_PF=rotation_matrix(entry.orientation),
                joint=entry.joint,
                coordinates=coordinates,
                speeds=speeds,
                rigid=entry.rigid,
                flexible=terms,
                loads=tuple(entry.loads),
                joint_loads=tuple(entry.joint_loads),
            )
        )
    return Model(
        bodies=tuple(bodies),
        gravity=gravity.copy(),
        slopes=slopes,
        coordinate_count=coordinate,
        free_count=free,
        driven_count=driven,
        fixed_count=fixed_speed - free - driven,
        initial_coordinates=np.concatenate(q) if q else np.zeros(0),
        initial_speeds=np.concatenate(u) if u else np.zeros(0),
    )


def _free_joint_speeds(entry: BodyEntry) -> int:
    return 0 if entry.joint.motion is not None else len(entry.joint.speed_names)


def _transferred_damping(body: FlexibleBody) -> np.ndarray | None:
    """Return C over all rows of the body, (K, k), or None if undamped: no damping code runs then."""
    k = body.free_count
    if not np.any(body.damping):
        return None
    transfer = np.linalg.solve(body.stiffness[:k, :k], body.stiffness[:k, k:]).T
    return np.vstack((body.damping, transfer @ body.damping))


def _fixed_motions(body: FlexibleBody) -> dict[str, np.ndarray]:
    """Return the motion of G and of the coordinates with each fixed component: see `FlexibleTerms`."""
    k, fixed = body.free_count, body.fixed_count
    if not fixed:
        return {"fixed_rigid": np.zeros((6, 0)), "fixed_elastic": np.zeros((k, 0))}
    held = np.zeros((fixed, 6))  # fixed components of the unit rigid motions about G's origin
    for frame in body.interfaces:
        rows = rigid_motion(frame.position[None], (0.0, 0.0, 0.0), COMPONENTS)[list(frame.fixed_components)]
        held[[column - k for column in frame.fixed_columns]] = rows
    rigid = np.linalg.pinv(held)
    elastic = np.zeros((k + fixed, fixed))
    elastic[k:] = np.eye(fixed) - held @ rigid
    elastic[:k] = np.linalg.solve(body.stiffness[:k, :k], body.stiffness[:k, k:] @ held @ rigid)
    return {"fixed_rigid": rigid, "fixed_elastic": elastic}
