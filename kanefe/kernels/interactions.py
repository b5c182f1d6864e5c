"""Springs, dampers and bushings between two markers (Eq. 11)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.layout import FlexibleTables
from kanefe.kernels.loads import push
from kanefe.kernels.markers import axes_of, lever_of, motion_of
from kanefe.kernels.slopes import slope_motion
from kanefe.kernels.vectors import (
    Numbers,
    cross,
    dot,
    minus,
    plus,
    product,
    rotated,
    rotated_back,
    three,
    times,
    transposed,
    vector,
)

# Columns of the integers of a spring or bushing
ROW_A, ROW_B, INPUT, TABLE, TABLE_LENGTH = range(5)
INTERACTION_INTEGERS = 5
SPRING_STIFFNESS, SPRING_DAMPING, REST_LENGTH = range(3)


class Interactions(NamedTuple):
    """Springs and bushings of a scene; None in its place leaves out their code.

    Attributes
    ----------
    springs, bushings : ndarray of int, shape (n, INTERACTION_INTEGERS)
        Rows of both markers (-1: N), first input of the user's law (-1: none), first number and length of a table.
    spring_markers, bushing_markers : ndarray, shape (2 n, MARKER_NUMBERS)
        Markers a and b of each.
    spring_laws : ndarray, shape (n, 3)
        Stiffness, damping, rest length.
    bushing_laws : ndarray, shape (n, 12)
        Stiffness and damping.
    tables : ndarray
        Lengths, then forces, of each table.
    """

    springs: np.ndarray
    bushings: np.ndarray
    spring_markers: np.ndarray
    bushing_markers: np.ndarray
    spring_laws: np.ndarray
    bushing_laws: np.ndarray
    tables: np.ndarray


@kernel
def add_interactions(
    between: Interactions,
    rows: np.ndarray,
    flexible: FlexibleTables | None,
    inputs: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
) -> tuple[Any, Any]:
    """Apply springs and bushings; return the power that dampers take, and what tables and laws of the user give."""
    taken = given = 0.0 * work[0, 0]
    zero = 0.0 * work[0, 0]
    none = (zero, zero, zero)
    for n in range(len(between.springs)):
        a, b = between.springs[n, ROW_A], between.springs[n, ROW_B]
        lever_a = lever_of(between.spring_markers, 2 * n, a, work)
        lever_b = lever_of(between.spring_markers, 2 * n + 1, b, work)
        p_a, v_a, _ = motion_of(a, lever_a, work)
        p_b, v_b, _ = motion_of(b, lever_b, work)
        line = minus(p_b, p_a)
        length = np.sqrt(dot(line, line))
        e = times(1.0 / length, line)
        rate = dot(e, minus(v_b, v_a))
        extra = zero
        if between.springs[n, INPUT] >= 0:
            extra += inputs[between.springs[n, INPUT]]
        if between.springs[n, TABLE_LENGTH] > 0:
            extra += _interpolated(between.tables, between.springs[n, TABLE], between.springs[n, TABLE_LENGTH], length)
        damping = between.spring_laws[n, SPRING_DAMPING] * rate
        stretch = length - between.spring_laws[n, REST_LENGTH]
        tension = between.spring_laws[n, SPRING_STIFFNESS] * stretch + damping + extra
        taken += damping * rate
        given -= extra * rate
        pull = times(tension, e)
        push(rows, flexible, a, pull, cross(lever_a, pull), work, modal)
        back = times(-1.0, pull)
        push(rows, flexible, b, back, cross(lever_b, back), work, modal)
    for n in range(len(between.bushings)):
        a, b = between.bushings[n, ROW_A], between.bushings[n, ROW_B]
        lever_a = lever_of(between.bushing_markers, 2 * n, a, work)
        lever_b = lever_of(between.bushing_markers, 2 * n + 1, b, work)
        A_a, A_b = (
            axes_of(between.bushing_markers, 2 * n, a, work),
            axes_of(between.bushing_markers, 2 * n + 1, b, work),
        )
        p_a, v_a, w_a = motion_of(a, lever_a, work)
        p_b, v_b, w_b = motion_of(b, lever_b, work)
        offset = minus(p_b, p_a)
        d = rotated_back(A_a, offset)
        rate = rotated_back(A_a, minus(minus(v_b, v_a), cross(w_a, offset)))
        spin = rotated_back(A_a, minus(w_b, w_a))
        theta = rotation_vector_of(product(transposed(A_a), A_b))
        tangent = slope_motion(0, theta, none)[1]
        k, c = vector(between.bushing_laws, n, 0), vector(between.bushing_laws, n, 6)
        k_r, c_r = vector(between.bushing_laws, n, 3), vector(between.bushing_laws, n, 9)
        brake = (c[0] * rate[0], c[1] * rate[1], c[2] * rate[2])
        brake_r = (c_r[0] * spin[0], c_r[1] * spin[1], c_r[2] * spin[2])
        spring_r = (-k_r[0] * theta[0], -k_r[1] * theta[1], -k_r[2] * theta[2])
        force = minus((-k[0] * d[0], -k[1] * d[1], -k[2] * d[2]), brake)
        moment = minus(solved(transposed(tangent), spring_r), brake_r)
        taken += dot(brake, rate) + dot(brake_r, spin)
        at = between.bushings[n, INPUT]
        if at >= 0:
            more, more_r = three(inputs, at), three(inputs, at + 3)
            force, moment = plus(force, more), plus(moment, more_r)
            given += dot(rate, more) + dot(spin, more_r)
        force, moment = rotated(A_a, force), rotated(A_a, moment)
        push(rows, flexible, b, force, plus(moment, cross(lever_b, force)), work, modal)
        # a feels the reverse at the same point, b's origin
        arm = plus(lever_a, offset)
        push(rows, flexible, a, times(-1.0, force), times(-1.0, plus(moment, cross(arm, force))), work, modal)
    return taken, given


@kernel
def interaction_energy(between: Interactions, work: np.ndarray) -> float:
    """Return the energy in the linear part of springs and bushings; tables and laws of the user do work."""
    energy = 0.0
    for n in range(len(between.springs)):
        a, b = between.springs[n, ROW_A], between.springs[n, ROW_B]
        p_a = motion_of(a, lever_of(between.spring_markers, 2 * n, a, work), work)[0]
        p_b = motion_of(b, lever_of(between.spring_markers, 2 * n + 1, b, work), work)[0]
        line = minus(p_b, p_a)
        stretch = np.sqrt(dot(line, line)) - between.spring_laws[n, REST_LENGTH]
        energy += 0.5 * between.spring_laws[n, SPRING_STIFFNESS] * stretch * stretch
    for n in range(len(between.bushings)):
        a, b = between.bushings[n, ROW_A], between.bushings[n, ROW_B]
        p_a = motion_of(a, lever_of(between.bushing_markers, 2 * n, a, work), work)[0]
        p_b = motion_of(b, lever_of(between.bushing_markers, 2 * n + 1, b, work), work)[0]
        A_a = axes_of(between.bushing_markers, 2 * n, a, work)
        A_b = axes_of(between.bushing_markers, 2 * n + 1, b, work)
        d, theta = rotated_back(A_a, minus(p_b, p_a)), rotation_vector_of(product(transposed(A_a), A_b))
        for c in range(3):
            energy += 0.5 * between.bushing_laws[n, c] * d[c] * d[c]
            energy += 0.5 * between.bushing_laws[n, 3 + c] * theta[c] * theta[c]
    return energy


@inlined
def _interpolated(tables: np.ndarray, at: int, count: int, x: Any) -> Any:
    """Return a table's value at x, straight between its points and beyond its ends."""
    i = 1
    while i < count - 1 and tables[at + i] < x.real:
        i += 1
    x0, f0 = tables[at + i - 1], tables[at + count + i - 1]
    return f0 + (tables[at + count + i] - f0) / (tables[at + i] - x0) * (x - x0)


