"""The imbalance of a state, relative to the forces that act."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector, cross
from kanefe.kane.active import elastic_forces
from kanefe.kane.inertia import flexible_inertia
from kanefe.linear.tangents import tangent_names
from kanefe.linear.unit_forces import scene_load_columns
from kanefe.loads.coordinate_friction import CoordinateFriction
from kanefe.states.interactions import generalised_force
from kanefe.states.kinematics import elastic_state
from kanefe.states.state import State, once
from kanefe.tree.load_names import scene_loads

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.contact.contact import Contact
    from kanefe.linear.small_motions import SmallMotions

BALANCED = 1e-9
"""Remaining force, relative to those that balance in the same motion, that counts as zero: round-off of stiff bodies.
"""

FLOOR = 1e-6
"""Reference force for motions without loads, relative to the largest forces."""

ROUNDED = float(np.finfo(float).eps)
"""Displacement of a body relative to its size (1) that is round-off."""


@dataclass(frozen=True)
class Imbalance:
    """The remaining force in the motion with the worst balance.

    Attributes
    ----------
    name : str
        Name of the coordinate, with its unit.
    force : float
        N for a displacement, N m for an angle.
    ratio : float
        Relative to the forces that act in this motion.
    """

    name: str
    force: float
    ratio: float

    def __str__(self) -> str:
        unit = "N m" if "rad]" in self.name else "N" if "[m]" in self.name else "(modal force)"
        return f"{abs(self.force):.4g} {unit} along {self.name}"


def worst_imbalance(state: State, M: Matrix, du: Vector, N: Matrix, leading: Vector) -> Imbalance:
    """Return the largest of the remaining generalised forces ``N^T M du``, relative to those that act.

    Parameters
    ----------
    M : ndarray, shape (free, free)
        The mass matrix.
    du : ndarray, shape (free,)
        Accelerations at the state.
    N : ndarray, shape (free, k)
        Independent motions, led by the coordinates `leading`.
    """
    model, n = state.model, state.model.free_count
    left = N.T @ (M @ du)
    sizes = np.abs(N).T @ force_sizes(state)[:n]
    floor = FLOOR * float(sizes.max(initial=0.0))
    ratios = np.abs(left) / np.maximum(np.maximum(sizes, floor), 1e-300)
    if not len(ratios):
        return Imbalance("", 0.0, 0.0)
    worst = int(np.argmax(ratios))
    return Imbalance(tangent_names(model)[int(leading[worst])], float(left[worst]), float(ratios[worst]))


def imbalance_of(small: SmallMotions) -> Imbalance:
    """Return the worst imbalance of the state of small motions."""
    return worst_imbalance(small.here, small.mass, small.du, small.speeds.N, small.speeds.leading)


def slipping_friction(model: Model, t: float, q: Vector, u: Vector, left: Imbalance) -> str:
    """Return the required and the available friction in a joint along which equilibrium is lost; otherwise nothing.

    Parameters
    ----------
    left : Imbalance
        The imbalance of the state.
    """
    state = State(model, t, q, u)
    for i, load in enumerate(model.loads):
        if not isinstance(load, CoordinateFriction):
            continue
        found = load.slipping(state.load_ends(i), state.load_states(i))
        if found is not None and left.name.startswith(f"{model.bodies[load.ends[0].body].name}: "):
            held, unit = found
            needed = held + abs(left.force)
            return f"{load.kind} of {load.subject} needs {needed:.4g} {unit} and holds {held:.4g} {unit}"
    return ""


@once
def force_sizes(state: State) -> Vector:
    """Return the sum of the magnitudes of all generalised forces along each speed, free and driven, N and N m.

    Inertia and gravity of each body, stiffness, damping, loads and springs are added separately, so that they do not
    cancel, and with full lever arms: a measure of round-off, not a force.
    """
    model = cast(Model, state.model)
    sizes = np.zeros(state.columns)
    pushed, turned = np.zeros(len(model.bodies)), np.zeros(len(model.bodies))
    for number, body in enumerate(model.bodies):
        pushed[number], turned[number] = _body_sizes(state, number, sizes)
        if body.has_coordinate_forces:
            at = body.joint_coordinates(state.t, state.q)
            for x, speed, law in zip(at, body.speeds, body.joint.coordinate_forces, strict=True):
                if law is not None:
                    sizes[speed] += abs(law.force(float(x), float(state.full[speed])))
    for forces, partial in (
        (pushed, [frame.V for frame in state.motions]),
        (turned, [frame.W for frame in state.motions]),
    ):
        sizes += forces @ np.sqrt((np.reshape(partial, (-1, 3, state.columns)) ** 2).sum(axis=1))
    for load in scene_loads(model):
        columns_of = scene_load_columns(state, load)
        sizes[: model.free_count] += np.abs(columns_of) @ np.abs(np.atleast_1d(load.value(state.t, state)))
    if model.loads:
        from kanefe.contact.contact import Contact
    y = np.concatenate((state.q, state.u, state.z))
    for i, wrenches in model.route.wrenches_of_loads(state.t, y).items():
        load_between = model.loads[i]
        if isinstance(load_between, Contact):
            sizes += _contact_sizes(state, load_between, wrenches)
        else:
            sizes += np.abs(generalised_force(state, load_between.ends, wrenches))
    return sizes


def _body_sizes(state: State, number: int, sizes: Vector) -> tuple[float, float]:
    """Return the sizes of force and moment of a body's inertia and gravity; add those on its modes to `sizes`."""
    model, body, frame = state.model, state.model.bodies[number], state.motions[number]
    gravity = frame.A_NF.T @ model.gravity * body.has_gravity
    # magnitudes of the acceleration of the origin and of that per lever arm, whatever their directions
    pull = float(np.linalg.norm(frame.Z - gravity))
    pull += float(np.linalg.norm(frame.V[:, model.free_count :] @ state.driven_rates))
    spin = float(frame.w @ frame.w + np.linalg.norm(frame.Y + frame.W[:, model.free_count :] @ state.driven_rates))
    lever = mass = turned = 0.0
    if body.rigid is not None:
        lever, mass = float(np.linalg.norm(body.rigid.com)), body.rigid.mass
        turned = float(np.abs(body.rigid.inertia).max()) * spin
        turned += float(np.linalg.norm(cross(frame.w, body.rigid.rotor)))
    if body.flexible is not None:
        terms = body.flexible
        lever, mass = float(np.linalg.norm(terms.body.nodes, axis=1).max()), terms.body.mass
        eta, deta = elastic_state(terms, state.q, state.full, False)
        M, F = flexible_inertia(terms, frame, gravity, eta, deta)
        k = terms.body.free_count
        own = np.abs(F[terms.speeds]) + np.abs(elastic_forces(terms, eta, deta))
        sizes[terms.speeds] += own + np.abs(terms.body.stiffness[:k, :k]) @ np.abs(eta)
        # upper bound of the modal force (Cauchy-Schwarz), also for modes on which it vanishes by symmetry
        moved = np.sqrt(np.diag(M)[terms.speeds] / mass)
        sizes[terms.speeds] += mass * moved * (pull + spin * lever)
        # elastic forces of round-off displacements count as zero
        rounded = np.divide(ROUNDED * lever, moved, out=np.zeros(k), where=moved > 0.0)
        sizes[terms.speeds] += terms.body.stiffness.diagonal()[:k] * rounded / BALANCED
    pushed = mass * (pull + spin * lever)
    return pushed, turned + pushed * lever


