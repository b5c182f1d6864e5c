"""Tables of loads, springs and joint forces for the kernels."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.constraints.rows import CouplerRow
from kanefe.kernels.interactions import INTERACTION_INTEGERS, Interactions
from kanefe.kernels.markers import MARKER_NUMBERS
from kanefe.loads import Bushing, SpringDamper
from kanefe.order_n.inputs import interactions_of
from kanefe.order_n.seats import Seats
from kanefe.tree.model_data import ModelData


def attached_interfaces(model: ModelData) -> list[dict[str, tuple[InterfaceFrame, bool]]]:
    """Return for each body its interfaces with something attached, and whether they carry a body or close a loop."""
    attached: list[dict[str, tuple[InterfaceFrame, bool]]] = [{} for _ in model.bodies]
    for body in model.bodies:
        if body.parent_interface is not None:
            attached[body.parent][body.parent_interface.name] = body.parent_interface, True
    for number, body in enumerate(model.bodies):
        for _, interface in body.loads:
            if interface is not None:
                attached[number].setdefault(interface.name, (interface, False))
    for item in interactions_of(model):
        for marker in (item.a, item.b):
            if marker.interface is not None:
                attached[marker.body].setdefault(marker.interface.name, (marker.interface, False))
    for constraint in model.constraints:
        for row in constraint.rows:
            if not isinstance(row, CouplerRow):
                for marker in (row.a, row.b):
                    if marker.interface is not None:
                        attached[marker.body][marker.interface.name] = marker.interface, True
    return attached


def point_load_tables(builder: Seats) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.loads` and `Tables.points`."""
    loads, points = [], []
    for number, body in enumerate(builder.model.bodies):
        for load, interface in body.loads:
            seat = builder.seat(number, interface)
            loads.append((seat.row, builder.inputs.of(load), int(load.is_torque), int(load.follows)))
            points.append(np.concatenate((seat.place + seat.axes @ load.point, seat.axes.ravel())))
    return np.array(loads, dtype=np.int64).reshape(-1, 4), np.array(points, dtype=float).reshape(-1, 12)


def joint_force_tables(builder: Seats) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.joint_forces` and `Tables.laws`."""
    forces: list[tuple[int, ...]] = []
    laws: list[tuple[float, ...]] = []
    free = builder.model.free_count
    for body in builder.model.bodies:
        places = [
            (int(at) if at >= 0 else int(free - 1 - speed), int(speed))
            for at, speed in zip(body.coordinates, body.speeds, strict=False)
        ]
        for load in body.joint_loads:
            forces.append((*places[load.coordinate], -1, builder.inputs.of(load)))
        for i, law in enumerate(body.joint.coordinate_forces):
            if law is not None:
                forces.append((*places[i], len(laws), -1))
                laws.append(
                    (
                        law.stiffness, law.damping, law.rest, law.friction, law.friction_speed, law.lower, law.upper,
                        law.limit_stiffness, law.limit_damping,
                    )
                )  # fmt: skip
    return np.array(forces, dtype=np.int64).reshape(-1, 4), np.array(laws, dtype=float).reshape(-1, 9)


def interaction_tables(builder: Seats) -> Interactions | None:
    """Return the tables of springs and bushings, or None where there are none."""
    model = builder.model
    if not model.has_interactions:
        return None
    pool: list[float] = []
    integers: dict[type, list[list[int]]] = {SpringDamper: [], Bushing: []}
    markers: dict[type, list[np.ndarray]] = {SpringDamper: [], Bushing: []}
    for item in interactions_of(model):
        rows = []
        for marker in (item.a, item.b):
            row, numbers = builder.marker_numbers(marker)
            rows.append(row)
            markers[type(item)].append(numbers)
        table = [-1, 0]
        if isinstance(item, SpringDamper) and len(item.lengths):
            table = [len(pool), len(item.lengths)]
            pool += [*item.lengths, *item.forces]
        integers[type(item)].append([*rows, builder.inputs.of(item), *table])
    return Interactions(
        springs=np.array(integers[SpringDamper], dtype=np.int64).reshape(-1, INTERACTION_INTEGERS),
        bushings=np.array(integers[Bushing], dtype=np.int64).reshape(-1, INTERACTION_INTEGERS),
        spring_markers=np.array(markers[SpringDamper]).reshape(-1, MARKER_NUMBERS),
        bushing_markers=np.array(markers[Bushing]).reshape(-1, MARKER_NUMBERS),
        spring_laws=np.array([(s.stiffness, s.damping, s.rest_length) for s in model.springs]).reshape(-1, 3),
        bushing_laws=np.array([[*b.stiffness, *b.damping] for b in model.bushings]).reshape(-1, 12),
        tables=np.array(pool, dtype=float),
    )
