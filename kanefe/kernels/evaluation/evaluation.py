"""One evaluation of the right-hand side in order n: dy/dt of a state ``(q, u, z, energy dissipated, work)``.

`put_rates` is the order of things. What else is computed of states (forces, energies, masses, outputs) begins as it
does, and says what it asks for behind that.
"""

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.bodies import AllModalCoordinates
from kanefe.kernels.compiler.arrays import Values
from kanefe.kernels.constraints.contact_rates import put_contact_rates
from kanefe.kernels.constraints.holding import accelerations_to_hold
from kanefe.kernels.constraints.loop_tables import hold_size
from kanefe.kernels.constraints.multipliers import hold, respond_to_multipliers
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_inward
from kanefe.kernels.joints.by_kind import put_coordinate_rates
from kanefe.kernels.language import COMPLEX, REAL, RealRows, Reals, ValueRows, entry, expanded, inlined, kernel
from kanefe.kernels.loads.acting import acting_size
from kanefe.kernels.loads.coordinate_law import CoordinateLaws
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.loads.joint_reactions import add_reactions, follow_reactions
from kanefe.kernels.loads.loads_between import add_loads_between
from kanefe.kernels.loads.point_and_field_loads import add_field_loads, add_point_loads
from kanefe.kernels.scene import Rates, Scene, Sizes, State, Work, bodies_of, links_of, rates_in, state_in, work_in
from kanefe.kernels.steppers.step_commands import NO_INERTIA, NOT_FINITE, RATES, VECTOR, is_finite
from kanefe.kernels.sweeps.driving_forces import put_driving_forces, turn_driven_rotors
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.implicit import Pushes, stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.sweeps.unit_mass import scale_beams
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.kernels.values.filled import laid_out


def scene_of(
    tables: Tables, flexible: FlexibleTables, between: LoadsBetween, loops: Loops, kind: type[Work] = Work, **more: int
) -> Scene:
    """Return a scene, with what its evaluation writes; that of another kind has more whole numbers."""
    sizes = Sizes(tables.sizes)
    speeds = sizes.free_count + sizes.driven_count
    modal, border, _ = flexible.sizes.tolist()
    work = laid_out(
        kind,
        row_count=len(tables.rows) + 1,
        speed_count=speeds,
        driven_count=sizes.driven_count,
        modal_size=modal,
        border_size=border,
        constraint_count=len(loops.rows),
        holding_size=hold_size(loops),
        bearing_count=len(between.bearings),
        load_size=acting_size(between),
        **more,
    )
    return Scene(tables, flexible, between, loops, work)


# Of a prepared call of `evaluate` and `evaluate_planar`: its place, and its numbers with what is returned
IS_IMPLICIT, KEEPS = range(2)
AT_TIME, SHARE_OF_DAMPING, SHARE_OF_STIFFNESS, SHARE_OF_RATES, DONE_AS, LEAST_PIVOT = range(6)


class Asked(NamedTuple):
    """How an evaluation is done.

    Attributes
    ----------
    is_implicit : bool
        Whether it is linearly implicit.
    keeps : bool
        Whether the memory is of the last evaluation of the scene, so that what is as before need not be computed again;
        not in a linearly implicit evaluation, nor in the plane.
    t : float
        Time, s.
    share_damping, share_stiffness, share_of_rates : float
        s, r and p of a linearly implicit evaluation.
    """

    is_implicit: bool
    keeps: bool
    t: float
    share_damping: float
    share_stiffness: float
    share_of_rates: float


ASKED = Asked(is_implicit=False, keeps=False, t=0.0, share_damping=0.0, share_stiffness=0.0, share_of_rates=0.0)
"""Way of an evaluation that a prepared call is told before it is called."""


@entry(REAL, COMPLEX)
def evaluate(
    asked: Asked, scene: Scene, drives: RealRows, inputs: Reals, vectors: ValueRows, memory: Values
) -> tuple[int, float]:
    """Evaluate dy/dt.

    Parameters
    ----------
    asked : Asked
    scene : Scene
    drives, inputs : ndarray
        See `State`.
    vectors : ndarray, shape (2 or more, state)
        The state, of `coordinates + free + states + 2` numbers, and, on return, dy/dt; two pushes follow for a linearly
        implicit evaluation, which gives ``z`` in the place of du: see `kanefe.kernels.sweeps.implicit`.
    memory : ndarray
        For `Work`, of the type of the vectors.

    Returns
    -------
    done : int
        RATES, or NO_INERTIA along a joint, or rates that are NOT_FINITE.
    weakest : float
        Smallest pivot of a constraint, of 1: it falls to zero towards a singular position.
    """
    state, work = state_in(scene.tables, asked.t, vectors[VECTOR.at], drives, inputs), work_in(scene, memory)
    is_regular, pivot = put_rates(scene, state, work, rates_in(scene.tables, vectors[VECTOR.slope]), asked, vectors)
    weakest = min(1.0, pivot)
    if not is_regular:
        return NO_INERTIA, weakest
    return RATES if is_finite(vectors[VECTOR.slope]) else NOT_FINITE, weakest


