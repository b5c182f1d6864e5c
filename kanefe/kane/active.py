"""Generalised active forces: loads, stiffness and damping (Eq. 11, 28, 30, 35, 36)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kanefe.frames import Vector
from kanefe.states.kinematics import FrameMotion, elastic_partial_rates, elastic_state, interface_motion
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms

if TYPE_CHECKING:
    from kanefe.loads.point_load import PointLoad
    from kanefe.states.state import State


def elastic_forces(terms: FlexibleTerms, eta: Vector, deta: Vector) -> Vector:
    """Return ``-K (q_n - q_n0) - C dq_n`` on the coordinates of the body (Eq. 19, 27, 28, 36).

    C acts on the rate of deformation in G, where Eq. 27 and 36 apply it to the absolute nodal velocity, which brakes
    rigid motion. The fixed components, where eta is extended by them, stay at zero.
    """
    body = terms.body
    free, rows = body.free_count, len(eta)
    force = -(body.stiffness[:rows, :free] @ eta[:free])
    if terms.damping is not None:
        force -= terms.damping[:rows] @ deta[:free]
    return force


def loaded_frames(state: State, body: BodyTerms, motion: FrameMotion) -> list[tuple[PointLoad, FrameMotion]]:
    """Return each point load of a body with the motion of the frame it acts on: R, G or an interface n (Eq. 30)."""
    frames: list[tuple[PointLoad, FrameMotion]] = []
    for load, interface in body.loads:
        if interface is None or body.flexible is None:
            frames.append((load, motion))
        else:
            n = interface_motion(motion, interface, body.flexible, state.q, state.full, state.model.slopes)
            frames.append((load, n))
    return frames


def add_field_loads(state: State, body: BodyTerms, motion: FrameMotion, F: Vector) -> None:
    """Add the generalised forces of tractions, pressures and line loads on a flexible body to F."""
    terms = body.flexible
    if terms is None or not body.field_loads:
        return
    eta, _ = elastic_state(terms, state.q, state.full, len(F) > terms.fixed.start)
    rates = elastic_partial_rates(terms, len(F))
    for load in body.field_loads:
        force, moment, elastic = load.forces(state.t, motion.A_NF, eta, state)
        F += motion.V.T @ force + motion.W.T @ moment + rates.T @ elastic


def add_loads(state: State, body: BodyTerms, motion: FrameMotion, F: Vector) -> None:
    """Add ``V^T R + W^T T`` of the body's known forces to F (Eq. 11, 19, 30, 35)."""
    for load, frame in loaded_frames(state, body, motion):
        force, moment = load.wrench(state.t, frame, state)
        F += frame.V.T @ force + frame.W.T @ moment
    add_field_loads(state, body, motion, F)
    for joint_load in body.joint_loads:
        F[body.speeds[joint_load.coordinate]] += joint_load.value(state.t, state)
    if body.has_coordinate_forces:
        at = body.joint_coordinates(state.t, state.q)
        for i, (speed, coordinate_force) in enumerate(zip(body.speeds, body.joint.coordinate_forces, strict=True)):
            if coordinate_force is not None:
                F[speed] += coordinate_force.force(float(at[i]), float(state.full[speed]))
