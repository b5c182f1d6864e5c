"""How far loops are open, and how fast they open: residuals of rows after an outward sweep, and their rates."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, norm, plus, rotated, three, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import AT, CONTACT_ROW, COUPLER_ROW, row_residual
from kanefe.kernels.constraints.loop_tables import (
    DIRECTION,
    FIRST_TERM,
    HOLDS_PLACE,
    IS_ANGLE,
    IS_BALL,
    KIND_OF,
    LENGTH,
    POINT,
    ROW_A,
    ROW_B,
    TERM_COUNT,
    RowWrenches,
    holds,
)
from kanefe.kernels.contact.rigid_points import KEPT, MET, ON_SURFACE, STATUS, meet
from kanefe.kernels.layout import OMEGA, POSITION, VELOCITY
from kanefe.kernels.loads.markers import axes_of, lever_of
from kanefe.kernels.tables import Loops, Tables


@kernel
def openings(
    loops: Loops,
    tables: Tables,
    drives: np.ndarray,
    q: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    met: np.ndarray,
    residuals: np.ndarray,
) -> tuple[float, float]:
    """Write g of all rows after an outward sweep; return the largest opening, and the sum of their squares.

    Openings are of the scene's length, or in rad; zero for rows on speeds alone, and for those that do not hold.
    """
    length = loops.limits[LENGTH]
    for i in range(len(tables.rows)):  # far from N's origin round-off is that of the distance
        for c in range(3):
            length = max(length, abs(work[i, POSITION + c]))
    worst = total = 0.0
    for j in range(len(loops.rows)):
        residuals[j] = 0.0
        if not loops.rows[j, HOLDS_PLACE] or not holds(loops, j, z):
            continue
        if loops.rows[j, KIND_OF] == CONTACT_ROW:
            residuals[j] = _off(loops, j, tables.gravity, z, work, met)
        elif loops.rows[j, KIND_OF] == COUPLER_ROW:
            residuals[j] = -loops.numbers[j, AT.constant]
            for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
                i = loops.coordinates[term]
                residuals[j] += loops.coefficients[term] * (q[i] if i >= 0 else drives[-1 - i, 0])
        else:
            residuals[j] = row_residual(
                loops.rows[j, KIND_OF],
                loops.numbers,
                j,
                loops.rows[j, IS_BALL] != 0,
                _place(loops.markers, 2 * j, loops.rows[j, ROW_A], work),
                _place(loops.markers, 2 * j + 1, loops.rows[j, ROW_B], work),
            )
        opening = abs(residuals[j]) / (1.0 if loops.rows[j, IS_ANGLE] else length)
        worst = max(worst, opening)
        total += opening * opening
    return worst if total < np.inf else np.inf, total


@inlined
def _off(loops: Loops, j: int, gravity: np.ndarray, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> float:
    """Return the gap of a point, or how far it is along a direction of the surface from where it sticks, m."""
    points, p, direction = loops.points, loops.rows[j, POINT], loops.rows[j, DIRECTION]
    if direction == 0:
        meet(points, p, gravity, work, met)
        return met[p, MET.gap]
    off = minus(vector(met, p, MET.place), three(z, points.places[p, STATUS] + KEPT))
    axes = axes_of(points.markers, 2 * p, points.places[p, ON_SURFACE], work)
    return dot(vector(met, p, int(MET.normal) + 3 * direction), rotated(axes, off))


@inlined
def _place(markers: np.ndarray, n: int, row: int, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return position and axes of a marker in N."""
    lever = lever_of(markers, n, row, work)
    axes = axes_of(markers, n, row, work)
    if row < 0:
        return lever, axes
    return plus(vector(work, row, POSITION), lever), axes


@inlined
def rate_of_row(
    loops: Loops, j: int, drives: np.ndarray, work: np.ndarray, exerted: RowWrenches, u: np.ndarray
) -> float:
    """Return dg/dt of a row from the velocities of its ends."""
    if loops.rows[j, KIND_OF] == CONTACT_ROW:
        return exerted.met[loops.rows[j, POINT], int(MET.rates) + loops.rows[j, DIRECTION]]
    total, wrenches = 0.0, exerted.wrenches
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            speed = loops.speeds[term]
            total += loops.coefficients[term] * (u[speed] if speed < len(u) else drives[speed - len(u), 1])
        return total
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        if row >= 0:
            total += dot(vector(wrenches, j, 6 * end), vector(work, row, VELOCITY))
            total += dot(vector(wrenches, j, 6 * end + 3), vector(work, row, OMEGA))
    return total


@inlined
def size_of_rate(loops: Loops, j: int, work: np.ndarray, exerted: RowWrenches) -> float:
    """Return how large dg/dt of a row between two ends could be at their speeds; zero of other rows."""
    total = 0.0
    if loops.rows[j, KIND_OF] == CONTACT_ROW or loops.rows[j, KIND_OF] == COUPLER_ROW:
        return total
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        if row >= 0:
            total += norm(vector(exerted.wrenches, j, 6 * end)) * norm(vector(work, row, VELOCITY))
            total += norm(vector(exerted.wrenches, j, 6 * end + 3)) * norm(vector(work, row, OMEGA))
    return total
