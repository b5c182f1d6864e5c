"""Energy, momenta and rigid motions of a whole scene at a state: what a method that keeps them asks for.

All is summed over the rows after `sweep_outward` and `set_inertia`, in components of N. Momenta are told about the
centre of mass of the scene, which keeps them sharp however far away it drifts.
"""

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import BorderedBodies
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import RealRows, Reals, Record, Rows, entry, inlined, kernel
from kanefe.kernels.loads.coordinate_law import CoordinateLaws, coordinate_potential
from kanefe.kernels.loads.joint_forces import JointForces, along
from kanefe.kernels.loads.loads_between import potential_between
from kanefe.kernels.loads.telling import States, state_at
from kanefe.kernels.scene import Scene, Sizes, State, Work, bodies_of, links_of, state_in, work_in
from kanefe.kernels.steppers.step_commands import BalancedStep, StepArrays
from kanefe.kernels.sweeps.body_inertia import first_moment
from kanefe.kernels.sweeps.elastic import combination
from kanefe.kernels.sweeps.exact_beam_inertia import energies_of_beam
from kanefe.kernels.sweeps.fluid import weighed
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tables import Tables
from kanefe.kernels.tree import Frame, Kind, Link
from kanefe.kernels.values.tensors import NO_INERTIA, ZERO, Vector, cross, diagonal, dot, outer, symmetric


class Balance(Record):
    """Energies (J) and momenta of a state.

    Attributes
    ----------
    kinetic, elastic, weight : float
        The latter by gravity.
    momentum, spin : Vector
        Linear, kg m/s, and angular about N's origin, kg m2/s.
    """

    kinetic: float
    elastic: float
    weight: float
    momentum: Vector
    spin: Vector


Balances = Rows[Balance]


@kernel
def _energies(scene: Scene, state: State, work: Work) -> tuple[float, float, float, float]:
    """Sweep a state; return kinetic, elastic and gravity energy, and the sum of the sizes of the latter two's parts."""
    sweep_outward(scene, state, work, False)
    set_inertia(scene, work)
    links, frames, bodies = links_of(scene), work.frames, bodies_of(scene, work)
    kinetic, weight, gravity = 0.0, 0.0, three(scene.tables.gravity, 0)
    elastic = _joint_energy(scene.tables, state) + potential_between(scene, state, work)
    size = abs(elastic)
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        momentum, spin = _momenta_of_row(link, frame, bodies)
        kinetic += 0.5 * (dot(frame.v, momentum) + dot(frame.w, spin))
        if has_modes(link):
            of_modes, strain = _modal_energies(scene, work, link.flexible, frame)
            kinetic += of_modes
            elastic += strain
            size += strain
        if link.armature > 0.0:
            kinetic += 0.5 * link.armature * _square_of_rates(link, state)
        if link.has_gravity:
            fall = dot(gravity, _weighed(link, frame, bodies))
            weight -= fall
            size += abs(fall)
    return kinetic, elastic, weight, size


@inlined
def _square_of_rates(link: Link, state: State) -> float:
    """Return the sum of the squares of the speeds of a link."""
    if link.kind != Kind.SPHERICAL and link.kind != Kind.FREE:
        _, rate = along(state, link.coordinate if link.drive < 0 else -1 - link.drive, link.speed)
        return rate * rate
    turn = three(state.u, link.speed)
    found = dot(turn, turn)
    if link.kind == Kind.FREE:
        turn = three(state.u, link.speed + 3)
        found += dot(turn, turn)
    return found


@inlined
def has_modes(link: Link) -> bool:
    """Return whether the body of a row is a flexible one."""
    return link.kind != Kind.INTERFACE and link.flexible >= 0


@inlined
def _weighed(link: Link, frame: Frame, bodies: BorderedBodies) -> Vector:
    """Return mass times centre of mass of a row, from N's origin; a fluid has no weight."""
    if has_modes(link) and bodies[link.flexible].wet >= 0:
        return weighed(bodies[link.flexible], frame)
    return frame.M @ frame.p + first_moment(frame.H)


@kernel
def _momenta_of_row(link: Link, frame: Frame, bodies: BorderedBodies) -> tuple[Vector, Vector]:
    """Return momentum and angular momentum of a row about its origin, without rotors."""
    momentum, spin = frame.M @ frame.v + frame.H @ frame.w, frame.H.T @ frame.v + frame.J @ frame.w
    if has_modes(link):
        body, G = bodies[link.flexible], frame.R
        momentum += G @ combination(body.linear, body.deta)
        spin += G @ combination(body.angular, body.deta)
    return momentum, spin


@kernel
def _modal_energies(scene: Scene, work: Work, f: int, frame: Frame) -> tuple[float, float]:
    """Return the kinetic energy of the modes, beyond their share in the momenta, and their strain energy."""
    body = bodies_of(scene, work)[f]
    eta, deta, stiffness, back = body.eta, body.deta, body.stiffness, frame.R.T
    carried = dot(back @ frame.v, combination(body.linear, deta)) + dot(back @ frame.w, combination(body.angular, deta))
    if body.is_exact:
        own, strain = energies_of_beam(ExactBeam(body))
        return 0.5 * (carried + own), strain
    own = strain = 0.0
    for j in range(body.k):
        own += deta[j] * deta[j]
        strain += 0.5 * stiffness[j] * eta[j] * eta[j]
    return 0.5 * (carried + own), strain


