"""All forces of states of a run: of joints, drives, loops and loads, and at interfaces of flexible bodies.

Accelerations and multipliers are those of an evaluation. With them the balance of each body, Newton's and Euler's
equations, gives the wrench of its joint in one inward sweep; no system is solved again. Forces along components that
are fixed in G follow from the wrench on the body by virtual work (Eq. 31-35).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    copy,
    cross,
    dot,
    matrix,
    minus,
    plus,
    product,
    put,
    put_three,
    rotated,
    rotated_back,
    symmetric,
    symmetric_times,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import expanded, inlined, kernel
from kanefe.kernels.compiler.arrays import Integers, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import Variant
from kanefe.kernels.constraints.loop_tables import (
    FORCE_B,
    MOMENT_B,
    ROW_A,
    ROW_B,
    Loops,
    UnitResponses,
    holds,
    unit_responses_in,
)
from kanefe.kernels.constraints.multipliers import push_row, write_row
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import AT_TIME, DONE_AS, IS_ERROR, LEAST_PIVOT
from kanefe.kernels.evaluation.force_tables import (
    AT_ROW,
    COMPONENT,
    DRIVING,
    ENDS,
    FIRST_SOURCE,
    LOOP_FORCES,
    OF_CARRIER,
    OF_CHILD,
    OF_LOAD,
    OF_LOOP,
    PART_ROW,
    PARTS,
    REACTIONS,
    SOURCE_COUNT,
    WRENCH,
    ForceTables,
    ForceWorkspace,
    force_workspace,
)
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCHES, P
from kanefe.kernels.layout import (
    BASIS,
    BENT,
    COORDINATES,
    COUNT,
    DRIVE,
    FLEXIBLE,
    FORCE,
    INTERFACE,
    KIND,
    MASS,
    MOMENT,
    OFFSET,
    OMEGA,
    PARENT,
    POSITION,
    SPEED,
    SPEEDS,
    STATES,
    TANGENT,
    VELOCITY,
    WORK_DETA,
    FlexibleTables,
    H,
    J,
    M,
    R,
    Tables,
)
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.loads.loads_between import apply_load, evaluate_load
from kanefe.kernels.loads.loads_layout import END_COUNT, FIRST_END, TEAM, LoadsBetween, place_of_load, span_of_load
from kanefe.kernels.loads.markers import axes_of, lever_of
from kanefe.kernels.loads.point_and_field_loads import add_field_loads, add_point_loads
from kanefe.kernels.loads.points import gather_points, push_points
from kanefe.kernels.loads.reach import find_near, nearness_at
from kanefe.kernels.steppers.step_commands import AT, RATES, SLOPE
from kanefe.kernels.sweeps.elastic import project, span
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.link_motion import partials
from kanefe.kernels.sweeps.modal_elimination import coupling_span
from kanefe.kernels.sweeps.outward import sweep_outward


@entry(Variant(has_flexible=True))
def forces_of_states(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
    forces: ForceTables,
    evaluation: Prepared,
    vectors: RealRows,
    drives: RealRows,
    inputs: Reals,
    multipliers: Reals,
    scale: Reals,
    times: Reals,
    driven: RealBlocks,
    values: RealRows,
    states: RealRows,
    found: RealRows,
    is_told: Integers,
    memory: Reals,
) -> None:
    """Write rates and forces of all of some states.

    Parameters
    ----------
    tables, flexible, between, loops, forces
        Of the scene with a row for each body and each interface.
    evaluation : Prepared
        A call of `kanefe.kernels.evaluation.evaluation.evaluate`, which is not implicit, with the next five arrays.
    vectors, drives, inputs : ndarray
        See there.
    multipliers, scale : ndarray, shape (m,)
        Of the constraints, and the scale of their rows, as the evaluation leaves them in its memory.
    times : ndarray, shape (T,)
        s.
    driven : ndarray, shape (T, driven, 3)
    values : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, width)
        See `ForceTables.places`.
    is_told : ndarray of int, shape (T,)
        1, or 0 where the literal route has to tell: near singular positions, and where rows depend on each other, so
        that several multipliers do the same.
    memory : ndarray, shape (`force_memory_size`,)
    """
    workspace = force_workspace(memory, tables, flexible, between, loops, forces)
    n = tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    last = m + tables.sizes[STATES]
    for k in range(len(states)):
        y, given = states[k, :last], values[min(k, len(values) - 1)]
        vectors[AT, :] = 0.0
        copy(y, vectors[AT, :last])
        copy(given, inputs)
        for i in range(len(drives)):
            copy(driven[k, i], drives[i])
        evaluation.numbers[AT_TIME] = times[k]
        call_address(evaluation.address, (evaluation.places, evaluation.numbers))
        copy(vectors[SLOPE], found[k, : vectors.shape[1]])
        is_told[k] = 0
        if evaluation.numbers[IS_ERROR] != 0.0 or evaluation.numbers[DONE_AS] != RATES:
            continue
        if evaluation.numbers[LEAST_PIVOT] < NEAR_SINGULAR or not are_independent(loops, y[m:], multipliers, scale):
            continue
        is_told[k] = 1
        put_forces(
            tables,
            flexible,
            between,
            loops,
            forces,
            times[k],
            drives,
            given,
            y,
            vectors[SLOPE, n:m],
            multipliers,
            workspace,
            found[k],
        )


@inlined
def are_independent(loops: Loops, z: np.ndarray, multipliers: np.ndarray, scale: np.ndarray) -> bool:
    """Return whether no row depends on others: the multiplier of such a row is left out, and so is zero."""
    left_out = 0
    for j in range(len(multipliers)):
        if multipliers[j] == 0.0 and scale[j] != 0.0 and holds(loops, j, z):
            left_out += 1
    return left_out == 0


@expanded
def put_forces(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
    forces: ForceTables,
    t: float,
    drives: np.ndarray,
    inputs: np.ndarray,
    y: np.ndarray,
    du: np.ndarray,
    multipliers: np.ndarray,
    workspace: ForceWorkspace,
    out: np.ndarray,
) -> None:
    """Write the forces of a state whose accelerations and multipliers are known."""
    work, moving, modal, modal_rates = workspace.work, workspace.moving, workspace.modal, workspace.modal_rates
    applied, still, n, speeds = workspace.applied, workspace.still, tables.sizes[COORDINATES], tables.sizes[SPEEDS]
    q, u, z = y[:n], y[n : n + speeds], y[n + speeds :]
    sweep_outward(tables, flexible, drives, q, u, work, modal)
    set_inertia(tables, flexible, work, modal)
    applied[:] = 0.0
    add_point_loads(tables, flexible, inputs, work, modal)
    add_joint_forces(tables, drives, inputs, q, u, applied)
    add_field_loads(flexible, inputs, work, modal)
    if len(between.loads) > 0:
        add_and_tell_loads(
            between,
            tables.rows,
            flexible,
            t,
            inputs,
            z,
            drives,
            q,
            u,
            work,
            modal,
            workspace,
            out[forces.places[ENDS] :],
        )
    kept = unit_responses_in(workspace.holding, loops, len(applied))
    for j in range(len(multipliers)):
        if multipliers[j] != 0.0:
            write_row(loops, j, tables.gravity, drives, z, speeds, work, kept)
            push_row(loops, tables, flexible, j, multipliers[j], True, kept, applied, work, modal)
    still[:, :] = 0.0
    for i in range(len(still)):
        still[i, 0] = drives[i, 0]
    sweep_outward(tables, flexible, still, q, du, moving, modal_rates)
    add_inertia_forces(tables, flexible, work, moving, modal, modal_rates)
    sum_inward(tables, applied, work, out[forces.places[DRIVING] :])
    tell_joints(forces, work, out[forces.places[REACTIONS] :])
    tell_loops(forces, loops, multipliers, work, kept, out[forces.places[LOOP_FORCES] :])
    for h in range(len(forces.held)):
        hold_components(forces, tables.rows, flexible, h, work, modal, workspace)
    tell_parts(tables, between, loops, forces, inputs, multipliers, work, kept, workspace, out)


@expanded
def add_and_tell_loads(
    between: LoadsBetween,
    rows: np.ndarray,
    flexible: FlexibleTables,
    t: float,
    inputs: np.ndarray,
    states: np.ndarray,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    workspace: ForceWorkspace,
    told: np.ndarray,
) -> None:
    """Apply loads between frames one by one, and write what each does on its ends, in N, and where these are."""
    acting, applied, rates, points = workspace.acting, workspace.applied, workspace.load_rates, workspace.points
    find_near(between.reach, flexible, work, modal, acting)
    nearness = acting[nearness_at(between.reach) :]
    told[: WRENCH * len(between.rows)] = 0.0
    points[:, :] = 0.0
    for i in range(len(between.loads)):
        if nearness[i] <= 0.0:
            continue
        team, first = between.loads[i, TEAM], between.loads[i, FIRST_END]
        gather_points(between, flexible, team, i, i + 1, work, modal, acting)
        evaluate_load(between, i, i, flexible, t, inputs, states, drives, q, u, work, acting)
        ends, done = acting[place_of_load(between) :], acting[span_of_load(between, i)]
        for e in range(between.loads[i, END_COUNT]):
            put(points, first + e, 0, three(ends, END_NUMBERS * e + P))
            for c in range(WRENCH):
                told[WRENCH * (first + e) + c] = done[WRENCHES + WRENCH * e + c]
        apply_load(between, i, i, rows, flexible, rates, applied, work, modal, acting)
        push_points(between, flexible, team, i, i + 1, modal, acting)


@kernel
def add_inertia_forces(
    tables: Tables,
    flexible: FlexibleTables,
    work: np.ndarray,
    moving: np.ndarray,
    modal: np.ndarray,
    modal_rates: np.ndarray,
) -> None:
    """Add what du needs to the forces of all rows; velocities of `moving` are accelerations (Eq. 15, 16)."""
    for i in range(len(tables.rows)):
        f = tables.rows[i, FLEXIBLE]
        if tables.rows[i, KIND] == INTERFACE or (f < 0 and tables.geometry[i, MASS] == 0.0):
            continue
        a, alpha, h = vector(moving, i, VELOCITY), vector(moving, i, OMEGA), matrix(work, i, H)
        accumulate(work, i, FORCE, plus(symmetric_times(symmetric(work, i, M), a), rotated(h, alpha)))
        accumulate(work, i, MOMENT, plus(rotated_back(h, a), symmetric_times(symmetric(work, i, J), alpha)))
        if f >= 0 and flexible.bodies[f, COUNT] > 0:
            body, G = flexible.bodies[f], matrix(work, i, R)
            coupling, ddeta = modal[coupling_span(body)].reshape(6, body[COUNT]), modal_rates[span(body, WORK_DETA)]
            accumulate(work, i, FORCE, rotated(G, project(coupling, 0, ddeta)))
            accumulate(work, i, MOMENT, rotated(G, project(coupling, 3, ddeta)))


@kernel
def sum_inward(tables: Tables, applied: np.ndarray, work: np.ndarray, driving: np.ndarray) -> None:
    """Hand the forces that rows need to what carries them, and write what drives give beyond what is applied."""
    rows, geometry = tables.rows, tables.geometry
    for i in range(len(rows) - 1, -1, -1):
        force, moment, parent = vector(work, i, FORCE), vector(work, i, MOMENT), rows[i, PARENT]
        if rows[i, DRIVE] >= 0:
            v, w = partials(rows, geometry, i, work)
            driving[rows[i, DRIVE]] = dot(v, force) + dot(w, moment) - applied[rows[i, SPEED]]
        if parent >= 0:
            accumulate(work, parent, FORCE, force)
            accumulate(work, parent, MOMENT, plus(moment, cross(vector(work, i, OFFSET), force)))


@kernel
def tell_joints(forces: ForceTables, work: np.ndarray, told: np.ndarray) -> None:
    """Write the wrench of each joint on its body, about the origin of the body's frame, in its axes."""
    for b in range(len(forces.bodies)):
        i = forces.bodies[b]
        axes, force = matrix(work, i, R), vector(work, i, FORCE)
        moment = minus(vector(work, i, MOMENT), cross(rotated(axes, vector(forces.frames, b, 0)), force))
        own = product(axes, matrix(forces.frames, b, 3))
        put_three(told, WRENCH * b, rotated_back(own, force))
        put_three(told, WRENCH * b + 3, rotated_back(own, moment))


