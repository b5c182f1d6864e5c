"""Beams that bend far: how their sections move, from the coordinates of their strains.

The kernels of `kanefe.bodies.exact.beam_line`.
"""

from typing import Any

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.language import ZERO, Matrix, Vector, cross, inlined, kernel, turned_about_z, vector_kernel
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.slopes import Slopes, slope_motion
from kanefe.kernels.sweeps.turning_steps import turn_of_step


@kernel
def is_as_before(beam: ExactBeam, q: np.ndarray, u: np.ndarray) -> bool:
    """Return whether the coordinates of a beam and their rates are those in the modal work."""
    eta, deta, at, speed = beam.eta, beam.deta, beam.first_eta, beam.first_deta
    is_same = True
    for j in range(len(eta)):
        is_same = is_same and q[at + j] == eta[j] and u[speed + j] == deta[j]
    return is_same


@kernel
def move_sections(beam: ExactBeam, is_kept: bool) -> None:
    """Write how all sections of a beam move, seen from G (Eq. 22, 24-26 for sections that turn far).

    With `is_kept` that is there, as is the mass, from the last evaluation.
    """
    beam.kept[0] = 1.0 if is_kept else 0.0
    if is_kept:
        return
    P, sections, motions, slopes, slope_motions = (
        beam.point_count,
        beam.sections,
        beam.motions,
        beam.slopes,
        beam.slope_motions,
    )
    moving, integration, lengths = 2 if beam.in_plane else 3, beam.integration, beam.lengths
    root = sections[0]
    root.A, root.p, root.v, root.w, root.Z, root.Y = beam.root, ZERO, ZERO, ZERO, ZERO, ZERO
    motions[:, :] = 0.0
    node = 0
    for c in range(len(lengths)):
        start, h = node, lengths[c]
        for g in range(P + 1):
            if beam.in_plane:
                _turn_in_plane(beam, c * (P + 1) + g, node)
            else:
                _turn(beam, c * (P + 1) + g, node)
            node += 1
            if g < P:
                _slope(beam, c * P + g, g, node, moving)
        first = sections[start]
        for g in range(P + 1):
            i, weights = start + 1 + g, integration[g]
            p, v, Z = first.p, first.v, first.Z
            for b in range(P):
                weight, slope = h * weights[b], slopes[b]
                p, v, Z = p + weight * slope.t, v + weight * slope.v, Z + weight * slope.Z
            section = sections[i]
            section.p, section.v, section.Z = p, v, Z
            for a in range(moving):
                _integrate(motions[6 * start + a], h, weights, slope_motions, a, motions[6 * i + a])


@inlined
def _three_of(values: np.ndarray, begins: np.ndarray, first: int, x: np.ndarray) -> Vector:
    """Return what coordinates of three strains from one on change of a vector."""
    a, b, c, end = int(begins[first]), int(begins[first + 1]), int(begins[first + 2]), int(begins[first + 3])
    return Vector(total(values[a:b], x[a:b]), total(values[b:c], x[b:c]), total(values[c:end], x[c:end]))


@inlined
def _turn(beam: ExactBeam, row: int, node: int) -> None:
    """Write axes and rotation of the next section."""
    eta, deta, rest, begins, motions = beam.eta, beam.deta, beam.steps[row], beam.begins, beam.motions
    values = beam.step_values[3 * row : 3 * row + 3]
    a1, d1 = rest.a1 + _three_of(values[0], begins, 3, eta), _three_of(values[0], begins, 3, deta)
    a2, d2 = rest.a2 + _three_of(values[1], begins, 3, eta), _three_of(values[1], begins, 3, deta)
    a3, d3 = rest.a3 + _three_of(values[2], begins, 3, eta), _three_of(values[2], begins, 3, deta)
    omega, rate, second, by_a1, by_a2, by_a3 = turn_of_step(a1, a2, a3, d1, d2, d3)
    E, T, remainder = slope_motion(Slopes.ROTATION_VECTOR, omega, rate)
    here, there = beam.sections[node], beam.sections[node + 1]
    A, w = here.A, here.w
    AT = A @ T
    spin = AT @ rate
    there.A, there.w = A @ E, w + spin
    there.Y = here.Y + cross(w, spin) + AT @ second + A @ remainder
    first, middle, last = AT @ by_a1, AT @ by_a2, AT @ by_a3
    for strain in range(3):
        x, y, z = column_of(first, strain), column_of(middle, strain), column_of(last, strain)
        begin, end = int(begins[3 + strain]), int(begins[4 + strain])
        old, new = motions[6 * node + 3 : 6 * node + 6], motions[6 * node + 9 : 6 * node + 12]
        _add_three(begin, end, Vector(x.x, y.x, z.x), values, old[0], new[0])
        _add_three(begin, end, Vector(x.y, y.y, z.y), values, old[1], new[1])
        _add_three(begin, end, Vector(x.z, y.z, z.z), values, old[2], new[2])


