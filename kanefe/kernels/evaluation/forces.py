"""All forces of states of a run: of joints, drives, loops and loads, and at interfaces of flexible bodies.

Accelerations and multipliers are those of an evaluation. With them the balance of each body, Newton's and Euler's
equations, gives the wrench of its joint in one inward sweep; no system is solved again. Forces along components that
are fixed in G follow from the wrench on the body by virtual work (Eq. 31-35).
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Integers, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.constraints.loop_tables import factors_in, holds, row_work_in, rows_of, unit_responses_in
from kanefe.kernels.constraints.row_wrenches import push_row, write_rows
from kanefe.kernels.constraints.told_shares import told_multipliers
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import AT_TIME, DONE_AS, LEAST_PIVOT, add_forces
from kanefe.kernels.evaluation.force_tables import ForceMemory, ForceTables, ForceWork, ToldForces, forces_in
from kanefe.kernels.evaluation.told_contacts import tell_contacts
from kanefe.kernels.evaluation.told_forces import hold_components, tell_gears, tell_joints, tell_loops, tell_parts
from kanefe.kernels.force_elements.places import Done, Ends, Wrenches
from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.joints.handing import hand_force_inward
from kanefe.kernels.language import call_address, copy, entry, expanded, inlined, kernel
from kanefe.kernels.loads.acting import acting_in, loads_of
from kanefe.kernels.loads.loads_between import apply_load, evaluate_alone
from kanefe.kernels.loads.points import push_points
from kanefe.kernels.loads.reach import find_near
from kanefe.kernels.scene import Rates, Scene, State, Work, bodies_of, links_of, rates_in, state_in, work_in
from kanefe.kernels.steppers.step_commands import RATES, VECTOR
from kanefe.kernels.sweeps.elastic import combination
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward, with_rates
from kanefe.kernels.tables import Loops
from kanefe.kernels.tree import Kind
from kanefe.kernels.values.tensors import ZERO, dot


class Evaluated(NamedTuple):
    """An evaluation of a scene, whose memory is looked into.

    Attributes
    ----------
    call : Prepared
        Of `kanefe.kernels.evaluation.evaluation.evaluate`, not implicit, with all that follows.
    scene : Scene
    drives, inputs, vectors, memory : ndarray
    """

    call: Prepared
    scene: Scene
    drives: RealRows
    inputs: Reals
    vectors: RealRows
    memory: Reals


class States(NamedTuple):
    """States of which forces are told.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s.
    driven : ndarray, shape (T, driven, 3)
    values : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    rates : ndarray, shape (T or 0, state and quadratures)
        Their rates, of scenes without constraints: none are computed here.
    """

    times: Reals
    driven: RealBlocks
    values: RealRows
    states: RealRows
    rates: RealRows


@entry()
def forces_of_states(
    scene: Scene,
    forces: ForceTables,
    evaluated: Evaluated,
    told: States,
    found: RealRows,
    is_told: Integers,
    memory: Reals,
) -> None:
    """Write rates and forces of all of some states.

    Parameters
    ----------
    scene : Scene
        With a row for each body and each interface.
    forces : ForceTables
    evaluated : Evaluated
    told : States
    found : ndarray, shape (T, width)
        `ToldForces` of each.
    is_told : ndarray of int, shape (T,)
        1, or 0 where the literal route has to tell: near singular positions, and where rows depend on each other, so
        that several multipliers do the same; of those of rigid contacts where `told_multipliers` does not know them.
    memory : ndarray, shape (`force_memory_size`,)
    """
    own, vectors, drives = forces_in(memory, scene, forces), evaluated.vectors, evaluated.drives
    multipliers = work_in(evaluated.scene, evaluated.memory).multipliers
    size = len(vectors[VECTOR.at]) - len(own.own.powers)
    for k in range(len(told.states)):
        copy(told.states[k, :size], vectors[VECTOR.at, :size])
        copy(told.values[min(k, len(told.values) - 1)], evaluated.inputs)
        for i in range(len(drives)):
            copy(told.driven[k, i], drives[i])
        state = state_in(scene.tables, told.times[k], vectors[VECTOR.at], drives, evaluated.inputs)
        is_told[k] = 0
        if len(told.rates) > 0:
            copy(told.rates[k], vectors[VECTOR.slope])
        else:
            vectors[VECTOR.at, size:] = 0.0
            evaluated.call.numbers[AT_TIME] = told.times[k]
            call_address(evaluated.call.address, (evaluated.call.places, evaluated.call.numbers))
            if not has_all_forces(evaluated, state.z):
                continue
        row = ToldForces(forces.told, found[k])
        copy(vectors[VECTOR.slope], row.rates)
        is_told[k] = 1
        copy(multipliers, own.work.multipliers)
        put_forces(scene, forces, state, rates_in(scene.tables, vectors[VECTOR.slope]).du, own, row)


@inlined
def has_all_forces(evaluated: Evaluated, z: np.ndarray) -> bool:
    """Return whether an evaluation knows all multipliers."""
    scene, numbers = evaluated.scene, evaluated.call.numbers
    loops, work = scene.loops, work_in(scene, evaluated.memory)
    if numbers[DONE_AS] != RATES or numbers[LEAST_PIVOT] < NEAR_SINGULAR:
        return False
    if len(loops.points.places) > 0:
        return told_multipliers(loops, z, work.multipliers, unit_responses_in(work.holding, loops))
    return are_independent(loops, z, work.multipliers, factors_in(work.holding, loops).scale)


@inlined
def are_independent(loops: Loops, z: np.ndarray, multipliers: np.ndarray, scale: np.ndarray) -> bool:
    """Return whether no row depends on others: the multiplier of such a row is left out, and so is zero."""
    left_out = 0
    for j in range(len(multipliers)):
        if multipliers[j] == 0.0 and scale[j] != 0.0 and holds(rows_of(loops)[j], z):
            left_out += 1
    return left_out == 0


@expanded
def put_forces(
    scene: Scene, forces: ForceTables, state: State, du: np.ndarray, memory: ForceMemory, told: ToldForces
) -> None:
    """Write the forces of a state whose accelerations and multipliers are known."""
    loops, work, moving, own, multipliers = scene.loops, memory.work, memory.moving, memory.own, memory.work.multipliers
    sweep_outward(scene, state, work, False)
    set_inertia(scene, work)
    add_forces(scene, state, work, Rates(du, du, own.load_rates, own.powers))
    if len(scene.between.loads) > 0:
        add_and_tell_loads(scene, state, work, own, told.ends)
    exerted = row_work_in(own.exerted, loops)
    write_rows(scene, state, work, exerted)
    for j in range(len(multipliers)):
        if multipliers[j] != 0.0:
            push_row(scene, work, exerted, j, multipliers[j], True)
    sweep_outward(scene, with_rates(state, du, moving.still), moving, False)
    add_inertia_forces(scene, work, moving)
    sum_inward(scene, work, told.driving)
    tell_joints(forces, work, told.reactions)
    tell_loops(scene, forces, work, exerted, told.loops)
    tell_gears(forces, multipliers, told.gears)
    for h in range(len(forces.held)):
        hold_components(scene, forces, work, own, h)
    tell_parts(scene, forces, state, work, own, told)
    if len(loops.points.places) > 0:
        tell_contacts(scene, state, work, exerted, told.contacts, told.points)


@expanded
def add_and_tell_loads(scene: Scene, state: State, work: Work, own: ForceWork, told: Wrenches) -> None:
    """Apply loads between frames one by one, and write what each does on its ends, in N, and where these are."""
    loads, acting, points = loads_of(scene), acting_in(scene, work), own.points
    ends, wrenches = Ends(acting.ends), Wrenches(Done(acting.done).wrenches)
    find_near(scene, work)
    for e in range(len(told)):
        told[e].force, told[e].moment, points[e] = ZERO, ZERO, ZERO
    for n in range(len(loads)):
        load = loads[n]
        if acting.nearness[n] <= 0.0:
            continue
        evaluate_alone(scene, state, work, n)
        for e in range(load.end_count):
            at = load.first_end + e
            told[at].force, told[at].moment, points[at] = wrenches[e].force, wrenches[e].moment, ends[e].p
        apply_load(scene, work, n, n, own.load_rates)
        push_points(scene, work, load.team, n, n + 1)


@kernel
def add_inertia_forces(scene: Scene, work: Work, moving: Work) -> None:
    """Add what du needs to the forces of all rows; velocities of `moving` are accelerations (Eq. 15, 16)."""
    links, frames, moves = links_of(scene), work.frames, moving.frames
    bodies, rates = bodies_of(scene, work), bodies_of(scene, moving)
    for i in range(len(links)):
        link, frame, moved = links[i], frames[i], moves[i]
        if link.kind == Kind.INTERFACE or (link.flexible < 0 and link.mass == 0.0):
            continue
        frame.f += frame.M @ moved.v + frame.H @ moved.w
        frame.n += frame.H.T @ moved.v + frame.J @ moved.w
        if link.flexible >= 0 and bodies[link.flexible].k > 0:
            body, ddeta, G = bodies[link.flexible], rates[link.flexible].deta, frame.R
            frame.f += G @ combination(body.linear, ddeta)
            frame.n += G @ combination(body.angular, ddeta)


@kernel
def sum_inward(scene: Scene, work: Work, driving: np.ndarray) -> None:
    """Hand the forces that rows need to what carries them, and write what drives give beyond what is applied."""
    links, frames, applied = links_of(scene), work.frames, work.applied
    for i in range(len(links) - 1, -1, -1):
        link, frame = links[i], frames[i]
        if link.drive >= 0:
            v, w = partials(link, frame)
            driving[link.drive] = dot(v, frame.f) + dot(w, frame.n) - applied[link.speed]
        if link.parent >= 0:
            hand_force_inward(frames[link.parent], frame.r, frame.f, frame.n)
