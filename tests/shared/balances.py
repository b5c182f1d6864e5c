"""What a run says acts on each body, in its axes about its origin: together it must be what inertia takes."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.nodal_moments import NodalMoments
from kanefe.frames import rotation_matrix
from kanefe.instants.instant import Instant
from kanefe.kane.active import loaded_frames
from kanefe.kane.reactions import held_wrenches, moved_wrench
from kanefe.states.interactions import load_wrenches
from kanefe.states.state import State
from kanefe.tree.neighbours import interface_at


def wrench_of(force: np.ndarray, moment: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Return a wrench (6,) about the origin from one at a place `arm` from it, all in one set of axes."""
    return np.concatenate((force, moment + np.cross(arm, force)))


def state_of(instant: Instant) -> tuple[State, np.ndarray]:
    model = instant.model
    du = model.parts(model.rhs(instant.time, instant.state))[1]
    return model.route.acting(instant.time, instant.state, du)


def inertia_of(instant: Instant, state: State, du: np.ndarray, number: int) -> np.ndarray:
    """Return the rate of momentum less gravity of a body, (6,), from its mass points where they move with the modes.

    Of unreduced bodies too, whose frames alone move in `state` with `du`.
    """
    body, F = state.model.bodies[number], state.motions[number]
    rates = np.concatenate((du, state.driven_rates))
    a, alpha, w = F.V @ rates + F.Z, F.W @ rates + F.Y, F.w
    if body.has_gravity:
        a = a - F.A_NF.T @ state.model.gravity
    if body.rigid is not None:
        c, I_C = body.rigid.com, body.rigid.inertia
        f = body.rigid.mass * (a + np.cross(alpha, c) + np.cross(w, np.cross(w, c)))
        return wrench_of(f, I_C @ alpha + np.cross(w, I_C @ w + body.rigid.rotor), c)
    if body.flexible is None:
        return np.zeros(6)
    terms = instant.model.bodies[number].flexible
    own, moments = terms.body, terms.free_moments
    rates = instant.model.parts(instant.model.rhs(instant.time, instant.state))[1]
    eta, deta, ddeta = instant.q[terms.eta], instant.u[terms.speeds], rates[terms.speeds]
    if isinstance(moments, NodalMoments) or getattr(moments, "quadratic_first", None) is not None:
        mass, bias = moments.terms(eta, deta, w)
        return np.asarray((mass @ np.concatenate((a, alpha, ddeta)) + bias)[:6])
    psi = own.inertia_basis[:, : own.free_count]
    u, du_, ddu = ((psi @ x).reshape(-1, 3) for x in (eta, deta, ddeta))
    r = own.inertia_points + u
    f = own.inertia_mass @ (a + np.cross(alpha, r) + np.cross(w, np.cross(w, r) + 2.0 * du_) + ddu)
    return np.concatenate((f.sum(axis=0), np.cross(r, f).sum(axis=0)))


def loads_elsewhere(state: State, number: int, instant: Instant) -> np.ndarray:
    """Return what acts on a body besides its joints and interfaces, (6,)."""
    body, F = state.model.bodies[number], state.motions[number]
    total = np.zeros(6)
    frames = zip(loaded_frames(state, body, F), body.loads, strict=True)
    acting = [(np.concatenate(load.wrench(state.t, n, state)), n, at) for (load, n), (_, at) in frames]
    for one in (*held_wrenches(state), *load_wrenches(state)):
        if one.marker.body == number:
            acting.append((one.wrench, one.frame, one.marker.interface))
    for wrench, frame, at in acting:
        if body.flexible is None or at is None or interface_at(body.flexible.body, at) is None:
            total += moved_wrench(wrench, frame, F)
    real = instant.model.bodies[number]
    for load in real.field_loads:
        eta = instant.q[real.flexible.eta]
        total += np.concatenate(load.forces(state.t, F.A_NF, eta, state)[:2])
    return total


def told(instant: Instant, number: int) -> list[np.ndarray]:
    """Return what the instant tells of forces of joints and at interfaces on a body, each (6,)."""
    model, name = instant.model, instant.model.bodies[number].name
    A = rotation_matrix(instant.rotation(name))
    p = instant.position(name)
    found = []
    if model.bodies[number].flexible is not None:
        for interface in instant.interfaces(name):
            force = instant.coupling_force(name, interface)
            found.append(wrench_of(force[:3], force[3:], A.T @ (instant.position(name, interface) - p)))
        return found
    found.append(instant.joint_reaction(name))
    for child in model.bodies:
        if child.parent == number:
            turn = A.T @ rotation_matrix(instant.rotation(child.name))
            force = -instant.joint_reaction(child.name)
            arm = A.T @ (instant.position(child.name) - p)
            found.append(wrench_of(turn @ force[:3], turn @ force[3:], arm))
    return found


def imbalances(instant: Instant) -> dict[str, float]:
    """Return of each body by how much forces and inertia differ, of the largest force or moment on it.

    Of a thousandth of the largest in the scene at least: what weighs next to nothing has round-off alone.
    """
    state, du = state_of(instant)
    left, largest = {}, {}
    for number, body in enumerate(instant.model.bodies):
        acting = [*told(instant, number), loads_elsewhere(state, number, instant)]
        needed = inertia_of(instant, state, du, number)
        # what floats is held by its joint as a whole, at no interface
        if body.flexible is not None and body.flexible.body.is_floating:
            acting.append(instant.joint_reaction(body.name))
        left[body.name] = sum(acting) - needed
        if body.flexible is not None and "z" not in instant.body(body.name).components:
            left[body.name] = left[body.name][[0, 1, 5]]  # a planar mesh: what its joint holds across it is elsewhere
        largest[body.name] = max(float(np.abs(x).max()) for x in (*acting, needed))
    least = 1e-3 * max(largest.values()) or 1.0
    return {name: float(np.abs(x).max()) / max(largest[name], least) for name, x in left.items()}
