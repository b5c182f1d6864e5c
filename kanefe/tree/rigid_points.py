"""The points of rigid contacts as tables of the kernels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.kernels.contact.rigid_points import GivenPoints, RigidPoint, no_rigid_points
from kanefe.kernels.loads.markers import Marker as PlacedMarker
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.tensors import Matrix, Vector
from kanefe.tree.model_data import ModelData


def rigid_points(
    model: ModelData, end_of: Callable[[Marker], tuple[int, np.ndarray]] = lambda _: (-1, np.zeros(12))
) -> RigidPoints:
    """Return the tables of all points, contact by contact; without rows of markers for who has none."""
    if not model.rigid_contacts:
        return no_rigid_points()
    from kanefe.contact.rigid.rigid import IMPACT_LAWS
    from kanefe.contact.rigid.rigid_contact import EACH, REPORTED_CHANGES

    count, shapes = len(points_of_contacts(model)), list[float]()
    places, numbers = np.zeros((count, RigidPoint.integer_count), np.int64), np.zeros((count, RigidPoint.number_count))
    points = iter(GivenPoints(places, numbers))
    for number, load in enumerate(model.rigid_contacts):
        contact, first = model.rigid_contact(number), model.load_states[load].start
        ends, law = [end_of(marker) for marker in contact.ends], contact.law
        steady = None if contact.friction is None else contact.friction.steady
        for i, (end, probe) in enumerate(contact.probes):
            own = next(points)
            put_marker(own.surface, *ends[0])
            put_marker(own.probe, *ends[end])
            own.status, own.first_state, own.shape = first + REPORTED_CHANGES + EACH * i, first, len(shapes)
            own.contact, own.law = number, IMPACT_LAWS.index(law.impact)
            own.rubs, own.has_mark = contact.friction is not None, contact.has_mark(i)
            own.tells = contact.reports_points
            own.point, own.axis, own.belt = Vector(*probe.point), Vector(*probe.axis), Vector(*contact.belt)
            own.radius, own.ring, own.share = probe.radius, probe.ring, probe.share
            own.restitution, own.stiffness, own.exponent = law.restitution, law.stiffness, law.exponent
            if steady is not None:
                for name in steady.fields:
                    setattr(own.friction, name, getattr(steady, name))
        shapes += [float(contact.shape.kind), *contact.shape.numbers.tolist()]
    return RigidPoints(places, numbers, np.array(shapes, dtype=float))


def put_marker(marker: PlacedMarker, row: int, placed: np.ndarray) -> None:
    """Write a marker in a row: its origin (m) and its axes, shape (12,), in those of the row."""
    marker.row, marker.point, marker.axes = row, Vector(*placed[:3]), Matrix(*placed[3:])


def points_of_contacts(model: ModelData) -> list[tuple[int, int]]:
    """Return of each point the number of its contact among the rigid ones, and its number there."""
    numbers = range(len(model.rigid_contacts))
    return [(number, i) for number in numbers for i in range(len(model.rigid_contact(number).probes))]
