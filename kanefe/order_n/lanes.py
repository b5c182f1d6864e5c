"""Scenes that are evaluated at once, in vector instructions: which are, and their tables for that."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.evaluation.rigid_lanes import LaneTables, evaluate_lanes, lanes_here
from kanefe.kernels.planar.evaluation import planar_memory_size
from kanefe.kernels.planar.lanes import PlanarLanes, evaluate_planar_lanes
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.steppers.lanes import Slots
from kanefe.kernels.tables import Tables
from kanefe.kernels.tree import Kind, Link
from kanefe.kernels.values.records import column
from kanefe.order_n.evaluated import Evaluated

ALIGNMENT = 64
"""Alignment of what is read in vector instructions, bytes: that of the longest register."""


def why_alone(route: Evaluated) -> str:
    """Return why evaluations of a scene are made one by one, or nothing where several are made at once."""
    kinds = route.tables.rows[:, column(Link, "kind")]
    for reason, holds in (
        ("kernels are not compiled", not IS_COMPILED),
        ("flexible bodies", len(route.flexible.bodies) > 0),
        ("loads between frames", len(route.between.loads) > 0),
        ("loops or rigid contacts", len(route.loops.rows) > 0),
        ("joints of a function", bool((kinds == Kind.GIVEN).any())),
    ):
        if holds:
            return reason
    return ""


class _Parts(NamedTuple):
    """The tables of a scene whose numbers may be others in each lane."""

    geometry: np.ndarray
    gravity: np.ndarray
    points: np.ndarray
    laws: np.ndarray


WHOLE = "rows", "loads", "joint_forces", "sizes"
"""Tables whose numbers are the same in all lanes."""


MOTIONS = "motions", "pieces", "spans"
"""Tables of driven coordinates, which are the same too."""


def _tables_of(route: Evaluated) -> Tables | PlanarTables:
    """Return the tables by which the rates of a scene are evaluated."""
    return getattr(route, "planar", route.tables)


def _parts_of(route: Evaluated) -> _Parts:
    tables = _tables_of(route)
    return _Parts(tables.geometry, tables.gravity, tables.points, tables.laws)


def numbers_of(route: Evaluated) -> np.ndarray:
    """Return all numbers of a scene that may be others in each lane."""
    return np.concatenate([part.ravel() for part in _parts_of(route)])


def are_alike(one: Evaluated, other: Evaluated) -> bool:
    """Return whether scenes differ in numbers alone, and are driven by the same motions."""
    first, second = _tables_of(one), _tables_of(other)
    if type(first) is not type(second) or len(one.inputs.constants) != len(other.inputs.constants):
        return False
    pairs = [(getattr(first, name), getattr(second, name)) for name in WHOLE]
    for name in MOTIONS:
        pairs.append((getattr(one.motion_tables, name), getattr(other.motion_tables, name)))
    return all(a is b or np.array_equal(a, b) for a, b in pairs)


def slots_for(route: Evaluated, state_size: int) -> Slots:
    """Return slots for lanes of scenes that are alike, with the numbers of one of them.

    Parameters
    ----------
    route : Evaluated
        Of that.
    state_size : int
        Numbers of a state of a run.
    """
    width, tables = lanes_here(), _tables_of(route)
    own, parts, at = _aligned(len(numbers_of(route)), width), [], 0
    own[:] = numbers_of(route)[:, None]
    for part in _parts_of(route):
        parts.append(own[at : at + part.size].reshape(*part.shape, width))
        at += part.size
    drives, inputs = _aligned(len(route.model.drives), 3, width), _aligned(len(route.inputs.constants), width)
    vectors, evaluate, size = _aligned(2, state_size, width), evaluate_lanes, route.memory_size
    scene: LaneTables | PlanarLanes
    if isinstance(tables, PlanarTables):
        scene, evaluate, size = PlanarLanes(tables, *parts), evaluate_planar_lanes, planar_memory_size(tables)
    else:
        scene = LaneTables(tables, route.scene.work, *parts)
    call = evaluate.bound(scene, drives, inputs, vectors, _aligned(size, width)).prepared()
    lanes, done_at = np.full(width, -1), call.signature.number_count
    made = Slots(lanes, call.for_kernels(), done_at, drives, inputs, vectors, own, own, own)
    return with_numbers(made, (), [route.inputs.constants])


def with_numbers(slots: Slots, constants: Sequence[np.ndarray], values: Sequence[np.ndarray]) -> Slots:
    """Return slots for lanes with such constants, none where they are those in the slots, and values of loads."""
    none = np.zeros((0, len(slots.held)))
    return slots._replace(constants=np.array(constants) if len(constants) else none, values=np.array(values))


def for_some(slots: Slots, lanes: np.ndarray) -> Slots:
    """Return slots for some of the lanes."""
    constants, values = (array if len(array) < 2 else array[lanes] for array in (slots.constants, slots.values))
    return slots._replace(constants=constants, values=values)


def _aligned(*shape: int) -> np.ndarray:
    """Return zeros that begin where a vector register is read fastest."""
    count = int(np.prod(shape))
    room = np.zeros(count + ALIGNMENT // 8)
    first = -room.ctypes.data % ALIGNMENT // 8
    return room[first : first + count].reshape(shape)
