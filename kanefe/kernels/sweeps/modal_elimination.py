"""Elimination of the modes of a flexible body: a constant diagonal with a border of low rank.

In modes of unit mass, with the acceleration V of G (share of du), forces p on the modes, and for each interface that
carries something its motion ``X V + B x`` and what it carries, ``y = A (X V + B x) + f``:

    x + C^T V + B^T y = p,      so that      (1 + A B B^T) y = A (H V + B p) + f,      H = X - B C^T,

a system of six unknowns an interface, whatever the number of modes. G then feels

    (M - C C^T + H^T A' H) V + f_G + C p + H^T y_0,      A' = (1 + A B B^T)^-1 A,   y_0 = A' B p + (1 + A B B^T)^-1 f.

Nothing large is subtracted from something large: A' is the carried inertia in series with the compliance of the modes.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve, solve_columns
from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    accumulate_matrix,
    accumulate_symmetric,
    congruent,
    cross,
    dot,
    matrix,
    plus,
    product,
    put,
    put_three,
    rotated,
    rotated_back,
    symmetric,
    three,
    times,
    transposed,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    ACCELERATION,
    ALPHA,
    BASIS,
    BENT,
    CARRIED,
    CARRIED_COUNT,
    COUNT,
    DETA,
    EXACT,
    FORCE,
    MOMENT,
    OFFSET,
    ROW,
    TANGENT,
    TRANSFORM,
    WORK_DDETA,
    WORK_FORCE,
    WORK_SCALE,
    FlexibleTables,
    H,
    J,
    M,
    R,
)
from kanefe.kernels.sweeps.body_inertia import hand_inward
from kanefe.kernels.sweeps.border import Border, border_in
from kanefe.kernels.sweeps.elastic import coupling_span, project, span, total, transposed_product
from kanefe.kernels.sweeps.unit_mass import from_unit_mass, to_unit_mass


@kernel
def eliminate_modes(
    rows: np.ndarray,
    flexible: FlexibleTables,
    f: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
) -> None:
    """Take the modes of a body out of the articulated inertia of its link; scaled ones in an implicit sweep."""
    body = flexible.bodies[f]
    if body[COUNT] == 0:
        _hand_over_stiffly(flexible, body, work)
        return
    link = body[ROW]
    G = matrix(work, link, R)
    coupling, p = modal[coupling_span(body)].reshape(6, body[COUNT]), modal[span(body, WORK_FORCE)]
    parts = border_in(border, body)
    _put_change_by_modes(coupling, p, parts)
    if body[CARRIED_COUNT] > 0:
        _gather_carried(rows, flexible, body, G, work, modal, coupling, is_implicit, parts)
        _put_in_series(p, parts)
        _add_change_by_carried(parts)
    _change_link(work, link, G, parts)


@inlined
def _put_change_by_modes(coupling: np.ndarray, p: np.ndarray, parts: Border) -> None:
    """Write what the modes alone do to the inertia and the force of G: -C C^T and C p."""
    zero = 0.0 * p[0]
    for a in range(6):
        parts.push[a] = total(coupling[a], p)
        for b in range(a, 6):
            parts.change[a, b] = zero - total(coupling[a], coupling[b])


@inlined
def _gather_carried(
    rows: np.ndarray,
    flexible: FlexibleTables,
    body: np.ndarray,
    G: Numbers,
    work: np.ndarray,
    modal: np.ndarray,
    coupling: np.ndarray,
    is_implicit: bool,
    parts: Border,
) -> None:
    """Write B, H, A and f of the interfaces that carry something, in G."""
    k, back = body[COUNT], transposed(G)
    for c in range(body[CARRIED_COUNT]):
        i = flexible.carrying[body[CARRIED] + c]
        T, placed = matrix(work, i, TANGENT), parts.basis[6 * c : 6 * c + 6]
        at, bent = rows[i, BASIS], rows[i, BENT]
        if bent < 0:
            _place_basis(flexible.pool[at : at + 6 * k].reshape(6, k), T, placed)
        else:
            _place_basis(modal[bent : bent + 6 * k].reshape(6, k), T, placed)
        scale(body, placed, modal, is_implicit)
        r = rotated(back, vector(work, i, OFFSET))
        block = parts.lever[6 * c : 6 * c + 6]
        for a in range(6):
            for b in range(6):
                block[a, b] = -total(parts.basis[6 * c + a], coupling[b])
            block[a, a] += 1.0
        block[0, 4] += r[2]
        block[0, 5] -= r[1]
        block[1, 3] -= r[2]
        block[1, 5] += r[0]
        block[2, 3] += r[1]
        block[2, 4] -= r[0]
        m, j = congruent(back, symmetric(work, i, M)), congruent(back, symmetric(work, i, J))
        h = product(product(back, matrix(work, i, H)), G)
        _put_block(parts.inertia[6 * c : 6 * c + 6], m, h, j)
        force, moment = rotated(back, vector(work, i, FORCE)), rotated(back, vector(work, i, MOMENT))
        put_three(parts.force, 6 * c, force)
        put_three(parts.force, 6 * c + 3, moment)


@inlined
def _put_in_series(p: np.ndarray, parts: Border) -> None:
    """Write A' H, y_0 and the factors of 1 + A B B^T: what is carried, in series with the compliance of the modes."""
    n = len(parts.force)
    for a in range(n):
        for b in range(a + 1):
            parts.gram[a, b] = parts.gram[b, a] = total(parts.basis[a], parts.basis[b])
        parts.column[a] = total(parts.basis[a], p)
    for first in range(0, n, 6):
        motion, lever = parts.gram[first : first + 6], parts.lever[first : first + 6]
        for a in range(first, first + 6):
            row = parts.inertia[a]
            transposed_product(motion, 0, row, parts.factors[a])
            transposed_product(lever, 0, row, parts.series[a])
            parts.factors[a, a] += 1.0
            parts.held[a] = parts.force[a] + total(row, parts.column[first : first + 6])
    factorise(parts.factors, parts.pivots)
    solve(parts.factors, parts.pivots, parts.held)
    solve_columns(parts.factors, parts.pivots, parts.series)