@inlined
def solved(A: Numbers, b: Numbers) -> Numbers:
    """Return A^-1 b by cofactors."""
    r0, r1, r2 = (A[0], A[1], A[2]), (A[3], A[4], A[5]), (A[6], A[7], A[8])
    c0, c1, c2 = cross(r1, r2), cross(r2, r0), cross(r0, r1)
    return times(1.0 / dot(r0, c0), plus(times(b[0], c0), plus(times(b[1], c1), times(b[2], c2))))


@inlined
def rotation_vector_of(A: Numbers) -> Numbers:
    """Return the rotation vector (at most half a turn) of a rotation matrix, through its largest Euler parameter."""
    trace = A[0] + A[4] + A[8]
    squares = (1.0 + trace, 1.0 + 2.0 * A[0] - trace, 1.0 + 2.0 * A[4] - trace, 1.0 + 2.0 * A[8] - trace)
    largest = max(squares[0].real, squares[1].real, squares[2].real, squares[3].real)
    x, y, z = A[7] - A[5], A[2] - A[6], A[3] - A[1]
    if squares[0].real == largest:
        e = (squares[0], x, y, z)
    elif squares[1].real == largest:
        e = (x, squares[1], A[1] + A[3], A[2] + A[6])
    elif squares[2].real == largest:
        e = (y, A[1] + A[3], squares[2], A[5] + A[7])
    else:
        e = (z, A[2] + A[6], A[5] + A[7], squares[3])
    square = e[1] * e[1] + e[2] * e[2] + e[3] * e[3]
    sign = -1.0 if e[0].real < 0.0 else 1.0
    cosine = sign * e[0]
    if square.real < 1e-16 * (cosine * cosine).real:
        return times(2.0 * sign / cosine, (e[1], e[2], e[3]))
    sine = np.sqrt(square)
    angle = 2.0 * np.arctan(sine / cosine) if cosine.real > sine.real else np.pi - 2.0 * np.arctan(cosine / sine)
    return times(sign * angle / sine, (e[1], e[2], e[3]))
