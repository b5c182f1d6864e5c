"""Channels of a result in its file: a table of each quantity, with the columns of all that have it side by side."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from kanefe.results.body_shape import BodyShape
from kanefe.results.quantities import (
    CENTRES,
    DRIVES,
    FORCES,
    GEARS,
    INTERFACES,
    JOINTS,
    LOADS,
    LOOPS,
    MODES,
    MOTIONS,
    OF_SCENE,
    POINTS,
)
from kanefe.results.quantity_reader import QuantityReader
from kanefe.results.reader import Reader
from kanefe.storage.watched import long_work
from kanefe.tree.neighbours import Neighbours

Key = tuple[str, str, str, str]
"""Quantity, body ("" for the whole scene), interface ("" for the body's own frame), and name of a part ("" for all)."""

PARTED = "coupling_force"
"""Name of the quantity that has parts: see `Reader.neighbours`."""

FOLDER = "channels/"
"""Group of the tables in a file."""

SKIPPED_WITHOUT_FORCES = (*FORCES, *POINTS, "acceleration", "angular_acceleration")


def stored_parts(neighbours: Neighbours) -> tuple[str, ...]:
    """Return the parts of a coupling force that a file holds besides the total: none if there is only one."""
    parts = neighbours.unknown + neighbours.known
    return parts if len(parts) > 1 else ()


def saved_keys(shapes: Iterable[BodyShape], result: Reader, forces: bool) -> list[Key]:
    """Return the key of every channel that a file holds."""
    keys: list[Key] = [(quantity, "", "", "") for quantity in (*OF_SCENE, *CENTRES)]
    for names, quantities in (
        (result.loops, LOOPS),
        (result.gears, GEARS),
        (result.loads, LOADS),
        (result.contacts, POINTS),
    ):
        keys += [(quantity, name, "", "") for name in names for quantity in quantities]
    for shape in shapes:
        own = [*MOTIONS, *CENTRES, *JOINTS, *(DRIVES if shape.is_driven else ()), *(MODES if shape.is_flexible else ())]
        keys += [(quantity, shape.name, "", "") for quantity in own]
        for face in shape.interfaces:
            keys += [(quantity, shape.name, face, "") for quantity in (*MOTIONS, *INTERFACES)]
            keys += [(PARTED, shape.name, face, part) for part in stored_parts(shape.neighbours[face])]
    return [key for key in keys if forces or key[0] not in SKIPPED_WITHOUT_FORCES]


class Column(NamedTuple):
    """What a table of a quantity has of one body, interface or connection.

    Attributes
    ----------
    name, interface, part : str
        As in `Key`; the name is that of the body or connection.
    shape : list of int
        Of its numbers at one time.
    unit : str
    """

    name: str
    interface: str
    part: str
    shape: list[int]
    unit: str


Tables = dict[str, tuple[list[Column], list[np.ndarray]]]
"""Columns and their numbers, time first, by quantity."""


def tables_of(result: Reader, forces: bool, what: str) -> Tables:
    """Return the tables of a result; `what` is being done, for a bar."""
    forces = forces and result.has_forces
    # without forces their errors, which are told beside them, are not asked for
    read = result.read if forces else partial(QuantityReader.read, result)
    tables: Tables = {}
    keys = saved_keys(map(result.body, result.bodies), result, forces)
    keys.sort(key=lambda key: key[0] != "acceleration")  # with accelerations, all that frames do is known
    for quantity, name, face, part in long_work(what, keys):
        array = read(quantity, name, face or None, part or None)
        columns, arrays = tables.setdefault(quantity, ([], []))
        columns.append(Column(name, face, part, list(array.shape[1:]), result.units(quantity, name or None)))
        arrays.append(array.reshape(len(array), -1))
    return tables


def channels_of(listed: Mapping[str, Any], arrays: Mapping[str, np.ndarray], count: int) -> dict[Key, np.ndarray]:
    """Return the channels in the tables of a file; a ValueError if a table is not of `count` times and its columns."""
    channels: dict[Key, np.ndarray] = {}
    for quantity, entries in listed.items():
        columns = [Column(**entry) for entry in entries]
        ends = np.cumsum([math.prod(column.shape) for column in columns]).tolist()
        table = arrays[FOLDER + quantity]
        if table.dtype != float or table.shape != (count, ends[-1]):
            raise ValueError(
                f"{quantity} is {table.dtype} {table.shape}, and should have {ends[-1]} numbers "
                f"for each of {count} times"
            )
        for column, first, end in zip(columns, [0, *ends], ends, strict=False):
            key = (quantity, column.name, column.interface, column.part)
            channels[key] = table[:, first:end].reshape(count, *column.shape)
    return channels


def check_channels(channels: Mapping[Key, np.ndarray], reader: Reader) -> None:
    """Raise an error unless there is each channel of a result, with as many numbers as it has columns."""
    shapes = [reader.body(name) for name in reader.bodies]
    for key in saved_keys(shapes, reader, True):
        if key not in channels and key[0] in SKIPPED_WITHOUT_FORCES:
            continue
        width = sum(len(columns) or 1 for _, _, columns in reader.parts(*key[:2]))
        if channels[key].shape[1:] != (width,) and (channels[key].ndim != 1 or width != 1):
            raise ValueError(f"{' '.join(key)} is {channels[key].shape}, and should have {width} numbers a time")
