"""Forces and torques on rows, and distributed loads on flexible bodies (Eq. 11, 30, 35)."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import Array, One, Record, Rows, Start, inlined, kernel, vector_kernel
from kanefe.kernels.scene import Scene, State, Work, bodies_of, links_of
from kanefe.kernels.sweeps.elastic import combined, total, transposed_product
from kanefe.kernels.tree import Frame, Frames, InterfaceFrame, InterfaceLink, Kind
from kanefe.kernels.values.tensors import Matrix, Vector, cross, dot


class PointLoad(Record):
    """A force or a torque."""

    row: int
    first_input: int
    is_torque: bool
    follows: bool
    point: Vector  # where it acts in its row, and of one that follows its axes to those of the row
    axes: Matrix


class PointLoads(Rows[PointLoad]):
    """All of them: of `Tables.loads` and `Tables.points`."""


class FieldLoad(Record):
    """A distributed load."""

    body: int  # flexible body, and how many modes it has
    mode_count: int
    first_input: int
    is_pressure: bool
    follows: bool


class Pressure(FieldLoad):
    """A pressure."""

    constants: Annotated[int, Start("pool")]  # where what follows begins in the pool
    force: Annotated[Vector, One(Vector)]  # of a unit of it, in G
    moment: Annotated[Vector, One(Vector)]
    shares: Annotated[np.ndarray, Array("mode_count")]  # (k,): on the modes
    changes: Annotated[int, Start("pool")]  # where their change with the modes begins in the pool; -1: there is none
    resultants: Annotated[np.ndarray, Array(6, "mode_count")]  # (6, k): of force and moment
    stiffness: Annotated[np.ndarray, Array("mode_count", "mode_count")]  # (k, k): of the shares


class Traction(FieldLoad):
    """A traction, or a line load."""

    constants: Annotated[int, Start("pool")]  # where what follows begins in the pool
    size: Annotated[float, One(float)]  # area or length
    first: Annotated[Vector, One(Vector)]  # its first moment, in G
    basis: Annotated[np.ndarray, Array(3, "mode_count")]  # (3, k): how the modes change that
    changes: Annotated[int, Start("pool")]  # where second-order moments begin in the pool; -1: there are none
    moments: Annotated[np.ndarray, Array("mode_count", "3mode_count")]  # (k, 3 k)
    bent: Annotated[int, Start("modal")]  # where their workspace is in the modal work
    bending: Annotated[np.ndarray, Array(3, "mode_count")]  # (3, k)


class Tractions(Rows[Traction]):
    """All distributed loads: of `FlexibleTables.fields`, `FlexibleTables.pool` and the modal work."""


@inlined
def push_frame(frame: Frame, force: Vector, moment: Vector) -> None:
    """Apply a force and a moment, about the row's origin in N, to a row that carries them."""
    frame.f -= force
    frame.n -= moment


@inlined
def push(scene: Scene, work: Work, i: int, force: Vector, moment: Vector) -> None:
    """Apply a force and a moment, about the row's origin in N, to a row; i = -1 is N, which does not move."""
    if i < 0:
        return
    link, frame = links_of(scene)[i], work.frames[i]
    if link.kind == Kind.INTERFACE and not link.carries:
        body = bodies_of(scene, work)[link.flexible]
        share_of_modes(scene, work.frames, work.modal, i, (force, moment), body.p)
        push_frame(work.frames[link.parent], force, moment + cross(frame.r, force))
    else:
        push_frame(frame, force, moment)


@inlined
def wrench_on_slopes(scene: Scene, frames: Frames, i: int, wrench: tuple[Vector, Vector]) -> tuple[Vector, Vector]:
    """Return a force in N on an interface in G, and a moment as it acts on the rates of its slopes."""
    back = frames[links_of(scene)[i].parent].R.T
    return back @ wrench[0], InterfaceFrame(frames[i]).tangent.T @ (back @ wrench[1])


@kernel
def share_of_modes(
    scene: Scene, frames: Frames, modal: np.ndarray, i: int, wrench: tuple[Vector, Vector], p: np.ndarray
) -> None:
    """Add the share of the modes in what acts on an interface, force and moment in N, to the forces p on them."""
    k, link, (force, moment) = len(p), InterfaceLink(links_of(scene)[i]), wrench_on_slopes(scene, frames, i, wrench)
    if link.bent < 0:
        _add_share(scene.flexible.pool[link.basis : link.basis + 6 * k].reshape(6, k), force, moment, p)
    else:
        _add_share(modal[link.bent : link.bent + 6 * k].reshape(6, k), force, moment, p)


