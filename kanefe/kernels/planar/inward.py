"""The inward sweep of a planar scene, and the sweep outward for du (Eq. 18).

The coordinates of each joint are eliminated from the inertia of what it carries. A body on a turning joint then shows
its parent a mass that resists translations only: three numbers in place of six.
"""

from typing import Any

import numpy as np

from kanefe.kernels.language import inlined
from kanefe.kernels.planar.layout import (
    ACCELERATION,
    ALPHA,
    ARMATURE,
    AXIS,
    BIAS,
    DRIVE,
    FLOAT,
    FORCE,
    KIND,
    MOMENT,
    OFFSET,
    PARENT,
    REST,
    SIGN,
    SLIDE,
    SPEED,
    TURN,
    C,
    H,
    J,
    M,
    PlanarTables,
    S,
    U,
)


@inlined
def axis_of(tables: PlanarTables, work: np.ndarray, i: int) -> tuple[Any, Any]:
    """Return the axis of a slide, or the first of a float, in N."""
    parent, x, y = tables.rows[i, PARENT], tables.geometry[i, AXIS], tables.geometry[i, AXIS + 1]
    c, s = work[parent, C], work[parent, S]
    return c * x - s * y, s * x + c * y


@inlined
def float_freely(tables: PlanarTables, applied: np.ndarray, work: np.ndarray, i: int) -> bool:
    """Write the acceleration of a body on a planar joint: its parent exerts forces along the joint only."""
    parent, speed, sign = tables.rows[i, PARENT], tables.rows[i, SPEED], tables.geometry[i, SIGN]
    axis_x, axis_y = axis_of(tables, work, i)
    along, aside, torque = applied[speed], sign * applied[speed + 1], sign * applied[speed + 2]
    force_x, force_y = along * axis_x - aside * axis_y, along * axis_y + aside * axis_x
    h_x, h_y, j = work[i, H], work[i, H + 1], work[i, J]
    pivot, rest = 1.0 / j, torque - work[i, MOMENT]
    m_xx = work[i, M] - pivot * h_x * h_x
    m_xy = work[i, M + 1] - pivot * h_x * h_y
    m_yy = work[i, M + 2] - pivot * h_y * h_y
    rest_x = force_x - work[i, FORCE] - pivot * rest * h_x
    rest_y = force_y - work[i, FORCE + 1] - pivot * rest * h_y
    determinant = m_xx * m_yy - m_xy * m_xy
    a_x, a_y = (m_yy * rest_x - m_xy * rest_y) / determinant, (m_xx * rest_y - m_xy * rest_x) / determinant
    work[i, ACCELERATION], work[i, ACCELERATION + 1] = a_x, a_y
    work[i, ALPHA] = pivot * (rest - h_x * a_x - h_y * a_y)
    work[parent, FORCE] += force_x
    work[parent, FORCE + 1] += force_y
    work[parent, MOMENT] += torque + work[i, OFFSET] * force_y - work[i, OFFSET + 1] * force_x
    return j.real > 0.0 and determinant.real > 0.0


@inlined
def sweep_inward(
    tables: PlanarTables,
    drives: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    is_implicit: bool,
    added: np.ndarray,
) -> bool:
    """Eliminate all joints, children before parents; return whether each of them has inertia along it.

    `added` is inertia along the joints, which counts in an implicit sweep.
    """
    rows, geometry = tables.rows, tables.geometry
    is_regular = True
    for i in range(len(rows) - 1, 0, -1):
        kind, parent, drive, speed = rows[i, KIND], rows[i, PARENT], rows[i, DRIVE], rows[i, SPEED]
        m_xx, m_xy, m_yy = work[i, M], work[i, M + 1], work[i, M + 2]
        h_x, h_y, j = work[i, H], work[i, H + 1], work[i, J]
        force_x, force_y, moment = work[i, FORCE], work[i, FORCE + 1], work[i, MOMENT]
        r_x, r_y = work[i, OFFSET], work[i, OFFSET + 1]
        b_x, b_y = work[i, BIAS], work[i, BIAS + 1]
        if kind == TURN and drive < 0:
            # All that waits for the division is written as few operations after it: the time of a chain is how long the
            # longest dependence from a body to its parent takes.
            torque = geometry[i, SIGN] * applied[speed]
            m_r_x, m_r_y = m_xy * r_x - m_xx * r_y, m_yy * r_x - m_xy * r_y  # M times the normal cross r
            h_r = h_y * r_x - h_x * r_y
            resists = geometry[i, ARMATURE] + added[speed] if is_implicit else geometry[i, ARMATURE]
            j += resists  # the turn against the parent, not that against N
            h_r -= resists
            work[parent, J] += resists
            pivot = 1.0 / j
            is_regular = is_regular and j.real > 0.0
            e_x, e_y, e_r = pivot * h_x, pivot * h_y, pivot * h_r
            rest = pivot * (torque - moment - h_x * b_x - h_y * b_y)
            work[i, U], work[i, U + 1], work[i, U + 2], work[i, REST] = e_x, e_y, e_r, rest
            force_x += m_xx * b_x + m_xy * b_y
            force_y += m_xy * b_x + m_yy * b_y
            work[parent, M] += m_xx - h_x * e_x
            work[parent, M + 1] += m_xy - h_x * e_y
            work[parent, M + 2] += m_yy - h_y * e_y
            work[parent, H] += m_r_x - h_x * e_r
            work[parent, H + 1] += m_r_y - h_y * e_r
            work[parent, J] += (m_r_y * r_x - m_r_x * r_y) - h_r * e_r
            work[parent, FORCE] += force_x + h_x * rest
            work[parent, FORCE + 1] += force_y + h_y * rest
            work[parent, MOMENT] += (torque + r_x * force_y - r_y * force_x) + h_r * rest
        elif kind == FLOAT:
            is_regular = float_freely(tables, applied, work, i) and is_regular
        else:
            if kind == TURN:
                turning = geometry[i, SIGN] * drives[drive, 2]
                force_x, force_y, moment = force_x + turning * h_x, force_y + turning * h_y, moment + turning * j
            elif drive < 0:
                axis_x, axis_y = axis_of(tables, work, i)
                u_x, u_y = m_xx * axis_x + m_xy * axis_y, m_xy * axis_x + m_yy * axis_y
                u_j = h_x * axis_x + h_y * axis_y
                inertia = axis_x * u_x + axis_y * u_y + geometry[i, ARMATURE]
                if is_implicit:
                    inertia += added[speed]
                is_regular = is_regular and inertia.real > 0.0
                pivot = 1.0 / inertia
                rest = pivot * (applied[speed] - axis_x * force_x - axis_y * force_y)
                e_x, e_y, e_j = pivot * u_x, pivot * u_y, pivot * u_j
                work[i, U], work[i, U + 1], work[i, U + 2], work[i, REST] = e_x, e_y, e_j, rest
                m_xx, m_xy, m_yy = m_xx - u_x * e_x, m_xy - u_x * e_y, m_yy - u_y * e_y
                h_x, h_y, j = h_x - u_x * e_j, h_y - u_y * e_j, j - u_j * e_j
                force_x, force_y, moment = force_x + rest * u_x, force_y + rest * u_y, moment + rest * u_j
            force_x, force_y = force_x + m_xx * b_x + m_xy * b_y, force_y + m_xy * b_x + m_yy * b_y
            moment += h_x * b_x + h_y * b_y
            m_r_x, m_r_y = m_xy * r_x - m_xx * r_y, m_yy * r_x - m_xy * r_y
            work[parent, H] += h_x + m_r_x
            work[parent, H + 1] += h_y + m_r_y
            work[parent, J] += j + (2.0 * h_y + m_r_y) * r_x - (2.0 * h_x + m_r_x) * r_y
            work[parent, M] += m_xx
            work[parent, M + 1] += m_xy
            work[parent, M + 2] += m_yy
            work[parent, FORCE] += force_x
            work[parent, FORCE + 1] += force_y
            work[parent, MOMENT] += moment + r_x * force_y - r_y * force_x
    return is_regular


