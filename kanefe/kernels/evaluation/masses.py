"""The mass matrix of a scene (Eq. 18, 39) by one inward sweep: inertias of links with all that they carry.

The column of a speed is the wrench that its unit acceleration needs, from the composite inertia of its link, seen by
the joints and modes between the link and the ground (Featherstone, "Rigid Body Dynamics Algorithms", section 6.2;
modes as in `kanefe.kernels.sweeps.modal_elimination`, where nothing gives way here). `kanefe.kane.assemble` computes
the same from dense partial velocities.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.bodies import ModalBodies, ModalBody
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.joints.handing import hand_inward
from kanefe.kernels.joints.motion import put_three
from kanefe.kernels.layout import COORDINATES, COUNT, MODAL_SIZE, SPEEDS, WORK, work_size
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.exact_beam_layout import beam_work_in
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tables import FlexibleTables, Tables
from kanefe.kernels.tree import Frame, Frames, InterfaceFrame, InterfaceLink, Kind, Link, Links
from kanefe.kernels.values.tensors import ZERO, Matrix, Vector, cross, dot


@entry()
def put_masses(
    tables: Tables, flexible: FlexibleTables, drives: RealRows, y: Reals, found: RealRows, memory: Reals
) -> None:
    """Write the mass matrix of a state ``(q, u, ...)`` over its free and driven speeds.

    Parameters
    ----------
    drives : ndarray, shape (driven, 3)
    y : ndarray
    found : ndarray, shape (free + driven, free + driven)
    memory : ndarray, shape (`masses_memory_size`,)
    """
    n, size = tables.sizes[COORDINATES], work_size(tables)
    work, rest = memory[:size].reshape(-1, WORK), memory[size:]
    modal, column = rest[: flexible.sizes[MODAL_SIZE]], rest[flexible.sizes[MODAL_SIZE] :]
    sweep_outward(tables, flexible, drives, y[:n], y[n : n + tables.sizes[SPEEDS]], work, modal)
    set_inertia(tables, flexible, work, modal)
    found[:, :] = 0.0
    links, frames = Links(tables.rows, tables.geometry), Frames(work)
    for i in range(len(links) - 1, -1, -1):
        link, frame = links[i], frames[i]
        if link.kind != Kind.INTERFACE:
            if link.flexible >= 0:
                _put_modes(links, flexible, i, frames, modal, found)
            _put_joint(links, flexible, i, frames, modal, found)
        if link.parent >= 0:
            hand_inward(frames[link.parent], frame.r, frame.M, frame.H, frame.J, ZERO, ZERO)
    bodies = ModalBodies(flexible.bodies, flexible.pool, modal)
    for f in range(len(bodies)):
        body = bodies[f]
        if body.transform >= 0:
            _transform_columns(found, body.first_deta, body.to_modes, column[: body.k])
            _transform_rows(found, body.first_deta, body.to_modes, column[: body.k])


@kernel
def _put_joint(
    links: Links, flexible: FlexibleTables, i: int, frames: Frames, modal: np.ndarray, found: np.ndarray
) -> None:
    """Write the columns of the joint of a link."""
    link, frame = links[i], frames[i]
    speed = link.speed
    if link.kind == Kind.FIXED:
        return
    if link.kind == Kind.SPHERICAL or link.kind == Kind.FREE:
        if link.kind == Kind.FREE:
            axes = frames[link.parent].R @ link.axes
            for c in range(3):
                _put_motion(links, flexible, i, _column(axes, c), ZERO, speed + c, frames, modal, found)
            speed += 3
        for c in range(3):
            _put_motion(links, flexible, i, ZERO, _column(frame.R, c), speed + c, frames, modal, found)
        return
    v, w = partials(link, frame)
    _put_motion(links, flexible, i, v, w, speed, frames, modal, found)


@inlined
def _column(A: Matrix, c: int) -> Vector:
    """Return a column of a matrix."""
    return A.x if c == 0 else (A.y if c == 1 else A.z)


@kernel
def _put_motion(
    links: Links,
    flexible: FlexibleTables,
    i: int,
    v: Vector,
    w: Vector,
    speed: int,
    frames: Frames,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Write the column of a speed with which a link, and all that it carries, moves as one rigid body."""
    f, n = _wrench(frames[i], v, w)
    _hand_to_ground(links, flexible, i, f, n, speed, frames, modal, found)


