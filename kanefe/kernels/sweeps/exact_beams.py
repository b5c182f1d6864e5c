"""Beams that bend far: how their sections move, and their inertia, from the coordinates of their strains.

The kernels of `kanefe.bodies.exact.beam_line` and `kanefe.bodies.exact.inertia`. Their mass matrix M depends on the
state. With its factors ``M = L L^T`` the coordinates ``L^T q`` have unit mass, as the modes of other bodies have:
`to_unit_mass` and `from_unit_mass` convert, and the elimination of `modal_elimination` is the same for both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    congruent,
    cross,
    dot,
    matrix,
    plus,
    product,
    put,
    put_matrix,
    rotated,
    rotated_back,
    symmetric_times,
    three,
    times,
    turned_about_z,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    COUNT,
    DAMPING,
    EXACT,
    EXACT_CELLS,
    EXACT_IN_PLANE,
    EXACT_POINTS,
    EXACT_WORK,
    OMEGA,
    ROTATION_VECTOR,
    SECTION,
    WORK_DETA,
    WORK_ETA,
    WORK_FORCE,
    FlexibleTables,
    R,
    Y,
    Z,
)
from kanefe.kernels.sweeps.body_inertia import put_inertia
from kanefe.kernels.sweeps.elastic import coupling_span, span, total
from kanefe.kernels.sweeps.slopes import slope_motion
from kanefe.kernels.sweeps.turning_steps import turn_of_step

# Numbers of a section in its work: axes, place, velocity, angular velocity, remainder accelerations
AXES_AT, PLACE_AT, V_AT, W_AT, Z_AT, Y_AT = 0, 9, 12, 15, 18, 21

HEAD = 19
"""Numbers of a beam in the pool before its arrays: place, axes, and where the coordinates of each strain begin."""


class Beam(NamedTuple):
    """Constants of a beam of C cells with P Gauss points each: see `kanefe.bodies.exact.beam_line.BeamLine`.

    Attributes
    ----------
    head : ndarray, shape (HEAD,)
    lengths : ndarray, shape (C,)
    integration : ndarray, shape (P + 1, P)
    turn_rest : ndarray, shape (C (P + 1), 9)
    turn_values : ndarray, shape (3 C (P + 1), k)
    values : ndarray, shape (C P, k)
    sections : ndarray, shape (C P, 10)
        Mass, centre of mass and inertia of the Gauss points, kg, m and kg m2.
    stiffness : ndarray, shape (k, k)
    """

    head: np.ndarray
    lengths: np.ndarray
    integration: np.ndarray
    turn_rest: np.ndarray
    turn_values: np.ndarray
    values: np.ndarray
    sections: np.ndarray
    stiffness: np.ndarray


class BeamWork(NamedTuple):
    """What changes with the state of a beam of n sections.

    Attributes
    ----------
    sections : ndarray, shape (n, SECTION)
        Their motion: see the numbers above.
    motions : ndarray, shape (6 n, k)
        Its derivatives by the rates of the coordinates: velocity, angular velocity.
    slopes : ndarray, shape (9, P)
        Of the places of the Gauss points of a cell, along the beam, and their two rates.
    slope_motions : ndarray, shape (3 P, k)
        Derivatives of the first of them.
    rows : ndarray, shape (6, k)
        Workspace.
    mass : ndarray, shape (k, k)
        M in its lower half, or L.
    """

    sections: np.ndarray
    motions: np.ndarray
    slopes: np.ndarray
    slope_motions: np.ndarray
    rows: np.ndarray
    mass: np.ndarray


@inlined
def beam_in(flexible: FlexibleTables, body: np.ndarray) -> Beam:
    """Return the constants of a beam, in the pool."""
    k, C, P, pool = body[COUNT], body[EXACT_CELLS], body[EXACT_POINTS], flexible.pool
    lengths = body[EXACT] + HEAD
    integration = lengths + C
    rest = integration + (P + 1) * P
    turns = rest + 9 * C * (P + 1)
    values = turns + 3 * C * (P + 1) * k
    sections = values + C * P * k
    stiffness = sections + 10 * C * P
    return Beam(
        pool[body[EXACT] : lengths],
        pool[lengths:integration],
        pool[integration:rest].reshape(P + 1, P),
        pool[rest:turns].reshape(C * (P + 1), 9),
        pool[turns:values].reshape(3 * C * (P + 1), k),
        pool[values:sections].reshape(C * P, k),
        pool[sections:stiffness].reshape(C * P, 10),
        pool[stiffness : stiffness + k * k].reshape(k, k),
    )


def beam_work_size(k: int, cells: int, points: int) -> int:
    """Return how many numbers the work of a beam takes."""
    n = 1 + cells * (points + 1)
    return n * (SECTION + 6 * k) + points * (9 + 3 * k) + 6 * k + k * k


@inlined
def beam_work_in(body: np.ndarray, modal: np.ndarray) -> BeamWork:
    """Return the work of a beam, in the modal work."""
    k, C, P = body[COUNT], body[EXACT_CELLS], body[EXACT_POINTS]
    n = 1 + C * (P + 1)
    motions = body[EXACT_WORK] + n * SECTION
    slopes = motions + 6 * n * k
    slope_motions = slopes + 9 * P
    rows = slope_motions + 3 * P * k
    mass = rows + 6 * k
    return BeamWork(
        modal[body[EXACT_WORK] : motions].reshape(n, SECTION),
        modal[motions:slopes].reshape(6 * n, k),
        modal[slopes:slope_motions].reshape(9, P),
        modal[slope_motions:rows].reshape(3 * P, k),
        modal[rows:mass].reshape(6, k),
        modal[mass : mass + k * k].reshape(k, k),
    )


def motion_of_section(body: np.ndarray, station: int) -> int:
    """Return where the motion of a section by the coordinates, (6, k), is in the modal work."""
    k, n = int(body[COUNT]), 1 + int(body[EXACT_CELLS]) * (int(body[EXACT_POINTS]) + 1)
    return int(body[EXACT_WORK]) + n * SECTION + 6 * k * station


@kernel
def move_sections(flexible: FlexibleTables, f: int, modal: np.ndarray) -> None:
    """Write how all sections of a beam move, seen from G (Eq. 22, 24-26 for sections that turn far)."""
    body = flexible.bodies[f]
    C, P, in_plane = body[EXACT_CELLS], body[EXACT_POINTS], body[EXACT_IN_PLANE] > 0
    moving = 2 if in_plane else 3
    beam, at = beam_in(flexible, body), beam_work_in(body, modal)
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    zero = 0.0 * eta[0]
    at.sections[0, :] = zero
    put(at.sections, 0, PLACE_AT, three(beam.head, 0))
    for i in range(9):
        at.sections[0, AXES_AT + i] = zero + beam.head[3 + i]
    at.motions[:, :] = zero
    node = 0
    for c in range(C):
        start = node
        for g in range(P + 1):
            if in_plane:
                _turn_in_plane(beam, c * (P + 1) + g, node, eta, deta, at)
            else:
                _turn(beam, c * (P + 1) + g, node, eta, deta, at)
            node += 1
            if g < P:
                _slope(beam, c * P + g, g, node, eta, deta, moving, at)
        h = beam.lengths[c]
        for g in range(P + 1):
            i, weights = start + 1 + g, beam.integration[g]
            for a in range(3):
                at.sections[i, PLACE_AT + a] = at.sections[start, PLACE_AT + a] + h * total(weights, at.slopes[a])
                at.sections[i, V_AT + a] = at.sections[start, V_AT + a] + h * total(weights, at.slopes[3 + a])
                at.sections[i, Z_AT + a] = at.sections[start, Z_AT + a] + h * total(weights, at.slopes[6 + a])
            for a in range(moving):
                _integrate(at.motions[6 * start + a], h, weights, at.slope_motions, a, at.motions[6 * i + a])


@inlined
def _curved(beam: Beam, row: int, which: int, x: np.ndarray) -> Numbers:
    """Return one of the three vectors of a step times coordinates."""
    values, twist, y, z = beam.turn_values[3 * row + which], int(beam.head[15]), int(beam.head[16]), int(beam.head[17])
    end = int(beam.head[18])
    return total(values[twist:y], x[twist:y]), total(values[y:z], x[y:z]), total(values[z:end], x[z:end])


@inlined
def _turn(beam: Beam, row: int, node: int, eta: np.ndarray, deta: np.ndarray, at: BeamWork) -> None:
    """Write axes and rotation of the next section."""
    rest = three(beam.turn_rest[row], 0), three(beam.turn_rest[row], 3), three(beam.turn_rest[row], 6)
    a1 = plus(rest[0], _curved(beam, row, 0, eta))
    a2 = plus(rest[1], _curved(beam, row, 1, eta))
    a3 = plus(rest[2], _curved(beam, row, 2, eta))
    d1, d2, d3 = _curved(beam, row, 0, deta), _curved(beam, row, 1, deta), _curved(beam, row, 2, deta)
    omega, rate, second, by_a1, by_a2, by_a3 = turn_of_step(a1, a2, a3, d1, d2, d3)
    E, T, remainder = slope_motion(ROTATION_VECTOR, omega, rate)
    A, w = matrix(at.sections, node, AXES_AT), vector(at.sections, node, W_AT)
    AT = product(A, T)
    spin = rotated(AT, rate)
    put_matrix(at.sections, node + 1, AXES_AT, product(A, E))
    put(at.sections, node + 1, W_AT, plus(w, spin))
    twist = plus(rotated(AT, second), rotated(A, remainder))
    put(at.sections, node + 1, Y_AT, plus(vector(at.sections, node, Y_AT), plus(cross(w, spin), twist)))
    first, middle, last = product(AT, by_a1), product(AT, by_a2), product(AT, by_a3)
    values, begins = beam.turn_values[3 * row : 3 * row + 3], beam.head[12:HEAD]
    for a in range(3):
        old, new = at.motions[6 * node + 3 + a], at.motions[6 * node + 9 + a]
        for j in range(int(begins[3])):
            new[j] = old[j]
        for strain in range(3):
            x, y, z = first[3 * a + strain], middle[3 * a + strain], last[3 * a + strain]
            _add_three(int(begins[3 + strain]), int(begins[4 + strain]), x, y, z, values, old, new)


@inlined
def _turn_in_plane(beam: Beam, row: int, node: int, eta: np.ndarray, deta: np.ndarray, at: BeamWork) -> None:
    """Write axes and rotation of the next section of a beam that turns about z alone: brackets are zero."""
    begin, end, rest = int(beam.head[17]), int(beam.head[18]), beam.turn_rest[row]
    middle, curved = beam.turn_values[3 * row], beam.turn_values[3 * row + 2]
    angle, rate = rest[2] + rest[8] / 12.0, 0.0 * eta[0]
    angle = angle + total(middle[begin:end], eta[begin:end]) + total(curved[begin:end], eta[begin:end]) / 12.0
    rate = rate + total(middle[begin:end], deta[begin:end]) + total(curved[begin:end], deta[begin:end]) / 12.0
    A, w = matrix(at.sections, node, AXES_AT), vector(at.sections, node, W_AT)
    put_matrix(at.sections, node + 1, AXES_AT, turned_about_z(A, angle))
    put(at.sections, node + 1, W_AT, (w[0], w[1], w[2] + A[8] * rate))
    put(at.sections, node + 1, Y_AT, vector(at.sections, node, Y_AT))
    old, new = at.motions[6 * node + 5], at.motions[6 * node + 11]
    for j in range(begin):
        new[j] = old[j]
    for j in range(begin, end):
        new[j] = old[j] + A[8] * (middle[j] + curved[j] / 12.0)


@vector_kernel
def _add_three(
    begin: int, end: int, x: float, y: float, z: float, values: np.ndarray, old: np.ndarray, new: np.ndarray
) -> None:
    """Write a row plus weighted rows."""
    for j in range(begin, end):
        new[j] = old[j] + x * values[0, j] + y * values[1, j] + z * values[2, j]


@inlined
def _slope(
    beam: Beam, row: int, g: int, node: int, eta: np.ndarray, deta: np.ndarray, moving: int, at: BeamWork
) -> None:
    """Write the derivative of the place along the beam at a Gauss point, A t, and its rates."""
    values, begins = beam.values[row], beam.head[12:HEAD]
    x, y, z, end = int(begins[0]), int(begins[1]), int(begins[2]), int(begins[3])
    A, w, turn = matrix(at.sections, node, AXES_AT), vector(at.sections, node, W_AT), vector(at.sections, node, Y_AT)
    stretched = total(values[x:y], eta[x:y]), total(values[y:z], eta[y:z]), total(values[z:end], eta[z:end])
    rate = total(values[x:y], deta[x:y]), total(values[y:z], deta[y:z]), total(values[z:end], deta[z:end])
    t = rotated(A, (1.0 + stretched[0], stretched[1], stretched[2]))
    stretch, swing = rotated(A, rate), cross(w, t)
    velocity = plus(swing, stretch)
    pull = plus(cross(turn, t), cross(w, plus(swing, times(2.0, stretch))))
    for a in range(3):
        at.slopes[a, g], at.slopes[3 + a, g], at.slopes[6 + a, g] = t[a], velocity[a], pull[a]
    for a in range(moving):
        b, d = (a + 1) % 3, (a + 2) % 3
        # W_j x t
        _cross_rows(t[d], at.motions[6 * node + 3 + b], t[b], at.motions[6 * node + 3 + d], at.slope_motions[3 * g + a])
        for j in range(x, y):
            at.slope_motions[3 * g + a, j] += A[3 * a] * values[j]
        for j in range(y, z):
            at.slope_motions[3 * g + a, j] += A[3 * a + 1] * values[j]
        for j in range(z, end):
            at.slope_motions[3 * g + a, j] += A[3 * a + 2] * values[j]


@vector_kernel
def _cross_rows(s: float, first: np.ndarray, r: float, second: np.ndarray, out: np.ndarray) -> None:
    """Write ``s first - r second``."""
    for j in range(len(out)):
        out[j] = s * first[j] - r * second[j]


@vector_kernel
def _integrate(start: np.ndarray, h: float, weights: np.ndarray, rows: np.ndarray, a: int, out: np.ndarray) -> None:
    """Write a row plus h times the weighted sum of every third row from a."""
    for j in range(len(out)):
        out[j] = start[j]
    for g in range(len(weights)):
        weight = h * weights[g]
        row = rows[3 * g + a]
        for j in range(len(out)):
            out[j] += weight * row[j]


@kernel
def set_exact(flexible: FlexibleTables, f: int, i: int, work: np.ndarray, modal: np.ndarray) -> None:
    """Write what `set_flexible` does, for a beam, and the mass of its coordinates (Eq. 38)."""
    body = flexible.bodies[f]
    k = body[COUNT]
    beam, at = beam_in(flexible, body), beam_work_in(body, modal)
    eta, deta, p = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)], modal[span(body, WORK_FORCE)]
    coupling = modal[coupling_span(body)].reshape(6, k)
    G = matrix(work, i, R)
    w = rotated_back(G, vector(work, i, OMEGA))
    a, alpha = rotated_back(G, vector(work, i, Z)), rotated_back(G, vector(work, i, Y))
    zero = 0.0 * G[0]
    coupling[:, :] = zero
    at.mass[:, :] = zero
    _resist(flexible, body, beam, eta, deta, p)
    mass = 0.0
    first, force, moment = (zero, zero, zero), (zero, zero, zero), (zero, zero, zero)
    xx = xy = xz = yy = yz = zz = zero
    P = body[EXACT_POINTS]
    for n in range(len(beam.sections)):
        node = 1 + n + n // P  # after the Gauss points of a cell there is its end
        m, own = beam.sections[n, 0], vector(at.sections, node, W_AT)
        A = matrix(at.sections, node, AXES_AT)
        arm = rotated(A, vector(beam.sections, n, 1))
        r = plus(vector(at.sections, node, PLACE_AT), arm)
        of_section = beam.sections[n]
        inertia = congruent(
            A, (of_section[4], of_section[5], of_section[6], of_section[7], of_section[8], of_section[9])
        )
        swing = cross(own, arm)
        velocity = plus(vector(at.sections, node, V_AT), swing)
        inner = plus(
            vector(at.sections, node, Z_AT), plus(cross(vector(at.sections, node, Y_AT), arm), cross(own, swing))
        )
        carried = plus(a, plus(cross(alpha, r), cross(w, plus(cross(w, r), times(2.0, velocity)))))
        pull = times(m, plus(carried, inner))
        spin = plus(w, own)
        turning = plus(alpha, plus(vector(at.sections, node, Y_AT), cross(w, own)))
        twist = plus(symmetric_times(inertia, turning), cross(spin, symmetric_times(inertia, spin)))
        force, moment = plus(force, pull), plus(moment, plus(cross(r, pull), twist))
        mass += m
        first = plus(first, times(m, r))
        square = m * dot(r, r)
        xx += inertia[0] + square - m * r[0] * r[0]
        xy += inertia[1] - m * r[0] * r[1]
        xz += inertia[2] - m * r[0] * r[2]
        yy += inertia[3] + square - m * r[1] * r[1]
        yz += inertia[4] - m * r[1] * r[2]
        zz += inertia[5] + square - m * r[2] * r[2]
        rows = at.motions[6 * node : 6 * node + 6]
        if body[EXACT_IN_PLANE]:
            _couple_in_plane(rows, m, arm, r, inertia, pull, plus(cross(arm, pull), twist), p, coupling, at.rows)
            _add_mass_in_plane(rows, at.rows, at.mass)
        else:
            _couple(rows, m, arm, r, inertia, pull, plus(cross(arm, pull), twist), p, coupling, at.rows)
            _add_mass(rows, at.rows, at.mass)
    put_inertia(
        work, i, mass, rotated(G, first), congruent(G, (xx, xy, xz, yy, yz, zz)), rotated(G, force), rotated(G, moment)
    )


@inlined
def _resist(
    flexible: FlexibleTables, body: np.ndarray, beam: Beam, eta: np.ndarray, deta: np.ndarray, p: np.ndarray
) -> None:
    """Write the forces of stiffness and damping on the coordinates."""
    k = body[COUNT]
    for j in range(k):
        p[j] = -total(beam.stiffness[j], eta)
    if body[DAMPING] >= 0:
        C = flexible.pool[body[DAMPING] : body[DAMPING] + k * k].reshape(k, k)
        for j in range(k):
            p[j] -= total(C[j], deta)


@vector_kernel
def _couple(
    motion: np.ndarray,
    m: float,
    arm: Numbers,
    r: Numbers,
    inertia: Numbers,
    pull: Numbers,
    twist: Numbers,
    p: np.ndarray,
    coupling: np.ndarray,
    rows: np.ndarray,
) -> None:
    """Add forces on the coordinates and inertia between them and G; write m V and I W of the section to `rows`."""
    for j in range(len(p)):
        w0, w1, w2 = motion[3, j], motion[4, j], motion[5, j]
        p[j] -= (
            motion[0, j] * pull[0]
            + motion[1, j] * pull[1]
            + motion[2, j] * pull[2]
            + w0 * twist[0]
            + w1 * twist[1]
            + w2 * twist[2]
        )
        v0 = m * (motion[0, j] + w1 * arm[2] - w2 * arm[1])
        v1 = m * (motion[1, j] + w2 * arm[0] - w0 * arm[2])
        v2 = m * (motion[2, j] + w0 * arm[1] - w1 * arm[0])
        s0 = inertia[0] * w0 + inertia[1] * w1 + inertia[2] * w2
        s1 = inertia[1] * w0 + inertia[3] * w1 + inertia[4] * w2
        s2 = inertia[2] * w0 + inertia[4] * w1 + inertia[5] * w2
        rows[0, j], rows[1, j], rows[2, j] = v0, v1, v2
        # spin about the origin of the section, which motion[3:] moves
        rows[3, j] = s0 + arm[1] * v2 - arm[2] * v1
        rows[4, j] = s1 + arm[2] * v0 - arm[0] * v2
        rows[5, j] = s2 + arm[0] * v1 - arm[1] * v0
        coupling[0, j] += v0
        coupling[1, j] += v1
        coupling[2, j] += v2
        coupling[3, j] += s0 + r[1] * v2 - r[2] * v1
        coupling[4, j] += s1 + r[2] * v0 - r[0] * v2
        coupling[5, j] += s2 + r[0] * v1 - r[1] * v0


@vector_kernel
def _add_mass(motion: np.ndarray, rows: np.ndarray, mass: np.ndarray) -> None:
    """Add what a section gives to the lower half of M: its motion times its momenta."""
    for i in range(len(mass)):
        a, b, c, d, e, f = motion[0, i], motion[1, i], motion[2, i], motion[3, i], motion[4, i], motion[5, i]
        row = mass[i]
        for j in range(i + 1):
            row[j] += (
                a * rows[0, j] + b * rows[1, j] + c * rows[2, j] + d * rows[3, j] + e * rows[4, j] + f * rows[5, j]
            )


@vector_kernel
def _couple_in_plane(
    motion: np.ndarray,
    m: float,
    arm: Numbers,
    r: Numbers,
    inertia: Numbers,
    pull: Numbers,
    twist: Numbers,
    p: np.ndarray,
    coupling: np.ndarray,
    rows: np.ndarray,
) -> None:
    """Do what `_couple` does where sections move along x and y and turn about z."""
    for j in range(len(p)):
        w = motion[5, j]
        p[j] -= motion[0, j] * pull[0] + motion[1, j] * pull[1] + w * twist[2]
        v0, v1 = m * (motion[0, j] - w * arm[1]), m * (motion[1, j] + w * arm[0])
        rows[0, j], rows[1, j], rows[5, j] = v0, v1, inertia[5] * w + arm[0] * v1 - arm[1] * v0
        coupling[0, j] += v0
        coupling[1, j] += v1
        coupling[3, j] += inertia[2] * w - r[2] * v1
        coupling[4, j] += inertia[4] * w + r[2] * v0
        coupling[5, j] += inertia[5] * w + r[0] * v1 - r[1] * v0


@vector_kernel
def _add_mass_in_plane(motion: np.ndarray, rows: np.ndarray, mass: np.ndarray) -> None:
    """Do what `_add_mass` does where sections move along x and y and turn about z."""
    for i in range(len(mass)):
        a, b, c = motion[0, i], motion[1, i], motion[5, i]
        row = mass[i]
        for j in range(i + 1):
            row[j] += a * rows[0, j] + b * rows[1, j] + c * rows[5, j]


@inlined
def section_motion(
    flexible: FlexibleTables, body: np.ndarray, station: int, at_rest: Numbers, modal: np.ndarray
) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Return place, axes, velocity, angular velocity and remainder accelerations of a section seen from G."""
    at = beam_work_in(body, modal)
    return (
        vector(at.sections, station, PLACE_AT),
        product(matrix(at.sections, station, AXES_AT), at_rest),
        vector(at.sections, station, V_AT),
        vector(at.sections, station, W_AT),
        vector(at.sections, station, Z_AT),
        vector(at.sections, station, Y_AT),
    )