@inlined
def sweep_accelerations(
    tables: PlanarTables, drives: np.ndarray, applied: np.ndarray, work: np.ndarray, du: np.ndarray
) -> Any:
    """Write du of the free speeds, and the acceleration of every row; return the power of the driving forces."""
    rows, geometry = tables.rows, tables.geometry
    zero = work[0, ALPHA]
    work[0, ACCELERATION], work[0, ACCELERATION + 1] = zero - tables.gravity[0], zero - tables.gravity[1]
    power = zero
    for i in range(1, len(rows)):
        kind, parent, drive, speed = rows[i, KIND], rows[i, PARENT], rows[i, DRIVE], rows[i, SPEED]
        carried = work[parent, ALPHA]
        a_x = work[parent, ACCELERATION] - carried * work[i, OFFSET + 1] + work[i, BIAS]
        a_y = work[parent, ACCELERATION + 1] + carried * work[i, OFFSET] + work[i, BIAS + 1]
        if drive >= 0:
            alpha = carried + geometry[i, SIGN] * drives[drive, 2] if kind == TURN else carried
            h_x, h_y = work[i, H], work[i, H + 1]
            if kind == TURN:
                needed = geometry[i, SIGN] * (work[i, MOMENT] + h_x * a_x + h_y * a_y + work[i, J] * alpha)
            else:
                axis_x, axis_y = axis_of(tables, work, i)
                force_x = work[i, FORCE] + work[i, M] * a_x + work[i, M + 1] * a_y + h_x * alpha
                force_y = work[i, FORCE + 1] + work[i, M + 1] * a_x + work[i, M + 2] * a_y + h_y * alpha
                needed = axis_x * force_x + axis_y * force_y
            power += (needed + geometry[i, ARMATURE] * drives[drive, 2] - applied[speed]) * drives[drive, 1]
        elif kind == TURN:
            alpha = work[i, REST] - work[i, U] * work[parent, ACCELERATION]
            alpha = alpha - work[i, U + 1] * work[parent, ACCELERATION + 1] - work[i, U + 2] * carried
            du[speed] = geometry[i, SIGN] * (alpha - carried)
        elif kind == SLIDE:
            alpha = carried
            rate = work[i, REST] - work[i, U] * a_x - work[i, U + 1] * a_y - work[i, U + 2] * carried
            du[speed] = rate
            axis_x, axis_y = axis_of(tables, work, i)
            a_x, a_y = a_x + rate * axis_x, a_y + rate * axis_y
        else:
            alpha, sign = work[i, ALPHA], geometry[i, SIGN]
            axis_x, axis_y = axis_of(tables, work, i)
            d_x, d_y = work[i, ACCELERATION] - a_x, work[i, ACCELERATION + 1] - a_y
            du[speed] = d_x * axis_x + d_y * axis_y
            du[speed + 1] = sign * (d_y * axis_x - d_x * axis_y)
            du[speed + 2] = sign * (alpha - carried)
            a_x, a_y = work[i, ACCELERATION], work[i, ACCELERATION + 1]
        work[i, ACCELERATION], work[i, ACCELERATION + 1], work[i, ALPHA] = a_x, a_y, alpha
    return power