def _contact_sizes(state: State, contact: Contact, wrenches: Matrix) -> Vector:
    """Return the sizes of the generalised forces of a contact, from its wrenches on its ends.

    The force through a wheel's axle and its friction cancel at the axle: forces count with their lever arms.
    """
    arms = np.zeros(len(contact.ends))
    for end, probe in contact.probes:
        arms[end] = max(arms[end], float(np.linalg.norm(probe.point)) + probe.radius + probe.ring)
    forces, moments = (np.linalg.norm(part, axis=1) for part in (wrenches[:, :3], wrenches[:, 3:]))
    acting: dict[tuple[int, InterfaceFrame | None], tuple[float, float]] = {}
    for marker, force, moment, arm in zip(contact.ends, forces, moments, arms, strict=True):
        if marker.body >= 0 and force > 0.0:
            pushed, turned = acting.get((marker.body, marker.interface), (0.0, 0.0))
            lever = float(np.linalg.norm(marker.point)) + arm
            acting[marker.body, marker.interface] = pushed + force, turned + moment + force * lever
    sizes = np.zeros(state.columns)
    for (body, interface), (pushed, turned) in acting.items():
        frame = state.motion(body, interface)
        sizes += pushed * np.linalg.norm(frame.V, axis=0) + turned * np.linalg.norm(frame.W, axis=0)
    return sizes
