"""Energy, momenta and rigid motions of a whole scene at a state: what a method that keeps them asks for.

All is summed over the rows after `sweep_outward` and `set_inertia`, in components of N. Momenta are told about the
centre of mass of the scene, which keeps them sharp however far away it drifts.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    matrix,
    minus,
    plus,
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
from kanefe.kernels.compiler.arrays import Integers, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.layout import (
    AXES,
    COORDINATES,
    COUNT,
    EXACT,
    FLEXIBLE,
    FREE,
    HAS_GRAVITY,
    INTERFACE,
    KIND,
    MODAL_SIZE,
    OMEGA,
    PARENT,
    POOL,
    POOL_STIFFNESS,
    POSITION,
    ROTOR,
    SPEED,
    SPEEDS,
    STATES,
    VELOCITY,
    WORK,
    WORK_DETA,
    WORK_ETA,
    FlexibleTables,
    H,
    J,
    M,
    R,
    Tables,
)
from kanefe.kernels.loads.coordinate_law import coordinate_potential
from kanefe.kernels.loads.loads_between import potential_between
from kanefe.kernels.loads.loads_layout import LoadsBetween
from kanefe.kernels.steppers.step_commands import (
    AT,
    CENTRE,
    ENERGY,
    ENERGY_SIZE,
    KEEPS_MOMENTA,
    KINETIC,
    LOCKED,
    MOMENTUM,
    RIGID,
    ROTORS,
    SPIN,
    TOTAL_MASS,
)
from kanefe.kernels.sweeps.elastic import coupling_span, project, span
from kanefe.kernels.sweeps.exact_beam_inertia import energies_of_beam
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward

BALANCE_NUMBERS = 9
"""Number of values per state: see `balances_of_states`."""


@kernel
def _energies(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    t: float,
    drives: np.ndarray,
    inputs: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    acting: np.ndarray,
) -> tuple[float, float, float, float]:
    """Sweep a state; return kinetic, elastic and gravity energy, and the sum of the sizes of the latter two's parts."""
    sweep_outward(tables, flexible, drives, q, u, work, modal)
    set_inertia(tables, flexible, work, modal)
    kinetic, weight = 0.0, 0.0
    elastic = _joint_energy(tables, drives, q)
    elastic += potential_between(between, flexible, t, inputs, z, drives, q, u, work, modal, acting)
    size = abs(elastic)
    for i in range(len(tables.rows)):
        mass, c, v, w, momentum, spin = _momenta_of_row(tables, flexible, i, work, modal)
        kinetic += 0.5 * (dot(v, momentum) + dot(w, spin))
        if tables.rows[i, KIND] != INTERFACE and tables.rows[i, FLEXIBLE] >= 0:
            of_modes, strain = _modal_energies(flexible, tables.rows[i, FLEXIBLE], v, w, matrix(work, i, R), modal)
            kinetic += of_modes
            elastic += strain
            size += strain
        if tables.rows[i, HAS_GRAVITY]:
            fall = dot(three(tables.gravity, 0), plus(times(mass, vector(work, i, POSITION)), c))
            weight -= fall
            size += abs(fall)
    return kinetic, elastic, weight, size