@kernel
def _joint_energy(tables: Tables, state: State) -> float:
    """Return the energy in springs and stops along joint coordinates."""
    forces, laws, energy = JointForces(tables.joint_forces), CoordinateLaws(tables.laws), 0.0
    for n in range(len(forces)):
        force = forces[n]
        if force.law >= 0:
            position, _ = along(state, force.coordinate, force.speed)
            energy += coordinate_potential(laws[force.law], position)
    return energy


@kernel
def _put_momenta(scene: Scene, work: Work, step: BalancedStep) -> None:
    """Write mass, centre of mass, momenta about it, and the inertia about it as of one rigid body."""
    links, frames, bodies = links_of(scene), work.frames, bodies_of(scene, work)
    origin = frames[0].p  # moments about a place in the scene: it may be far from N's origin
    total, first, momentum = 0.0, ZERO, ZERO
    for i in range(len(links)):
        frame = frames[i]
        own, _ = _momenta_of_row(links[i], frame, bodies)
        total += frame.M.full.x.x
        first += frame.M @ (frame.p - origin) + first_moment(frame.H)
        momentum += own
    centre = (1.0 / total) * first
    spin, rotors, locked = ZERO, ZERO, NO_INERTIA
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        own, own_spin = _momenta_of_row(link, frame, bodies)
        r, c = frame.p - origin - centre, first_moment(frame.H)
        first, spin = frame.M @ r + c, spin + own_spin + cross(r, own)
        if link.kind != Kind.INTERFACE:
            rotors += frame.R @ link.rotor
        locked += frame.J + diagonal(dot(r, first + c)) - symmetric(outer(r, first) + outer(c, r))
    step.mass, step.centre, step.locked = total, origin + centre, locked
    step.momentum, step.spin, step.rotors = momentum, spin + rotors, rotors


@kernel
def _put_rigid_motions(scene: Scene, work: Work, step: BalancedStep) -> None:
    """Write the speeds of translations of the scene along the axes of N, and of rotations about its centre of mass."""
    n, rigid = Sizes(scene.tables.sizes).coordinate_count, step.rigid
    rigid[:] = 0.0
    centre, links, frames = step.centre, links_of(scene), work.frames
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        if link.kind != Kind.FREE or link.parent >= 0:
            continue
        speed, r = n + link.speed, frame.p - centre
        for k in range(3):
            along = Vector(1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
            put_three(rigid[k], speed, link.axes.T @ along)
            put_three(rigid[3 + k], speed, link.axes.T @ cross(along, r))
            put_three(rigid[3 + k], speed + 3, frame.R.T @ along)


# Of a prepared call of `balance`: its number
BALANCE_TIME = 0


@entry()
def balance(t: float, scene: Scene, drives: RealRows, inputs: Reals, arrays: StepArrays, memory: Reals) -> None:
    """Write what a method asks for by BALANCE: see `BalancedStep`.

    The energies of the state `at`, and where momenta are kept those, and the rigid motions of the scene. `memory` is of
    the size of that of an evaluation.
    """
    work, step = work_in(scene, memory), BalancedStep(*arrays)
    kinetic, elastic, weight, size = _energies(scene, state_in(scene.tables, t, step.at, drives, inputs), work)
    step.kinetic, step.energy, step.energy_size = kinetic, kinetic + elastic + weight, kinetic + size
    if step.keeps_momenta:
        _put_momenta(scene, work, step)
        _put_rigid_motions(scene, work, step)


@entry()
def balances_of_states(scene: Scene, states: States, found: RealRows, memory: Reals) -> None:
    """Write energies and momenta of all of some states.

    Parameters
    ----------
    scene : Scene
    states : States
    found : ndarray
        `Balances`, of each.
    memory : ndarray
        Of the size of that of an evaluation.
    """
    work, told = work_in(scene, memory), Balances(found)
    for k in range(len(states.states)):
        one = told[k]
        one.kinetic, one.elastic, one.weight, _ = _energies(scene, state_at(scene, states, k), work)
        one.momentum, one.spin = _momenta_about_origin(scene, work)


@kernel
def _momenta_about_origin(scene: Scene, work: Work) -> tuple[Vector, Vector]:
    """Return linear momentum, and angular momentum about N's origin with that of rotors."""
    links, frames, bodies = links_of(scene), work.frames, bodies_of(scene, work)
    momentum, spin = ZERO, ZERO
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        own, own_spin = _momenta_of_row(link, frame, bodies)
        momentum += own
        spin += own_spin + cross(frame.p, own)
        if link.kind != Kind.INTERFACE:
            spin += frame.R @ link.rotor
    return momentum, spin
