"""Constraint equations of a scene over its speeds: residuals, Jacobian, bias accelerations, equations of motion.

    M du = F + J^T lambda,     J du + remainder = 0

The rows may depend on each other, for good (a planar loop closed by spatial joints) or for a moment (a mechanism that
passes a position with more freedom). Then the multipliers of least norm are taken, which leaves the motion as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Matrix, Vector
from kanefe.states.state import State, once
from kanefe.tree.row_rates import Rates
from kanefe.tree.scales import kept_of_scene

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint, MarkerMotion, MarkerRow, Row
    from kanefe.contact.rigid.meeting import Meeting
    from kanefe.contact.rigid.rigid_contact import ContactRow, RigidContact
    from kanefe.states.kinematics import FrameMotion
    from kanefe.tree.model_data import ModelData

OfMarkers = TypeVar("OfMarkers", "MarkerRow", "ContactRow")


@once
def held_rows(state: State) -> list[tuple[Constraint | RigidContact, Row | ContactRow]]:
    """Return the rows that hold in a state, each with its constraint: what is switched off or open is left out."""
    found: list[tuple[Constraint | RigidContact, Row | ContactRow]] = []
    found += [(c, row) for c in state.model.constraints if c.holds(state.z) for row in c.rows]
    return found + [(contact, row) for contact, _, rows in touching_rows(state) for row in rows]


@once
def meetings(state: State) -> list[list[Meeting]]:
    """Return where the contact points of each rigid contact of the scene meet its surface."""
    contacts = range(len(state.model.rigid_contacts))
    return [met(state, number, range(len(state.model.rigid_contact(number).probes))) for number in contacts]


def met(state: State, number: int, which: Sequence[int]) -> list[Meeting]:
    """Return where some points of a rigid contact, by its number among them, meet its surface, each computed once."""
    known = _known_meetings(state)
    missing = [i for i in which if (number, i) not in known]
    if missing:
        contact = state.model.rigid_contact(number)
        surface = motion_in_N(state, contact.ends[0])
        found = contact.met(missing, surface, [motion_in_N(state, contact.ends[contact.probes[i][0]]) for i in missing])
        known.update({(number, i): one for i, one in zip(missing, found, strict=True)})
    return [known[number, i] for i in which]


@once
def _known_meetings(state: State) -> dict[tuple[int, int], Meeting]:
    return {}


@once
def touching_rows(state: State) -> list[tuple[RigidContact, int, tuple[ContactRow, ...]]]:
    """Return the rows of each closed contact point, with its contact and its number in it."""
    found: list[tuple[RigidContact, int, tuple[ContactRow, ...]]] = []
    if not state.model.rigid_contacts:
        return found
    from kanefe.contact.rigid.rigid_contact import OPEN

    for number, load in enumerate(state.model.rigid_contacts):
        contact, z = state.model.rigid_contact(number), state.load_states(load)
        touching = [i for i, status in enumerate(contact.status(z)) if status != OPEN]
        if touching:
            surface = motion_in_N(state, contact.ends[0])
            rows = contact.rows(z, touching, met(state, number, touching), surface)
            found += [(contact, i, own) for i, own in zip(touching, rows, strict=True)]
    return found


@once
def place_rows(state: State) -> np.ndarray:
    """Return the numbers of those among them that hold coordinates, and not speeds alone."""
    return np.flatnonzero([row.holds_place for _, row in held_rows(state)])


def motion_in_N(state: State, marker: Marker) -> MarkerMotion:
    """Return the motion of a marker in components of N; found once."""
    from kanefe.constraints.rows import MarkerMotion

    known = _known_motions(state)
    if marker not in known:
        F = state.marker(marker)
        A = F.A_NF
        known[marker] = MarkerMotion(F.p_NoFo_N, A, A @ F.v, A @ F.w, A @ F.Z, A @ F.Y)
    return known[marker]


@once
def _known_motions(state: State) -> dict[Marker, MarkerMotion]:
    return {}


@once
def constraint_residuals(state: State) -> Vector:
    """Return g of all rows that hold (rows,), in the unit of each; zero of those on speeds alone: see `place_rows`."""
    from kanefe.constraints.rows import CouplerRow

    model = state.model
    values = np.zeros(len(held_rows(state)))
    for i in place_rows(state):
        row = held_rows(state)[i][1]
        if isinstance(row, CouplerRow):
            coordinates = (model.bodies[body].joint_coordinates(state.t, state.q)[j] for body, j, _ in row.terms)
            values[i] = sum(c * x for (_, _, c), x in zip(row.terms, coordinates, strict=True)) - row.constant
        else:
            values[i] = row.residual(motion_in_N(state, row.a), motion_in_N(state, row.b))
    return values


@once
def constraint_rates(state: State) -> Rates:
    """Return J and the bias accelerations of all active rows over the speeds that the state spans."""
    model, columns = state.model, state.columns
    rows = held_rows(state)
    J, remainder, reach = np.zeros((len(rows), columns)), np.zeros(len(rows)), np.zeros((len(rows), columns))
    given = np.zeros(len(rows))
    if not rows:
        return Rates(J, remainder, reach, given)
    from kanefe.constraints.rows import CouplerRow
    from kanefe.contact.rigid.rigid_contact import ContactRow, wrenches_of

    between: dict[tuple[Marker, Marker], tuple[list[int], list[MarkerRow]]] = {}
    touching: dict[tuple[Marker, Marker], tuple[list[int], list[ContactRow]]] = {}
    for i, (_, row) in enumerate(rows):
        if isinstance(row, CouplerRow):
            for body, coordinate, coefficient in row.terms:
                J[i, model.bodies[body].speeds[coordinate]] += coefficient
            reach[i] = J[i] ** 2
        elif isinstance(row, ContactRow):
            _add(touching, i, row)
            given[i] = row.given
        else:
            _add(between, i, row)
    for (a, b), (which, own) in between.items():
        ends = motion_in_N(state, a), motion_in_N(state, b)
        terms = [row.terms(*ends) for row in own]
        J[which], reach[which] = _marker_rows(state, own, zip(*(wrenches for wrenches, _ in terms), strict=True))
        remainder[which] = [left for _, left in terms]
    for (a, b), (which, met_rows) in touching.items():
        ends = motion_in_N(state, a), motion_in_N(state, b)
        J[which], reach[which] = _marker_rows(state, met_rows, wrenches_of(met_rows, *ends))
        remainder[which] = [row.remainder(*ends) for row in met_rows]
    return Rates(J, remainder, reach, given)


@once
def force_rows(state: State) -> Matrix | None:
    """Return the generalised forces of unit multipliers, (rows, columns), where slip friction makes them differ from J.

    None: they are J.
    """
    if not state.model.rigid_contacts:
        return None
    from kanefe.contact.rigid.rigid_contact import ContactRow, wrenches_of

    between: dict[tuple[Marker, Marker], tuple[list[int], list[ContactRow]]] = {}
    for i, (_, row) in enumerate(held_rows(state)):
        if isinstance(row, ContactRow) and row.tangential is not None:
            _add(between, i, row)
    if not between:
        return None
    forces = constraint_rates(state).J.copy()
    for (a, b), (which, own) in between.items():
        wrenches = wrenches_of(own, motion_in_N(state, a), motion_in_N(state, b), is_pushed=True)
        forces[which], _ = _marker_rows(state, own, wrenches)
    return forces


def _add(between: dict[tuple[Marker, Marker], tuple[list[int], list[OfMarkers]]], i: int, row: OfMarkers) -> None:
    """Put a row, with its number, to those that are between the same two markers."""
    which, own = between.setdefault((row.a, row.b), ([], []))
    which.append(i)
    own.append(row)


def _marker_rows(
    state: State, rows: Sequence[MarkerRow | ContactRow], wrenches: Iterable[Sequence[Vector] | Vector]
) -> tuple[Matrix, Matrix]:
    """Return rows of J that are between the same two markers, and their reach.

    From force and moment on a, then on b, of the unit multiplier of each.
    """
    from kanefe.constraints.rows import RADIAN

    entries, squares = np.zeros((len(rows), state.columns)), np.zeros((len(rows), state.columns))
    a, b = state.marker(rows[0].a), state.marker(rows[0].b)
    turn = np.array([row.unit == RADIAN for row in rows])
    for F, wide, is_turned, vectors in zip((a, a, b, b), (a.V, a.W, b.V, b.W), (0, 1, 0, 1), wrenches, strict=True):
        along = np.array(vectors)[:, :, None]
        if along.any() and wide.any():
            entries += (np.matmul(F.A_NF.T, along).transpose(0, 2, 1) @ wide)[:, 0]
            # the moment of two directions vanishes as they become parallel, and so must not measure itself
            sizes = np.where(turn, along.any(axis=(1, 2)), (along.transpose(0, 2, 1) @ along)[:, 0, 0])
            moved = np.einsum("ij,ij->j", wide, wide)
            if not is_turned:  # nor must the motion of a point on its axis of rotation, which is round-off
                moved = np.maximum(moved, np.einsum("ij,ij->j", F.W, F.W) * _levers(state, F))
            squares += sizes[:, None] * moved
    return entries, squares


def _levers(state: State, F: FrameMotion) -> Vector:
    """Return the squares of the distances of a frame from the body of each joint speed, (columns,), m2; of others 0."""
    speeds, bodies = _joint_speeds(state.model)
    places = np.array([motion.p_NoFo_N for motion in state.motions])[bodies]
    levers = np.zeros(state.columns)
    levers[speeds] = ((places - F.p_NoFo_N) ** 2).sum(axis=1)
    return levers


@kept_of_scene
def _joint_speeds(model: ModelData) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the speeds of joints, and of their bodies."""
    counts = [len(body.speeds) for body in model.bodies]
    return np.concatenate([body.speeds for body in model.bodies]).astype(int), np.repeat(range(len(counts)), counts)


