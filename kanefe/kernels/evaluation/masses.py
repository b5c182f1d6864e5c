"""The mass matrix of a scene (Eq. 18, 39) by one inward sweep: inertias of links with all that they carry.

The column of a speed is the wrench that its unit acceleration needs, from the composite inertia of its link, seen by
the joints and modes between the link and the ground (Featherstone, "Rigid Body Dynamics Algorithms", section 6.2;
modes as in `kanefe.kernels.sweeps.modal_elimination`, where nothing gives way here). `kanefe.kane.assemble` computes
the same from dense partial velocities.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.joints.handing import Felt, hand_inward
from kanefe.kernels.joints.motion import put_three
from kanefe.kernels.language import ZERO, RealRows, Reals, Vector, copy, cross, dot, entry, inlined, kernel
from kanefe.kernels.scene import Scene, Work, bodies_of, links_of, state_in, work_in
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.exact_beams import column_of
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tree import Frame, InterfaceFrame, InterfaceLink, Kind, Link


class Columns(NamedTuple):
    """What columns of the mass matrix are written with.

    Attributes
    ----------
    scene : Scene
    work : Work
        After an outward sweep, with inertias of links and all that they carry.
    found : ndarray, shape (free + driven, free + driven)
    """

    scene: Scene
    work: Work
    found: np.ndarray


@entry()
def put_masses(scene: Scene, drives: RealRows, y: Reals, found: RealRows, memory: Reals) -> None:
    """Write the mass matrix of a state ``(q, u, ...)`` over its free and driven speeds.

    Parameters
    ----------
    drives : ndarray, shape (driven, 3)
    y : ndarray
    found : ndarray, shape (free + driven, free + driven)
    memory : ndarray
        For `Work`.
    """
    work = work_in(scene, memory)
    sweep_outward(scene, state_in(scene.tables, 0.0, y, drives, y), work, False)
    set_inertia(scene, work)
    found[:, :] = 0.0
    links, frames, bodies, columns = links_of(scene), work.frames, bodies_of(scene, work), Columns(scene, work, found)
    for i in range(len(links) - 1, -1, -1):
        link, frame = links[i], frames[i]
        if link.kind != Kind.INTERFACE:
            if link.flexible >= 0:
                _put_modes(columns, i)
            _put_joint(columns, i)
        if link.parent >= 0:
            hand_inward(frames[link.parent], frame.r, Felt(frame.M, frame.H, frame.J, ZERO, ZERO))
    for f in range(len(bodies)):
        body = bodies[f]
        if body.transform >= 0:
            _transform_columns(found, body.first_deta, body.to_modes, body.x)
            _transform_rows(found, body.first_deta, body.to_modes, body.x)


@kernel
def _put_joint(columns: Columns, i: int) -> None:
    """Write the columns of the joint of a link."""
    frames = columns.work.frames
    link, frame = links_of(columns.scene)[i], frames[i]
    speed = link.speed
    if link.kind == Kind.FIXED:
        return
    if link.kind == Kind.SPHERICAL or link.kind == Kind.FREE:
        if link.kind == Kind.FREE:
            axes = frames[link.parent].R @ link.axes
            for c in range(3):
                _put_motion(columns, i, column_of(axes, c), ZERO, speed + c)
            speed += 3
        for c in range(3):
            _put_motion(columns, i, ZERO, column_of(frame.R, c), speed + c)
        for s in range(link.speed, speed + 3):
            columns.found[s, s] += link.armature
        return
    v, w = partials(link, frame)
    _put_motion(columns, i, v, w, speed)
    columns.found[speed, speed] += link.armature


@kernel
def _put_motion(columns: Columns, i: int, v: Vector, w: Vector, speed: int) -> None:
    """Write the column of a speed with which a link, and all that it carries, moves as one rigid body."""
    f, n = _wrench(columns.work.frames[i], v, w)
    _hand_to_ground(columns, i, f, n, speed)


@inlined
def _wrench(frame: Frame, v: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return the wrench that accelerations of a row need, about its origin."""
    return frame.M @ v + frame.H @ w, frame.H.T @ v + frame.J @ w


