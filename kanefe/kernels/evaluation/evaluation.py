"""One evaluation of the right-hand side in order n: dy/dt of a state ``(q, u, z, energy dissipated, work)``."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import expanded, inlined
from kanefe.kernels.compiler.arrays import RealRows, Reals, ValueRows, Values
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import COMPLEX, REAL
from kanefe.kernels.constraints.contact_rates import put_contact_rates
from kanefe.kernels.constraints.holding import Held, hold_size
from kanefe.kernels.constraints.loop_factors import loop_factors_in
from kanefe.kernels.constraints.loop_tables import unit_responses_in
from kanefe.kernels.constraints.multipliers import hold, respond_to_multipliers
from kanefe.kernels.constraints.row_wrenches import write_rows
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_inward
from kanefe.kernels.joints.by_kind import put_coordinate_rates
from kanefe.kernels.layout import (
    BORDER_SIZE,
    COORDINATES,
    COUNT,
    DAMPING,
    DETA,
    DRIVES,
    ETA,
    MODAL_SIZE,
    SPEEDS,
    STATES,
    WORK,
    WORK_DETA,
    work_size,
)
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.loads.joint_reactions import REACTION, add_reactions, follow_reactions
from kanefe.kernels.loads.loads_between import add_loads_between
from kanefe.kernels.loads.loads_layout import WHOLE
from kanefe.kernels.loads.point_and_field_loads import add_field_loads, add_point_loads
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.steppers.step_commands import (
    AT,
    DAMPING_DIRECTION,
    NO_INERTIA,
    NOT_FINITE,
    RATES,
    SLOPE,
    STIFFNESS_DIRECTION,
    is_finite,
)
from kanefe.kernels.sweeps.driving_forces import put_driving_forces
from kanefe.kernels.sweeps.elastic import span, total
from kanefe.kernels.sweeps.implicit import stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward_again
from kanefe.kernels.sweeps.unit_mass import scale_beams
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.kernels.tree import Links


class Workspace(NamedTuple):
    """What an evaluation writes on its way, of the type of the state.

    Attributes
    ----------
    work : ndarray, shape (rows, WORK)
    modal, border : ndarray
        Of flexible bodies: see `kanefe.kernels.bodies`.
    applied, added : ndarray, shape (free + driven,)
        Generalised forces at the joints, and inertia that a linearly implicit evaluation adds along them.
    driving : ndarray, shape (driven,)
        Forces that drive the driven coordinates.
    multipliers : ndarray, shape (m,)
        Of the constraints.
    holding : ndarray, shape (`hold_size`,)
        Of the sweeps with loops, or of `hold` where there are rigid contacts.
    reactions : ndarray, shape (bearings, REACTION)
        Of joints whose load is followed.
    acting : ndarray
        Of `add_loads_between`.
    """

    work: np.ndarray
    modal: np.ndarray
    border: np.ndarray
    applied: np.ndarray
    added: np.ndarray
    driving: np.ndarray
    multipliers: np.ndarray
    holding: np.ndarray
    reactions: np.ndarray
    acting: np.ndarray


class Parts(NamedTuple):
    """Parts of the state AT and of the rates SLOPE.

    Attributes
    ----------
    q, u, z : ndarray, shapes (coordinates,), (free,), (states,)
        Coordinates, free speeds, internal states of loads.
    du, dz : ndarray, shapes (free,), (states,)
    powers : ndarray, shape (2,)
        Taken and given, W.
    """

    q: np.ndarray
    u: np.ndarray
    z: np.ndarray
    du: np.ndarray
    dz: np.ndarray
    powers: np.ndarray


def workspace_size(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
) -> int:
    """Return how many numbers the workspace of a scene has."""
    speeds = int(tables.sizes[SPEEDS] + tables.sizes[DRIVES])
    size = work_size(tables) + 2 * speeds + int(tables.sizes[DRIVES])
    size += int(flexible.sizes[MODAL_SIZE] + flexible.sizes[BORDER_SIZE])
    m = len(loops.rows)
    of_loads = int(between.workspace_size[WHOLE]) + REACTION * len(between.bearings)
    return size + of_loads + m + hold_size(loops, speeds)


@expanded
def workspace_in(
    memory: np.ndarray, tables: Tables, flexible: FlexibleTables, between: LoadsBetween, loops: Loops
) -> Workspace:
    """Return the parts of a memory of `workspace_size`."""
    rows, driven = work_size(tables), tables.sizes[DRIVES]
    speeds, m = tables.sizes[SPEEDS] + driven, len(loops.rows)
    holds, modes, borders = hold_size(loops, speeds), flexible.sizes[MODAL_SIZE], flexible.sizes[BORDER_SIZE]
    work, rest = memory[:rows].reshape(-1, WORK), memory[rows:]
    modal, border, rest = rest[:modes], rest[modes : modes + borders], rest[modes + borders :]
    applied, added, rest = rest[:speeds], rest[speeds : 2 * speeds], rest[2 * speeds :]
    driving, multipliers, rest = rest[:driven], rest[driven : driven + m], rest[driven + m :]
    holding, rest, count = rest[:holds], rest[holds:], REACTION * len(between.bearings)
    reactions, acting = rest[:count].reshape(-1, REACTION), rest[count:]
    return Workspace(work, modal, border, applied, added, driving, multipliers, holding, reactions, acting)


@inlined
def parts_of(tables: Tables | PlanarTables, vectors: np.ndarray) -> Parts:
    """Return the parts of the state and of its rates."""
    at, slope, n = vectors[AT], vectors[SLOPE], tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    k = m + tables.sizes[STATES]
    return Parts(at[:n], at[n:m], at[m:k], slope[n:m], slope[m:k], slope[k:])


# Of a prepared call of `evaluate` and `evaluate_planar`: its place, and its numbers with what is returned
IS_IMPLICIT, KEEPS = 0, 1  # the second of `evaluate` alone
AT_TIME, SHARE_OF_DAMPING, SHARE_OF_STIFFNESS, DONE_AS, LEAST_PIVOT = range(5)


@entry(REAL, COMPLEX)
def evaluate(
    is_implicit: bool,
    keeps: bool,
    t: float,
    share_damping: float,
    share_stiffness: float,
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
    drives: RealRows,
    inputs: Reals,
    vectors: ValueRows,
    memory: Values,
) -> tuple[int, float]:
    """Evaluate dy/dt.

    Parameters
    ----------
    is_implicit : bool
        Whether the evaluation is linearly implicit.
    keeps : bool
        Whether the memory is of the last evaluation of the scene, so that what is as before need not be computed again;
        not in a linearly implicit evaluation.
    t : float
        Time, s.
    share_damping, share_stiffness : float
        s and r of a linearly implicit evaluation.
    tables : Tables
    flexible : FlexibleTables
    between : LoadsBetween
    loops : Loops
    drives : ndarray, shape (driven, 3)
        Position, speed and acceleration of the driven coordinates.
    inputs : ndarray
        Values of loads.
    vectors : ndarray, shape (2 or more, state)
        The state, of `coordinates + free + states + 2` numbers, and, on return, dy/dt; two pushes follow for a linearly
        implicit evaluation, which gives ``z`` in the place of du: see `kanefe.kernels.sweeps.implicit`.
    memory : ndarray, shape (`workspace_size`,)
        Of the type of the vectors.

    Returns
    -------
    done : int
        RATES, or NO_INERTIA along a joint, or rates that are NOT_FINITE.
    weakest : float
        Smallest pivot of a constraint, of 1: it falls to zero towards a singular position.
    """
    workspace, shares = workspace_in(memory, tables, flexible, between, loops), (share_damping, share_stiffness)
    parts = parts_of(tables, vectors)
    is_regular, pivot = put_rates(
        tables, flexible, between, loops, drives, t, inputs, vectors, parts, is_implicit, keeps, shares, workspace
    )
    weakest = min(1.0, pivot)
    if not is_regular:
        return NO_INERTIA, weakest
    return RATES if is_finite(vectors[SLOPE]) else NOT_FINITE, weakest


@expanded
def put_rates(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
    drives: np.ndarray,
    t: float,
    inputs: np.ndarray,
    vectors: np.ndarray,
    parts: Parts,
    is_implicit: bool,
    keeps: bool,
    shares: tuple[float, float],
    workspace: Workspace,
) -> tuple[bool, Any]:
    """Write dy/dt; return whether every joint has inertia along it, and the smallest pivot of the constraints."""
    work, modal, border, applied, added, driving, multipliers, holding, reactions, acting = workspace
    q, u, z, du, dz, powers = parts

    rates_of_coordinates(tables, flexible, q, u, vectors[SLOPE])
    sweep_outward_again(tables, flexible, drives, q, u, keeps and not is_implicit, work, modal)
    set_inertia(tables, flexible, work, modal)

    applied[:] = 0.0
    dz[:] = 0.0
    powers[1] = add_point_loads(tables, flexible, inputs, work, modal)
    dissipated, motors = add_joint_forces(tables, drives, inputs, q, u, applied)
    powers[0] = dissipated
    powers[1] += motors
    if len(flexible.bodies) > 0:
        powers[0] += modal_dissipation(flexible, modal, powers)
        powers[1] += add_field_loads(flexible, inputs, work, modal)
    if len(between.loads) > 0:
        taken, given = add_loads_between(
            between, tables.rows, flexible, t, inputs, z, dz, drives, q, u, applied, work, modal, acting
        )
        powers[0] += taken
        powers[1] += given

    if is_implicit:
        speeds = slice(len(q), len(q) + len(u))
        directions = vectors[DAMPING_DIRECTION, speeds], vectors[STIFFNESS_DIRECTION, speeds]
        stiffen_joints(tables, shares[0], shares[1], directions[0], directions[1], q, u, applied, added)
        stiffen_modes(flexible, shares[0], shares[1], directions[0], directions[1], modal)
    scale_beams(flexible, modal)

    if len(loops.rows) > 0 and len(loops.points.places) == 0:
        kept = loop_factors_in(holding, loops)
        write_rows(loops, tables.gravity, drives, z, len(u), work, kept.exerted)
        for j in range(len(loops.rows)):
            kept.rest[j] = -kept.exerted.remainders[j]
        held = Held(loops, kept, multipliers, z, False, 0.0)
        is_regular, pivot = sweep_inward(tables, flexible, applied, work, modal, border, is_implicit, added, held)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, held, du)
    else:
        is_regular, pivot = sweep_inward(tables, flexible, applied, work, modal, border, is_implicit, added, None)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, None, du)
    if len(driving) > 0:
        put_driving_forces(tables, applied, work, driving)
    if len(reactions) > 0:
        reactions[:] = 0.0
        add_reactions(between, work, reactions)
    if len(loops.points.places) > 0:
        pivot = hold(
            loops,
            tables,
            flexible,
            drives,
            z,
            applied,
            work,
            modal,
            border,
            du,
            driving,
            multipliers,
            holding,
            is_implicit,
        )
        if len(reactions) > 0:
            respond_to_multipliers(
                loops, tables, flexible, applied, work, modal, border, is_implicit, len(du), multipliers, holding
            )
            add_reactions(between, work, reactions)
        put_contact_rates(loops, z, multipliers, unit_responses_in(holding, loops, len(applied)), work, dz, powers)
    if len(reactions) > 0:
        follow_reactions(between, drives, q, u, z, work, reactions, acting, dz)
    for i in range(len(driving)):
        powers[1] += driving[i] * drives[i, 1]
    return is_regular, pivot


@inlined
def rates_of_coordinates(
    tables: Tables, flexible: FlexibleTables, q: np.ndarray, u: np.ndarray, rates: np.ndarray
) -> None:
    """Write dq/dt."""
    links = Links(tables.rows, tables.geometry)
    for i in range(len(links)):
        put_coordinate_rates(links[i], q, u, rates)
    for f in range(len(flexible.bodies)):
        at, speed = flexible.bodies[f, ETA], flexible.bodies[f, DETA]
        for j in range(flexible.bodies[f, COUNT]):
            rates[at + j] = u[speed + j]


@inlined
def modal_dissipation(flexible: FlexibleTables, modal: np.ndarray, powers: np.ndarray) -> float:
    """Return deta^T C deta of all flexible bodies."""
    power = 0.0 * powers[1]
    for f in range(len(flexible.bodies)):
        body = flexible.bodies[f]
        if body[DAMPING] >= 0:
            k = body[COUNT]
            deta = modal[span(body, WORK_DETA)]
            C = flexible.pool[body[DAMPING] : body[DAMPING] + k * k].reshape(k, k)
            for j in range(k):
                power += deta[j] * total(C[j], deta)
    return power
