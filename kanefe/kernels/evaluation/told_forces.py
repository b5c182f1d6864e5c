"""Forces of a state that are told: of joints and loops, along fixed components, and at interfaces."""

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.constraints.loop_tables import RowWork, row_work_in, rows_of
from kanefe.kernels.constraints.row_wrenches import wrench_on
from kanefe.kernels.evaluation.force_tables import (
    BodyFrames,
    FixedComponents,
    ForceTables,
    ForceWork,
    HeldBodies,
    SourceKind,
    ToldForces,
    ToldGears,
    ToldLoops,
    ToldParts,
    ToldSource,
    ToldSources,
)
from kanefe.kernels.force_elements.places import Wrench, Wrenches
from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import ZERO, Matrix, Vector, cross, dot, inlined, kernel
from kanefe.kernels.loads.point_and_field_loads import point_load, point_loads_of
from kanefe.kernels.scene import Scene, State, Work, links_of
from kanefe.kernels.sweeps.elastic import combined
from kanefe.kernels.tree import InterfaceFrame, InterfaceLink


@kernel
def tell_joints(forces: ForceTables, work: Work, told: Wrenches) -> None:
    """Write the wrench of each joint on its body, about the origin of the body's frame, in its axes."""
    bodies = BodyFrames(forces.bodies, forces.frames)
    for b in range(len(bodies)):
        body, frame = bodies[b], work.frames[bodies[b].row]
        axes = frame.R @ body.axes
        told[b].force = axes.T @ frame.f
        told[b].moment = axes.T @ (frame.n - cross(frame.R @ body.point, frame.f))


@kernel
def tell_loops(scene: Scene, forces: ForceTables, work: Work, exerted: RowWork, told: Wrenches) -> None:
    """Write what each loop joint exerts on its end b, about the origin of b, in its axes."""
    rows, loops, multipliers = rows_of(scene.loops), ToldLoops(forces.loops), work.multipliers
    for c in range(len(loops)):
        first, force, moment = loops[c].first, ZERO, ZERO
        end = rows[first].b
        R = work.frames[end.row].R
        axes, lever = R @ end.axes, R @ end.point
        for j in range(first, first + loops[c].count):
            if multipliers[j] != 0.0:
                action = exerted.actions[j]
                own = multipliers[j] * action.force
                force, moment = force + own, moment + multipliers[j] * action.moment_b - cross(lever, own)
        told[c].force, told[c].moment = axes.T @ force, axes.T @ moment


@kernel
def tell_gears(forces: ForceTables, multipliers: np.ndarray, told: np.ndarray) -> None:
    """Write the force of each gear on each coordinate that it couples, its coefficient times the multiplier."""
    gears = ToldGears(forces.gears, forces.coefficients)
    for g in range(len(gears)):
        told[g] = gears[g].coefficient * multipliers[gears[g].row]


@kernel
def hold_components(scene: Scene, forces: ForceTables, work: Work, own: ForceWork, h: int) -> None:
    """Write the forces along the components of a body that are fixed in G, from the wrench on it.

    A displacement along one of them moves G and, against it, the modes, which are in balance: the wrench on G does the
    same work as these forces where the interfaces are.
    """
    held = HeldBodies(forces.held, forces.pool)[h]
    first, count, frame = held.first, held.count, work.frames[held.row]
    back = frame.R.T
    force, moment = back @ frame.f, back @ frame.n
    found, size_of_all = own.components[first : first + count], len(own.components)
    system = own.system.reshape(size_of_all * size_of_all)[: count * count].reshape(count, count)
    for c in range(count):
        shift, turn = three(held.motions[c], 0), three(held.motions[c], 3)
        found[c] = dot(shift, force) + dot(turn, moment)
        for d in range(count):
            system[c, d] = _work_at(scene, forces, work, first + d, held.motions[c])
    factorise(system, own.pivots[:count])
    solve(system, own.pivots[:count], found)


