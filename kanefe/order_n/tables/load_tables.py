"""Tables of loads and joint forces for the kernels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, ModalMarker
from kanefe.kernels.compiler.addresses import addresses
from kanefe.kernels.force_elements.given import given
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, done_size
from kanefe.kernels.loads.acting import A_POINT, COORDINATE, Acting, BetweenLoad, LoadEnd
from kanefe.kernels.loads.coordinate_law import CoordinateLaw
from kanefe.kernels.loads.joint_forces import JointForce
from kanefe.kernels.loads.joint_reactions import Bearing
from kanefe.kernels.loads.point_and_field_loads import PointLoad
from kanefe.kernels.loads.reach import ReachSizes, Teams
from kanefe.kernels.tables import LoadsBetween, Reach
from kanefe.kernels.values.filled import filled_rows, laid_out
from kanefe.loads.action import LoadKernel
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.reach_tables import in_teams, reach_tables, sweeps
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

Kernels = Mapping[int, tuple[tuple[int, int], np.ndarray]]
"""Addresses of the functions of loads, and their constants, by their numbers in the model."""


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


def point_load_tables(builder: FrameOffsets) -> tuple[np.ndarray, ...]:
    """Return `Tables.loads` and `Tables.points`."""
    found = []
    for number, body in enumerate(builder.model.bodies):
        for load, interface in body.loads:
            at = builder.frame_offset(number, interface)
            kind = {"is_torque": load.is_torque, "follows": load.follows, "first_input": builder.inputs.of(load)}
            found.append(kind | {"row": at.row, "point": at.place + at.axes @ load.point, "axes": at.axes})
    return filled_rows(PointLoad, found)


def joint_force_tables(builder: FrameOffsets) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.joint_forces` and `Tables.laws`."""
    forces, laws = [], list[np.ndarray]()
    for number, body in enumerate(builder.model.bodies):
        places = [{"coordinate": at, "speed": speed} for at, speed in builder.model.coordinate_places(number)]
        for load in body.joint_loads:
            forces.append(places[load.coordinate] | {"law": -1, "motor": builder.inputs.of(load)})
        for i, law in enumerate(body.joint.coordinate_forces):
            if law is not None and law.acts:
                forces.append(places[i] | {"law": len(laws), "motor": -1})
                laws.append(law.law)
    return filled_rows(JointForce, forces)[0], np.array(laws).reshape(-1, CoordinateLaw.number_count)


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


def _tables(builder: FrameOffsets, kernels: Kernels, values: int = 0) -> tuple[LoadsBetween, list[int]]:
    """Return the tables of loads by their numbers in the model, and these in the order of the tables.

    `values` are what one of them writes at most, where that is not what it does: each has room for them beside states.
    """
    swept = sweeps(builder, list(kernels))
    by_sweep = set(swept)
    teams = in_teams(builder, [number for number in kernels if number not in by_sweep])
    order = [number for team in teams for number in team] + swept
    loads, ends = _loads_and_ends(builder, kernels, [*enumerate(teams), (-1, swept)], values)
    numbers = np.concatenate((*(kernels[number][1] for number in order), np.zeros(0)))
    decays = np.zeros((2, builder.model.state_count))
    for number in order:
        reach_of_load = builder.reaches[number]
        if reach_of_load is not None:
            decays[:, builder.model.load_states[number]] = reach_of_load.decays.T
    (rows, markers), bearings = filled_rows(LoadEnd, ends), filled_rows(Bearing, list(_bearings(builder, order)))
    own, reach = filled_rows(BetweenLoad, loads)[0], reach_tables(builder, teams, swept)
    moving, workspace = (numbers, decays[0], decays[1]), _workspace(reach, loads)
    return LoadsBetween(own, rows, markers, *moving, reach, workspace, bearings[0], bearings[1]), order


def _loads_and_ends(
    builder: FrameOffsets, kernels: Kernels, teams: Sequence[tuple[int, Sequence[int]]], values: int
) -> tuple[list[dict[str, int]], list[dict[str, Any]]]:
    """Return what the tables have of the loads of teams, by their numbers, and of their ends."""
    loads, ends, first = [], list[dict[str, Any]](), 0
    for team, numbers in teams:
        first_point = 0
        for number in numbers:
            own, states, load = (
                _ends_of(builder, number),
                builder.model.load_states[number],
                builder.model.loads[number],
            )
            points = sum(end["row"] == A_POINT for end in own)
            of_ends = {"first_end": len(ends), "end_count": len(own), "point_end": len(own) - points}
            of_points = {"team": team, "first_point": first_point, "point_count": points}
            of_states = {"first_state": states.start, "state_count": states.stop - states.start + values}
            of_numbers = {
                "is_swept": number in builder.arms,
                "first_number": first,
                "first_input": max(builder.inputs.of(load), 0),
            }
            functions = dict(zip(("function", "complex_function"), kernels[number][0], strict=True))
            loads.append(of_ends | of_points | of_states | of_numbers | functions)
            ends += own
            first += len(kernels[number][1])
            first_point += points
    return loads, ends


def _ends_of(builder: FrameOffsets, number: int) -> list[dict[str, Any]]:
    """Return the ends of a load; the last ones may be points of a flexible body."""
    found = []
    for end, marker in enumerate(builder.model.loads[number].ends):
        row, place, axes, coordinate, speed, flexible = A_POINT, marker.point, marker.axes, 0, 0, -1
        if isinstance(marker, CoordinateMarker):
            row, (coordinate, speed) = COORDINATE, builder.model.place_of(marker)
            flexible = builder.flexible_numbers[marker.body] if isinstance(marker, ModalMarker) else -1
        elif end == 0 or builder.point_bodies[number] < 0:
            at = builder.frame_offset(marker.body, marker.interface)
            row, place, axes = at.row, at.place + at.axes @ marker.point, at.axes @ marker.axes
        of_coordinate = {"coordinate": coordinate, "speed": speed, "flexible": flexible}
        found.append({"row": row, "point": place, "axes": axes} | of_coordinate)
    return found


def _bearings(builder: FrameOffsets, order: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yield the joints whose load is followed."""
    for load, number in enumerate(order):
        if number in builder.model.bearings:
            at = builder.frame_offsets[builder.model.bearings[number]]
            surfaces = builder.model.following(number).surfaces
            axis = at.axes @ surfaces.axis
            yield {"load": load, "row": at.row, "has_moment": surfaces.has_moment, "place": at.place, "axis": axis}


def _workspace(reach: Reach, loads: Sequence[Mapping[str, int]]) -> np.ndarray:
    """Return the whole numbers of `Acting`."""
    sizes, teams = ReachSizes(reach.sizes), Teams(reach.teams, reach.points)
    most = {"point_count": max((team.point_count for team in teams), default=0)}
    most |= {"end_count": max((load["end_count"] for load in loads), default=0)}
    most |= {"done_size": max((done_size(load["end_count"], load["state_count"]) for load in loads), default=0)}
    balls = {"ball_count": len(reach.balls), "swell_count": len(reach.swells), "swept_ball_count": sizes.swept_balls}
    return laid_out(Acting, load_count=len(loads), near_count=len(loads) - sizes.first_swept, **balls, **most)
