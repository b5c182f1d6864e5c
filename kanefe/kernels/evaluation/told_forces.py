"""Forces of a state that are told: of joints and loops, along fixed components, and at interfaces."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    matrix,
    minus,
    numbers_of,
    plus,
    product,
    put_three,
    rotated,
    rotated_back,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.loop_tables import RowWork, row_work_in, rows_of
from kanefe.kernels.constraints.row_wrenches import wrench_on
from kanefe.kernels.evaluation.force_tables import (
    AT_ROW,
    COMPONENT,
    ENDS,
    FIRST_SOURCE,
    OF_CARRIER,
    OF_CHILD,
    OF_LOAD,
    OF_LOOP,
    PART_ROW,
    PARTS,
    SOURCE_COUNT,
    WRENCH,
    ForceTables,
    ForceWork,
)
from kanefe.kernels.joints.motion import put_three as put_vector
from kanefe.kernels.layout import BASIS, BENT, COUNT, FLEXIBLE, FORCE, MOMENT, OFFSET, PARENT, POSITION, TANGENT, R
from kanefe.kernels.loads.point_and_field_loads import point_load, point_loads_of
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.sweeps.elastic import project
from kanefe.kernels.values.tensors import ZERO
from kanefe.kernels.values.tensors import cross as vector_product


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
def tell_loops(scene: Scene, forces: ForceTables, work: Work, exerted: RowWork, told: np.ndarray) -> None:
    """Write what each loop joint exerts on its end b, about the origin of b, in its axes."""
    rows, frames, multipliers = rows_of(scene.loops), work.frames, work.multipliers
    for c in range(len(forces.loops)):
        first, force, moment = forces.loops[c, 0], ZERO, ZERO
        end = rows[first].b
        R = frames[end.row].R
        axes, lever = R @ end.axes, R @ end.point
        for j in range(first, first + forces.loops[c, 1]):
            if multipliers[j] != 0.0:
                action = exerted.actions[j]
                own = multipliers[j] * action.force
                force, moment = force + own, moment + multipliers[j] * action.moment_b - vector_product(lever, own)
        put_vector(told, WRENCH * c, axes.T @ force)
        put_vector(told, WRENCH * c + 3, axes.T @ moment)


@kernel
def tell_gears(forces: ForceTables, multipliers: np.ndarray, told: np.ndarray) -> None:
    """Write the force of each gear on each coordinate that it couples, its coefficient times the multiplier."""
    for g in range(len(forces.gear_rows)):
        told[g] = forces.coefficients[g] * multipliers[forces.gear_rows[g]]


@kernel
def hold_components(scene: Scene, forces: ForceTables, work: Work, own: ForceWork, h: int) -> None:
    """Write the forces along the components of a body that are fixed in G, from the wrench on it.

    A displacement along one of them moves G and, against it, the modes, which are in balance: the wrench on G does the
    same work as these forces where the interfaces are.
    """
    rows, flexible, frames, modal = scene.tables.rows, scene.flexible, work.frames.numbers, work.modal
    row, first, count, at = forces.held[h]
    body = flexible.bodies[rows[row, FLEXIBLE]]
    k = body[COUNT]
    size = WRENCH + k
    G = matrix(frames, row, R)
    force, moment = rotated_back(G, vector(frames, row, FORCE)), rotated_back(G, vector(frames, row, MOMENT))
    found, size_of_all = own.components[first : first + count], len(own.components)
    system = own.system.reshape(size_of_all * size_of_all)[: count * count].reshape(count, count)
    pivots = own.pivots[:count]
    for c in range(count):
        constants = forces.pool[at + size * c : at + size * (c + 1)]
        shift, turn, elastic = three(constants, 0), three(constants, 3), constants[WRENCH:]
        found[c] = dot(shift, force) + dot(turn, moment)
        for d in range(count):
            i, component = forces.components[first + d, AT_ROW], forces.components[first + d, COMPONENT]
            arm = rotated_back(G, vector(frames, i, OFFSET))
            velocity, spin = plus(shift, cross(turn, arm)), turn
            if k > 0:
                basis_at, bent = rows[i, BASIS], rows[i, BENT]
                # one name for both, since `modal` is real here: in other kernels it may be complex, unlike the pool
                if bent < 0:
                    basis = flexible.pool[basis_at : basis_at + 6 * k].reshape(6, k)
                else:
                    basis = modal[bent : bent + 6 * k].reshape(6, k)
                velocity = plus(velocity, project(basis, 0, elastic))
                spin = plus(spin, rotated(matrix(frames, i, TANGENT), project(basis, 3, elastic)))
            along, about = unit_wrench(component, vector(forces.axes, first + d, 0), matrix(frames, i, TANGENT))
            system[c, d] = dot(velocity, along) + dot(spin, about)
    factorise(system, pivots)
    solve(system, pivots, found)


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


@kernel
def tell_parts(scene: Scene, forces: ForceTables, state: State, work: Work, own: ForceWork, out: np.ndarray) -> None:
    """Write the parts of the forces at interfaces, about their deformed positions, in G (Eq. 30)."""
    tables, loops, multipliers, rows = scene.tables, scene.loops, work.multipliers, work.frames.numbers
    exerted = row_work_in(own.exerted, loops)
    told, of_ends = out[forces.places[PARTS] :], out[forces.places[ENDS] :]
    for p in range(len(forces.parts)):
        target = forces.parts[p, PART_ROW]
        place, G = vector(rows, target, POSITION), matrix(rows, tables.rows[target, PARENT], R)
        force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for s in range(forces.parts[p, FIRST_SOURCE], forces.parts[p, FIRST_SOURCE] + forces.parts[p, SOURCE_COUNT]):
            kind, first, count, end = forces.sources[s]
            if kind == OF_CARRIER:
                for d in range(first, first + count):
                    axis, T = vector(forces.axes, d, 0), matrix(rows, target, TANGENT)
                    along, about = unit_wrench(forces.components[d, COMPONENT], axis, T)
                    force = plus(force, rotated(G, times(own.components[d], along)))
                    moment = plus(moment, rotated(G, times(own.components[d], about)))
            elif kind == OF_CHILD:
                i = forces.bodies[first]
                pull = times(-1.0, vector(rows, i, FORCE))
                force, arm = plus(force, pull), minus(vector(rows, i, POSITION), place)
                moment = plus(moment, minus(cross(arm, pull), vector(rows, i, MOMENT)))
            elif kind == OF_LOOP:
                for j in range(first, first + count):
                    if multipliers[j] != 0.0:
                        own_force, own_moment = wrench_on(scene, work, exerted, j, end, True)
                        pull, turning = numbers_of(multipliers[j] * own_force), numbers_of(multipliers[j] * own_moment)
                        at = rows_of(loops)[j].b.row if end == 1 else rows_of(loops)[j].a.row
                        arm = minus(vector(rows, at, POSITION), place)
                        force, moment = plus(force, pull), plus(moment, plus(turning, cross(arm, pull)))
            elif kind == OF_LOAD:
                pull, arm = three(of_ends, WRENCH * first), minus(vector(own.points, first, 0), place)
                force = plus(force, pull)
                moment = plus(moment, plus(three(of_ends, WRENCH * first + 3), cross(arm, pull)))
            else:
                load = point_loads_of(scene)[first]
                given = point_load(load, state.inputs, work.frames[load.row])
                pull, arm = numbers_of(given[0]), minus(vector(rows, load.row, POSITION), place)
                force, moment = plus(force, pull), plus(moment, plus(numbers_of(given[1]), cross(arm, pull)))
        put_three(told, WRENCH * p, rotated_back(G, force))
        put_three(told, WRENCH * p + 3, rotated_back(G, moment))
