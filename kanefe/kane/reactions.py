"""Forces that do no work, from the balance of each body: joint reactions and forces on carrying interfaces.

An inward sweep over Newton-Euler's equations, independent of the projected ones: the oracle of the coupling forces.
"""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.bodies.marker import Marker
from kanefe.frames import Vector, cross
from kanefe.kane.active import loaded_frames
from kanefe.kane.assemble import all_speeds, constrained_accelerations
from kanefe.kane.constraints import marker_wrenches
from kanefe.kane.interactions import interaction_wrenches
from kanefe.kane.kinematics import FrameMotion, interface_motion, sweep_outward
from kanefe.tree.model_data import BodyTerms, ModelData
from kanefe.tree.scene_state import SceneState


def joint_reactions(model: ModelData, t: float, q: Vector, u: Vector, du: Vector) -> list[Vector]:
    """Return for each body the wrench that its joint exerts on it, (6,): force and moment about its frame's origin.

    In components of the body's frame (R or G); the part of motors and drives included.

    Parameters
    ----------
    du : ndarray, shape (free,)
        Accelerations of the free speeds at this state.
    """
    full, motions, rates = _state(model, t, q, u, du)
    return _sweep_inward(model, t, q, full, motions, rates, _loop_wrenches(model, t, q, u, motions))


def loop_forces(model: ModelData, t: float, q: Vector, u: Vector) -> dict[str, Vector]:
    """Return what each loop joint, distance and rolling contact exerts on its end b, (6,), by name.

    Force (N) and moment (N m) about the origin of b's marker, in its axes. Couplers of joint coordinates have no ends.
    """
    motions = sweep_outward(model, t, q, all_speeds(model, t, u))
    at = {id(marker): wrench for marker, _, wrench in _loop_wrenches(model, t, q, u, motions)}
    return {c.name: at[id(c.b)] for c in model.constraints if c.b is not None}


LoopWrench = tuple[Marker, FrameMotion, Vector]


def _loop_wrenches(model: ModelData, t: float, q: Vector, u: Vector, motions: list[FrameMotion]) -> list[LoopWrench]:
    """Return what loop joints and rolling contacts exert on their markers."""
    if not model.constraints:
        return []
    _, multipliers = constrained_accelerations(model, t, q, u)
    return marker_wrenches(model, motions, q, all_speeds(model, t, u), multipliers)


def _sweep_inward(
    model: ModelData,
    t: float,
    q: Vector,
    full: Vector,
    motions: list[FrameMotion],
    rates: Vector,
    loops: list[LoopWrench],
) -> list[Vector]:
    """Return the wrench on each body from its joint: its own demand and, moved inward, those of its children."""
    state = SceneState(model, t, q, full, motions)
    pairs = zip(model.bodies, motions, strict=True)
    wrenches = [body_demand(model, body, frame, t, q, full, rates, state) for body, frame in pairs]
    for marker, at, wrench in (*loops, *interaction_wrenches(model, motions, t, q, full, len(rates))):
        if marker.body >= 0:
            wrenches[marker.body] -= moved_wrench(wrench, at, motions[marker.body])
    for number in reversed(range(len(model.bodies))):
        body = model.bodies[number]
        if body.parent >= 0:
            wrenches[body.parent] += moved_wrench(wrenches[number], motions[number], motions[body.parent])
    return wrenches


def carried_wrench(
    model: ModelData, number: int, interface: InterfaceFrame, t: float, q: Vector, u: Vector, du: Vector
) -> Vector:
    """Return the wrench (6,) on a flexible body from what its interface carries, about the interface, in axes of G."""
    full, motions, rates = _state(model, t, q, u, du)
    loops = _loop_wrenches(model, t, q, u, motions)
    reactions = _sweep_inward(model, t, q, full, motions, rates, loops)
    terms = model.bodies[number].flexible
    if terms is None:
        raise TypeError("an interface belongs to a flexible body")
    n = interface_motion(motions[number], interface, terms, q, full, model.slopes)
    total = np.zeros(6)
    for child, body in enumerate(model.bodies):
        if body.parent == number and body.parent_interface is not None and body.parent_interface.name == interface.name:
            total -= moved_wrench(reactions[child], motions[child], n)
    for marker, at, wrench in loops:
        if marker.body == number and marker.interface is not None and marker.interface.name == interface.name:
            total += moved_wrench(wrench, at, n)
    A_Gn = motions[number].A_NF.T @ n.A_NF
    return np.concatenate((A_Gn @ total[:3], A_Gn @ total[3:]))


def body_demand(
    model: ModelData,
    body: BodyTerms,
    frame: FrameMotion,
    t: float,
    q: Vector,
    full: Vector,
    rates: Vector,
    state: SceneState,
) -> Vector:
    """Return the wrench (6,) a body needs beyond gravity and its loads: inertia force less known forces."""
    gravity = frame.A_NF.T @ model.gravity if body.has_gravity else np.zeros(3)
    a = frame.V @ rates + frame.Z - gravity
    alpha = frame.W @ rates + frame.Y
    if body.rigid is not None:
        c, w, I_C = body.rigid.com, frame.w, body.rigid.inertia
        a_C = a + cross(alpha, c) + cross(w, cross(w, c))
        force = body.rigid.mass * a_C
        demand = np.concatenate((force, I_C @ alpha + cross(w, I_C @ w + body.rigid.rotor) + cross(c, force)))
    elif body.flexible is not None:
        terms = body.flexible
        mass, bias = terms.free_moments.terms(q[terms.eta], full[terms.speeds], frame.w)
        demand = (mass @ np.concatenate((a, alpha, rates[terms.speeds])) + bias)[:6]
        for field_load in body.field_loads:
            demand -= np.concatenate(field_load.forces(t, frame.A_NF, q[terms.eta], state)[:2])
    else:
        demand = np.zeros(6)
    for load, loaded in loaded_frames(model, body, frame, q, full):
        demand -= moved_wrench(np.concatenate(load.wrench(t, loaded, state)), loaded, frame)
    return demand


def moved_wrench(wrench: Vector, source: FrameMotion, target: FrameMotion) -> Vector:
    """Return a wrench about the origin of `source`, in its axes, about the origin and in the axes of `target`."""
    A = target.A_NF.T @ source.A_NF
    force = A @ wrench[:3]
    r = target.A_NF.T @ (source.p_NoFo_N - target.p_NoFo_N)
    return np.concatenate((force, A @ wrench[3:] + cross(r, force)))


def _state(model: ModelData, t: float, q: Vector, u: Vector, du: Vector) -> tuple[Vector, list[FrameMotion], Vector]:
    """Return all speeds, the outward sweep over free and driven ones, and the rates of those."""
    full = all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full)
    _, driven_rates = model.driven_speeds(t)
    return full, motions, np.concatenate((du, driven_rates))