@inlined
def _work_at(scene: Scene, forces: ForceTables, work: Work, d: int, motion: np.ndarray) -> float:
    """Return the work of a unit force along a component, by a motion of G and of the modes."""
    fixed = FixedComponents(forces.components, forces.axes)[d]
    link, frame = InterfaceLink(links_of(scene)[fixed.row]), InterfaceFrame(work.frames[fixed.row])
    k, shift, turn, elastic = len(motion) - 6, three(motion, 0), three(motion, 3), motion[6:]
    velocity, spin, back = shift + cross(turn, work.frames[link.parent].R.T @ frame.r), turn, frame.tangent
    if k > 0:
        # one name for both, since `modal` is real here: in other kernels it may be complex, unlike the pool
        if link.bent < 0:
            basis = scene.flexible.pool[link.basis : link.basis + 6 * k].reshape(6, k)
        else:
            basis = work.modal[link.bent : link.bent + 6 * k].reshape(6, k)
        velocity += combined(basis, 0, elastic)
        spin += back @ combined(basis, 3, elastic)
    along, about = unit_wrench(fixed.component, fixed.axis, back)
    return dot(velocity, along) + dot(spin, about)  # type: ignore[no-any-return]


@inlined
def unit_wrench(component: int, axis: Vector, T: Matrix) -> tuple[Vector, Vector]:
    """Return force and moment in G of a unit force along a component, as `kanefe.states.interactions.unit_wrenches`."""
    if component < 3:
        return axis, ZERO
    area = cross(T.y, T.z)
    about = axis.x * area + axis.y * cross(T.z, T.x) + axis.z * cross(T.x, T.y)
    return ZERO, (1.0 / dot(T.x, area)) * about


@kernel
def tell_parts(scene: Scene, forces: ForceTables, state: State, work: Work, own: ForceWork, told: ToldForces) -> None:
    """Write the parts of the forces at interfaces, about their deformed positions, in G (Eq. 30)."""
    parts, sources = ToldParts(forces.parts), ToldSources(forces.sources)
    for p in range(len(parts)):
        part, found = parts[p], told.parts[p]
        place, G = work.frames[part.row].p, work.frames[links_of(scene)[part.row].parent].R
        found.force, found.moment = ZERO, ZERO
        for s in range(part.first, part.first + part.count):
            source = sources[s]
            if source.kind == SourceKind.CARRIER:
                _tell_carrier(forces, own, source, (G, InterfaceFrame(work.frames[part.row]).tangent), found)
            elif source.kind == SourceKind.CHILD:
                frame = work.frames[BodyFrames(forces.bodies, forces.frames)[source.first].row]
                _tell(found, frame.p - place, -frame.f, -frame.n)
            elif source.kind == SourceKind.LOOP:
                _tell_rows(scene, work, own, source, place, found)
            elif source.kind == SourceKind.LOAD:
                end = told.ends[source.first]
                _tell(found, own.points[source.first] - place, end.force, end.moment)
            else:
                load = point_loads_of(scene)[source.first]
                frame = work.frames[load.row]
                force, moment = point_load(load, state.inputs, frame)
                _tell(found, frame.p - place, force, moment)
        found.force, found.moment = G.T @ found.force, G.T @ found.moment


@inlined
def _tell(found: Wrench, arm: Vector, force: Vector, moment: Vector) -> None:
    """Add a wrench that acts at the end of an arm."""
    found.force += force
    found.moment += moment + cross(arm, force)


@inlined
def _tell_carrier(
    forces: ForceTables, own: ForceWork, source: ToldSource, axes: tuple[Matrix, Matrix], found: Wrench
) -> None:
    """Add what holds components that are fixed in G; `axes`: those of G, and the tangent of the interface."""
    fixed, (G, T) = FixedComponents(forces.components, forces.axes), axes
    for d in range(source.first, source.first + source.count):
        along, about = unit_wrench(fixed[d].component, fixed[d].axis, T)
        found.force += own.components[d] * (G @ along)
        found.moment += own.components[d] * (G @ about)


@inlined
def _tell_rows(scene: Scene, work: Work, own: ForceWork, source: ToldSource, place: Vector, found: Wrench) -> None:
    """Add what rows of constraints exert on an end."""
    rows, exerted, multipliers = rows_of(scene.loops), row_work_in(own.exerted, scene.loops), work.multipliers
    for j in range(source.first, source.first + source.count):
        if multipliers[j] != 0.0:
            force, moment = wrench_on(scene, work, exerted, j, source.end, True)
            at = rows[j].b.row if source.end == 1 else rows[j].a.row
            _tell(found, work.frames[at].p - place, multipliers[j] * force, multipliers[j] * moment)
