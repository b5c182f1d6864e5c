"""Energies of the scene and the power of what exchanges energy with it, in two books: what is taken, what is given."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.active import loaded_frames
from kanefe.kane.assemble import equations, mass_matrix
from kanefe.kane.contact_shares import constraint_forces
from kanefe.kane.inertia import inertia_in_frame
from kanefe.states.state import State, actions, once


@once
def kinetic_energy(state: State) -> float:
    """Return 1/2 u^T M_sys u over free and driven speeds, in J."""
    M = mass_matrix(state)
    speeds = state.full[: len(M)]
    return float(0.5 * speeds @ M @ speeds)


@once
def elastic_energy(state: State) -> float:
    """Return 1/2 eta^T K eta of all flexible bodies, and of springs of joints and loads between frames, in J."""
    total = 0.0
    for body in state.model.bodies:
        if body.has_coordinate_forces:
            at = body.joint_coordinates(state.t, state.q)
            forces = body.joint.coordinate_forces
            total += sum(force.potential(float(x)) for force, x in zip(forces, at, strict=True) if force is not None)
        if body.flexible:
            eta, k = state.q[body.flexible.eta], body.flexible.body.free_count
            total += 0.5 * float(eta @ body.flexible.body.stiffness[:k, :k] @ eta)
    return total + sum(action.potential for action in actions(state))


@once
def gravity_energy(state: State) -> float:
    """Return -sum m g . p_C of bodies with weight, in J: zero where every centre of mass lies at N's origin."""
    total = 0.0
    for body, frame in zip(state.model.bodies, state.motions, strict=True):
        if not body.has_gravity:
            continue
        if body.rigid is not None:
            mass, first = body.rigid.mass, body.rigid.mass * body.rigid.com
        elif body.flexible is not None:
            eta = state.q[body.flexible.eta]
            generalised, _ = body.flexible.free_moments.terms(eta, np.zeros_like(eta), np.zeros(3))
            mass = float(body.flexible.free_moments.mass)
            c = generalised[3:6, :3]  # the first moment as c~
            first = np.array((c[2, 1], c[0, 2], c[1, 0]))
        else:
            continue
        total -= float(state.model.gravity @ (mass * frame.p_NoFo_N + frame.A_NF @ first))
    return total


@once
def momenta(state: State) -> tuple[Vector, Vector]:
    """Return linear momentum (3,) in kg m/s and angular momentum (3,) about N's origin in kg m2/s, components of N."""
    linear, angular = np.zeros(3), np.zeros(3)
    for body, frame in zip(state.model.bodies, state.motions, strict=True):
        if body.rigid is not None:
            p = body.rigid.spatial @ np.concatenate((frame.v, frame.w))
            p[3:] += body.rigid.rotor
        elif body.flexible is not None:
            terms = body.flexible
            mass, _ = inertia_in_frame(terms, frame, np.zeros(3), state.q[terms.eta], state.full[terms.speeds])
            p = mass[:6] @ np.concatenate((frame.v, frame.w, state.full[terms.speeds]))
        else:
            continue
        force = frame.A_NF @ p[:3]
        linear += force
        angular += frame.A_NF @ p[3:] + np.cross(frame.p_NoFo_N, force)
    return linear, angular


@once
def dissipated_power(state: State) -> float:
    """Return the power that deta^T C deta, stops and all dampers take, in W."""
    total = 0.0
    for body in state.model.bodies:
        if body.has_coordinate_forces:
            at = body.joint_coordinates(state.t, state.q)
            for force, x, rate in zip(body.joint.coordinate_forces, at, state.full[body.speeds], strict=True):
                total += 0.0 if force is None else force.dissipation(float(x), float(rate))
        if body.flexible and body.flexible.damping is not None:
            deta = state.u[body.flexible.speeds]
            total += float(deta @ body.flexible.damping[: len(deta)] @ deta)
    return total + sum(action.taken for action in actions(state))


@once
def load_power(state: State) -> float:
    """Return the power of forces, torques, and what loads between frames give (not of gravity, nor of drives), in W."""
    total = 0.0
    for body, frame in zip(state.model.bodies, state.motions, strict=True):
        for load, loaded in loaded_frames(state, body, frame):
            force, moment = load.wrench(state.t, loaded, state)
            total += float(force @ loaded.v + moment @ loaded.w)
        if body.flexible is not None:
            eta, deta = state.q[body.flexible.eta], state.full[body.flexible.speeds]
            for field_load in body.field_loads:
                force, moment, elastic = field_load.forces(state.t, frame.A_NF, eta, state)
                total += float(force @ frame.v + moment @ frame.w + elastic @ deta)
        for joint_load in body.joint_loads:
            total += float(joint_load.value(state.t, state)) * float(state.full[body.speeds[joint_load.coordinate]])
    return total + sum(action.given for action in actions(state))


def drive_power(state: State, du: Vector) -> float:
    """Return the power of the driving forces of given motions, in W, with the accelerations du (free,)."""
    model = state.model
    if model.driven_count == 0:
        return 0.0
    M, F = equations(state)
    known = F + constraint_forces(state, state)
    forces = M[model.free_count :] @ np.concatenate((du, state.driven_rates)) - known[model.free_count :]
    return float(forces @ state.full[model.free_count : len(M)])