@expanded
def put_rates(
    scene: Scene, state: State, work: Work, rates: Rates, asked: Asked, vectors: np.ndarray
) -> tuple[bool, Any]:
    """Write dy/dt; return whether every joint has inertia along it, and the smallest pivot of the constraints."""
    put_rates_of_coordinates(scene, state, rates.dq)
    sweep_outward(scene, state, work, asked.keeps and not asked.is_implicit)  # Eq. 3, 13-16, 22, 24-26
    set_inertia(scene, work)  # Eq. 12, 17, 20, 37, 38
    add_forces(scene, state, work, rates)  # Eq. 11, 30, 35
    if len(scene.between.loads) > 0:
        taken, given = add_loads_between(scene, state, work, rates.dz)
        rates.powers[0] += taken
        rates.powers[1] += given
    if asked.is_implicit:
        pushes = pushes_in(asked, vectors, len(state.q), len(state.u))
        stiffen_joints(scene.tables, state, pushes, work.applied, work.added)
        stiffen_modes(scene, work, pushes)
    scale_beams(scene, work)
    is_regular, weakest = accelerate_all(scene, state, work, rates, asked.is_implicit)  # Eq. 18, 39, with constraints
    if len(work.reactions) > 0:
        follow_reactions(scene, state, work, rates.dz)
    for i in range(len(state.drives)):
        rates.powers[1] += work.driving[i] * state.drives[i, 1]
    return is_regular, weakest


@inlined
def put_rates_of_coordinates(scene: Scene, state: State, dq: np.ndarray) -> None:
    """Write dq/dt."""
    links, bodies = links_of(scene), AllModalCoordinates(scene.flexible.bodies)
    for i in range(len(links)):
        put_coordinate_rates(links[i], state.q, state.u, dq)
    for f in range(len(bodies)):
        at, speed = bodies[f].first_eta, bodies[f].first_deta
        for j in range(bodies[f].k):
            dq[at + j] = state.u[speed + j]


@kernel
def add_forces(scene: Scene, state: State, work: Work, rates: Rates) -> None:
    """Add forces on rows, along joints and on modes, but for loads between frames; write their powers."""
    powers, tables = rates.powers, scene.tables
    work.applied[:] = 0.0
    rates.dz[:] = 0.0
    powers[1] = add_point_loads(scene, state, work)
    dissipated, motors = add_joint_forces(tables.joint_forces, CoordinateLaws(tables.laws), state, work.applied)
    powers[0] = dissipated
    powers[1] += motors
    if len(state.drives) > 0:
        turn_driven_rotors(links_of(scene), state.drives, work.applied)
    if len(scene.flexible.bodies) > 0:
        powers[0] += modal_dissipation(scene, work)
        powers[1] += add_field_loads(scene, state, work)


@inlined
def modal_dissipation(scene: Scene, work: Work) -> Any:
    """Return deta^T C deta of all flexible bodies."""
    bodies, power = bodies_of(scene, work), 0.0 * work.frames[0].p.x
    for f in range(len(bodies)):
        body = bodies[f]
        if body.damped >= 0:
            deta, damping = body.deta, body.damping
            for j in range(len(deta)):
                power += deta[j] * total(damping[j], deta)
    return power


@inlined
def pushes_in(asked: Asked, vectors: np.ndarray, coordinates: int, free: int) -> Pushes:
    """Return what a linearly implicit evaluation is given more."""
    speeds = slice(coordinates, coordinates + free)
    along = vectors[VECTOR.damping_direction, speeds], vectors[VECTOR.stiffness_direction, speeds]
    return Pushes(asked.share_damping, asked.share_stiffness, asked.share_of_rates, along[0], along[1])


@expanded
def accelerate_all(scene: Scene, state: State, work: Work, rates: Rates, is_implicit: bool) -> tuple[bool, Any]:
    """Write du, driving forces and multipliers, and what contacts and joint reactions add to the rates."""
    loops, du = scene.loops, rates.du
    if len(loops.rows) > 0 and len(loops.points.places) == 0:
        held = accelerations_to_hold(scene, state, work)
        is_regular, weakest = sweep_inward(scene, work, is_implicit, held)
        sweep_accelerations(scene, work, is_implicit, held, du)
    else:
        is_regular, weakest = sweep_inward(scene, work, is_implicit, None)
        sweep_accelerations(scene, work, is_implicit, None, du)
    if len(work.driving) > 0:
        put_driving_forces(links_of(scene), work.frames, work.applied, work.driving)
    if len(work.reactions) > 0:
        work.reactions[:] = 0.0
        add_reactions(scene, work)
    if len(loops.points.places) > 0:
        weakest = hold(scene, state, work, is_implicit, du)
        if len(work.reactions) > 0:
            respond_to_multipliers(scene, work, is_implicit)
            add_reactions(scene, work)
        put_contact_rates(scene, state, work, rates)
    return is_regular, weakest
