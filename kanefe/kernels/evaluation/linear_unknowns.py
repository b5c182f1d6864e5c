"""Unknowns of the linearised equations of a tree, how rows move beside a state, and what they need by themselves."""

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.evaluation.derivatives import COMPLEX_STEP
from kanefe.kernels.evaluation.evaluation import add_forces
from kanefe.kernels.joints.by_kind import move, partials
from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import IntegerRows, Integers, Reals, Record, Rows, inlined, kernel
from kanefe.kernels.loads.point_and_field_loads import share_of_modes
from kanefe.kernels.scene import Rates, Scene, State, Work, bodies_of, links_of
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.sweeps.elastic import combination
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import move_interface
from kanefe.kernels.tree import Frame, InterfaceLink, Kind, Link, Motion
from kanefe.kernels.values.tensors import IDENTITY, Vector, cross, dot, skew


class Size(IntEnum):
    """How many numbers there are of a motion x and of a need y."""

    MOTION = 18
    NEED = 6


class Part(IntEnum):
    """Vectors of a motion, in their order."""

    TURN = 0
    PLACE = 1
    VELOCITY = 2
    SPIN = 3
    PULL = 4
    TWIST = 5


class Motions(Rows[Motion]):
    """Motions of all rows, and of the ground, one behind the other in a list."""


class Need(Record):
    """Force and moment about its origin that a row needs from its parent, N."""

    f: Vector
    n: Vector


class Needs(Rows[Need]):
    """Those of all rows."""


class Place(Record):
    """Where the unknowns of a row are.

    Attributes
    ----------
    motion, need : int
        First of x and of y.
    joint, modes : int
        How many free speeds its joint has, and the modes of its body.
    turns : bool
        Whether forces on it alone stay where they are when it turns: a weight that is not its own motion's, loads in N.
    first_load, loads : int
        Of `Unknowns.inner`.
    """

    motion: int
    need: int
    joint: int
    modes: int
    turns: bool
    first_load: int
    loads: int


class Places(Rows[Place]):
    """Those of all rows."""


class Unknowns(NamedTuple):
    """Where all unknowns are.

    Attributes
    ----------
    places : ndarray of int, shape (rows, 7)
        `Places`.
    coordinates, speeds, states : ndarray of int
        Of z, du, and internal states.
    inner : ndarray of int
        Loads between a row and its parent, by rows: what they do depends on how the one moves seen from the other.
    is_inner : ndarray of int, shape (loads,)
    """

    places: IntegerRows
    coordinates: Integers
    speeds: Integers
    states: Integers
    inner: Integers
    is_inner: Integers


class Entries(NamedTuple):
    """Entries of a matrix in the order in which they are found, which is always the same.

    Attributes
    ----------
    found : ndarray of int, shape (1,)
        How many there are; those beyond the lengths of the others are not written.
    rows, columns, values : ndarray
    """

    found: Integers
    rows: Integers
    columns: Integers
    values: Reals


class Linearised(NamedTuple):
    """What a linearisation works with.

    Attributes
    ----------
    scene, state, work, rates
    unknowns : Unknowns
    kept : Motions
        With the accelerations in place of the remainders.
    needs, felt : Needs
        As they are, and turned with the row where it is displaced by its own coordinates.
    known, masses : Entries
    """

    scene: Scene
    state: State
    work: Work
    rates: Rates
    unknowns: Unknowns
    kept: Motions
    needs: Needs
    felt: Needs
    known: Entries
    masses: Entries


@kernel
def put_entry(entries: Entries, row: int, column: int, value: float) -> None:
    """Put an entry behind the others."""
    k = entries.found[0]
    if k < len(entries.values):
        entries.rows[k], entries.columns[k], entries.values[k] = row, column, value
    entries.found[0] = k + 1


@inlined
def put_changes(entries: Entries, row: int, column: int, x: Vector, share: float) -> None:
    """Put what a displacement changes of a vector into three rows of its column."""
    share = share / COMPLEX_STEP
    put_entry(entries, row, column, share * x.x.imag)
    put_entry(entries, row + 1, column, share * x.y.imag)
    put_entry(entries, row + 2, column, share * x.z.imag)