@inlined
def energies_of_beam(
    flexible: FlexibleTables, body: np.ndarray, eta: np.ndarray, deta: np.ndarray, modal: np.ndarray
) -> tuple[float, float]:
    """Return deta^T M deta and the strain energy."""
    mass, stiffness = beam_work_in(body, modal).mass, beam_in(flexible, body).stiffness
    own = strain = 0.0
    for i in range(len(eta)):
        own += deta[i] * (2.0 * total(mass[i, :i], deta[:i]) + mass[i, i] * deta[i])
        strain += 0.5 * eta[i] * total(stiffness[i], eta)
    return own, strain


@kernel
def stiffen_beam(
    flexible: FlexibleTables,
    f: int,
    share_damping: float,
    share_stiffness: float,
    damping_direction: np.ndarray,
    stiffness_direction: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Add ``s C + r K`` to the mass of a beam, and directional products to its forces: see `implicit`."""
    body = flexible.bodies[f]
    k = body[COUNT]
    beam, at, p = beam_in(flexible, body), beam_work_in(body, modal), modal[span(body, WORK_FORCE)]
    is_damped = body[DAMPING] >= 0
    place = body[DAMPING] if is_damped else body[EXACT]
    C = flexible.pool[place : place + k * k].reshape(k, k)  # read where there is damping
    for i in range(k):
        p[i] += total(beam.stiffness[i], stiffness_direction)
        if is_damped:
            p[i] += total(C[i], damping_direction)
        for j in range(i + 1):
            at.mass[i, j] += share_stiffness * beam.stiffness[i, j]
            if is_damped:
                at.mass[i, j] += share_damping * C[i, j]


@kernel
def scale_beams(flexible: FlexibleTables, modal: np.ndarray) -> None:
    """Factor the mass of all beams, and write their forces and couplings for coordinates of unit mass."""
    for f in range(len(flexible.bodies)):
        body = flexible.bodies[f]
        if body[EXACT] < 0:
            continue
        at, k = beam_work_in(body, modal), body[COUNT]
        L = at.mass
        for i in range(k):
            for j in range(i):
                L[i, j] = (L[i, j] - total(L[i, :j], L[j, :j])) / L[j, j]
            L[i, i] = np.sqrt(L[i, i] - total(L[i, :i], L[i, :i]))
        _divide(L, modal[span(body, WORK_FORCE)])
        coupling = modal[coupling_span(body)].reshape(6, k)
        for a in range(6):
            _divide(L, coupling[a])


@inlined
def _divide(L: np.ndarray, x: np.ndarray) -> None:
    """Replace x by L^-1 x."""
    for i in range(len(x)):
        x[i] = (x[i] - total(L[i, :i], x[:i])) / L[i, i]


@kernel
def to_unit_mass(body: np.ndarray, rows: np.ndarray, modal: np.ndarray) -> None:
    """Replace each row, of forces or of a motion by the coordinates of a beam, by that of coordinates of unit mass."""
    L = beam_work_in(body, modal).mass
    for a in range(len(rows)):
        _divide(L, rows[a])


@kernel
def from_unit_mass(body: np.ndarray, x: np.ndarray, modal: np.ndarray) -> None:
    """Replace accelerations of coordinates of unit mass by those of the coordinates of a beam, L^-T x."""
    L = beam_work_in(body, modal).mass
    for i in range(len(x) - 1, -1, -1):
        x[i] = x[i] / L[i, i]
        for j in range(i):
            x[j] -= L[i, j] * x[i]
