"""Rigid contacts between their events: forces of what touches, and how near they are to lifting, slipping, sticking.

    M du = F + W_N l_N + W_T l_T,    W_N^T du + r_N = 0 of what touches,    W_T^T du + r_T = 0 of what sticks,
    l_T = -mu l_N v_T / |v_T| of what slips

The multipliers l are those of the rows that `kanefe.states.constraints` has of contacts among the others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.contact.contact_point_outputs import POINT_OUTPUTS
from kanefe.contact.rigid.rigid_contact import OPEN, SLIPS, STICKS, RigidContact
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross
from kanefe.kane.assemble import held_solver
from kanefe.kane.contact_shares import shared_forces
from kanefe.states.constraints import force_rows, held_rows, meetings, motion_in_N, touching_rows
from kanefe.states.state import State, once
from kanefe.tree.contact_changes import paradox

if TYPE_CHECKING:
    from kanefe.bodies.marker import Marker
    from kanefe.contact.rigid.meeting import Meeting


class ProbeForce(NamedTuple):
    """Force on a closed contact point.

    Attributes
    ----------
    contact, probe : int
        Number of the contact among the rigid ones, and of the probe in it.
    status : int
    normal : float
        N.
    friction : ndarray, shape (3,)
        On the probe, in N (the frame), N.
    met : Meeting
        Where it touches.
    """

    contact: int
    probe: int
    status: int
    normal: float
    friction: Vector
    met: Meeting


@once
def probe_forces(state: State) -> list[ProbeForce]:
    """Return the force on each closed contact point."""
    found: list[ProbeForce] = []
    touching = touching_rows(state)
    if not touching:
        return found
    numbers = {id(state.model.rigid_contact(k)): k for k in range(len(state.model.rigid_contacts))}
    forces = shared_forces(state)
    at = len(held_rows(state)) - sum(len(rows) for _, _, rows in touching)
    for contact, i, rows in touching:
        own = forces[at : at + len(rows)]
        at += len(rows)
        if len(rows) == 1:
            tangential = rows[0].tangential
            friction = np.zeros(3) if tangential is None else own[0] * tangential
            found.append(ProbeForce(numbers[id(contact)], i, SLIPS, float(own[0]), friction, rows[0].found))
        else:
            friction = own[1] * rows[1].found.axes[1] + own[2] * rows[2].found.axes[2]
            found.append(ProbeForce(numbers[id(contact)], i, STICKS, float(own[0]), friction, rows[0].found))
    return found


@once
def friction_powers(state: State) -> tuple[float, float]:
    """Return the power that sliding takes, and that belts give, W."""
    taken = given = 0.0
    for force in probe_forces(state):
        contact = state.model.rigid_contact(force.contact)
        rates = force.met.axes[1:].T @ force.met.rates[1:]
        belt = state.marker(contact.ends[0]).A_NF @ contact.belt
        taken -= float(force.friction @ rates)
        given += float(force.friction @ belt)
    return taken, given


def contact_rates(state: State, rates: Vector) -> None:
    """Write the rates of the paths slid and of the work of friction to those of all internal states."""
    for force in probe_forces(state):
        if force.status != SLIPS:
            continue
        contact = state.model.rigid_contact(force.contact)
        where = state.model.load_states[state.model.rigid_contacts[force.contact]]
        share = contact.probes[force.probe][1].share
        slip = force.met.axes[1:].T @ force.met.rates[1:]
        rates[where.start] += share * float(np.linalg.norm(slip))
        rates[where.start + 1] -= float(force.friction @ slip)
        contact.turn(state.z[where], force.probe, rates[where])


def told(state: State, number: int) -> Vector:
    """Return the outputs of a rigid contact, by its number among the rigid ones: see `Contact.columns`."""
    contact, z = state.model.rigid_contact(number), state.load_states(state.model.rigid_contacts[number])
    total, tangential, moved, normal = np.zeros(3), np.zeros(3), np.zeros(3), 0.0
    met = meetings(state)[number]
    for force in probe_forces(state):
        if force.contact == number:
            normal += force.normal
            tangential += force.friction
            total += force.normal * met[force.probe].axes[0] + force.friction
            moved += force.normal * met[force.probe].point
    statuses = [status for status in contact.status(z) if status != OPEN]
    status = OPEN if not statuses else SLIPS if SLIPS in statuses else STICKS
    nearest = min(met, key=lambda one: one.gap)
    point = moved / normal if normal > 0.0 else nearest.point
    return np.array((*total, normal, np.linalg.norm(tangential), -nearest.gap, z[0], *point, z[1], status))


def rigid_point_outputs(state: State, number: int) -> Matrix:
    """Return what each point of a rigid contact does, (points, 12): see `kanefe.results.contact_points`."""
    contact, z = state.model.rigid_contact(number), state.load_states(state.model.rigid_contacts[number])
    back = state.marker(contact.ends[0]).A_NF.T
    met, statuses = meetings(state)[number], contact.status(z)
    found = np.zeros((len(met), POINT_OUTPUTS))
    found[:, 4], found[:, 11] = [-one.gap for one in met], statuses
    for force in probe_forces(state):
        if force.contact == number:
            found[force.probe, 0], found[force.probe, 1:4] = force.normal, back @ force.friction
    for i, (one, status) in enumerate(zip(met, statuses, strict=True)):
        if status == SLIPS:
            found[i, 8:11] = back @ (one.axes[1:].T @ one.rates[1:])
    return found


class ContactMargins(NamedTuple):
    """Distance of each closed contact point from each of its possible events; below zero it has passed it.

    Attributes
    ----------
    gaps, normals, slip_margins, slips : dict of (int, int) to float
        Gap of what is open, above where it left (m), normal force of what touches (N), what friction could hold beyond
        what it does of what sticks (N), and speed in the direction of the slip of what slips (m/s); by the number of
        the contact among the rigid ones, and of the probe in it.
    """

    gaps: dict[tuple[int, int], float]
    normals: dict[tuple[int, int], float]
    slip_margins: dict[tuple[int, int], float]
    slips: dict[tuple[int, int], float]


@once
def margins(state: State) -> ContactMargins:
    """Return how far what touches is from its next event."""
    found = ContactMargins({}, {}, {}, {})
    for number, (load, met) in enumerate(zip(state.model.rigid_contacts, meetings(state), strict=True)):
        contact, z = state.model.rigid_contact(number), state.load_states(load)
        for i, status in enumerate(contact.status(z)):
            if status == OPEN:
                found.gaps[number, i] = contact.left_of_gap(met[i], z, i)
            elif status == SLIPS and contact.friction is not None:
                surface = motion_in_N(state, contact.ends[0])
                found.slips[number, i] = contact.left_of_slip(met[i], contact.kept(z, i), surface)
    for force in probe_forces(state):
        key = force.contact, force.probe
        found.normals[key] = force.normal
        if force.status == STICKS:
            contact = state.model.rigid_contact(force.contact)
            found.slip_margins[key] = contact.static * force.normal - float(np.linalg.norm(force.friction))
    return found


def check_determined(state: State, least: float = 1e-9) -> None:
    """Raise a SimulationError if a growing force would press a slipping point still more: Painleve's paradox.

    The normal force of a probe that slips then has no value, or several.

    Parameters
    ----------
    state : State
    least : float
        Share of what a normal force does without friction, below which friction takes away all that it does.
    """
    if force_rows(state) is None:
        return
    loops = first = sum(len(c.rows) for c in state.model.constraints if c.holds(state.z))
    slipping: dict[int, tuple[RigidContact, int]] = {}
    for contact, i, own in touching_rows(state):
        if len(own) == 1 and own[0].tangential is not None:
            slipping[first] = contact, i
        first += len(own)
    gained, plain = held_solver(state).gained(list(slipping), loops)
    lost = np.flatnonzero(gained <= least * plain)
    if len(lost):
        contact, i = list(slipping.values())[int(lost[0])]
        raise paradox(contact.title, i, state.t)


def check_movable(state: State, contact: RigidContact) -> None:
    """Raise a ModelError if a point and its surface are on frames that no free speed moves."""
    n = state.model.free_count

    def moves(marker: Marker) -> bool:
        frame = state.marker(marker)
        return bool(frame.V[:, :n].any() or frame.W[:, :n].any())

    if moves(contact.ends[0]):
        return
    for i, (end, _) in enumerate(contact.probes):
        if not moves(contact.ends[end]):
            raise ModelError(
                f"{contact.title}: neither its surface nor the body of probe {i + 1} is free to move: both are fixed "
                "or driven, and a force between them has no value. Remedy: leave it out, or free one of the two"
            )


def probe_jacobian(state: State, number: int, i: int) -> Matrix:
    """Return the partial derivatives of the rates of a contact point by the speeds, (3, columns), touching or not."""
    contact, met = state.model.rigid_contact(number), meetings(state)[number][i]
    a, b = state.marker(contact.ends[0]), state.marker(contact.ends[contact.probes[i][0]])
    found = np.zeros((3, state.columns))
    for row, e in zip(found, met.axes, strict=True):
        for F, sign in ((b, 1.0), (a, -1.0)):
            force, arm = F.A_NF.T @ e, F.A_NF.T @ (met.point - F.p_NoFo_N)
            row += sign * (force @ F.V + cross(arm, force) @ F.W)
    return found
