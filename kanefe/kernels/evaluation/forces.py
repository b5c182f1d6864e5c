"""All forces of states of a run: of joints, drives, loops and loads, and at interfaces of flexible bodies.

Accelerations and multipliers are those of an evaluation. With them the balance of each body, Newton's and Euler's
equations, gives the wrench of its joint in one inward sweep; no system is solved again. Forces along components that
are fixed in G follow from the wrench on the body by virtual work (Eq. 31-35).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy, put, three
from kanefe.kernels.bodies import ModalBodies
from kanefe.kernels.compiler._numba import expanded, inlined, kernel
from kanefe.kernels.compiler.arrays import Integers, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.loop_tables import holds, unit_responses_in, wrenches_in
from kanefe.kernels.constraints.row_wrenches import push_row, write_rows
from kanefe.kernels.constraints.told_shares import told_multipliers
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import AT_TIME, DONE_AS, LEAST_PIVOT
from kanefe.kernels.evaluation.force_tables import (
    DRIVING,
    ENDS,
    GEAR_FORCES,
    LOOP_FORCES,
    REACTIONS,
    WRENCH,
    ForceTables,
    ForceWorkspace,
    force_workspace,
)
from kanefe.kernels.evaluation.told_contacts import tell_contacts
from kanefe.kernels.evaluation.told_forces import hold_components, tell_gears, tell_joints, tell_loops, tell_parts
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCHES, P
from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.joints.handing import hand_force_inward
from kanefe.kernels.layout import COORDINATES, SPEEDS, STATES
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.loads.loads_between import apply_load, evaluate_load
from kanefe.kernels.loads.loads_layout import END_COUNT, FIRST_END, TEAM, place_of_load, span_of_load
from kanefe.kernels.loads.point_and_field_loads import add_field_loads, add_point_loads
from kanefe.kernels.loads.points import gather_points, push_points
from kanefe.kernels.loads.reach import find_near, nearness_at
from kanefe.kernels.steppers.step_commands import AT, RATES, SLOPE
from kanefe.kernels.sweeps.elastic import combination
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.kernels.tree import Frames, Kind, Links
from kanefe.kernels.values.tensors import dot


@entry()
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
    holding: Reals,
    times: Reals,
    driven: RealBlocks,
    values: RealRows,
    states: RealRows,
    rates: RealRows,
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
        A call of `kanefe.kernels.evaluation.evaluation.evaluate`, which is not implicit, with the next six arrays.
    vectors, drives, inputs : ndarray
        See there.
    multipliers, scale : ndarray, shape (m,)
        Of the constraints, and the scale of their rows, as the evaluation leaves them in its memory.
    holding : ndarray
        See `kanefe.kernels.evaluation.evaluation.Workspace`.
    times : ndarray, shape (T,)
        s.
    driven : ndarray, shape (T, driven, 3)
    values : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    rates : ndarray, shape (T or 0, state and quadratures)
        Their rates, of scenes without constraints: none are computed here.
    found : ndarray, shape (T, width)
        See `ForceTables.places`.
    is_told : ndarray of int, shape (T,)
        1, or 0 where the literal route has to tell: near singular positions, and where rows depend on each other, so
        that several multipliers do the same; of those of rigid contacts where `told_multipliers` does not know them.
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
        is_told[k] = 0
        if len(rates) > 0:
            copy(rates[k], vectors[SLOPE])
        else:
            evaluation.numbers[AT_TIME] = times[k]
            call_address(evaluation.address, (evaluation.places, evaluation.numbers))
            if evaluation.numbers[DONE_AS] != RATES:
                continue
            if evaluation.numbers[LEAST_PIVOT] < NEAR_SINGULAR:
                continue
            if len(loops.points.places) > 0:
                count = tables.sizes[SPEEDS]
                kept = unit_responses_in(holding, loops, count + len(drives))
                if not told_multipliers(loops, y[m:], count, multipliers, kept):
                    continue
            elif not are_independent(loops, y[m:], multipliers, scale):
                continue
        copy(vectors[SLOPE], found[k, : vectors.shape[1]])
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
    exerted = wrenches_in(workspace.holding, loops)
    write_rows(loops, tables.gravity, drives, z, speeds, work, exerted)
    for j in range(len(multipliers)):
        if multipliers[j] != 0.0:
            push_row(loops, tables, flexible, j, multipliers[j], True, exerted, applied, work, modal)
    still[:, :] = 0.0
    for i in range(len(still)):
        still[i, 0] = drives[i, 0]
    sweep_outward(tables, flexible, still, q, du, moving, modal_rates)
    add_inertia_forces(tables, flexible, work, moving, modal, modal_rates)
    sum_inward(tables, applied, work, out[forces.places[DRIVING] :])
    tell_joints(forces, work, out[forces.places[REACTIONS] :])
    tell_loops(forces, loops, multipliers, work, exerted, out[forces.places[LOOP_FORCES] :])
    tell_gears(forces, multipliers, out[forces.places[GEAR_FORCES] :])
    for h in range(len(forces.held)):
        hold_components(forces, tables.rows, flexible, h, work, modal, workspace)
    tell_parts(tables, loops, forces, inputs, multipliers, work, exerted, workspace, out)
    if len(loops.points.places) > 0:
        tell_contacts(forces, loops, tables.gravity, z, multipliers, work, exerted.met, out)


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
    links, frames, moves = Links(tables.rows, tables.geometry), Frames(work), Frames(moving)
    bodies = ModalBodies(flexible.bodies, flexible.pool, modal)
    rates = ModalBodies(flexible.bodies, flexible.pool, modal_rates)
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
def sum_inward(tables: Tables, applied: np.ndarray, work: np.ndarray, driving: np.ndarray) -> None:
    """Hand the forces that rows need to what carries them, and write what drives give beyond what is applied."""
    links, frames = Links(tables.rows, tables.geometry), Frames(work)
    for i in range(len(links) - 1, -1, -1):
        link, frame = links[i], frames[i]
        if link.drive >= 0:
            v, w = partials(link, frame)
            driving[link.drive] = dot(v, frame.f) + dot(w, frame.n) - applied[link.speed]
        if link.parent >= 0:
            hand_force_inward(frames[link.parent], frame.r, frame.f, frame.n)