@kernel
def tell_loops(
    forces: ForceTables,
    loops: Loops,
    multipliers: np.ndarray,
    work: np.ndarray,
    kept: UnitResponses,
    told: np.ndarray,
) -> None:
    """Write what each loop joint exerts on its end b, about the origin of b, in its axes."""
    for c in range(len(forces.loops)):
        force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        first = forces.loops[c, 0]
        row = loops.rows[first, ROW_B]
        lever, axes = (
            lever_of(loops.markers, 2 * first + 1, row, work),
            axes_of(loops.markers, 2 * first + 1, row, work),
        )
        for j in range(first, first + forces.loops[c, 1]):
            if multipliers[j] != 0.0:
                own = times(multipliers[j], vector(kept.wrenches, j, FORCE_B))
                turning = times(multipliers[j], vector(kept.wrenches, j, MOMENT_B))
                force, moment = plus(force, own), plus(moment, minus(turning, cross(lever, own)))
        put_three(told, WRENCH * c, rotated_back(axes, force))
        put_three(told, WRENCH * c + 3, rotated_back(axes, moment))


@kernel
def hold_components(
    forces: ForceTables,
    rows: np.ndarray,
    flexible: FlexibleTables,
    h: int,
    work: np.ndarray,
    modal: np.ndarray,
    workspace: ForceWorkspace,
) -> None:
    """Write the forces along the components of a body that are fixed in G, from the wrench on it.

    A displacement along one of them moves G and, against it, the modes, which are in balance: the wrench on G does the
    same work as these forces where the interfaces are.
    """
    row, first, count, at = forces.held[h]
    body = flexible.bodies[rows[row, FLEXIBLE]]
    k = body[COUNT]
    size = WRENCH + k
    G = matrix(work, row, R)
    force, moment = rotated_back(G, vector(work, row, FORCE)), rotated_back(G, vector(work, row, MOMENT))
    own = workspace.components[first : first + count]
    system, pivots = workspace.system[: count * count].reshape(count, count), workspace.pivots[:count]
    for c in range(count):
        constants = forces.pool[at + size * c : at + size * (c + 1)]
        shift, turn, elastic = three(constants, 0), three(constants, 3), constants[WRENCH:]
        own[c] = dot(shift, force) + dot(turn, moment)
        for d in range(count):
            i, component = forces.components[first + d, AT_ROW], forces.components[first + d, COMPONENT]
            arm = rotated_back(G, vector(work, i, OFFSET))
            velocity, spin = plus(shift, cross(turn, arm)), turn
            if k > 0:
                basis_at, bent = rows[i, BASIS], rows[i, BENT]
                if bent < 0:
                    basis = flexible.pool[basis_at : basis_at + 6 * k].reshape(6, k)
                    v, w = project(basis, 0, elastic), project(basis, 3, elastic)
                else:
                    basis = modal[bent : bent + 6 * k].reshape(6, k)
                    v, w = project(basis, 0, elastic), project(basis, 3, elastic)
                velocity, spin = plus(velocity, v), plus(spin, rotated(matrix(work, i, TANGENT), w))
            along, about = unit_wrench(component, vector(forces.axes, first + d, 0), matrix(work, i, TANGENT))
            system[c, d] = dot(velocity, along) + dot(spin, about)
    factorise(system, pivots)
    solve(system, pivots, own)