@vector_kernel
def _add_share(basis: np.ndarray, a: Vector, b: Vector, p: np.ndarray) -> None:
    for j in range(len(p)):
        p[j] += (
            basis[0, j] * a.x
            + basis[1, j] * a.y
            + basis[2, j] * a.z
            + basis[3, j] * b.x
            + basis[4, j] * b.y
            + basis[5, j] * b.z
        )


@vector_kernel
def _add_shares(basis: np.ndarray, a: Vector, p: np.ndarray) -> None:
    for j in range(len(p)):
        p[j] += basis[0, j] * a.x + basis[1, j] * a.y + basis[2, j] * a.z


@inlined
def point_loads_of(scene: Scene) -> PointLoads:
    """Return all forces and torques."""
    return PointLoads(scene.tables.loads, scene.tables.points)


@inlined
def point_load(load: PointLoad, inputs: np.ndarray, frame: Frame) -> tuple[Vector, Vector]:
    """Return a force and its moment about the origin of its row, or a torque, in N."""
    value, none = three(inputs, load.first_input), 0.0 * frame.p
    value = frame.R @ (load.axes @ value) if load.follows else value + none
    return (none, value) if load.is_torque else (value, cross(frame.R @ load.point, value))


@inlined
def add_point_loads(scene: Scene, state: State, work: Work) -> Any:
    """Apply forces and torques; return their power."""
    power, loads = 0.0 * work.frames[0].p.x, point_loads_of(scene)
    for n in range(len(loads)):
        frame = work.frames[loads[n].row]
        force, moment = point_load(loads[n], state.inputs, frame)
        power += dot(force, frame.v) + dot(moment, frame.w)
        push(scene, work, loads[n].row, force, moment)
    return power


@inlined
def add_field_loads(scene: Scene, state: State, work: Work) -> Any:
    """Apply tractions, line loads and pressures; return their power."""
    power, flexible = 0.0 * work.frames[0].p.x, scene.flexible
    loads, bodies = Tractions(flexible.fields, flexible.pool, work.modal), bodies_of(scene, work)
    for n in range(len(loads)):
        load, body = loads[n], bodies[loads[n].body]
        frame = work.frames[body.link]
        if load.is_pressure:
            pressure, own = state.inputs[load.first_input], Pressure(load)
            force, moment = own.force + 0.0 * frame.p, own.moment + 0.0 * frame.p
            for j in range(body.k):
                body.p[j] += pressure * own.shares[j]
            power += pressure * total(own.shares, body.deta)
            if own.changes >= 0:
                force += combined(own.resultants, 0, body.eta)
                moment += combined(own.resultants, 3, body.eta)
                power += _follow(pressure, own.stiffness, body.eta, body.deta, body.p)
            force, moment = pressure * force, pressure * moment
        else:
            t = three(state.inputs, load.first_input) + 0.0 * frame.p
            t = t if load.follows else frame.R.T @ t
            force, (place, rate) = load.size * t, moved_by_modes(load, body.eta, body.deta)
            _add_shares(load.basis, t, body.p)
            if load.changes >= 0:
                _add_shares(load.bending, t, body.p)
            moment = cross(place, t)
            power += dot(t, rate)
        force, moment = frame.R @ force, frame.R @ moment
        power += dot(force, frame.v) + dot(moment, frame.w)
        push_frame(frame, force, moment)
    return power


@kernel
def _follow(pressure: Any, stiffness: np.ndarray, eta: np.ndarray, deta: np.ndarray, p: np.ndarray) -> Any:
    """Add what a pressure that follows its surface gains as the modes deform it to the forces p; return its power."""
    power = 0.0 * p.dtype.type(0.0)
    for j in range(len(p)):
        force = pressure * total(stiffness[j], eta)
        p[j] += force
        power += force * deta[j]
    return power


@inlined
def moved_by_modes(load: Traction, eta: np.ndarray, deta: np.ndarray) -> tuple[Vector, Vector]:
    """Return the first moment of what a traction acts on as the modes have displaced it, and its rate, in G."""
    place, rate = load.first + combined(load.basis, 0, eta), combined(load.basis, 0, deta)
    if load.changes >= 0:
        transposed_product(load.moments, 0, eta, load.bending.reshape(3 * load.mode_count))
        place, rate = place + 0.5 * combined(load.bending, 0, eta), rate + combined(load.bending, 0, deta)
    return place, rate
