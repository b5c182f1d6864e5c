"""Beams that bend far: how their sections move, from the coordinates of their strains.

The kernels of `kanefe.bodies.exact.beam_line`.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    matrix,
    plus,
    product,
    put,
    put_matrix,
    rotated,
    three,
    times,
    turned_about_z,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    COUNT,
    DETA,
    ETA,
    EXACT_CELLS,
    EXACT_IN_PLANE,
    EXACT_POINTS,
    ROTATION_VECTOR,
    WORK_DETA,
    WORK_ETA,
)
from kanefe.kernels.sweeps.elastic import span, total
from kanefe.kernels.sweeps.exact_beam_layout import (
    AXES_AT,
    BEGINS,
    HEAD,
    PLACE_AT,
    ROOT,
    V_AT,
    W_AT,
    Y_AT,
    Z_AT,
    Beam,
    BeamWork,
    beam_in,
    beam_work_in,
)
from kanefe.kernels.sweeps.slopes import slope_motion
from kanefe.kernels.sweeps.turning_steps import turn_of_step
from kanefe.kernels.tables import FlexibleTables


@kernel
def is_as_before(flexible: FlexibleTables, f: int, q: np.ndarray, u: np.ndarray, modal: np.ndarray) -> bool:
    """Return whether the coordinates of a beam and their rates are those in the modal work."""
    body = flexible.bodies[f]
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    is_same = True
    for j in range(body[COUNT]):
        is_same = is_same and q[body[ETA] + j] == eta[j] and u[body[DETA] + j] == deta[j]
    return is_same


@kernel
def move_sections(flexible: FlexibleTables, f: int, is_kept: bool, modal: np.ndarray) -> None:
    """Write how all sections of a beam move, seen from G (Eq. 22, 24-26 for sections that turn far).

    With `is_kept` that is there, as is the mass, from the last evaluation.
    """
    body = flexible.bodies[f]
    C, P, in_plane = body[EXACT_CELLS], body[EXACT_POINTS], body[EXACT_IN_PLANE] > 0
    moving = 2 if in_plane else 3
    beam, at = beam_in(flexible, body), beam_work_in(body, modal)
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    zero = 0.0 * eta[0]
    at.kept[0] = zero
    if is_kept:
        at.kept[0] = zero + 1.0
        return
    at.sections[0, :] = zero
    for i in range(9):
        at.sections[0, AXES_AT + i] = zero + beam.head[ROOT + i]
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
    values, begins = beam.turn_values[3 * row + which], beam.head[BEGINS:HEAD]
    twist, y, z, end = int(begins[3]), int(begins[4]), int(begins[5]), int(begins[6])
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
    values, begins = beam.turn_values[3 * row : 3 * row + 3], beam.head[BEGINS:HEAD]
    for a in range(3):
        old, new = at.motions[6 * node + 3 + a], at.motions[6 * node + 9 + a]
        for strain in range(3):
            x, y, z = first[3 * a + strain], middle[3 * a + strain], last[3 * a + strain]
            _add_three(int(begins[3 + strain]), int(begins[4 + strain]), x, y, z, values, old, new)


@inlined
def _turn_in_plane(beam: Beam, row: int, node: int, eta: np.ndarray, deta: np.ndarray, at: BeamWork) -> None:
    """Write axes and rotation of the next section of a beam that turns about z alone: brackets are zero."""
    begin, end, rest = int(beam.head[BEGINS + 5]), int(beam.head[BEGINS + 6]), beam.turn_rest[row]
    middle, curved = beam.turn_values[3 * row], beam.turn_values[3 * row + 2]
    angle, rate = rest[2] + rest[8] / 12.0, 0.0 * eta[0]
    angle = angle + total(middle[begin:end], eta[begin:end]) + total(curved[begin:end], eta[begin:end]) / 12.0
    rate = rate + total(middle[begin:end], deta[begin:end]) + total(curved[begin:end], deta[begin:end]) / 12.0
    A, w = matrix(at.sections, node, AXES_AT), vector(at.sections, node, W_AT)
    put_matrix(at.sections, node + 1, AXES_AT, turned_about_z(A, angle))
    put(at.sections, node + 1, W_AT, (w[0], w[1], w[2] + A[8] * rate))
    put(at.sections, node + 1, Y_AT, vector(at.sections, node, Y_AT))
    old, new = at.motions[6 * node + 5], at.motions[6 * node + 11]
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
    values, begins = beam.values[row], beam.head[BEGINS:HEAD]
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


@inlined
def section_motion(
    body: np.ndarray, station: int, modal: np.ndarray
) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Return place, axes, velocity, angular velocity and remainder accelerations of a section seen from G."""
    at = beam_work_in(body, modal)
    return (
        vector(at.sections, station, PLACE_AT),
        matrix(at.sections, station, AXES_AT),
        vector(at.sections, station, V_AT),
        vector(at.sections, station, W_AT),
        vector(at.sections, station, Z_AT),
        vector(at.sections, station, Y_AT),
    )
