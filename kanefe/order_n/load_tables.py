"""Tables of loads, springs and joint forces for the kernels, and the values that go with them at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.constraints.rows import CouplerRow
from kanefe.kernels._numba import Part
from kanefe.kernels.interactions import INTERACTION_INTEGERS, Interactions
from kanefe.kernels.markers import MARKER_NUMBERS
from kanefe.loads import Bushing, FieldLoad, JointLoad, PointLoad, SpringDamper
from kanefe.loads.functions import CompiledCallback
from kanefe.order_n.seats import marker_numbers
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.order_n.tables import TableBuilder


ValuedLoad = PointLoad | JointLoad | FieldLoad


class InputLayout:
    """Where the values of loads are in the kernels' `inputs`, and how they are found.

    Loads that are the same at all times are filled in once. What depends on the time alone is asked for once an
    evaluation; what depends on the state needs the outward sweep first.

    Attributes
    ----------
    constants : ndarray
        `inputs` with what never changes.
    of_time, of_state : list of (slice, load)
    laws : list of (slice, spring or bushing)
        With a law of the user's, which looks at the state.
    """

    def __init__(self, model: ModelData) -> None:
        self._at: dict[int, int] = {}
        self.of_time: list[tuple[slice, ValuedLoad]] = []
        self.of_state: list[tuple[slice, ValuedLoad]] = []
        values: list[float] = []
        for load, count in _loads_with_values(model):
            where = slice(len(values), len(values) + count)
            self._at[id(load)] = where.start
            values += [0.0] * count
            if load.is_constant:
                values[where] = np.atleast_1d(load.value(0.0, None)).tolist()
            else:
                (self.of_state if load.takes_state else self.of_time).append((where, load))
        self.laws: list[tuple[slice, SpringDamper | Bushing]] = []
        for item in interactions_of(model):
            if item.function is not None:
                where = slice(len(values), len(values) + (6 if isinstance(item, Bushing) else 1))
                self._at[id(item)] = where.start
                values += [0.0] * (where.stop - where.start)
                self.laws.append((where, item))
        self.constants = np.array(values)

    def compiled(self) -> list[Part]:
        """Return the functions that numba has compiled, for the kernels; none if there are others besides."""
        parts: list[Part] = []
        for where, load in (*self.of_time, *self.of_state):
            if self.laws or not isinstance(load.function, CompiledCallback):
                return []
            count = where.stop - where.start
            parts.append((load.function.function, where.start, count if count > 1 else 0, load.takes_state))
        return parts

    @property
    def needs_state(self) -> bool:
        """Whether functions of the user look at the state."""
        return bool(self.of_state or self.laws)

    @property
    def is_constant(self) -> bool:
        """Whether no function of the user is called in a run."""
        return not (self.of_time or self.of_state or self.laws)

    def of(self, item: object) -> int:
        """Return where the values of a load, spring or bushing begin; -1: it has none."""
        return self._at.get(id(item), -1)


def interactions_of(model: ModelData) -> tuple[SpringDamper | Bushing, ...]:
    """Return springs, then bushings."""
    return (*model.springs, *model.bushings)


def _loads_with_values(model: ModelData) -> list[tuple[Any, int]]:
    """Return every load with the number of its values."""
    found: list[tuple[Any, int]] = []
    for body in model.bodies:
        found += [(load, 3) for load, _ in body.loads]
        found += [(load, 1) for load in body.joint_loads]
        found += [(load, 1 if load.is_pressure else 3) for load in body.field_loads]
    return found


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


def point_load_tables(builder: TableBuilder) -> tuple[np.ndarray, np.ndarray]:
    """Return `Tables.loads` and `Tables.points`."""
    loads, points = [], []
    for number, body in enumerate(builder.model.bodies):
        for load, interface in body.loads:
            seat = builder.seat(number, interface)
            loads.append((seat.row, builder.inputs.of(load), int(load.is_torque), int(load.follows)))
            points.append(np.concatenate((seat.place + seat.axes @ load.point, seat.axes.ravel())))
    return np.array(loads, dtype=np.int64).reshape(-1, 4), np.array(points, dtype=float).reshape(-1, 12)


def joint_force_tables(builder: TableBuilder) -> tuple[np.ndarray, np.ndarray]:
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


def interaction_tables(builder: TableBuilder) -> Interactions | None:
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
            row, numbers = marker_numbers(builder, marker)
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
