"""Energies of the scene and the power of what exchanges energy with it."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.active import loaded_frames
from kanefe.kane.assemble import all_speeds, assemble, constraint_forces, mass_matrix
from kanefe.kane.interactions import interaction_energy, interaction_powers
from kanefe.kane.kinematics import sweep_outward
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState


def kinetic_energy(model: ModelData, t: float, q: Vector, u: Vector) -> float:
    """Return 1/2 u^T M_sys u over free and driven speeds, in J."""
    full = all_speeds(model, t, u)
    M = mass_matrix(model, sweep_outward(model, t, q, full), q, full)
    speeds = full[: len(M)]
    return float(0.5 * speeds @ M @ speeds)


def elastic_energy(model: ModelData, t: float, q: Vector) -> float:
    """Return 1/2 eta^T K eta of all flexible bodies and of the springs of joints and between markers, in J."""
    total = 0.0
    for body in model.bodies:
        if body.has_coordinate_forces:
            at = body.joint_coordinates(t, q)
            forces = body.joint.coordinate_forces
            total += sum(force.potential(float(x)) for force, x in zip(forces, at, strict=True) if force is not None)
        if body.flexible:
            eta, k = q[body.flexible.eta], body.flexible.body.free_count
            total += 0.5 * float(eta @ body.flexible.body.stiffness[:k, :k] @ eta)
    if model.has_interactions:
        full = all_speeds(model, t, np.zeros(model.free_count))
        total += interaction_energy(model, sweep_outward(model, t, q, full), t, q, full)
    return total


def gravity_energy(model: ModelData, t: float, q: Vector) -> float:
    """Return -sum m g . p_C of bodies with weight, in J: zero where every centre of mass lies at N's origin."""
    total = 0.0
    zero = np.zeros(model.free_count)
    motions = sweep_outward(model, t, q, all_speeds(model, t, zero))
    for body, frame in zip(model.bodies, motions, strict=True):
        if not body.has_gravity:
            continue
        if body.rigid is not None:
            mass, first = body.rigid.mass, body.rigid.mass * body.rigid.com
        elif body.flexible is not None:
            generalised, _ = body.flexible.free_moments.terms(
                q[body.flexible.eta], zero[body.flexible.speeds], np.zeros(3)
            )
            mass = float(body.flexible.free_moments.mass)
            c = generalised[3:6, :3]  # the first moment as c~
            first = np.array((c[2, 1], c[0, 2], c[1, 0]))
        else:
            continue
        total -= float(model.gravity @ (mass * frame.p_NoFo_N + frame.A_NF @ first))
    return total


def momenta(model: ModelData, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return linear momentum (3,) in kg m/s and angular momentum (3,) about N's origin in kg m2/s, components of N."""
    full = all_speeds(model, t, u)
    linear, angular = np.zeros(3), np.zeros(3)
    for body, frame in zip(model.bodies, sweep_outward(model, t, q, full), strict=True):
        if body.rigid is not None:
            p = body.rigid.spatial @ np.concatenate((frame.v, frame.w))
            p[3:] += body.rigid.rotor
        elif body.flexible is not None:
            terms = body.flexible
            mass, _ = terms.free_moments.terms(q[terms.eta], full[terms.speeds], frame.w)
            p = mass[:6] @ np.concatenate((frame.v, frame.w, full[terms.speeds]))
        else:
            continue
        force = frame.A_NF @ p[:3]
        linear += force
        angular += frame.A_NF @ p[3:] + np.cross(frame.p_NoFo_N, force)
    return linear, angular


def dissipated_power(model: ModelData, t: float, q: Vector, u: Vector) -> float:
    """Return the power that deta^T C deta, friction, stops and all dampers take, in W."""
    total = 0.0
    full = all_speeds(model, t, u)
    for body in model.bodies:
        if body.has_coordinate_forces:
            at = body.joint_coordinates(t, q)
            for force, x, rate in zip(body.joint.coordinate_forces, at, full[body.speeds], strict=True):
                total += 0.0 if force is None else force.dissipation(float(x), float(rate))
        if body.flexible and body.flexible.damping is not None:
            deta = u[body.flexible.speeds]
            total += float(deta @ body.flexible.damping[: len(deta)] @ deta)
    if model.has_interactions:
        total += interaction_powers(model, sweep_outward(model, t, q, full), t, q, full)[0]
    return total


def load_power(model: ModelData, t: float, q: Vector, u: Vector) -> float:
    """Return the power of forces, torques, and tables and laws of springs (not of gravity, nor of drives), in W."""
    full = all_speeds(model, t, u)
    total = 0.0
    motions = sweep_outward(model, t, q, full)
    state = SceneState(model, t, q, full, motions)
    for body, frame in zip(model.bodies, motions, strict=True):
        for load, loaded in loaded_frames(model, body, frame, q, full):
            force, moment = load.wrench(t, loaded, state)
            total += float(force @ loaded.v + moment @ loaded.w)
        if body.flexible is not None:
            eta, deta = q[body.flexible.eta], full[body.flexible.speeds]
            for field_load in body.field_loads:
                force, moment, elastic = field_load.forces(t, frame.A_NF, eta, state)
                total += float(force @ frame.v + moment @ frame.w + elastic @ deta)
        for joint_load in body.joint_loads:
            total += joint_load.value(t, state) * float(full[body.speeds[joint_load.coordinate]])
    if model.has_interactions:
        total += interaction_powers(model, motions, t, q, full)[1]
    return total


def drive_power(model: ModelData, t: float, q: Vector, u: Vector, du: Vector) -> float:
    """Return the power of the driving forces of given motions, in W, with the accelerations du (free,)."""
    if model.driven_count == 0:
        return 0.0
    motions = sweep_outward(model, t, q, all_speeds(model, t, u))
    M, F = assemble(model, t, q, u, motions=motions)
    speeds, rates = model.driven_speeds(t)
    known = F + constraint_forces(model, t, q, u, motions)
    forces = M[model.free_count :] @ np.concatenate((du, rates)) - known[model.free_count :]
    return float(forces @ speeds)
