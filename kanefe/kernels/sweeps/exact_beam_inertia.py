"""Inertia, stiffness and energy of beams that bend far, from the motion of their sections.

The kernels of `kanefe.bodies.exact.inertia`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    as_vector,
    congruent,
    cross,
    dot,
    matrix,
    plus,
    rotated,
    rotated_back,
    symmetric_times,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    COUNT,
    DAMPING,
    EXACT,
    EXACT_IN_PLANE,
    EXACT_POINTS,
    OMEGA,
    WORK_DETA,
    WORK_ETA,
    WORK_FORCE,
    R,
    Y,
    Z,
)
from kanefe.kernels.sweeps.body_inertia import put_inertia
from kanefe.kernels.sweeps.elastic import coupling_span, span, total
from kanefe.kernels.sweeps.exact_beam_layout import (
    AXES_AT,
    PLACE_AT,
    V_AT,
    W_AT,
    Y_AT,
    Z_AT,
    Beam,
    beam_in,
    beam_work_in,
)
from kanefe.kernels.tables import FlexibleTables
from kanefe.kernels.tree import Frames
from kanefe.kernels.values.tensors import Symmetric
from kanefe.kernels.values.tensors import congruent as of_axes


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
    is_kept = at.kept[0] != 0.0  # with the factors of the mass
    if not is_kept:
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
            if not is_kept:
                _add_mass_in_plane(rows, at.rows, at.mass)
        else:
            _couple(rows, m, arm, r, inertia, pull, plus(cross(arm, pull), twist), p, coupling, at.rows)
            if not is_kept:
                _add_mass(rows, at.rows, at.mass)
    frame = Frames(work)[i]
    J = of_axes(frame.R, Symmetric(xx, xy, xz, yy, yz, zz))
    push, turn = frame.R @ as_vector(force), frame.R @ as_vector(moment)
    put_inertia(frame, mass, frame.R @ as_vector(first), J, push, turn)


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
def stiffen_beam(flexible: FlexibleTables, f: int, pushes: Any, modal: np.ndarray) -> None:
    """Add ``s C + r K`` to the mass of a beam, and directional products to its forces: see `implicit`.

    `pushes`: `kanefe.kernels.sweeps.implicit.Pushes` along the coordinates of the beam.
    """
    body = flexible.bodies[f]
    k = body[COUNT]
    beam, at, p = beam_in(flexible, body), beam_work_in(body, modal), modal[span(body, WORK_FORCE)]
    is_damped = body[DAMPING] >= 0
    place = body[DAMPING] if is_damped else body[EXACT]
    C = flexible.pool[place : place + k * k].reshape(k, k)  # read where there is damping
    for i in range(k):
        p[i] += total(beam.stiffness[i], pushes.along_stiffness)
        if is_damped:
            p[i] += total(C[i], pushes.along_damping)
        for j in range(i + 1):
            at.mass[i, j] += pushes.stiffness * beam.stiffness[i, j]
            if is_damped:
                at.mass[i, j] += pushes.damping * C[i, j]
