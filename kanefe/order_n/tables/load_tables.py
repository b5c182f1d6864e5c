"""Tables of loads and joint forces for the kernels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.kernels.compiler.addresses import addresses
from kanefe.kernels.force_elements.given import given
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE
from kanefe.kernels.loads.loads_layout import (
    A_POINT,
    LOAD_INTEGERS,
    POINT_NUMBERS,
    load_workspace_size,
    no_loads_between,
)
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.loads.reach import POINTS, reach_size
from kanefe.kernels.tables import LoadsBetween
from kanefe.loads.action import LoadKernel
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.reach_tables import in_teams, reach_tables, sweeps
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


def attached_interfaces(
    model: ModelData, point_bodies: Sequence[int], is_complete: bool = False
) -> list[dict[str, tuple[InterfaceFrame, bool]]]:
    """Return for each body its interfaces with something attached, and whether they carry a body or close a loop.

    Ends that are points, see `FrameOffsets.point_bodies`, have no rows. `is_complete`: all its interfaces.
    """
    attached: list[dict[str, tuple[InterfaceFrame, bool]]] = [{} for _ in model.bodies]
    for body in model.bodies:
        if body.parent_interface is not None:
            attached[body.parent][body.parent_interface.name] = body.parent_interface, True
    for number, body in enumerate(model.bodies):
        for _, interface in body.loads:
            if interface is not None:
                attached[number].setdefault(interface.name, (interface, False))
    for number, (load, body_of_points) in enumerate(zip(model.loads, point_bodies, strict=True)):
        holds = number in model.rigid_contacts
        for marker in load.ends[: 1 if body_of_points >= 0 else None]:
            if marker.interface is not None and (holds or marker.interface.name not in attached[marker.body]):
                attached[marker.body][marker.interface.name] = marker.interface, holds
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


def point_load_tables(builder: FrameOffsets) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.loads` and `Tables.points`."""
    loads, points = [], []
    for number, body in enumerate(builder.model.bodies):
        for load, interface in body.loads:
            frame_offset = builder.frame_offset(number, interface)
            loads.append((frame_offset.row, builder.inputs.of(load), int(load.is_torque), int(load.follows)))
            points.append(
                np.concatenate((frame_offset.place + frame_offset.axes @ load.point, frame_offset.axes.ravel()))
            )
    return np.array(loads, dtype=np.int64).reshape(-1, 4), np.array(points, dtype=float).reshape(-1, 12)