@inlined
def _add_change_by_carried(parts: Border) -> None:
    """Add what the carried interfaces do to the inertia and the force of G: H^T A' H and H^T y_0."""
    for i in range(len(parts.held)):
        lever, series = parts.lever[i], parts.series[i]
        for a in range(6):
            parts.push[a] += lever[a] * parts.held[i]
            for b in range(a, 6):
                parts.change[a, b] += lever[a] * series[b]


@inlined
def _change_link(work: np.ndarray, link: int, G: Numbers, parts: Border) -> None:
    """Add the change of inertia and force, in G, to those of the link, in N."""
    c, push = parts.change, parts.push
    h = (c[0, 3], c[0, 4], c[0, 5], c[1, 3], c[1, 4], c[1, 5], c[2, 3], c[2, 4], c[2, 5])
    accumulate_symmetric(work, link, M, congruent(G, (c[0, 0], c[0, 1], c[0, 2], c[1, 1], c[1, 2], c[2, 2])))
    accumulate_matrix(work, link, H, product(product(G, h), transposed(G)))
    accumulate_symmetric(work, link, J, congruent(G, (c[3, 3], c[3, 4], c[3, 5], c[4, 4], c[4, 5], c[5, 5])))
    accumulate(work, link, FORCE, rotated(G, (push[0], push[1], push[2])))
    accumulate(work, link, MOMENT, rotated(G, (push[3], push[4], push[5])))


@vector_kernel
def _place_basis(raw: np.ndarray, T: Numbers, basis: np.ndarray) -> None:
    """Write the motion of an interface from the modes: translation, and the turn that the slopes make."""
    for i in range(raw.shape[1]):
        basis[0, i] = raw[0, i]
        basis[1, i] = raw[1, i]
        basis[2, i] = raw[2, i]
        basis[3, i] = T[0] * raw[3, i] + T[1] * raw[4, i] + T[2] * raw[5, i]
        basis[4, i] = T[3] * raw[3, i] + T[4] * raw[4, i] + T[5] * raw[5, i]
        basis[5, i] = T[6] * raw[3, i] + T[7] * raw[4, i] + T[8] * raw[5, i]