@inlined
def _momenta_of_row(
    tables: Tables, flexible: FlexibleTables, i: int, work: np.ndarray, modal: np.ndarray
) -> tuple[float, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Return mass, first moment, v, w, momentum and angular momentum of a row about its origin, without rotors."""
    h, v, w = matrix(work, i, H), vector(work, i, VELOCITY), vector(work, i, OMEGA)
    mass, c = work[i, M], (h[5], h[6], h[1])
    momentum = plus(times(mass, v), cross(w, c))
    spin = plus(cross(c, v), symmetric_times(symmetric(work, i, J), w))
    if tables.rows[i, KIND] != INTERFACE and tables.rows[i, FLEXIBLE] >= 0:
        body, G = flexible.bodies[tables.rows[i, FLEXIBLE]], matrix(work, i, R)
        coupling, deta = modal[coupling_span(body)].reshape(6, body[COUNT]), modal[span(body, WORK_DETA)]
        momentum = plus(momentum, rotated(G, project(coupling, 0, deta)))
        spin = plus(spin, rotated(G, project(coupling, 3, deta)))
    return mass, c, v, w, momentum, spin


@kernel
def _modal_energies(
    flexible: FlexibleTables, f: int, v: Numbers, w: Numbers, G: Numbers, modal: np.ndarray
) -> tuple[float, float]:
    """Return the kinetic energy of the modes, beyond their share in the momenta, and their strain energy."""
    body = flexible.bodies[f]
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    coupling = modal[coupling_span(body)].reshape(6, body[COUNT])
    stiffness = flexible.pool[body[POOL] + POOL_STIFFNESS :]
    carried = dot(rotated_back(G, v), project(coupling, 0, deta)) + dot(rotated_back(G, w), project(coupling, 3, deta))
    if body[EXACT] >= 0:
        own, strain = energies_of_beam(flexible, body, eta, deta, modal)
        return 0.5 * (carried + own), strain
    own = strain = 0.0
    for j in range(body[COUNT]):
        own += deta[j] * deta[j]
        strain += 0.5 * stiffness[j] * eta[j] * eta[j]
    return 0.5 * (carried + own), strain


@kernel
def _joint_energy(tables: Tables, drives: np.ndarray, q: np.ndarray) -> float:
    """Return the energy in springs and stops along joint coordinates."""
    energy = 0.0
    for n in range(len(tables.joint_forces)):
        at, law = tables.joint_forces[n, 0], tables.joint_forces[n, 2]
        if law >= 0:
            energy += coordinate_potential(tables.laws[law], q[at] if at >= 0 else drives[-1 - at, 0])
    return energy


@kernel
def _put_momenta(
    tables: Tables, flexible: FlexibleTables, work: np.ndarray, modal: np.ndarray, reals: np.ndarray
) -> None:
    """Write mass, centre of mass, momenta about it, and the inertia about it as of one rigid body."""
    none, origin = (0.0, 0.0, 0.0), vector(work, 0, POSITION)
    total, first, momentum = 0.0, none, none  # moments about a place in the scene: it may be far from N's origin
    for i in range(len(tables.rows)):
        mass, c, _, _, own, _ = _momenta_of_row(tables, flexible, i, work, modal)
        total += mass
        first = plus(first, plus(times(mass, minus(vector(work, i, POSITION), origin)), c))
        momentum = plus(momentum, own)
    centre = times(1.0 / total, first)
    spin, rotors = none, none
    xx = xy = xz = yy = yz = zz = 0.0
    for i in range(len(tables.rows)):
        mass, c, _, _, own, own_spin = _momenta_of_row(tables, flexible, i, work, modal)
        r, j = minus(minus(vector(work, i, POSITION), origin), centre), symmetric(work, i, J)
        spin = plus(spin, plus(own_spin, cross(r, own)))
        if tables.rows[i, KIND] != INTERFACE:
            rotors = plus(rotors, rotated(matrix(work, i, R), vector(tables.geometry, i, ROTOR)))
        about = mass * dot(r, r) + 2.0 * dot(r, c)
        xx += j[0] + about - mass * r[0] * r[0] - 2.0 * r[0] * c[0]
        xy += j[1] - mass * r[0] * r[1] - r[0] * c[1] - r[1] * c[0]
        xz += j[2] - mass * r[0] * r[2] - r[0] * c[2] - r[2] * c[0]
        yy += j[3] + about - mass * r[1] * r[1] - 2.0 * r[1] * c[1]
        yz += j[4] - mass * r[1] * r[2] - r[1] * c[2] - r[2] * c[1]
        zz += j[5] + about - mass * r[2] * r[2] - 2.0 * r[2] * c[2]
    reals[TOTAL_MASS] = total
    put_three(reals, CENTRE, plus(origin, centre))
    put_three(reals, MOMENTUM, momentum)
    put_three(reals, SPIN, plus(spin, rotors))
    put_three(reals, ROTORS, rotors)
    put_three(reals, LOCKED, (xx, xy, xz))
    put_three(reals, LOCKED + 3, (yy, yz, zz))


@kernel
def _put_rigid_motions(
    tables: Tables, work: np.ndarray, integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray
) -> None:
    """Write the speeds of translations of the scene along the axes of N, and of rotations about its centre of mass."""
    n = tables.sizes[COORDINATES]
    for k in range(6):
        vectors[RIGID + k, :] = 0.0
    centre = three(reals, CENTRE)
    for i in range(len(tables.rows)):
        if tables.rows[i, KIND] != FREE or tables.rows[i, PARENT] >= 0:
            continue
        speed, fixed, axes = n + tables.rows[i, SPEED], matrix(tables.geometry, i, AXES), matrix(work, i, R)
        r = minus(vector(work, i, POSITION), centre)
        for k in range(3):
            along = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
            put_three(vectors[RIGID + k], speed, rotated_back(fixed, along))
            put_three(vectors[RIGID + 3 + k], speed, rotated_back(fixed, cross(along, r)))
            put_three(vectors[RIGID + 3 + k], speed + 3, rotated_back(axes, along))


# Of a prepared call of `balance`: its number
BALANCE_TIME = 0


@entry()
def balance(
    t: float,
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    drives: RealRows,
    inputs: Reals,
    integers: Integers,
    reals: Reals,
    vectors: RealRows,
    memory: Reals,
) -> None:
    """Write what a method asks for by BALANCE.

    The energies of the state AT, and where momenta are kept those, and the rigid motions of the scene. `memory` is of
    the size of that of an evaluation.
    """
    work, modal, acting = _own(tables, flexible, memory)
    at, n, m = vectors[AT], tables.sizes[COORDINATES], tables.sizes[COORDINATES] + tables.sizes[SPEEDS]
    q, u, z = at[:n], at[n:m], at[m : m + tables.sizes[STATES]]
    kinetic, elastic, weight, size = _energies(
        tables, flexible, between, t, drives, inputs, q, u, z, work, modal, acting
    )
    reals[KINETIC], reals[ENERGY], reals[ENERGY_SIZE] = kinetic, kinetic + elastic + weight, kinetic + size
    if integers[KEEPS_MOMENTA]:
        _put_momenta(tables, flexible, work, modal, reals)
        _put_rigid_motions(tables, work, integers, reals, vectors)


@entry()
def balances_of_states(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    times: Reals,
    drives: RealBlocks,
    inputs: RealRows,
    states: RealRows,
    found: RealRows,
    memory: Reals,
) -> None:
    """Write energies and momenta of all of some states.

    Parameters
    ----------
    times : ndarray, shape (T,)
        s.
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, BALANCE_NUMBERS)
        Kinetic, elastic and gravity energy, linear momentum, and angular momentum about N's origin.
    memory : ndarray
        Of the size of that of an evaluation.
    """
    work, modal, acting = _own(tables, flexible, memory)
    n = tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    for k in range(len(states)):
        y, given = states[k], inputs[min(k, len(inputs) - 1)]
        kinetic, elastic, weight, _ = _energies(
            tables,
            flexible,
            between,
            times[k],
            drives[k],
            given,
            y[:n],
            y[n:m],
            y[m : m + tables.sizes[STATES]],
            work,
            modal,
            acting,
        )
        found[k, 0], found[k, 1], found[k, 2] = kinetic, elastic, weight
        momentum, spin = _momenta_about_origin(tables, flexible, work, modal)
        put_three(found[k], 3, momentum)
        put_three(found[k], 6, spin)


@kernel
def _momenta_about_origin(
    tables: Tables, flexible: FlexibleTables, work: np.ndarray, modal: np.ndarray
) -> tuple[Numbers, Numbers]:
    """Return linear momentum, and angular momentum about N's origin with that of rotors."""
    momentum, spin = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(len(tables.rows)):
        _, _, _, _, own, own_spin = _momenta_of_row(tables, flexible, i, work, modal)
        momentum = plus(momentum, own)
        spin = plus(spin, plus(own_spin, cross(vector(work, i, POSITION), own)))
        if tables.rows[i, KIND] != INTERFACE:
            spin = plus(spin, rotated(matrix(work, i, R), vector(tables.geometry, i, ROTOR)))
    return momentum, spin


@expanded
def _own(tables: Tables, flexible: FlexibleTables, memory: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the parts of a memory for rows, modes and loads between frames."""
    rows, modes = WORK * len(tables.rows), flexible.sizes[MODAL_SIZE]
    return memory[:rows].reshape(-1, WORK), memory[rows : rows + modes], memory[rows + modes :]
