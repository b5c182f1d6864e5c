"""Forces that do no work, from the balance of each body: joint reactions, and forces of loops and rigid contacts.

An inward sweep over Newton-Euler's equations, independent of the projected ones: the oracle of the coupling forces.
"""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector, cross
from kanefe.kane.active import loaded_frames
from kanefe.kane.contact_shares import shared_forces
from kanefe.kane.inertia import inertia_in_frame
from kanefe.states.constraints import HeldWrench, held_rows, marker_wrenches
from kanefe.states.interactions import MarkerWrench, load_wrenches
from kanefe.states.kinematics import FrameMotion
from kanefe.states.state import State, once
from kanefe.tree.body_terms import BodyTerms


def joint_reactions(state: State, du: Vector) -> list[Vector]:
    """Return for each body the wrench that its joint exerts on it, (6,): force and moment about its frame's origin.

    In components of the body's frame (R or G); the part of motors and drives included.

    Parameters
    ----------
    state : State
    du : ndarray, shape (free,)
        Accelerations of the free speeds at this state.
    """
    return _sweep_inward(state, np.concatenate((du, state.driven_rates)))


def loop_forces(state: State) -> dict[str, Vector]:
    """Return what each loop joint, distance and rolling contact exerts on its end b, (6,), by name.

    Force (N) and moment (N m) about the origin of b's marker, in its axes; zero where it is switched off. Couplers of
    joint coordinates have no ends.
    """
    at = {id(held.constraint): held.wrench for held in held_wrenches(state) if held.marker is held.constraint.ends[1]}
    return {c.name: at.get(id(c), np.zeros(6)) for c in state.model.constraints if c.b is not None}


def gear_forces(state: State) -> Vector:
    """Return the force (N) or torque (N m) of each gear, rack or other coupler on each coordinate that it couples.

    Its coefficient times its multiplier, gear by gear, (coordinates of all gears,); zero where it is switched off.
    """
    from kanefe.constraints.rows import CouplerRow

    rows = held_rows(state)
    multipliers = shared_forces(state) if rows else ()
    acting = {id(row): force for (_, row), force in zip(rows, multipliers, strict=True)}
    couplers = [row for c in state.model.constraints for row in c.rows if isinstance(row, CouplerRow)]
    return np.array([coefficient * acting.get(id(row), 0.0) for row in couplers for _, _, coefficient in row.terms])


@once
def held_wrenches(state: State) -> list[HeldWrench]:
    """Return what loop joints, rolling and rigid contacts exert on their markers."""
    if not state.model.is_constrained:
        return []
    return marker_wrenches(state, shared_forces(state))


def _sweep_inward(state: State, rates: Vector) -> list[Vector]:
    """Return the wrench on each body from its joint: its own demand and, moved inward, those of its children."""
    model, motions = state.model, state.motions
    pairs = zip(model.bodies, motions, strict=True)
    wrenches = [body_demand(state, body, frame, rates) for body, frame in pairs]
    acting: list[HeldWrench | MarkerWrench] = [*held_wrenches(state), *load_wrenches(state)]
    for one in acting:
        if one.marker.body >= 0:
            wrenches[one.marker.body] -= moved_wrench(one.wrench, one.frame, motions[one.marker.body])
    for number in reversed(range(len(model.bodies))):
        body = model.bodies[number]
        if body.parent >= 0:
            wrenches[body.parent] += moved_wrench(wrenches[number], motions[number], motions[body.parent])
    return wrenches


def body_demand(state: State, body: BodyTerms, frame: FrameMotion, rates: Vector) -> Vector:
    """Return the wrench (6,) a body needs beyond gravity and its loads: inertia force less known forces."""
    model = state.model
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
        mass, bias = inertia_in_frame(terms, frame, gravity, state.q[terms.eta], state.full[terms.speeds])
        demand = (mass @ np.concatenate((a, alpha, rates[terms.speeds])) + bias)[:6]
        for field_load in body.field_loads:
            demand -= np.concatenate(field_load.forces(state.t, frame.A_NF, state.q[terms.eta], state)[:2])
    else:
        demand = np.zeros(6)
    for load, loaded in loaded_frames(state, body, frame):
        demand -= moved_wrench(np.concatenate(load.wrench(state.t, loaded, state)), loaded, frame)
    return demand


def moved_wrench(wrench: Vector, source: FrameMotion, target: FrameMotion) -> Vector:
    """Return a wrench about the origin of `source`, in its axes, about the origin and in the axes of `target`."""
    A = target.A_NF.T @ source.A_NF
    force = A @ wrench[:3]
    r = target.A_NF.T @ (source.p_NoFo_N - target.p_NoFo_N)
    return np.concatenate((force, A @ wrench[3:] + cross(r, force)))