class HeldWrench(NamedTuple):
    """What a constraint or rigid contact exerts on one of its markers.

    Attributes
    ----------
    constraint : Constraint or RigidContact
    marker : Marker
    frame : FrameMotion
        Of the marker.
    wrench : ndarray, shape (6,)
        Force and moment about the marker's origin, in its axes.
    """

    constraint: Constraint | RigidContact
    marker: Marker
    frame: FrameMotion
    wrench: Vector


def marker_wrenches(state: State, multipliers: Vector) -> list[HeldWrench]:
    """Return what the constraints exert on their markers.

    Constraint by constraint that holds: end a, then end b, summed over the rows.
    """
    if not held_rows(state):
        return []
    from kanefe.constraints.rows import CouplerRow
    from kanefe.contact.rigid.rigid_contact import ContactRow

    sums: dict[tuple[int, int], HeldWrench] = {}
    for (constraint, row), multiplier in zip(held_rows(state), multipliers, strict=True):
        if isinstance(row, CouplerRow):
            continue
        of = row.forces if isinstance(row, ContactRow) else row.wrenches
        force_a, moment_a, force_b, moment_b = of(motion_in_N(state, row.a), motion_in_N(state, row.b))
        for marker, force, moment in ((row.a, force_a, moment_a), (row.b, force_b, moment_b)):
            F = state.marker(marker)
            wrench = multiplier * np.concatenate((F.A_NF.T @ force, F.A_NF.T @ moment))
            key = id(constraint), id(marker)
            before = sums[key].wrench if key in sums else 0.0
            sums[key] = HeldWrench(constraint, marker, F, wrench + before)
    return list(sums.values())
