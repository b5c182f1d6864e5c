"""Inertia, stiffness and energy of beams that bend far, from the motion of their sections.

The kernels of `kanefe.bodies.exact.inertia`.
"""

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.language import inlined, kernel, vector_kernel, vectors
from kanefe.kernels.sweeps.body_inertia import put_inertia
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.tree import Frame
from kanefe.kernels.values.tensors import NO_INERTIA, Symmetric, Vector, congruent, cross, diagonal, dot, square


class Carried(NamedTuple):
    """Mass at a section, and what it needs with the coordinates at rest, in G.

    Attributes
    ----------
    mass : float
    arm, r : Vector
        Centre of mass from the origins of the section and of G.
    inertia : Symmetric
        About it.
    pull, twist : Vector
        Force, and moment about the origin of the section.
    """

    mass: float
    arm: Vector
    r: Vector
    inertia: Symmetric
    pull: Vector
    twist: Vector


@kernel
def set_exact(beam: ExactBeam, frame: Frame) -> None:
    """Write what `set_flexible` does, for a beam, and the mass of its coordinates (Eq. 38)."""
    back, masses, sections, P = frame.R.T, beam.masses, beam.sections, beam.point_count
    w, a, alpha = back @ frame.w, back @ frame.Z, back @ frame.Y
    beam.linear.numbers[:] = 0.0
    beam.angular.numbers[:] = 0.0
    is_kept = beam.kept[0] != 0.0  # with the factors of the mass
    if not is_kept:
        beam.inertia_of_rates[:, :] = 0.0
    _resist(beam)
    mass, first, force, moment, J = 0.0, 0.0 * w, 0.0 * w, 0.0 * w, NO_INERTIA
    for n in range(len(masses)):
        node, point = 1 + n + n // P, masses[n]  # after the Gauss points of a cell there is its end
        section, m = sections[node], point.mass
        own, arm, inertia = section.w, section.A @ point.centre, congruent(section.A, point.inertia)
        r, swing = section.p + arm, cross(own, arm)
        inner = section.Z + cross(section.Y, arm) + cross(own, swing)
        pull = m * (a + cross(alpha, r) + cross(w, cross(w, r) + 2.0 * (section.v + swing)) + inner)
        spin = w + own
        twist = inertia @ (alpha + section.Y + cross(w, own)) + cross(spin, inertia @ spin)
        force, moment = force + pull, moment + cross(r, pull) + twist
        mass, first = mass + m, first + m * r
        J += inertia + m * (diagonal(dot(r, r)) - square(r, r))
        carried = Carried(m, arm, r, inertia, pull, cross(arm, pull) + twist)
        if beam.in_plane:
            _couple_in_plane(beam, node, carried)
            if not is_kept:
                _add_mass_in_plane(beam.motions[6 * node : 6 * node + 6], beam.momenta, beam.inertia_of_rates)
        else:
            _couple(beam, node, carried)
            if not is_kept:
                _add_mass(beam, node)
    G = frame.R
    put_inertia(frame, mass, G @ first, congruent(G, J), G @ force, G @ moment)


@inlined
def _resist(beam: ExactBeam) -> None:
    """Write the forces of stiffness and damping on the coordinates."""
    p, eta, deta, resistance = beam.p, beam.eta, beam.deta, beam.resistance
    for j in range(len(p)):
        p[j] = -total(resistance[j], eta)
    if beam.damped >= 0:
        damping = beam.damping
        for j in range(len(p)):
            p[j] -= total(damping[j], deta)


@vector_kernel
def _couple(beam: ExactBeam, node: int, carried: Carried) -> None:
    """Add forces on the coordinates and inertia between them and G; write the momenta of a section by the rates."""
    motion, p, linear, angular = beam.motions[6 * node : 6 * node + 6], beam.p, beam.linear, beam.angular
    velocities, turns = vectors(motion[:3]), vectors(motion[3:])
    momenta, spins = vectors(beam.momenta[:3]), vectors(beam.momenta[3:])
    arm, r, inertia = carried.arm, carried.r, carried.inertia
    for j in range(len(p)):
        velocity, turn = velocities[j], turns[j]
        p[j] -= dot(velocity, carried.pull) + dot(turn, carried.twist)
        momentum, spin = carried.mass * (velocity + cross(turn, arm)), inertia @ turn
        momenta[j], spins[j] = momentum, spin + cross(arm, momentum)  # about the origin, which `motion` moves
        linear[j], angular[j] = linear[j] + momentum, angular[j] + spin + cross(r, momentum)