def joint_force_tables(builder: FrameOffsets) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.joint_forces` and `Tables.laws`."""
    forces: list[tuple[int, ...]] = []
    laws: list[np.ndarray] = []
    for number, body in enumerate(builder.model.bodies):
        places = builder.model.coordinate_places(number)
        for load in body.joint_loads:
            forces.append((*places[load.coordinate], -1, builder.inputs.of(load)))
        for i, law in enumerate(body.joint.coordinate_forces):
            if law is not None and law.acts:
                forces.append((*places[i], len(laws), -1))
                laws.append(law.law)
    return np.array(forces, dtype=np.int64).reshape(-1, 4), np.array(laws, dtype=float).reshape(-1, 7)


def loads_between(builder: FrameOffsets) -> tuple[LoadsBetween, list[int]]:
    """Return the tables of loads between frames, and their numbers in the model; without rigid contacts, which hold."""
    kernels = {}
    for number, load in enumerate(builder.model.loads):
        if number in builder.model.rigid_contacts:
            continue
        kernel = load.kernel or LoadKernel(given, np.array((float(load.input_count),)), given)
        kernels[number] = addresses(kernel.real, kernel.complex_, SIGNATURE), kernel.numbers
    return _tables(builder, kernels)


def watched_loads(builder: FrameOffsets) -> tuple[LoadsBetween, list[int]]:
    """Return the load tables of loads whose functions write event values, and their numbers in the model."""
    kernels, most = {}, 0
    for number, load in enumerate(builder.model.loads):
        kernel = load.kernel
        if kernel is not None and kernel.watch is not None:
            kernels[number] = addresses(kernel.watch, kernel.change, WATCH_SIGNATURE), kernel.numbers
            most = max(most, len(load.events))
    return _tables(builder, kernels, most)


def told_loads(
    builder: FrameOffsets, functions: Mapping[int, tuple[Callable[..., None] | int, int]]
) -> tuple[LoadsBetween, list[int]]:
    """Return the load tables of loads whose functions write outputs, and their numbers in the model.

    `functions`: of each load by its number, and how many outputs it writes.
    """
    kernels = {}
    for number, (function, _) in functions.items():
        kernel = builder.model.loads[number].kernel
        if kernel is None:
            raise TypeError("a load without a kernel has no compiled outputs")
        kernels[number] = addresses(function, None, WATCH_SIGNATURE), kernel.numbers
    return _tables(builder, kernels, max((count for _, count in functions.values()), default=0))


def _tables(
    builder: FrameOffsets, kernels: Mapping[int, tuple[tuple[int, int], np.ndarray]], values: int = 0
) -> tuple[LoadsBetween, list[int]]:
    """Return the tables of loads by their numbers in the model, and these in the order of the tables.

    `values` are what one of them writes at most, where that is not what it does: each has room for them beside states.
    """
    if not kernels:
        return no_loads_between(), []
    model = builder.model
    swept = sweeps(builder, list(kernels))
    by_sweep = set(swept)
    teams = in_teams(builder, [number for number in kernels if number not in by_sweep])
    reach = reach_tables(builder, teams, swept)
    integers, rows, markers = [], list[int](), list[np.ndarray]()
    pool: list[float] = []
    bearings, places = list[tuple[int, int, int]](), list[np.ndarray]()
    decays = np.zeros((model.state_count, 2))
    for team, numbers in [*enumerate(teams), (-1, swept)]:
        points = 0
        for number in numbers:
            load, states, constants = model.loads[number], model.load_states[number], kernels[number][1]
            first, count = max(builder.inputs.of(load), 0), len(load.ends)
            own_points = count - 1 if builder.point_bodies[number] >= 0 else 0
            where = len(rows), count, len(pool), first, states.start, states.stop - states.start + values
            integers.append((*where, team, points, own_points, count - own_points))
            points += own_points
            if number in model.bearings:
                frame_offset, bearing = builder.frame_offsets[model.bearings[number]], model.following(number).surfaces
                bearings.append((len(integers) - 1, frame_offset.row, int(bearing.has_moment)))
                places.append(np.concatenate((frame_offset.place, frame_offset.axes @ bearing.axis)))
            pool += constants.tolist()
            reach_of_load = builder.reaches[number]
            if reach_of_load is not None:
                decays[states] = reach_of_load.decays
            for end, marker in enumerate(load.ends):
                if end >= count - own_points:
                    row, at = A_POINT, np.concatenate((marker.point, marker.axes.ravel()))
                else:
                    row, at = builder.marker_numbers(marker)
                rows.append(row)
                markers.append(at)
    order = [number for team in teams for number in team] + swept
    near, of_points = (
        reach_size(reach),
        POINT_NUMBERS * max((int(count) for count in reach.teams[:, POINTS]), default=0),
    )
    of_loads = max(load_workspace_size(row[1], row[5]) for row in integers)
    return LoadsBetween(
        loads=np.array(integers, dtype=np.int64).reshape(-1, LOAD_INTEGERS),
        addresses=np.array([kernels[number][0] for number in order], dtype=np.int64).reshape(-1, 2),
        rows=np.array(rows, dtype=np.int64),
        markers=np.array(markers).reshape(-1, MARKER_NUMBERS),
        numbers=np.array(pool, dtype=float),
        decay_rates=np.ascontiguousarray(decays[:, 0]),
        decay_energies=np.ascontiguousarray(decays[:, 1]),
        reach=reach,
        workspace_size=np.array([near + of_points + of_loads, near, of_points]),
        bearings=np.array(bearings, dtype=np.int64).reshape(-1, 3),
        bearing_places=np.array(places).reshape(-1, 6),
    ), order