@kernel
def _put_modes(columns: Columns, i: int) -> None:
    """Write the columns of the modes of a flexible body: of unit mass, with what their interfaces carry."""
    scene, work, found = columns.scene, columns.work, columns.found
    f, frames, carrying = links_of(scene)[i].flexible, work.frames, scene.flexible.carrying
    body, G = bodies_of(scene, work)[f], frames[i].R
    k, first, linear, angular = body.k, body.first_deta, body.linear, body.angular
    if k == 0:
        return
    for j in range(k):
        if not body.is_exact:
            found[first + j, first + j] += 1.0
        else:
            mass = ExactBeam(body).inertia_of_rates
            found[first + j, first + j] += mass[j, j]
            for other in range(j):
                found[first + j, first + other] += mass[j, other]
                found[first + other, first + j] += mass[j, other]
        force, moment = G @ linear[j], G @ angular[j]
        for c in range(body.carried, body.carried + body.carried_count):
            frame = frames[carrying[c]]
            v, w = _moved_by_mode(scene, work, carrying[c], j)
            own, turning = _wrench(frame, G @ v, G @ w)
            _add_to_modes(columns, carrying[c], own, turning, first + j)
            force += own
            moment += turning + cross(frame.r, own)
        _hand_to_ground(columns, i, force, moment, first + j)


@inlined
def _moved_by_mode(scene: Scene, work: Work, i: int, j: int) -> tuple[Vector, Vector]:
    """Return velocity and angular velocity of an interface by the rate of a mode, in G."""
    # one name for both, since `modal` is real here
    link = InterfaceLink(links_of(scene)[i])
    k = bodies_of(scene, work)[link.flexible].k
    if link.bent < 0:
        basis = scene.flexible.pool[link.basis : link.basis + 6 * k].reshape(6, k)
    else:
        basis = work.modal[link.bent : link.bent + 6 * k].reshape(6, k)
    turn = InterfaceFrame(work.frames[i]).tangent @ Vector(basis[3, j], basis[4, j], basis[5, j])
    return Vector(basis[0, j], basis[1, j], basis[2, j]), turn


@kernel
def _add_to_modes(columns: Columns, i: int, f: Vector, n: Vector, column: int) -> None:
    """Add what a wrench on an interface, in N, does on the modes of its body."""
    scene, work = columns.scene, columns.work
    link = links_of(scene)[i]
    body, back = bodies_of(scene, work)[link.flexible], work.frames[link.parent].R.T
    own, turning = back @ f, back @ n
    for j in range(body.k):
        v, w = _moved_by_mode(scene, work, i, j)
        columns.found[body.first_deta + j, column] += dot(v, own) + dot(w, turning)


@kernel
def _hand_to_ground(columns: Columns, i: int, f: Vector, n: Vector, column: int) -> None:
    """Write what a wrench on a link does along all speeds between the link and the ground, and the same as a row."""
    links, frames, found = links_of(columns.scene), columns.work.frames, columns.found
    while i >= 0:
        link, frame = links[i], frames[i]
        if link.kind == Kind.INTERFACE:
            body = bodies_of(columns.scene, columns.work)[link.flexible]
            first, count = body.first_deta, body.k
            _add_to_modes(columns, i, f, n, column)
        else:
            first, count = link.speed, _add_to_joint(link, frame, frames[link.parent], f, n, found[:, column])
        for s in range(first, first + count):
            found[column, s] = found[s, column]
        n += cross(frame.r, f)
        i = link.parent


@inlined
def _add_to_joint(link: Link, frame: Frame, parent: Frame, f: Vector, n: Vector, along: np.ndarray) -> int:
    """Write what a wrench on a link does along the speeds of its joint; return how many these are."""
    kind, speed = link.kind, link.speed
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