@inlined
def unit_wrench(component: int, axis: Numbers, T: Numbers) -> tuple[Numbers, Numbers]:
    """Return force and moment in G of a unit force along a component: see `kanefe.kane.coupling.unit_wrenches`."""
    none = (0.0, 0.0, 0.0)
    if component < 3:
        return axis, none
    first, second, third = (T[0], T[3], T[6]), (T[1], T[4], T[7]), (T[2], T[5], T[8])
    area = cross(second, third)
    about = plus(times(axis[0], area), plus(times(axis[1], cross(third, first)), times(axis[2], cross(first, second))))
    return none, times(1.0 / dot(first, area), about)


@inlined
def point_load(tables: Tables, n: int, inputs: np.ndarray, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return a force and its moment about the origin of its row, or a torque, in N."""
    i = tables.loads[n, 0]
    axes = matrix(work, i, R)
    zero = 0.0 * axes[0]
    value = three(inputs, tables.loads[n, 1])
    value = (zero + value[0], zero + value[1], zero + value[2])
    if tables.loads[n, 3]:  # follows
        value = rotated(axes, rotated(matrix(tables.points, n, 3), value))
    if tables.loads[n, 2]:  # a torque
        return (zero, zero, zero), value
    return value, cross(rotated(axes, vector(tables.points, n, 0)), value)


@kernel
def tell_parts(
    tables: Tables,
    between: LoadsBetween,
    loops: Loops,
    forces: ForceTables,
    inputs: np.ndarray,
    multipliers: np.ndarray,
    work: np.ndarray,
    kept: UnitResponses,
    workspace: ForceWorkspace,
    out: np.ndarray,
) -> None:
    """Write the parts of the forces at interfaces, about their deformed positions, in G (Eq. 30)."""
    told, of_ends = out[forces.places[PARTS] :], out[forces.places[ENDS] :]
    for p in range(len(forces.parts)):
        target = forces.parts[p, PART_ROW]
        place, G = vector(work, target, POSITION), matrix(work, tables.rows[target, PARENT], R)
        force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for s in range(forces.parts[p, FIRST_SOURCE], forces.parts[p, FIRST_SOURCE] + forces.parts[p, SOURCE_COUNT]):
            kind, first, count, end = forces.sources[s]
            if kind == OF_CARRIER:
                for d in range(first, first + count):
                    axis, T = vector(forces.axes, d, 0), matrix(work, target, TANGENT)
                    along, about = unit_wrench(forces.components[d, COMPONENT], axis, T)
                    force = plus(force, rotated(G, times(workspace.components[d], along)))
                    moment = plus(moment, rotated(G, times(workspace.components[d], about)))
            elif kind == OF_CHILD:
                i = forces.bodies[first]
                pull = times(-1.0, vector(work, i, FORCE))
                force, arm = plus(force, pull), minus(vector(work, i, POSITION), place)
                moment = plus(moment, minus(cross(arm, pull), vector(work, i, MOMENT)))
            elif kind == OF_LOOP:
                for j in range(first, first + count):
                    if multipliers[j] != 0.0:
                        pull = times(multipliers[j], vector(kept.wrenches, j, WRENCH * end))
                        turning = times(multipliers[j], vector(kept.wrenches, j, WRENCH * end + 3))
                        arm = minus(vector(work, loops.rows[j, ROW_A + end], POSITION), place)
                        force, moment = plus(force, pull), plus(moment, plus(turning, cross(arm, pull)))
            elif kind == OF_LOAD:
                pull, arm = three(of_ends, WRENCH * first), minus(vector(workspace.points, first, 0), place)
                force = plus(force, pull)
                moment = plus(moment, plus(three(of_ends, WRENCH * first + 3), cross(arm, pull)))
            else:
                pull, turning = point_load(tables, first, inputs, work)
                arm = minus(vector(work, tables.loads[first, 0], POSITION), place)
                force, moment = plus(force, pull), plus(moment, plus(turning, cross(arm, pull)))
        put_three(told, WRENCH * p, rotated_back(G, force))
        put_three(told, WRENCH * p + 3, rotated_back(G, moment))
