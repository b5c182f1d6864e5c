"""What rigid contacts do to their internal states, and the energy that friction takes and belts give."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import dot, plus, rotated, three, times, vector
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW
from kanefe.kernels.constraints.loop_tables import DIRECTION, KIND_OF, POINT, UnitResponses
from kanefe.kernels.contact.rigid_points import (
    FIRST_STATE,
    KEPT,
    KEPT_RATE,
    MET,
    OF_POINT,
    ON_SURFACE,
    SLIP,
    STATUS,
    WORK,
    is_closed,
    is_slipping,
)
from kanefe.kernels.loads.markers import axes_of
from kanefe.kernels.tables import Loops


@kernel
def put_contact_rates(
    loops: Loops,
    z: np.ndarray,
    multipliers: np.ndarray,
    kept: UnitResponses,
    work: np.ndarray,
    dz: np.ndarray,
    powers: np.ndarray,
) -> None:
    """Write the rates of the paths slid and of the work of friction, and add the power of that, taken and given."""
    points, met = loops.points, kept.exerted.met
    for j in range(len(loops.rows)):
        if loops.rows[j, KIND_OF] != CONTACT_ROW or loops.rows[j, DIRECTION] > 0:
            continue
        p = loops.rows[j, POINT]
        if not is_closed(points, p, z):
            continue
        slips, x, y = is_slipping(points, p, z), met[p, MET.rates + 1], met[p, MET.rates + 2]
        if slips:
            friction = times(multipliers[j], vector(met, p, MET.tangential))
        else:
            along = times(multipliers[j + 1], vector(met, p, MET.first))
            friction = plus(along, times(multipliers[j + 2], vector(met, p, MET.second)))
        slip = plus(times(x, vector(met, p, MET.first)), times(y, vector(met, p, MET.second)))
        axes = axes_of(points.markers, 2 * p, points.places[p, ON_SURFACE], work)
        taken = dot(friction, slip)
        powers[0] -= taken
        powers[1] += dot(friction, rotated(axes, three(points.numbers[p], OF_POINT.belt)))
        if slips:
            first, status = points.places[p, FIRST_STATE], points.places[p, STATUS]
            dz[first + SLIP] += points.numbers[p, OF_POINT.share] * np.sqrt(x * x + y * y)
            dz[first + WORK] -= taken
            for i in range(3):
                dz[status + KEPT + i] = z[status + KEPT_RATE + i]
