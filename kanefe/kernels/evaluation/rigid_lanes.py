"""One evaluation of several trees of rigid bodies at once, each a lane: of states, and of scenes that are alike.

Every number of a scene may be another in each lane; rows, kinds of joints and loads are the same. What is computed of a
lane is to the last bit what `kanefe.kernels.evaluation.evaluation.evaluate` computes of it alone.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Integers, RealBlocks, RealRows
from kanefe.kernels.joints.by_kind import accelerate, eliminate, hand_across, move, put_coordinate_rates
from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import dot, entry, is_there, kernel, lane_count, lanes_of
from kanefe.kernels.loads.coordinate_law import CoordinateLaws
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.loads.point_and_field_loads import PointLoads, point_load, push_frame
from kanefe.kernels.scene import Rates, State, Work, rates_in, state_in
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.kernels.sweeps.body_inertia import clear, put_rigid
from kanefe.kernels.sweeps.driving_forces import put_driving_forces, turn_driven_rotors
from kanefe.kernels.sweeps.inertia import take_gravity_off
from kanefe.kernels.sweeps.outward import put_ground
from kanefe.kernels.tables import Tables
from kanefe.kernels.tree import Frames, Links
from kanefe.kernels.values.tensors import Vector


class LaneTables(NamedTuple):
    """Scenes that are alike: see `Tables`; the last axis of arrays is that of the lanes.

    Attributes
    ----------
    tables : Tables
        Of one of them, for its whole numbers.
    work : ndarray of int
        The whole numbers of its `Work`.
    geometry, gravity, points, laws : ndarray, shape (..., lanes)
    """

    tables: Tables
    work: Integers
    geometry: RealBlocks
    gravity: RealRows
    points: RealBlocks
    laws: RealBlocks


@entry()
def lanes_here() -> int:
    """Return how many lanes an evaluation has."""
    return lane_count()


@entry()
def evaluate_lanes(
    scene: LaneTables, drives: RealBlocks, inputs: RealRows, vectors: RealBlocks, memory: RealRows
) -> bool:
    """Evaluate dy/dt of each lane; return whether every joint of all has inertia along it.

    Parameters
    ----------
    scene : LaneTables
    drives, inputs : ndarray, shapes (driven, 3, lanes), (inputs, lanes)
        See `State`.
    vectors : ndarray, shape (2, state, lanes)
        The states and, on return, their rates.
    memory : ndarray, shape (`Work.size`, lanes)
    """
    tables, of_lanes, work = scene.tables, lanes_of(vectors), Work(scene.work, lanes_of(memory))
    state = state_in(tables, 0.0, of_lanes[VECTOR.at], lanes_of(drives), lanes_of(inputs))
    rates, links = rates_in(tables, of_lanes[VECTOR.slope]), Links(tables.rows, lanes_of(scene.geometry))
    frames, applied, gravity = work.frames, work.applied, three(lanes_of(scene.gravity), 0)
    for i in range(len(links)):
        put_coordinate_rates(links[i], state.q, state.u, rates.dq)
    _sweep_outward(links, frames, state, gravity, tables.numbers)
    _put_inertia(links, frames, gravity)
    _add_forces(scene, links, state, work, rates)
    is_regular = _sweep_inward(links, frames, applied, work.added)
    for i in range(len(links)):
        accelerate(links[i], frames[i], frames[links[i].parent], applied, rates.du)
    if len(work.driving) > 0:
        put_driving_forces(links, frames, applied, work.driving)
    for i in range(len(state.drives)):
        rates.powers[1] += work.driving[i] * state.drives[i, 1]
    return is_regular


@kernel
def _sweep_outward(links: Links, frames: Frames, state: State, gravity: Vector, numbers: np.ndarray) -> None:
    """Write pose, velocity and remainder accelerations of all links."""
    put_ground(frames[-1], gravity)
    for i in range(len(links)):
        move(links[i], frames[i], frames[links[i].parent], state, numbers)


@kernel
def _put_inertia(links: Links, frames: Frames, gravity: Vector) -> None:
    """Write inertia, force and moment of all rows."""
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        if is_there(link.mass):
            put_rigid(frame, link.mass, link.first, link.second, link.rotor)
            if not link.has_gravity:
                take_gravity_off(frame, link.mass, gravity)
        else:
            clear(frame)


@kernel
def _add_forces(scene: LaneTables, links: Links, state: State, work: Work, rates: Rates) -> None:
    """Add forces on rows and along joints; write their powers."""
    tables, frames, applied = scene.tables, work.frames, work.applied
    applied[:] = 0.0
    rates.dz[:] = 0.0
    power, loads = 0.0 * frames[0].p.x, PointLoads(tables.loads, lanes_of(scene.points))
    for n in range(len(loads)):
        frame = frames[loads[n].row]
        force, moment = point_load(loads[n], state.inputs, frame)
        power += dot(force, frame.v) + dot(moment, frame.w)
        if loads[n].row >= 0:
            push_frame(frame, force, moment)
    rates.powers[1] = power
    laws = CoordinateLaws(lanes_of(scene.laws))
    dissipated, motors = add_joint_forces(tables.joint_forces, laws, state, applied)
    rates.powers[0] = dissipated
    rates.powers[1] += motors
    if len(state.drives) > 0:
        turn_driven_rotors(links, state.drives, applied)


@kernel
def _sweep_inward(links: Links, frames: Frames, applied: np.ndarray, added: np.ndarray) -> bool:
    """Eliminate all rows, children before parents; return whether every joint has inertia along it."""
    is_regular = True
    for i in range(len(links) - 1, -1, -1):
        link, frame = links[i], frames[i]
        is_regular = eliminate(link, frame, applied, False, added) and is_regular
        if link.parent >= 0:
            hand_across(link, frame, frames[link.parent], applied)
    return is_regular