@inlined
def _wrench(frame: Frame, v: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return the wrench that accelerations of a row need, about its origin."""
    return frame.M @ v + frame.H @ w, frame.H.T @ v + frame.J @ w


@kernel
def _put_modes(
    links: Links, flexible: FlexibleTables, i: int, frames: Frames, modal: np.ndarray, found: np.ndarray
) -> None:
    """Write the columns of the modes of a flexible body: of unit mass, with what their interfaces carry."""
    body, G = ModalBodies(flexible.bodies, flexible.pool, modal)[links[i].flexible], frames[i].R
    k, first, linear, angular = body.k, body.first_deta, body.linear, body.angular
    if k == 0:
        return
    for j in range(k):
        if body.exact < 0:
            found[first + j, first + j] += 1.0
        else:
            mass = beam_work_in(flexible.bodies[links[i].flexible], modal).mass
            found[first + j, first + j] += mass[j, j]
            for other in range(j):
                found[first + j, first + other] += mass[j, other]
                found[first + other, first + j] += mass[j, other]
        f, n = G @ linear[j], G @ angular[j]
        for c in range(body.carried, body.carried + body.carried_count):
            link, frame = InterfaceLink(links[flexible.carrying[c]]), frames[flexible.carrying[c]]
            v, w = _moved_by_mode(flexible, link, frame, k, j, modal)
            own, turning = _wrench(frame, G @ v, G @ w)
            _add_to_modes(flexible, link, frame, body, G, own, turning, first + j, modal, found)
            f += own
            n += turning + cross(frame.r, own)
        _hand_to_ground(links, flexible, i, f, n, first + j, frames, modal, found)


@inlined
def _moved_by_mode(
    flexible: FlexibleTables, link: InterfaceLink, frame: Frame, k: int, j: int, modal: np.ndarray
) -> tuple[Vector, Vector]:
    """Return velocity and angular velocity of an interface by the rate of a mode, in G."""
    # one name for both, since `modal` is real here
    if link.bent < 0:
        basis = flexible.pool[link.basis : link.basis + 6 * k].reshape(6, k)
    else:
        basis = modal[link.bent : link.bent + 6 * k].reshape(6, k)
    turn = InterfaceFrame(frame).tangent @ Vector(basis[3, j], basis[4, j], basis[5, j])
    return Vector(basis[0, j], basis[1, j], basis[2, j]), turn


@kernel
def _add_to_modes(
    flexible: FlexibleTables,
    link: InterfaceLink,
    frame: Frame,
    body: ModalBody,
    G: Matrix,
    f: Vector,
    n: Vector,
    column: int,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Add what a wrench on an interface, in N, does on the modes of its body."""
    own, turning = G.T @ f, G.T @ n
    for j in range(body.k):
        v, w = _moved_by_mode(flexible, link, frame, body.k, j, modal)
        found[body.first_deta + j, column] += dot(v, own) + dot(w, turning)


@kernel
def _hand_to_ground(
    links: Links,
    flexible: FlexibleTables,
    i: int,
    f: Vector,
    n: Vector,
    column: int,
    frames: Frames,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Write what a wrench on a link does along all speeds between the link and the ground, and the same as a row."""
    while i >= 0:
        link, frame = links[i], frames[i]
        parent = frames[link.parent]
        if link.kind == Kind.INTERFACE:
            body = ModalBodies(flexible.bodies, flexible.pool, modal)[link.flexible]
            first, count = body.first_deta, body.k
            _add_to_modes(flexible, InterfaceLink(link), frame, body, parent.R, f, n, column, modal, found)
        else:
            first, count = link.speed, _add_to_joint(link, frame, parent, f, n, column, found)
        for s in range(first, first + count):
            found[column, s] = found[s, column]
        n += cross(frame.r, f)
        i = link.parent


@inlined
def _add_to_joint(link: Link, frame: Frame, parent: Frame, f: Vector, n: Vector, column: int, found: np.ndarray) -> int:
    """Write what a wrench on a link does along the speeds of its joint; return how many these are."""
    kind, speed, along = link.kind, link.speed, found[:, column]
    if kind == Kind.FIXED:
        return 0
    if kind == Kind.SPHERICAL:
        put_three(along, speed, frame.R.T @ n)
        return 3
    if kind == Kind.FREE:
        put_three(along, speed, link.axes.T @ (parent.R.T @ f))
        put_three(along, speed + 3, frame.R.T @ n)
        return 6
    v, w = partials(link, frame)
    along[speed] = dot(v, f) + dot(w, n)
    return 1


@kernel
def _transform_columns(found: np.ndarray, first: int, transform: np.ndarray, column: np.ndarray) -> None:
    """Replace the entries of all columns that belong to the modes of a body by those of the user's coordinates."""
    k = len(column)
    for c in range(found.shape[1]):
        copy(found[first : first + k, c], column)
        for j in range(k):
            found[first + j, c] = total(transform[j], column)


@kernel
def _transform_rows(found: np.ndarray, first: int, transform: np.ndarray, row: np.ndarray) -> None:
    """Do the same in all rows."""
    k = len(row)
    for i in range(len(found)):
        copy(found[i, first : first + k], row)
        for j in range(k):
            found[i, first + j] = total(transform[j], row)


def masses_memory_size(tables: Tables, flexible: FlexibleTables) -> int:
    """Return how many numbers the memory of `put_masses` has."""
    return work_size(tables) + int(flexible.sizes[MODAL_SIZE] + flexible.bodies[:, COUNT].max(initial=0))
