"""The points of rigid contacts as tables of the kernels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.kernels.contact.falling import SteadyNumbers
from kanefe.kernels.contact.rigid_points import (
    POINT_CONSTANTS,
    POINT_INTEGERS,
    PointConstants,
    no_rigid_points,
)
from kanefe.kernels.force_elements.blocks import flat
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.tables import RigidPoints
from kanefe.tree.model_data import ModelData


def rigid_points(
    model: ModelData, end_of: Callable[[Marker], tuple[int, np.ndarray]] = lambda _: (-1, np.zeros(MARKER_NUMBERS))
) -> RigidPoints:
    """Return the tables of all points, contact by contact; without rows of markers for who has none."""
    if not model.rigid_contacts:
        return no_rigid_points()
    from kanefe.contact.rigid.rigid import IMPACT_LAWS
    from kanefe.contact.rigid.rigid_contact import EACH, REPORTED_CHANGES

    places, markers, numbers, shapes = [], list[np.ndarray](), list[np.ndarray](), list[float]()
    for number, load in enumerate(model.rigid_contacts):
        contact, first = model.rigid_contact(number), model.load_states[load].start
        ends = [end_of(marker) for marker in contact.ends]
        for i, (end, probe) in enumerate(contact.probes):
            status = first + REPORTED_CHANGES + EACH * i
            nature = int(contact.friction is not None), int(contact.has_mark(i))
            told = IMPACT_LAWS.index(contact.law.impact), int(contact.reports_points)
            places.append((ends[0][0], ends[end][0], status, len(shapes), *nature, first, number, *told))
            markers += [ends[0][1], ends[end][1]]
            friction = contact.friction
            steady = SteadyNumbers(0.0, 0.0) if friction is None else friction.steady
            own = probe.point, probe.radius, probe.ring, probe.axis, probe.share
            law = contact.law.restitution, contact.law.stiffness, contact.law.exponent
            numbers.append(flat(PointConstants(*own, *law, contact.belt, steady)))
        shapes += [float(contact.shape.kind), *contact.shape.numbers.tolist()]
    return RigidPoints(
        places=np.array(places, dtype=np.int64).reshape(-1, POINT_INTEGERS),
        markers=np.array(markers).reshape(-1, MARKER_NUMBERS),
        numbers=np.array(numbers).reshape(-1, POINT_CONSTANTS),
        shapes=np.array(shapes, dtype=float),
    )


def points_of_contacts(model: ModelData) -> list[tuple[int, int]]:
    """Return of each point the number of its contact among the rigid ones, and its number there."""
    numbers = range(len(model.rigid_contacts))
    return [(number, i) for number in numbers for i in range(len(model.rigid_contact(number).probes))]
