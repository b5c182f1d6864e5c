"""What rigid contacts do to their internal states, and the energy that friction takes and belts give."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import dot, plus, rotated, three, times, vector
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.constraints.loop_tables import head_of, unit_responses_in
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
from kanefe.kernels.scene import Rates, Scene, State, Work


@kernel
def put_contact_rates(scene: Scene, state: State, work: Work, rates: Rates) -> None:
    """Write the rates of the paths slid and of the work of friction, and add the power of that, taken and given."""
    points, z, multipliers, dz = scene.loops.points, state.z, work.multipliers, rates.dz
    met = unit_responses_in(work.holding, scene.loops).met
    for p in range(len(points.places)):
        if not is_closed(points, p, z):
            continue
        j, slips = head_of(scene.loops, p), is_slipping(points, p, z)
        x, y = met[p, MET.rates + 1], met[p, MET.rates + 2]
        if slips:
            friction = times(multipliers[j], vector(met, p, MET.tangential))
        else:
            along = times(multipliers[j + 1], vector(met, p, MET.first))
            friction = plus(along, times(multipliers[j + 2], vector(met, p, MET.second)))
        slip = plus(times(x, vector(met, p, MET.first)), times(y, vector(met, p, MET.second)))
        axes = axes_of(points.markers, 2 * p, points.places[p, ON_SURFACE], work.frames.numbers)
        taken = dot(friction, slip)
        rates.powers[0] -= taken
        rates.powers[1] += dot(friction, rotated(axes, three(points.numbers[p], OF_POINT.belt)))
        if slips:
            first, status = points.places[p, FIRST_STATE], points.places[p, STATUS]
            dz[first + SLIP] += points.numbers[p, OF_POINT.share] * np.sqrt(x * x + y * y)
            dz[first + WORK] -= taken
            for i in range(3):
                dz[status + KEPT + i] = z[status + KEPT_RATE + i]
