"""Energies of the scene and the power of what exchanges energy with it."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.active import loaded_frames
from kanefe.kane.assemble import all_speeds, assemble
from kanefe.kane.kinematics import sweep_outward
from kanefe.model import Model


def kinetic_energy(model: Model, t: float, q: Vector, u: Vector) -> float:
    """Return 1/2 u^T M_sys u over free and driven speeds, in J."""
    M, _ = assemble(model, t, q, u)
    speeds = all_speeds(model, t, u)[: len(M)]
    return float(0.5 * speeds @ M @ speeds)


def elastic_energy(model: Model, t: float, q: Vector) -> float:
    """Return 1/2 eta^T K eta of all flexible bodies and the energy of the joints' springs, in J."""
    total = 0.0
    for body in model.bodies:
        if body.has_spring:
            stretch = float(body.joint_coordinates(t, q)[0]) - body.joint.rest_position
            total += 0.5 * body.joint.stiffness_and_damping[0] * stretch**2
        if body.flexible:
            eta, k = q[body.flexible.eta], body.flexible.body.free_count
            total += 0.5 * float(eta @ body.flexible.body.stiffness[:k, :k] @ eta)
    return total


def gravity_energy(model: Model, t: float, q: Vector) -> float:
    """Return -sum m g . p_C, in J: zero where every centre of mass lies at N's origin."""
    total = 0.0
    zero = np.zeros(model.free_count)
    motions = sweep_outward(model, t, q, all_speeds(model, t, zero))
    for body, frame in zip(model.bodies, motions, strict=True):
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


def momenta(model: Model, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return linear momentum (3,) in kg m/s and angular momentum (3,) about N's origin in kg m2/s, components of N."""
    full = all_speeds(model, t, u)
    linear, angular = np.zeros(3), np.zeros(3)
    for body, frame in zip(model.bodies, sweep_outward(model, t, q, full), strict=True):
        if body.rigid is not None:
            p = body.rigid.spatial @ np.concatenate((frame.v, frame.w))
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


def dissipated_power(model: Model, t: float, u: Vector) -> float:
    """Return the power of damping, deta^T C deta and that of the joints' dampers, in W."""
    total = 0.0
    full = all_speeds(model, t, u)
    for body in model.bodies:
        if body.has_spring:
            total += body.joint.stiffness_and_damping[1] * float(full[body.speeds][0]) ** 2
        if body.flexible and body.flexible.damping is not None:
            deta = u[body.flexible.speeds]
            total += float(deta @ body.flexible.damping[: len(deta)] @ deta)
    return total


def load_power(model: Model, t: float, q: Vector, u: Vector) -> float:
    """Return the power of forces and torques (not of gravity, nor of drives), in W."""
    full = all_speeds(model, t, u)
    total = 0.0
    for body, frame in zip(model.bodies, sweep_outward(model, t, q, full), strict=True):
        for load, loaded in loaded_frames(model, body, frame, q, full):
            force, moment = load.wrench(t, loaded)
            total += float(force @ loaded.v + moment @ loaded.w)
        for joint_load in body.joint_loads:
            total += joint_load.value(t) * float(full[body.speeds][0])
    return total


def drive_power(model: Model, t: float, q: Vector, u: Vector, du: Vector) -> float:
    """Return the power of the driving forces of given motions, in W, with the accelerations du (free,)."""
    if model.driven_count == 0:
        return 0.0
    M, F = assemble(model, t, q, u)
    speeds, rates = model.driven_speeds(t)
    forces = M[model.free_count :] @ np.concatenate((du, rates)) - F[model.free_count :]
    return float(forces @ speeds)