@vector_kernel
def _add_mass(beam: ExactBeam, node: int) -> None:
    """Add what a section gives to the lower half of M: its motion times its momenta."""
    mass, motion, rows = beam.inertia_of_rates, beam.motions[6 * node : 6 * node + 6], beam.momenta
    for i in range(len(mass)):
        a, b, c, d, e, f = motion[0, i], motion[1, i], motion[2, i], motion[3, i], motion[4, i], motion[5, i]
        row = mass[i]
        for j in range(i + 1):
            row[j] += (
                a * rows[0, j] + b * rows[1, j] + c * rows[2, j] + d * rows[3, j] + e * rows[4, j] + f * rows[5, j]
            )


@vector_kernel
def _couple_in_plane(beam: ExactBeam, node: int, carried: Carried) -> None:
    """Do what `_couple` does where sections move along x and y and turn about z."""
    motion, rows, p = beam.motions[6 * node : 6 * node + 6], beam.momenta, beam.p
    linear, angular = beam.linear, beam.angular
    m, arm, r, pull, twist, about_z = (
        carried.mass,
        carried.arm,
        carried.r,
        carried.pull,
        carried.twist,
        carried.inertia.full.z,
    )
    for j in range(len(p)):
        turn = motion[5, j]
        p[j] -= motion[0, j] * pull.x + motion[1, j] * pull.y + turn * twist.z
        momentum = Vector(m * (motion[0, j] - turn * arm.y), m * (motion[1, j] + turn * arm.x), 0.0)
        spin = turn * about_z
        rows[0, j], rows[1, j] = momentum.x, momentum.y
        rows[5, j] = spin.z + arm.x * momentum.y - arm.y * momentum.x
        linear[j], angular[j] = linear[j] + momentum, angular[j] + spin + cross(r, momentum)


@vector_kernel
def _add_mass_in_plane(motion: np.ndarray, rows: np.ndarray, mass: np.ndarray) -> None:
    """Do what `_add_mass` does where sections move along x and y and turn about z."""
    for i in range(len(mass)):
        a, b, c = motion[0, i], motion[1, i], motion[5, i]
        row = mass[i]
        for j in range(i + 1):
            row[j] += a * rows[0, j] + b * rows[1, j] + c * rows[5, j]


@inlined
def energies_of_beam(beam: ExactBeam) -> tuple[float, float]:
    """Return deta^T M deta and the strain energy."""
    mass, stiffness, eta, deta = beam.inertia_of_rates, beam.resistance, beam.eta, beam.deta
    own = strain = 0.0
    for i in range(len(eta)):
        own += deta[i] * (2.0 * total(mass[i, :i], deta[:i]) + mass[i, i] * deta[i])
        strain += 0.5 * eta[i] * total(stiffness[i], eta)
    return own, strain


@kernel
def stiffen_beam(beam: ExactBeam, pushes: Any) -> None:
    """Add ``s C + r K`` to the mass of a beam, and directional products to its forces: see `implicit`.

    `pushes`: `kanefe.kernels.sweeps.implicit.Pushes` along the coordinates of the beam.
    """
    p, K, mass = beam.p, beam.resistance, beam.inertia_of_rates
    for i in range(len(p)):
        p[i] += total(K[i], pushes.along_stiffness)
        for j in range(i + 1):
            mass[i, j] += pushes.stiffness * K[i, j]
    if beam.damped >= 0:
        C = beam.damping
        for i in range(len(p)):
            p[i] += total(C[i], pushes.along_damping)
            for j in range(i + 1):
                mass[i, j] += pushes.damping * C[i, j]
