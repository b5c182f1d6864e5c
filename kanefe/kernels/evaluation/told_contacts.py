"""Outputs of rigid contacts in a state, as a whole and point by point."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import norm, plus, put_three, rotated_back, times, vector
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.contact.output_places import CONTACT_OUTPUTS, OPEN, POINT_OUTPUTS, SLIPS, STICKS
from kanefe.kernels.contact.rigid_points import (
    CONTACT,
    FIRST_STATE,
    MET,
    ON_SURFACE,
    SLIP,
    WORK,
    is_closed,
    is_slipping,
    meet,
)
from kanefe.kernels.evaluation.force_tables import CONTACTS, POINTS, ForceTables
from kanefe.kernels.loads.markers import axes_of
from kanefe.kernels.scene import Scene, State, Work


@kernel
def tell_contacts(
    scene: Scene, forces: ForceTables, state: State, work: Work, met: np.ndarray, out: np.ndarray
) -> None:
    """Write `CONTACT_OUTPUTS` of each contact, and `POINT_OUTPUTS` of each of its points.

    Parameters
    ----------
    work : Work
        Its multipliers of contact points are the last ones.
    met : ndarray, shape (points, MET_NUMBERS)
        Of what touches; that of open points is written here.
    """
    z, multipliers, rows = state.z, work.multipliers, work.frames.numbers
    points, of_contacts, of_points = scene.loops.points, out[forces.places[CONTACTS] :], out[forces.places[POINTS] :]
    count = len(points.places)
    first = len(multipliers) - 3 * count
    p = 0
    while p < count:
        contact, nearest = points.places[p, CONTACT], p
        total, tangential, moved = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        normal, status = 0.0, OPEN
        states = points.places[p, FIRST_STATE]
        while p < count and points.places[p, CONTACT] == contact:
            own, j = of_points[POINT_OUTPUTS * p : POINT_OUTPUTS * (p + 1)], first + 3 * p
            own[:] = 0.0
            if not is_closed(points, p, z):
                meet(points, p, scene.tables.gravity, rows, met)
            else:
                axes = axes_of(points.markers, 2 * p, points.places[p, ON_SURFACE], rows)
                along, across = vector(met, p, MET.first), vector(met, p, MET.second)
                if is_slipping(points, p, z):
                    status, own[11] = SLIPS, SLIPS
                    friction = times(multipliers[j], vector(met, p, MET.tangential))
                    slip = plus(times(met[p, MET.rates + 1], along), times(met[p, MET.rates + 2], across))
                    put_three(own, 8, rotated_back(axes, slip))
                else:
                    status, own[11] = max(status, STICKS), STICKS
                    friction = plus(times(multipliers[j + 1], along), times(multipliers[j + 2], across))
                own[0] = multipliers[j]
                put_three(own, 1, rotated_back(axes, friction))
                normal += multipliers[j]
                tangential = plus(tangential, friction)
                total = plus(total, plus(times(multipliers[j], vector(met, p, MET.normal)), friction))
                moved = plus(moved, times(multipliers[j], vector(met, p, MET.point)))
            own[4] = -met[p, MET.gap]
            if met[p, MET.gap] < met[nearest, MET.gap]:
                nearest = p
            p += 1
        told = of_contacts[CONTACT_OUTPUTS * contact : CONTACT_OUTPUTS * (contact + 1)]
        put_three(told, 0, total)
        told[3], told[4], told[5], told[6] = normal, norm(tangential), -met[nearest, MET.gap], z[states + SLIP]
        put_three(told, 7, times(1.0 / normal, moved) if normal > 0.0 else vector(met, nearest, MET.point))
        told[10], told[11] = z[states + WORK], status
