"""The inward sweep of a planar scene, and the sweep outward for du (Eq. 18).

The coordinates of each joint are eliminated from the inertia of what it carries. A body on a turning joint then shows
its parent a mass that resists translations only: three numbers in place of six.
"""

from typing import Any

import numpy as np

from kanefe.kernels.language import inlined, is_above
from kanefe.kernels.planar.layout import AT, ROW, SHAPE, PlanarTables, RowKind


@inlined
def axis_of(tables: PlanarTables, work: np.ndarray, i: int) -> tuple[Any, Any]:
    """Return the axis of a slide, or the first of a float, in N."""
    parent, x, y = tables.rows[i, ROW.parent], tables.geometry[i, SHAPE.axis], tables.geometry[i, SHAPE.axis + 1]
    c, s = work[parent, AT.c], work[parent, AT.s]
    return c * x - s * y, s * x + c * y


@inlined
def float_freely(tables: PlanarTables, applied: np.ndarray, work: np.ndarray, i: int) -> bool:
    """Write the acceleration of a body on a planar joint: its parent exerts forces along the joint only."""
    parent, speed, sign = tables.rows[i, ROW.parent], tables.rows[i, ROW.speed], tables.geometry[i, SHAPE.sign]
    axis_x, axis_y = axis_of(tables, work, i)
    along, aside, torque = applied[speed], sign * applied[speed + 1], sign * applied[speed + 2]
    force_x, force_y = along * axis_x - aside * axis_y, along * axis_y + aside * axis_x
    h_x, h_y, j = work[i, AT.h], work[i, AT.h + 1], work[i, AT.j]
    pivot, rest = 1.0 / j, torque - work[i, AT.moment]
    m_xx = work[i, AT.m] - pivot * h_x * h_x
    m_xy = work[i, AT.m + 1] - pivot * h_x * h_y
    m_yy = work[i, AT.m + 2] - pivot * h_y * h_y
    rest_x = force_x - work[i, AT.force] - pivot * rest * h_x
    rest_y = force_y - work[i, AT.force + 1] - pivot * rest * h_y
    determinant = m_xx * m_yy - m_xy * m_xy
    a_x, a_y = (m_yy * rest_x - m_xy * rest_y) / determinant, (m_xx * rest_y - m_xy * rest_x) / determinant
    work[i, AT.acceleration], work[i, AT.acceleration + 1] = a_x, a_y
    work[i, AT.alpha] = pivot * (rest - h_x * a_x - h_y * a_y)
    work[parent, AT.force] += force_x
    work[parent, AT.force + 1] += force_y
    work[parent, AT.moment] += torque + work[i, AT.offset] * force_y - work[i, AT.offset + 1] * force_x
    return is_above(j, 0.0) and is_above(determinant, 0.0)


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
        kind, parent, drive, speed = rows[i, ROW.kind], rows[i, ROW.parent], rows[i, ROW.drive], rows[i, ROW.speed]
        m_xx, m_xy, m_yy = work[i, AT.m], work[i, AT.m + 1], work[i, AT.m + 2]
        h_x, h_y, j = work[i, AT.h], work[i, AT.h + 1], work[i, AT.j]
        force_x, force_y, moment = work[i, AT.force], work[i, AT.force + 1], work[i, AT.moment]
        r_x, r_y = work[i, AT.offset], work[i, AT.offset + 1]
        b_x, b_y = work[i, AT.bias], work[i, AT.bias + 1]
        if kind == RowKind.TURN and drive < 0:
            # All that waits for the division is written as few operations after it: the time of a chain is how long the
            # longest dependence from a body to its parent takes.
            torque = geometry[i, SHAPE.sign] * applied[speed]
            m_r_x, m_r_y = m_xy * r_x - m_xx * r_y, m_yy * r_x - m_xy * r_y  # M times the normal cross r
            h_r = h_y * r_x - h_x * r_y
            resists = geometry[i, SHAPE.armature] + added[speed] if is_implicit else geometry[i, SHAPE.armature]
            j += resists  # the turn against the parent, not that against N
            h_r -= resists
            work[parent, AT.j] += resists
            pivot = 1.0 / j
            is_regular = is_regular and is_above(j, 0.0)
            e_x, e_y, e_r = pivot * h_x, pivot * h_y, pivot * h_r
            rest = pivot * (torque - moment - h_x * b_x - h_y * b_y)
            work[i, AT.u], work[i, AT.u + 1], work[i, AT.u + 2], work[i, AT.rest] = e_x, e_y, e_r, rest
            force_x += m_xx * b_x + m_xy * b_y
            force_y += m_xy * b_x + m_yy * b_y
            work[parent, AT.m] += m_xx - h_x * e_x
            work[parent, AT.m + 1] += m_xy - h_x * e_y
            work[parent, AT.m + 2] += m_yy - h_y * e_y
            work[parent, AT.h] += m_r_x - h_x * e_r
            work[parent, AT.h + 1] += m_r_y - h_y * e_r
            work[parent, AT.j] += (m_r_y * r_x - m_r_x * r_y) - h_r * e_r
            work[parent, AT.force] += force_x + h_x * rest
            work[parent, AT.force + 1] += force_y + h_y * rest
            work[parent, AT.moment] += (torque + r_x * force_y - r_y * force_x) + h_r * rest
        elif kind == RowKind.FLOAT:
            is_regular = float_freely(tables, applied, work, i) and is_regular
        else:
            if kind == RowKind.TURN:
                turning = geometry[i, SHAPE.sign] * drives[drive, 2]
                force_x, force_y, moment = force_x + turning * h_x, force_y + turning * h_y, moment + turning * j
            elif drive < 0:
                axis_x, axis_y = axis_of(tables, work, i)
                u_x, u_y = m_xx * axis_x + m_xy * axis_y, m_xy * axis_x + m_yy * axis_y
                u_j = h_x * axis_x + h_y * axis_y
                inertia = axis_x * u_x + axis_y * u_y + geometry[i, SHAPE.armature]
                if is_implicit:
                    inertia += added[speed]
                is_regular = is_regular and is_above(inertia, 0.0)
                pivot = 1.0 / inertia
                rest = pivot * (applied[speed] - axis_x * force_x - axis_y * force_y)
                e_x, e_y, e_j = pivot * u_x, pivot * u_y, pivot * u_j
                work[i, AT.u], work[i, AT.u + 1], work[i, AT.u + 2], work[i, AT.rest] = e_x, e_y, e_j, rest
                m_xx, m_xy, m_yy = m_xx - u_x * e_x, m_xy - u_x * e_y, m_yy - u_y * e_y
                h_x, h_y, j = h_x - u_x * e_j, h_y - u_y * e_j, j - u_j * e_j
                force_x, force_y, moment = force_x + rest * u_x, force_y + rest * u_y, moment + rest * u_j
            force_x, force_y = force_x + m_xx * b_x + m_xy * b_y, force_y + m_xy * b_x + m_yy * b_y
            moment += h_x * b_x + h_y * b_y
            m_r_x, m_r_y = m_xy * r_x - m_xx * r_y, m_yy * r_x - m_xy * r_y
            work[parent, AT.h] += h_x + m_r_x
            work[parent, AT.h + 1] += h_y + m_r_y
            work[parent, AT.j] += j + (2.0 * h_y + m_r_y) * r_x - (2.0 * h_x + m_r_x) * r_y
            work[parent, AT.m] += m_xx
            work[parent, AT.m + 1] += m_xy
            work[parent, AT.m + 2] += m_yy
            work[parent, AT.force] += force_x
            work[parent, AT.force + 1] += force_y
            work[parent, AT.moment] += moment + r_x * force_y - r_y * force_x
    return is_regular


