"""Contacts that are loaded where a scene starts: they act, and are stiff, from then on."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.contact.contact import compliant_contacts
from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.states.state import State
from kanefe.storage.scipy_later import scipy
from kanefe.tree.scales import scene_length

PRESSED = 1e-6
"""Acceleration into a surface, relative to gravity, up to which it is round-off."""

TOUCHES = 1e-9
"""Gap, relative to the size of the scene, up to which a point touches but for round-off."""


def loaded_depth(model: Model, start: float) -> float:
    """Return how deep contacts of straight laws are that stay loaded from the start (s) on, m; zero: none does.

    A point touches, and would move into its surface without them. It does not bounce: the contact holds it back no more
    than twice as much as that, and it is as slow as it would be in a vibration of that size. The least depth of all is
    told, as in statics.
    """
    state, n = State(model, start, model.initial_coordinates, model.initial_speeds), model.free_count
    rows, forces, stiffnesses, gap = list[Matrix](), list[float](), list[float](), TOUCHES * scene_length(model)
    for number, contact in compliant_contacts(model.loads):
        for touch in contact.touches(state.load_ends(number), state.load_states(number)):
            if touch.depth < -gap:
                continue
            J = velocity_at(state, contact.ends[0], contact.ends[touch.end], touch.point)[:, :n]
            rows.append(touch.normal[None] @ J)
            forces.append(touch.normal_force)
            stiffnesses.append((contact.straight or 0.0) * touch.share)
    if not rows:
        return 0.0
    dynamics, G, u = Dynamics(model), np.concatenate(rows), model.initial_speeds[:n]
    du = dynamics.rate(start, dynamics.initial_state(start))[model.coordinate_count :][:n]
    try:
        mass = scipy.linalg.cho_factor(model.literal.mass_at_start(start))
    except np.linalg.LinAlgError:  # something has inertia only through loops
        return 0.0
    # what the forces now, and those at the same depth of all points, do against it
    held, squares = (G @ scipy.linalg.cho_solve(mass, G.T @ np.array((forces, stiffnesses)).T)).T
    pressed, least = held - G @ du, PRESSED * float(np.linalg.norm(model.gravity))
    is_slow = (G @ u) ** 2 * squares <= pressed**2
    stays = (pressed > least) & (squares > 0.0) & (held <= 2.0 * pressed) & is_slow
    return float((pressed[stays] / squares[stays]).min()) if np.any(stays) else 0.0


def velocity_at(state: State, surface: Marker, end: Marker, point: Vector) -> Matrix:
    """Return the partial velocities in N of a point (N, m) that is fixed in an end, past a surface, (3, columns)."""
    parts = [F.A_NF @ F.shifted(F.A_NF.T @ (point - F.p_NoFo_N))[0] for F in (state.marker(surface), state.marker(end))]
    return np.asarray(parts[1] - parts[0])