@kernel
def _put_block(A: np.ndarray, m: Numbers, h: Numbers, j: Numbers) -> None:
    """Write a 6 x 6 matrix of three 3 x 3 ones."""
    A[0, 0], A[0, 1], A[0, 2] = m[0], m[1], m[2]
    A[1, 0], A[1, 1], A[1, 2] = m[1], m[3], m[4]
    A[2, 0], A[2, 1], A[2, 2] = m[2], m[4], m[5]
    for a in range(3):
        for b in range(3):
            A[a, 3 + b] = A[3 + b, a] = h[3 * a + b]
    A[3, 3], A[3, 4], A[3, 5] = j[0], j[1], j[2]
    A[4, 3], A[4, 4], A[4, 5] = j[1], j[3], j[4]
    A[5, 3], A[5, 4], A[5, 5] = j[2], j[4], j[5]


@kernel
def eliminate_modal_forces(
    flexible: FlexibleTables, f: int, work: np.ndarray, modal: np.ndarray, border: np.ndarray, is_implicit: bool
) -> None:
    """Hand other forces on the modes, and on what the body carries, to its link: the border is there already."""
    body = flexible.bodies[f]
    k, carried, link = body[COUNT], body[CARRIED_COUNT], body[ROW]
    if k == 0:
        for c in range(carried):
            i = flexible.carrying[body[CARRIED] + c]
            force = vector(work, i, FORCE)
            accumulate(work, link, FORCE, force)
            accumulate(work, link, MOMENT, plus(vector(work, i, MOMENT), cross(vector(work, i, OFFSET), force)))
        return
    G = matrix(work, link, R)
    coupling, p = modal[coupling_span(body)].reshape(6, body[COUNT]), modal[span(body, WORK_FORCE)]
    scale(body, p.reshape(1, k), modal, is_implicit)
    parts = border_in(border, body)
    for c in range(carried):
        i = flexible.carrying[body[CARRIED] + c]
        put_three(parts.column, 6 * c, rotated_back(G, vector(work, i, FORCE)))
        put_three(parts.column, 6 * c + 3, rotated_back(G, vector(work, i, MOMENT)))
    a, b = push_through_modes(coupling, parts, p, parts.column, parts.column, parts.held)
    accumulate(work, link, FORCE, rotated(G, a))
    accumulate(work, link, MOMENT, rotated(G, b))


@inlined
def push_through_modes(
    coupling: np.ndarray, parts: Border, p: np.ndarray, on: np.ndarray, moved: np.ndarray, held: np.ndarray
) -> tuple[Numbers, Numbers]:
    """Return what G feels of forces p on the modes and `on` on what they carry; write y_0 to `held`, B p to `moved`.

    Each of these is (n,); `moved` may be `on`, which is lost then.
    """
    a, b = project(coupling, 0, p), project(coupling, 3, p)
    for i in range(len(held)):
        held[i] = on[i]
        moved[i] = total(parts.basis[i], p)
    for i in range(len(held)):
        first = i - i % 6
        held[i] += total(parts.inertia[i], moved[first : first + 6])
    solve(parts.factors, parts.pivots, held)
    for i in range(len(held)):
        a = plus(a, times(held[i], three(parts.lever[i], 0)))
        b = plus(b, times(held[i], three(parts.lever[i], 3)))
    return a, b


@inlined
def _hand_over_stiffly(flexible: FlexibleTables, body: np.ndarray, work: np.ndarray) -> None:
    """Hand what a body without modes carries to its link: its interfaces are fixed in G."""
    for c in range(body[CARRIED_COUNT]):
        i = flexible.carrying[body[CARRIED] + c]
        hand_inward(
            work,
            body[ROW],
            vector(work, i, OFFSET),
            symmetric(work, i, M),
            matrix(work, i, H),
            symmetric(work, i, J),
            vector(work, i, FORCE),
            vector(work, i, MOMENT),
        )


