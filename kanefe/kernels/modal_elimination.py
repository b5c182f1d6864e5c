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

from kanefe.kernels._numba import inlined, kernel, vector_kernel
from kanefe.kernels.body_inertia import hand_inward
from kanefe.kernels.elastic import project, span, total, transposed_product
from kanefe.kernels.layout import (
    ACCELERATION,
    ALPHA,
    BASIS,
    BENT,
    BORDER,
    CARRIED,
    CARRIED_COUNT,
    COUNT,
    DETA,
    FORCE,
    MODAL,
    MOMENT,
    OFFSET,
    ROW,
    TANGENT,
    TRANSFORM,
    WORK_COUPLING,
    WORK_DDETA,
    WORK_FORCE,
    WORK_SCALE,
    FlexibleTables,
    H,
    J,
    M,
    R,
)
from kanefe.kernels.vectors import (
    Numbers,
    accumulate,
    accumulate_matrix,
    accumulate_symmetric,
    congruent,
    cross,
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


def border_size(count: int, carried: int) -> int:
    """Return how many numbers the border of a body with `count` modes and `carried` carrying interfaces takes.

    The parts of `border_span`, and a matrix and a column of six.
    """
    n = 6 * carried
    return n * count + 6 * n + 3 * n * n + 2 * n + 42


@inlined
def coupling_span(body: np.ndarray) -> slice:
    """Return where C (6, k), the inertia between the motion of G and the modes, is in the modal work."""
    k = body[COUNT]
    start = body[MODAL] + WORK_COUPLING * k
    return slice(start, start + 6 * k)


BASIS_PART, LEVER, SERIES, INVERSE, SYSTEM, HELD, COLUMN = range(7)


@inlined
def border_span(body: np.ndarray, which: int) -> slice:
    """Return where a part of a body's border is.

    B (n, k), H (n, 6), A' (n, n), (1 + A B B^T)^-1 (n, n), room (n, n), y_0 (n,) and room for a column (n,).
    """
    k, n = body[COUNT], 6 * body[CARRIED_COUNT]
    at = body[BORDER]
    if which == BASIS_PART:
        return slice(at, at + n * k)
    at += n * k
    if which == LEVER:
        return slice(at, at + 6 * n)
    at += 6 * n
    if which < HELD:
        at += (which - SERIES) * n * n
        return slice(at, at + n * n)
    at += 3 * n * n + (which - HELD) * n
    return slice(at, at + n)


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
    zero = 0.0 * p[0]
    at = border_span(body, COLUMN).stop
    push, change = border[at : at + 6], border[at + 6 : at + 42].reshape(6, 6)
    for a in range(6):
        push[a] = total(coupling[a], p)
        for b in range(a, 6):
            change[a, b] = zero - total(coupling[a], coupling[b])
    k, carried = body[COUNT], body[CARRIED_COUNT]
    n = 6 * carried
    if n > 0:
        basis = border[border_span(body, BASIS_PART)].reshape(n, k)
        lever = border[border_span(body, LEVER)].reshape(n, 6)
        series = border[border_span(body, SERIES)].reshape(n, n)
        inverse = border[border_span(body, INVERSE)].reshape(n, n)
        system = border[border_span(body, SYSTEM)].reshape(n, n)
        held = border[border_span(body, HELD)]
        column = border[border_span(body, COLUMN)]
        back = transposed(G)
        series[:] = 0.0  # A, until the system is solved
        for c in range(carried):
            i = flexible.carrying[body[CARRIED] + c]
            T, placed = matrix(work, i, TANGENT), basis[6 * c : 6 * c + 6]
            at, bent = rows[i, BASIS], rows[i, BENT]
            if bent < 0:
                _place_basis(flexible.pool[at : at + 6 * k].reshape(6, k), T, placed)
            else:
                _place_basis(modal[bent : bent + 6 * k].reshape(6, k), T, placed)
            if is_implicit:
                _scale(placed, modal[span(body, WORK_SCALE)])
            r = rotated(back, vector(work, i, OFFSET))
            block = lever[6 * c : 6 * c + 6]
            for a in range(6):
                for b in range(6):
                    block[a, b] = -total(basis[6 * c + a], coupling[b])
                block[a, a] += 1.0
            block[0, 4] += r[2]
            block[0, 5] -= r[1]
            block[1, 3] -= r[2]
            block[1, 5] += r[0]
            block[2, 3] += r[1]
            block[2, 4] -= r[0]
            m, j = congruent(back, symmetric(work, i, M)), congruent(back, symmetric(work, i, J))
            h = product(product(back, matrix(work, i, H)), G)
            _put_block(series, 6 * c, m, h, j)
            force, moment = rotated(back, vector(work, i, FORCE)), rotated(back, vector(work, i, MOMENT))
            put_three(held, 6 * c, force)
            put_three(held, 6 * c + 3, moment)
        gram = inverse  # room
        for a in range(n):
            for b in range(a + 1):
                gram[a, b] = gram[b, a] = total(basis[a], basis[b])
        for c in range(carried):
            for a in range(6 * c, 6 * c + 6):
                for b in range(n):
                    s = 0.0 * held[0]
                    for d in range(6 * c, 6 * c + 6):
                        s += series[a, d] * gram[d, b]
                    system[a, b] = s
                system[a, a] += 1.0
        inverse[:] = 0.0
        for a in range(n):
            inverse[a, a] = 1.0
        solve_in_place(system, series, inverse, held)
        for a in range(n):
            column[a] = total(basis[a], p)
        for a in range(n):
            held[a] += total(series[a], column)
        for i in range(n):
            for b in range(6):
                push[b] += lever[i, b] * held[i]
                s = zero
                for d in range(n):
                    s += series[i, d] * lever[d, b]
                for a in range(b + 1):
                    change[a, b] += lever[i, a] * s
    m = congruent(G, (change[0, 0], change[0, 1], change[0, 2], change[1, 1], change[1, 2], change[2, 2]))
    h = (
        change[0, 3], change[0, 4], change[0, 5], change[1, 3], change[1, 4], change[1, 5],
        change[2, 3], change[2, 4], change[2, 5],
    )  # fmt: skip
    accumulate_symmetric(work, link, M, m)
    accumulate_matrix(work, link, H, product(product(G, h), transposed(G)))
    accumulate_symmetric(
        work,
        link,
        J,
        congruent(G, (change[3, 3], change[3, 4], change[3, 5], change[4, 4], change[4, 5], change[5, 5])),
    )
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
def _put_block(A: np.ndarray, at: int, m: Numbers, h: Numbers, j: Numbers) -> None:
    """Write a 6 x 6 block of three 3 x 3 ones."""
    A[at, at], A[at, at + 1], A[at, at + 2] = m[0], m[1], m[2]
    A[at + 1, at], A[at + 1, at + 1], A[at + 1, at + 2] = m[1], m[3], m[4]
    A[at + 2, at], A[at + 2, at + 1], A[at + 2, at + 2] = m[2], m[4], m[5]
    for a in range(3):
        for b in range(3):
            A[at + a, at + 3 + b] = A[at + 3 + b, at + a] = h[3 * a + b]
    A[at + 3, at + 3], A[at + 3, at + 4], A[at + 3, at + 5] = j[0], j[1], j[2]
    A[at + 4, at + 3], A[at + 4, at + 4], A[at + 4, at + 5] = j[1], j[3], j[4]
    A[at + 5, at + 3], A[at + 5, at + 4], A[at + 5, at + 5] = j[2], j[4], j[5]


@kernel
def solve_in_place(system: np.ndarray, first: np.ndarray, second: np.ndarray, column: np.ndarray) -> None:
    """Replace two matrices and a column by ``system^-1`` times them; Gauss and Jordan with row exchange."""
    n = len(column)
    for i in range(n):
        best = i
        for a in range(i + 1, n):
            if abs(system[a, i].real) > abs(system[best, i].real):
                best = a
        if best != i:
            for b in range(n):
                system[i, b], system[best, b] = system[best, b], system[i, b]
                first[i, b], first[best, b] = first[best, b], first[i, b]
                second[i, b], second[best, b] = second[best, b], second[i, b]
            column[i], column[best] = column[best], column[i]
        pivot = 1.0 / system[i, i]
        for b in range(i, n):
            system[i, b] *= pivot
        for b in range(n):
            first[i, b] *= pivot
            second[i, b] *= pivot
        column[i] *= pivot
        for a in range(n):
            s = system[a, i]
            if a != i and s != 0.0:
                for b in range(i, n):
                    system[a, b] -= s * system[i, b]
                for b in range(n):
                    first[a, b] -= s * first[i, b]
                    second[a, b] -= s * second[i, b]
                column[a] -= s * column[i]


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
    if is_implicit:
        _scale(p.reshape(1, k), modal[span(body, WORK_SCALE)])
    a, b = project(coupling, 0, p), project(coupling, 3, p)
    n = 6 * carried
    if n > 0:
        basis = border[border_span(body, BASIS_PART)].reshape(n, k)
        lever = border[border_span(body, LEVER)].reshape(n, 6)
        series = border[border_span(body, SERIES)].reshape(n, n)
        inverse = border[border_span(body, INVERSE)].reshape(n, n)
        held = border[border_span(body, HELD)]
        column = border[border_span(body, COLUMN)]
        for c in range(carried):
            i = flexible.carrying[body[CARRIED] + c]
            put_three(column, 6 * c, rotated_back(G, vector(work, i, FORCE)))
            put_three(column, 6 * c + 3, rotated_back(G, vector(work, i, MOMENT)))
        for i in range(n):
            held[i] = total(inverse[i], column)
        for i in range(n):
            column[i] = total(basis[i], p)
        for i in range(n):
            held[i] += total(series[i], column)
            a = plus(a, times(held[i], three(lever[i], 0)))
            b = plus(b, times(held[i], three(lever[i], 3)))
    accumulate(work, link, FORCE, rotated(G, a))
    accumulate(work, link, MOMENT, rotated(G, b))


@inlined
def _hand_over_stiffly(flexible: FlexibleTables, body: np.ndarray, work: np.ndarray) -> None:
    """Hand what a body without modes carries to its link: its interfaces are fixed in G."""
    for c in range(body[CARRIED_COUNT]):
        i = flexible.carrying[body[CARRIED] + c]
        hand_inward(
            work, body[ROW], vector(work, i, OFFSET), symmetric(work, i, M), matrix(work, i, H), symmetric(work, i, J),
            vector(work, i, FORCE), vector(work, i, MOMENT),
        )  # fmt: skip


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
    x = modal[span(body, WORK_DDETA)]
    if k > 0:
        coupling, p = modal[coupling_span(body)].reshape(6, body[COUNT]), modal[span(body, WORK_FORCE)]
        _answer(coupling, p, a, alpha, x)
        if carried > 0:
            n = 6 * carried
            basis = border[border_span(body, BASIS_PART)].reshape(n, k)
            lever = border[border_span(body, LEVER)].reshape(n, 6)
            series = border[border_span(body, SERIES)].reshape(n, n)
            held = border[border_span(body, HELD)]
            column = border[border_span(body, COLUMN)]
            for i in range(6 * carried):
                block = lever[i]
                column[i] = (
                    block[0] * a[0] + block[1] * a[1] + block[2] * a[2]
                    + block[3] * alpha[0] + block[4] * alpha[1] + block[5] * alpha[2]
                )  # fmt: skip
            for i in range(6 * carried):
                y = held[i] + total(series[i], column)
                _subtract(basis[i], y, x)
    for c in range(carried):
        i = flexible.carrying[body[CARRIED] + c]
        zero = 0.0 * a[0]
        shift, turn = (zero, zero, zero), (zero, zero, zero)
        if k > 0:
            basis = border[border_span(body, BASIS_PART)].reshape(6 * carried, k)
            shift = (total(basis[6 * c], x), total(basis[6 * c + 1], x), total(basis[6 * c + 2], x))
            turn = (total(basis[6 * c + 3], x), total(basis[6 * c + 4], x), total(basis[6 * c + 5], x))
        put(work, i, ACCELERATION, plus(plus(linear, cross(angular, vector(work, i, OFFSET))), rotated(G, shift)))
        put(work, i, ALPHA, plus(angular, rotated(G, turn)))
    if k > 0:
        if is_implicit:
            _scale(x.reshape(1, k), modal[span(body, WORK_SCALE)])
        if body[TRANSFORM] < 0:
            for j in range(k):
                du[speed + j] = x[j]
        else:
            at = body[TRANSFORM] + k * k
            transposed_product(flexible.pool[at : at + k * k].reshape(k, k), 0, x, du[speed : speed + k])


@vector_kernel
def _scale(rows: np.ndarray, scale: np.ndarray) -> None:
    for a in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[a, i] *= scale[i]


@vector_kernel
def _answer(coupling: np.ndarray, p: np.ndarray, a: Numbers, alpha: Numbers, x: np.ndarray) -> None:
    for i in range(len(x)):
        x[i] = p[i] - (
            a[0] * coupling[0, i] + a[1] * coupling[1, i] + a[2] * coupling[2, i]
            + alpha[0] * coupling[3, i] + alpha[1] * coupling[4, i] + alpha[2] * coupling[5, i]
        )  # fmt: skip


@vector_kernel
def _subtract(row: np.ndarray, y: float, x: np.ndarray) -> None:
    for i in range(len(x)):
        x[i] -= y * row[i]