@inlined
def unit_vector(c: int) -> Vector:
    """Return a unit vector along an axis."""
    return Vector(1.0 * (c == 0), 1.0 * (c == 1), 1.0 * (c == 2))


@inlined
def component_of(x: Vector, c: int) -> Any:
    """Return a component of a vector."""
    return x.x if c == 0 else (x.y if c == 1 else x.z)


@inlined
def displace(motion: Motion, c: int) -> None:
    """Displace one of the 18 numbers of a motion."""
    along, group = complex(0.0, COMPLEX_STEP) * unit_vector(c % 3), c // 3
    if group == Part.TURN:  # all that moves with the row turns with it
        motion.R = motion.R + skew(along) @ motion.R
        motion.v, motion.w = motion.v + cross(along, motion.v), motion.w + cross(along, motion.w)
        motion.Z, motion.Y = motion.Z + cross(along, motion.Z), motion.Y + cross(along, motion.Y)
    elif group == Part.PLACE:
        motion.p = motion.p + along
    elif group == Part.VELOCITY:
        motion.v = motion.v + along
    elif group == Part.SPIN:
        motion.w = motion.w + along
    elif group == Part.PULL:
        motion.Z = motion.Z + along
    else:
        motion.Y = motion.Y + along


@inlined
def restore(motion: Motion, kept: Motion) -> None:
    """Take displacements off a motion."""
    motion.R, motion.r, motion.p = kept.R, kept.r, kept.p
    motion.v, motion.w, motion.Z, motion.Y = kept.v, kept.w, kept.Z, kept.Y


@kernel
def restore_all(given: Linearised) -> None:
    """Take displacements off the motions of all rows."""
    frames = given.work.frames
    for i in range(len(frames) - 1):
        restore(frames[i], given.kept[i])


@inlined
def vector_of(motion: Motion, kept: Motion, group: int) -> Vector:
    """Return one of the six vectors of a motion: of a turn that of its displacement, others without what it does."""
    turned = motion.R @ kept.R.T
    turn = Vector(turned.y.z, turned.z.x, turned.x.y)
    if group == Part.TURN:
        return turn
    if group == Part.PLACE:
        return motion.p
    if group == Part.VELOCITY:
        return motion.v - cross(turn, kept.v)
    if group == Part.SPIN:
        return motion.w - cross(turn, kept.w)
    return motion.Z - cross(turn, kept.Z) if group == Part.PULL else motion.Y - cross(turn, kept.Y)


@kernel
def set_real(given: Linearised) -> None:
    """Take displacements off the state."""
    q, u = given.state.q, given.state.u
    for i in range(len(q)):
        q[i] = q[i].real
    for i in range(len(u)):
        u[i] = u[i].real


@inlined
def own_speed(given: Linearised, i: int, c: int) -> int:
    """Return the speed number c of a row, of its joint or its modes; of an interface those of its body; -1: none."""
    link, places = links_of(given.scene)[i], Places(given.unknowns.places)
    place = places[link.parent] if link.kind == Kind.INTERFACE else places[i]
    if c < place.joint:
        return -1 if link.kind == Kind.INTERFACE else link.speed + c
    if c < place.joint + place.modes:
        return int(bodies_of(given.scene, given.work)[link.flexible].first_deta + c - place.joint)
    return -1


def own_size(rows: int) -> int:
    """Return how long the own memory of a linearisation is."""
    return (rows + 1) * (Motion.number_count + 2 * Need.number_count)