@kernel
def modal_accelerations(
    flexible: FlexibleTables,
    f: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    du: np.ndarray,
) -> None:
    """Write ddeta of a body, and the share of du in the motion of its carrying interfaces."""
    body = flexible.bodies[f]
    k, carried, speed = body[COUNT], body[CARRIED_COUNT], body[DETA]
    link = body[ROW]
    G = matrix(work, link, R)
    linear, angular = vector(work, link, ACCELERATION), vector(work, link, ALPHA)
    a, alpha = rotated_back(G, linear), rotated_back(G, angular)
    if k == 0:
        zero = 0.0 * a[0]
        none = zero, zero, zero
        for c in range(carried):
            _carry(work, flexible.carrying[body[CARRIED] + c], G, linear, angular, none, none)
        return
    coupling, p = modal[coupling_span(body)].reshape(6, body[COUNT]), modal[span(body, WORK_FORCE)]
    x = modal[span(body, WORK_DDETA)]
    _response(coupling, p, a, alpha, x)
    if carried > 0:
        parts = border_in(border, body)
        basis = parts.basis
        for i in range(6 * carried):
            series = parts.series[i]
            y = parts.held[i] + dot(three(series, 0), a) + dot(three(series, 3), alpha)
            subtract(basis[i], y, x)
        for c in range(carried):
            shift = total(basis[6 * c], x), total(basis[6 * c + 1], x), total(basis[6 * c + 2], x)
            turn = total(basis[6 * c + 3], x), total(basis[6 * c + 4], x), total(basis[6 * c + 5], x)
            _carry(work, flexible.carrying[body[CARRIED] + c], G, linear, angular, shift, turn)
    if body[EXACT] >= 0:
        from_unit_mass(body, x, modal)
    elif is_implicit:
        scale_rows(x.reshape(1, k), modal[span(body, WORK_SCALE)])
    if body[TRANSFORM] < 0:
        for j in range(k):
            du[speed + j] = x[j]
    else:
        at = body[TRANSFORM] + k * k
        transposed_product(flexible.pool[at : at + k * k].reshape(k, k), 0, x, du[speed : speed + k])


@inlined
def _carry(
    work: np.ndarray, i: int, G: Numbers, linear: Numbers, angular: Numbers, shift: Numbers, turn: Numbers
) -> None:
    """Write the share of du in the motion of an interface: with G, and in G from the modes."""
    put(work, i, ACCELERATION, plus(plus(linear, cross(angular, vector(work, i, OFFSET))), rotated(G, shift)))
    put(work, i, ALPHA, plus(angular, rotated(G, turn)))


@inlined
def scale(body: np.ndarray, rows: np.ndarray, modal: np.ndarray, is_implicit: bool) -> None:
    """Replace forces on the coordinates of a body, or motions by them, by those of coordinates of unit mass."""
    if body[EXACT] >= 0:
        to_unit_mass(body, rows, modal)
    elif is_implicit:
        scale_rows(rows, modal[span(body, WORK_SCALE)])


@vector_kernel
def scale_rows(rows: np.ndarray, scale: np.ndarray) -> None:
    """Multiply all rows by a scale of their columns."""
    for a in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[a, i] *= scale[i]


@vector_kernel
def _response(coupling: np.ndarray, p: np.ndarray, a: Numbers, alpha: Numbers, x: np.ndarray) -> None:
    for i in range(len(x)):
        x[i] = p[i] - (
            a[0] * coupling[0, i]
            + a[1] * coupling[1, i]
            + a[2] * coupling[2, i]
            + alpha[0] * coupling[3, i]
            + alpha[1] * coupling[4, i]
            + alpha[2] * coupling[5, i]
        )


@vector_kernel
def subtract(row: np.ndarray, y: float, x: np.ndarray) -> None:
    """Subtract a multiple of a row."""
    for i in range(len(x)):
        x[i] -= y * row[i]