@inlined
def sweep_accelerations(
    tables: PlanarTables, drives: np.ndarray, applied: np.ndarray, work: np.ndarray, du: np.ndarray
) -> Any:
    """Write du of the free speeds, and the acceleration of every row; return the power of the driving forces."""
    rows, geometry = tables.rows, tables.geometry
    zero = work[0, AT.alpha]
    work[0, AT.acceleration], work[0, AT.acceleration + 1] = zero - tables.gravity[0], zero - tables.gravity[1]
    power = zero
    for i in range(1, len(rows)):
        kind, parent, drive, speed = rows[i, ROW.kind], rows[i, ROW.parent], rows[i, ROW.drive], rows[i, ROW.speed]
        carried = work[parent, AT.alpha]
        a_x = work[parent, AT.acceleration] - carried * work[i, AT.offset + 1] + work[i, AT.bias]
        a_y = work[parent, AT.acceleration + 1] + carried * work[i, AT.offset] + work[i, AT.bias + 1]
        if drive >= 0:
            alpha = carried + geometry[i, SHAPE.sign] * drives[drive, 2] if kind == RowKind.TURN else carried
            h_x, h_y = work[i, AT.h], work[i, AT.h + 1]
            if kind == RowKind.TURN:
                needed = geometry[i, SHAPE.sign] * (work[i, AT.moment] + h_x * a_x + h_y * a_y + work[i, AT.j] * alpha)
            else:
                axis_x, axis_y = axis_of(tables, work, i)
                force_x = work[i, AT.force] + work[i, AT.m] * a_x + work[i, AT.m + 1] * a_y + h_x * alpha
                force_y = work[i, AT.force + 1] + work[i, AT.m + 1] * a_x + work[i, AT.m + 2] * a_y + h_y * alpha
                needed = axis_x * force_x + axis_y * force_y
            power += (needed + geometry[i, SHAPE.armature] * drives[drive, 2] - applied[speed]) * drives[drive, 1]
        elif kind == RowKind.TURN:
            alpha = work[i, AT.rest] - work[i, AT.u] * work[parent, AT.acceleration]
            alpha = alpha - work[i, AT.u + 1] * work[parent, AT.acceleration + 1] - work[i, AT.u + 2] * carried
            du[speed] = geometry[i, SHAPE.sign] * (alpha - carried)
        elif kind == RowKind.SLIDE:
            alpha = carried
            rate = work[i, AT.rest] - work[i, AT.u] * a_x - work[i, AT.u + 1] * a_y - work[i, AT.u + 2] * carried
            du[speed] = rate
            axis_x, axis_y = axis_of(tables, work, i)
            a_x, a_y = a_x + rate * axis_x, a_y + rate * axis_y
        else:
            alpha, sign = work[i, AT.alpha], geometry[i, SHAPE.sign]
            axis_x, axis_y = axis_of(tables, work, i)
            d_x, d_y = work[i, AT.acceleration] - a_x, work[i, AT.acceleration + 1] - a_y
            du[speed] = d_x * axis_x + d_y * axis_y
            du[speed + 1] = sign * (d_y * axis_x - d_x * axis_y)
            du[speed + 2] = sign * (alpha - carried)
            a_x, a_y = work[i, AT.acceleration], work[i, AT.acceleration + 1]
        work[i, AT.acceleration], work[i, AT.acceleration + 1], work[i, AT.alpha] = a_x, a_y, alpha
    return power
