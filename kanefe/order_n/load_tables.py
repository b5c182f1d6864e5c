"""Tables of loads and joint forces for the kernels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.kernels.addresses import addresses
from kanefe.kernels.force_elements.given import given
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE
from kanefe.kernels.loads_between import LOAD_INTEGERS, LoadsBetween, load_workspace_size, no_loads_between
from kanefe.kernels.markers import MARKER_NUMBERS
from kanefe.loads.base import LoadKernel
from kanefe.order_n.seats import Seats
from kanefe.tree.model_data import ModelData


def attached_interfaces(model: ModelData, is_complete: bool = False) -> list[dict[str, tuple[InterfaceFrame, bool]]]:
    """Return for each body its interfaces with something attached, and whether they carry a body or close a loop.

    `is_complete`: all its interfaces.
    """
    attached: list[dict[str, tuple[InterfaceFrame, bool]]] = [{} for _ in model.bodies]
    for body in model.bodies:
        if body.parent_interface is not None:
            attached[body.parent][body.parent_interface.name] = body.parent_interface, True
    for number, body in enumerate(model.bodies):
        for _, interface in body.loads:
            if interface is not None:
                attached[number].setdefault(interface.name, (interface, False))
    for load in model.loads:
        for marker in load.ends:
            if marker.interface is not None:
                attached[marker.body].setdefault(marker.interface.name, (marker.interface, False))
    for constraint in model.constraints:
        for row in constraint.rows:
            for marker in row.markers:
                if marker.interface is not None:
                    attached[marker.body][marker.interface.name] = marker.interface, True
    if is_complete:
        for number, body in enumerate(model.bodies):
            for interface in body.flexible.body.interfaces if body.flexible is not None else ():
                attached[number].setdefault(interface.name, (interface, False))
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
    for number, body in enumerate(builder.model.bodies):
        places = builder.model.coordinate_places(number)
        for load in body.joint_loads:
            forces.append((*places[load.coordinate], -1, builder.inputs.of(load)))
        for i, law in enumerate(body.joint.coordinate_forces):
            if law is not None and law.acts:
                forces.append((*places[i], len(laws), -1))
                laws.append(
                    (
                        law.stiffness, law.damping, law.rest, law.lower, law.upper, law.limit_stiffness,
                        law.limit_damping,
                    )
                )  # fmt: skip
    return np.array(forces, dtype=np.int64).reshape(-1, 4), np.array(laws, dtype=float).reshape(-1, 7)


def loads_between(builder: Seats) -> LoadsBetween:
    """Return the tables of loads between frames."""
    kernels = []
    for load in builder.model.loads:
        kernel = load.kernel or LoadKernel(given, np.array((float(load.input_count),)), given)
        kernels.append((addresses(kernel.real, kernel.complex_, SIGNATURE), kernel.numbers))
    return _tables(builder, range(len(kernels)), kernels)


def watched_loads(builder: Seats, chosen: Sequence[int]) -> LoadsBetween:
    """Return the same of some loads, whose functions write what their events look at."""
    kernels = []
    for number in chosen:
        kernel = builder.model.loads[number].kernel
        if kernel is not None and kernel.watch is not None:
            kernels.append((addresses(kernel.watch, None, WATCH_SIGNATURE), kernel.numbers))
    return _tables(builder, chosen, kernels)


def _tables(
    builder: Seats, chosen: Sequence[int], kernels: Sequence[tuple[tuple[int, int], np.ndarray]]
) -> LoadsBetween:
    if not chosen:
        return no_loads_between()
    model = builder.model
    integers, rows, markers = [], list[int](), list[np.ndarray]()
    pool: list[float] = []
    for number, (_, constants) in zip(chosen, kernels, strict=True):
        load, states = model.loads[number], model.load_states[number]
        first, count = max(builder.inputs.of(load), 0), len(load.ends)
        integers.append((len(rows), count, len(pool), first, states.start, states.stop - states.start))
        pool += constants.tolist()
        for marker in load.ends:
            row, numbers = builder.marker_numbers(marker)
            rows.append(row)
            markers.append(numbers)
    return LoadsBetween(
        loads=np.array(integers, dtype=np.int64).reshape(-1, LOAD_INTEGERS),
        addresses=np.array([found for found, _ in kernels], dtype=np.int64).reshape(-1, 2),
        rows=np.array(rows, dtype=np.int64),
        markers=np.array(markers).reshape(-1, MARKER_NUMBERS),
        numbers=np.array(pool, dtype=float),
        workspace_size=np.array([max(load_workspace_size(row[1], row[5]) for row in integers)]),
    )