@kernel
def move_row(given: Linearised, i: int) -> None:
    """Write the motion of a row by its parent's, with accelerations in place of the remainders."""
    scene, state, work, du = given.scene, given.state, given.work, given.rates.du
    link, frame, ground = links_of(scene)[i], work.frames[i], work.frames[-1]
    parent = work.frames[link.parent]
    if link.kind == Kind.INTERFACE:
        body, own = bodies_of(scene, work)[link.flexible], InterfaceLink(link)
        # velocities that the accelerations of the modes would cause
        _exchange(body.deta, body.x)
        ground.R = parent.R
        move_interface(scene.flexible, body, own, frame, ground, work.modal)
        Z, Y = frame.v, frame.w
        _exchange(body.deta, body.x)
        ground.R = IDENTITY
        move_interface(scene.flexible, body, own, frame, parent, work.modal)
        frame.Z, frame.Y = frame.Z + Z, frame.Y + Y
        return
    move(link, frame, parent, state, scene.tables.numbers)
    kind, speed = link.kind, link.speed
    if kind == Kind.SPHERICAL:
        frame.Y = frame.Y + frame.R @ three(du, speed)
    elif kind == Kind.FREE:
        frame.Z = frame.Z + parent.R @ (link.axes @ three(du, speed))
        frame.Y = frame.Y + frame.R @ three(du, speed + 3)
    elif kind != Kind.FIXED and link.drive < 0:
        v, w = partials(link, frame)
        frame.Z, frame.Y = frame.Z + du[speed] * v, frame.Y + du[speed] * w


@kernel
def _exchange(a: np.ndarray, b: np.ndarray) -> None:
    for i in range(len(a)):
        a[i], b[i] = b[i], a[i]


@inlined
def along_joint(link: Link, frame: Frame, parent: Frame, need: tuple[Vector, Vector], c: int) -> Any:
    """Return what force and moment do along a speed of the joint of a link."""
    f, n = need
    if link.kind == Kind.SPHERICAL:
        return component_of(frame.R.T @ n, c)
    if link.kind == Kind.FREE:
        if c < 3:
            return component_of(link.axes.T @ (parent.R.T @ f), c)
        return component_of(frame.R.T @ n, c - 3)
    v, w = partials(link, frame)
    return dot(v, f) + dot(w, n)


@kernel
def exert(given: Linearised, has_shares: bool) -> None:
    """Write force and moment that each row needs by itself, forces on modes and along joints; no loads between.

    With shares also what interfaces need of the modes of their bodies.
    """
    scene, work, bodies = given.scene, given.work, bodies_of(given.scene, given.work)
    links = links_of(scene)
    set_inertia(scene, work)
    add_forces(scene, given.state, work, given.rates)
    for f in range(len(bodies)):
        body = bodies[f]
        if body.k > 0:
            frame = work.frames[body.link]
            frame.f += frame.R @ combination(body.linear, body.x)
            frame.n += frame.R @ combination(body.angular, body.x)
    for i in range(len(links)):
        if has_shares and links[i].kind == Kind.INTERFACE:
            need, body = given.felt[i], bodies[links[i].flexible]
            share_of_modes(scene, work.frames, work.modal, i, (-need.f, -need.n), body.p)


@kernel
def displace_own(given: Linearised, moves: np.ndarray, c: int, is_speed: bool) -> None:
    """Displace the coordinates, along the speeds, or the speeds of number c of all rows."""
    q, u, links, number = given.state.q, given.state.u, links_of(given.scene), given.work.added
    set_real(given)
    number[:] = 0.0
    for i in range(len(links)):
        if links[i].kind != Kind.INTERFACE:
            speed = own_speed(given, i, c)
            if speed >= 0:
                number[speed] = COMPLEX_STEP
    for k in range(len(moves)):
        at, speed = moves[k, 1], moves[k, 2]
        if is_speed:
            for s in range(speed, speed + (1 if moves[k, 0] == STRAIGHT else 3)):
                u[s] += complex(0.0, number[s].real)
        elif moves[k, 0] == STRAIGHT:
            q[at] += complex(0.0, number[speed].real)
        else:
            e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
            half = complex(0.0, 0.5)
            x, y, z = half * number[speed], half * number[speed + 1], half * number[speed + 2]
            q[at], q[at + 1] = e0 - (e1 * x + e2 * y + e3 * z), e1 + e0 * x + e2 * z - e3 * y
            q[at + 2], q[at + 3] = e2 + e0 * y + e3 * x - e1 * z, e3 + e0 * z + e1 * y - e2 * x