@inlined
def _turn_in_plane(beam: ExactBeam, row: int, node: int) -> None:
    """Write axes and rotation of the next section of a beam that turns about z alone: brackets are zero."""
    eta, deta, begins, rest, motions = beam.eta, beam.deta, beam.begins, beam.steps[row], beam.motions
    begin, end, middle, curved = (
        int(begins[5]),
        int(begins[6]),
        beam.step_values[3 * row],
        beam.step_values[3 * row + 2],
    )
    angle, rate = rest.a1.z + rest.a3.z / 12.0, 0.0 * eta[0]
    angle = angle + total(middle[begin:end], eta[begin:end]) + total(curved[begin:end], eta[begin:end]) / 12.0
    rate = rate + total(middle[begin:end], deta[begin:end]) + total(curved[begin:end], deta[begin:end]) / 12.0
    here, there = beam.sections[node], beam.sections[node + 1]
    normal = here.A.z.z
    there.A = turned_about_z(here.A, np.cos(angle), np.sin(angle))
    there.w, there.Y = here.w + Vector(0.0, 0.0, normal * rate), here.Y
    old, new = motions[6 * node + 5], motions[6 * node + 11]
    for j in range(begin, end):
        new[j] = old[j] + normal * (middle[j] + curved[j] / 12.0)


@inlined
def column_of(A: Matrix, c: int) -> Vector:
    """Return a column of a matrix."""
    return A.x if c == 0 else (A.y if c == 1 else A.z)


@vector_kernel
def _add_three(begin: int, end: int, shares: Vector, values: np.ndarray, old: np.ndarray, new: np.ndarray) -> None:
    """Write a row plus weighted rows."""
    for j in range(begin, end):
        new[j] = old[j] + shares.x * values[0, j] + shares.y * values[1, j] + shares.z * values[2, j]


@inlined
def _slope(beam: ExactBeam, row: int, g: int, node: int, moving: int) -> None:
    """Write the derivative of the place along the beam at a Gauss point, A t, and its rates."""
    values, begins, section, slope = beam.values[row], beam.begins, beam.sections[node], beam.slopes[g]
    A, w = section.A, section.w
    t = A.x + A @ _three_of(values, begins, 0, beam.eta)
    stretch, swing = A @ _three_of(values, begins, 0, beam.deta), cross(w, t)
    slope.t, slope.v = t, swing + stretch
    slope.Z = cross(section.Y, t) + cross(w, swing + 2.0 * stretch)
    turns = beam.motions[6 * node + 3 : 6 * node + 6]
    for a in range(moving):
        b, d = (a + 1) % 3, (a + 2) % 3
        out, along = beam.slope_motions[3 * g + a], column_of(A.T, a)
        _cross_rows(_component_of(t, d), turns[b], _component_of(t, b), turns[d], out)  # W_j x t
        for strain in range(3):
            share = _component_of(along, strain)
            for j in range(int(begins[strain]), int(begins[strain + 1])):
                out[j] += share * values[j]


@inlined
def _component_of(a: Vector, c: int) -> Any:
    """Return a component of a vector."""
    return a.x if c == 0 else (a.y if c == 1 else a.z)


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
