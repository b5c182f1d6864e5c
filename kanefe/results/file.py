"""The file of a result: its arrays with names and units."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus, summary
from kanefe.results.body_shape import BodyShape
from kanefe.results.load_lines import LoadLine
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
from kanefe.results.recorded import Recorded
from kanefe.results.surface_outline import SurfaceOutline
from kanefe.storage.files import ready_path, write_whole
from kanefe.storage.hdf5 import decode, encode, safe_name
from kanefe.storage.watched import long_work
from kanefe.tree.neighbours import Neighbours

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine

FORMAT = "kanefe result"
VERSION = 13
"""Version of the file. Version 7 lacked the lines of loads and surfaces, version 8 the points of contacts, version 9
records, version 10 bodies that bend far."""
SUFFIXES = ("", ".h5", ".hdf5", ".hdf", ".he5")

LARGEST_BASIS = 2**29
"""Size of the dense basis of an unreduced body above which its result is not written, bytes."""

LOGGED = {"times": "s", "reads": "by column", "drives": "by column"}
"""Arrays of the log of a controller, with units."""

PARTED = "coupling_force"
"""Name of the quantity that has parts: see `Reader.neighbours`."""

PARTS = {
    "statistics": dict,
    "status": dict,
    "events": dict,
    "controllers": dict,
    "bodies": list,
    "loops": list,
    "gears": dict,
    "loads": dict,
    "points": dict,
    "surfaces": list,
    "lines": list,
    "records": list,
}
"""JSON attributes of a file, with the type of each."""

_SKIPPED_WITHOUT_FORCES = (*FORCES, *POINTS, "acceleration", "angular_acceleration")


def save_result(result: Reader, path: str | Path, *, forces: bool = True) -> None:
    """Write a result to `path`; if that fails, the file is as it was before.

    Raises
    ------
    FileError
        If the file cannot be written or the disk is full.
    ModelError
        If its suffix is that of another format.
    MissingDependency
        If h5py is not installed.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise ModelError(f"save writes HDF5, and {Path(path).name!r} ends otherwise. Remedy: a name that ends in .h5")
    path = ready_path(path)
    shapes = [result.body(name) for name in result.bodies]
    header = {
        "format": FORMAT,
        "version": VERSION,
        "units": "SI: m, kg, s, N, rad; each dataset names its own",
        "status": asdict(result.status),
        "events": {name: times.tolist() for name, times in result.events.items()},
        "bodies": [_described(shape) for shape in shapes],
        "loops": list(result.loops),
        "gears": {name: list(columns) for name, columns in result.gears.items()},
        "loads": {name: list(columns) for name, columns in result.loads.items()},
        "points": result.point_counts,
        "surfaces": [
            {"name": s.name, "body": s.body, "interface": s.interface, "is_endless": s.is_endless}
            for s in result.surfaces
        ],
    }
    lines = result.load_lines()
    header["lines"] = [line.name for line in lines]
    header["controllers"] = {
        name: {"read_names": log.read_names, "drive_names": log.drive_names} for name, log in result.controllers.items()
    }
    records = [column for column in result.records.values() if column.path is None]
    header["records"] = [
        {"name": column.name, "unit": column.unit, "is_extremes": column.is_extremes} for column in records
    ]
    arrays: dict[str, tuple[np.ndarray, str]] = {"times": (result.times, "s")}
    for i, column in enumerate(records):
        arrays |= {f"records/{i}/times": (column.times, "s"), f"records/{i}/values": (column.values, column.unit)}
    for name, log in result.controllers.items():
        for part, unit in LOGGED.items():
            arrays[f"controllers/{safe_name(name)}/{part}"] = (getattr(log, part), unit)
    for shape in shapes:
        arrays |= _shape_arrays(shape)
    for i, surface in enumerate(result.surfaces):
        arrays[f"surfaces/{i}/vertices"] = (surface.vertices, "m")
        arrays[f"surfaces/{i}/triangles"] = (surface.triangles, "1")
        arrays[f"surfaces/{i}/lines"] = (surface.lines, "1")
    for i, line in enumerate(lines):
        arrays[f"lines/{i}/points"] = (line.points, "m")
        arrays[f"lines/{i}/states"] = (line.states, "1")
    keys = _saved(shapes, result, forces and result.has_forces)
    # without forces their errors, which are told beside them, are not asked for
    read = result.read if forces else partial(QuantityReader.read, result)
    for quantity, body, interface in long_work(f"reading the channels for {path.name}", keys):
        unit = result.units(quantity, body) if body else result.units(quantity)
        arrays[_location(quantity, body, interface)] = (read(quantity, body, interface or None), unit)
        if quantity == PARTED:
            for part in _stored_parts(result.neighbours(body, interface)):
                where = _location(quantity, body, interface, part)
                arrays[where] = (result.read(quantity, body, interface, part), unit)
    header["statistics"] = dict(result.statistics)  # with the error of forces, which were read just now
    data = encode(header, arrays)
    write_whole(path, lambda file: file.write(data))


def read_channels(path: str | Path) -> FileChannels:
    """Read the channels of a result that `save_result` wrote.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or of another format or version.
    MissingDependency
        If h5py is not installed.
    """
    path = Path(path)
    header, arrays = decode(path)
    if header.get("format") != FORMAT:
        raise FileError(f"{path} is not a saved result. Remedy: give the file that Result.save wrote")
    if header.get("version") != VERSION:
        raise FileError(
            f"{path} has format version {header.get('version')}, this kanefe reads version {VERSION}. "
            "Remedy: run the scene again with this version"
        )
    try:
        return FileChannels(path, header, arrays)
    except (KeyError, ValueError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise FileError(f"{path} lacks parts of a result ({error!r}). Remedy: save the result again") from error


class FileChannels:
    """Channels of a saved run.

    Parameters
    ----------
    path : Path
        For messages.
    header : dict
        Attributes of the file.
    arrays : dict
        Its arrays by path.
    """

    def __init__(self, path: Path, header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        self.path = path
        self.times = arrays["times"]
        parts = {name: json.loads(text) for name, text in header.items() if name in PARTS}
        for name, kind in PARTS.items():
            if not isinstance(parts[name], kind):
                raise ValueError(f"{name} is no {kind.__name__}")
        self.statistics: dict[str, Any] = parts["statistics"]
        self.status = RunStatus(**parts["status"])
        self.events: Mapping[str, np.ndarray] = {name: np.array(times) for name, times in parts["events"].items()}
        summary(self.status, self.statistics, self.events)  # raises where parts are missing
        self.controllers: Mapping[str, ControllerLog] = {
            name: ControllerLog(
                **{part: arrays[f"controllers/{safe_name(name)}/{part}"] for part in LOGGED},
                read_names=tuple(names["read_names"]),
                drive_names=tuple(names["drive_names"]),
            )
            for name, names in parts["controllers"].items()
        }
        self.bodies = tuple(_shape(entry, arrays) for entry in parts["bodies"])
        self.loops = tuple(parts["loops"])
        self.gears: Mapping[str, tuple[str, ...]] = {name: tuple(columns) for name, columns in parts["gears"].items()}
        self.loads: Mapping[str, tuple[str, ...]] = {name: tuple(columns) for name, columns in parts["loads"].items()}
        self.points: Mapping[str, int] = {name: int(count) for name, count in parts["points"].items()}
        self.surfaces = tuple(
            SurfaceOutline(
                **entry,
                vertices=arrays[f"surfaces/{i}/vertices"],
                triangles=arrays[f"surfaces/{i}/triangles"],
                lines=arrays[f"surfaces/{i}/lines"],
            )
            for i, entry in enumerate(parts["surfaces"])
        )
        self._lines = tuple(
            LoadLine(str(name), arrays[f"lines/{i}/points"], arrays[f"lines/{i}/states"])
            for i, name in enumerate(parts["lines"])
        )
        self.records: Mapping[str, Recorded] = {
            entry["name"]: Recorded.in_memory(
                **entry, times=arrays[f"records/{i}/times"], values=arrays[f"records/{i}/values"]
            )
            for i, entry in enumerate(parts["records"])
        }
        self.has_forces = any(where.rpartition("/")[2] in FORCES for where in arrays)
        self._arrays = arrays
        self._check_arrays()

    def load_lines(self, rows: np.ndarray) -> tuple[LoadLine, ...]:
        """Return the lines of loads that act along one, at output times given by number."""
        return tuple(line.at(rows) for line in self._lines)

    def _check_arrays(self) -> None:
        """Raise a ValueError unless the times ascend and each channel has a row for each of them."""
        if self.times.ndim != 1 or self.times.dtype != float or not np.all(np.isfinite(self.times)):
            raise ValueError(f"times are not finite numbers in a row, but {self.times.dtype} {self.times.shape}")
        if not len(self.times) or np.any(np.diff(self.times) < 0.0):
            raise ValueError("times do not rise")
        for line in self._lines:
            count = len(self.times)
            if line.points.shape[:1] != (count,) or line.points.shape[2:] != (3,) or line.states.shape != (count,):
                raise ValueError(f"the line of {line.name!r} has not a row for each of {count} times")
        reader = Reader(self)
        for quantity, body, interface in _saved(list(self.bodies), reader, True):
            where = _location(quantity, body, interface)
            if where not in self._arrays and quantity in _SKIPPED_WITHOUT_FORCES:
                continue
            width = sum(len(columns) or 1 for _, _, columns in reader.parts(quantity, body))
            self._check_array(where, width)
            if quantity == PARTED:
                for part in _stored_parts(reader.neighbours(body, interface)):
                    self._check_array(_location(quantity, body, interface, part), width)

    def _check_array(self, where: str, width: int) -> None:
        array = self._arrays[where]
        if array.ndim and len(array) != len(self.times):
            raise ValueError(f"{where} has {len(array)} rows for {len(self.times)} times")
        if (
            array.dtype != float
            or array.shape not in {array.shape[:1], (*array.shape[:1], width)}
            or (array.ndim != 2 and width != 1)
        ):
            raise ValueError(f"{where} is {array.dtype} {array.shape}, and should have {width} numbers a time")

    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
        """Return a channel, or a part of a coupling force, time first.

        Raises
        ------
        ModelError
            If it was not saved.
        """
        whole = self._array(quantity, body, interface)
        if not of:
            return whole
        neighbours = next(shape for shape in self.bodies if shape.name == body).neighbours[interface]
        parts = neighbours.parts(of, f"{interface!r} of {body!r}")
        if not _stored_parts(neighbours):
            return whole if parts else np.zeros_like(whole)
        return sum((self._array(quantity, body, interface, part) for part in parts), np.zeros_like(whole))

    def _array(self, quantity: str, body: str, interface: str, part: str = "") -> np.ndarray:
        where = _location(quantity, body, interface, part)
        if where not in self._arrays:
            of = f" of {body!r}" + (f" at {interface!r}" if interface else "") if body else ""
            raise ModelError(
                f"{quantity}{of} was not saved in {self.path}. Remedy: run the scene again and save with forces=True"
            )
        return self._arrays[where]


def _stored_parts(neighbours: Neighbours) -> tuple[str, ...]:
    """Return the parts of a coupling force that a file holds besides the total: none if there is only one."""
    parts = neighbours.unknown + neighbours.known
    return parts if len(parts) > 1 else ()


def _saved(shapes: list[BodyShape], result: Reader, forces: bool) -> list[tuple[str, str, str]]:
    """Return quantity, body and interface of every channel that a file holds."""
    keys = [(quantity, "", "") for quantity in (*OF_SCENE, *CENTRES)]
    keys += [(quantity, name, "") for name in result.loops for quantity in LOOPS]
    keys += [(quantity, name, "") for name in result.gears for quantity in GEARS]
    keys += [(quantity, name, "") for name in result.loads for quantity in LOADS]
    keys += [(quantity, name, "") for name in result.contacts for quantity in POINTS]
    for shape in shapes:
        own = [*MOTIONS, *CENTRES, *JOINTS, *(DRIVES if shape.is_driven else ()), *(MODES if shape.is_flexible else ())]
        keys += [(quantity, shape.name, "") for quantity in own]
        keys += [(quantity, shape.name, n) for n in shape.interfaces for quantity in (*MOTIONS, *INTERFACES)]
    return [key for key in keys if forces or key[0] not in _SKIPPED_WITHOUT_FORCES]


def _location(quantity: str, body: str, interface: str = "", part: str = "") -> str:
    """Return the path of a channel in the file, which can contain any name of a mesh group."""
    if part:
        return f"{_folder(body)}/interfaces/{safe_name(interface)}/parts of {quantity}/{safe_name(part)}"
    if not body:
        return f"scene/{quantity}"
    for of, folder in ((LOOPS, "loops"), (GEARS, "gears"), (LOADS | POINTS, "loads")):
        if quantity in of:
            return f"{folder}/{safe_name(body)}/{quantity}"
    return f"{_folder(body)}/" + (f"interfaces/{safe_name(interface)}/{quantity}" if interface else quantity)


def _folder(body: str) -> str:
    return f"bodies/{safe_name(body)}"


def _described(shape: BodyShape) -> dict[str, Any]:
    return {
        "name": shape.name,
        "parent": shape.parent,
        "parent_interface": shape.parent_interface,
        "joint": shape.joint,
        "driven_names": shape.driven_names,
        "coordinate_names": shape.coordinate_names,
        "speed_names": shape.speed_names,
        "mass": shape.mass,
        "interfaces": shape.interfaces,
        "neighbours": {name: found._asdict() for name, found in shape.neighbours.items()},
        "components": shape.components,
        "cells": [block.kind for block in shape.cells],
        "is_orthonormal": shape.is_orthonormal,
        "provenance": dict(shape.provenance),
    }


def _dense_basis(shape: BodyShape) -> np.ndarray:
    basis: Any = shape.basis
    if not sp.issparse(basis):
        return np.asarray(basis)
    size = 8 * basis.shape[0] * basis.shape[1]
    if size > LARGEST_BASIS:
        raise ModelError(
            f"the unreduced body {shape.name!r} would take {size / 2**30:.1f} GiB in the file. Remedy: keep what is "
            "wanted as arrays, such as result.nodal_displacements, or reduction=CraigBampton(modes=20)"
        )
    return np.asarray(basis.toarray())


def _shape_arrays(shape: BodyShape) -> dict[str, tuple[np.ndarray, str]]:
    folder = _folder(shape.name)
    arrays = {f"{folder}/mass/com": (shape.com, "m"), f"{folder}/mass/inertia": (shape.inertia, "kg m2")}
    if shape.is_flexible:
        arrays[f"{folder}/mesh/nodes"] = (shape.nodes, "m")
        arrays[f"{folder}/mesh/basis"] = (_dense_basis(shape), "m or rad by modal coordinate")
        for i, block in enumerate(shape.cells):
            arrays[f"{folder}/mesh/cells_{i}"] = (block.nodes, "1")
        if shape.elasticity is not None:
            arrays |= {
                f"{folder}/elasticity/{f.name}": (value, "Pa of solids; N, N m2 of beams" if f.name == "table" else "1")
                for f in fields(shape.elasticity)
                if (value := getattr(shape.elasticity, f.name)) is not None
            }
        if shape.line is not None:
            arrays |= {f"{folder}/line/{f.name}": (getattr(shape.line, f.name), "SI") for f in fields(shape.line)}
    return arrays


def _shape(entry: dict[str, Any], arrays: dict[str, np.ndarray]) -> BodyShape:
    folder = _folder(entry["name"])
    return BodyShape(
        name=entry["name"],
        parent=entry["parent"],
        parent_interface=entry["parent_interface"],
        joint=entry["joint"],
        driven_names=tuple(entry["driven_names"]),
        coordinate_names=tuple(entry["coordinate_names"]),
        speed_names=tuple(entry["speed_names"]),
        mass=entry["mass"],
        com=arrays[f"{folder}/mass/com"],
        inertia=arrays[f"{folder}/mass/inertia"],
        interfaces=tuple(entry["interfaces"]),
        components=tuple(entry["components"]),
        nodes=arrays.get(f"{folder}/mesh/nodes", np.zeros((0, 3))),
        basis=arrays.get(f"{folder}/mesh/basis", np.zeros((0, 0))),
        cells=tuple(Cells(kind, arrays[f"{folder}/mesh/cells_{i}"]) for i, kind in enumerate(entry["cells"])),
        is_orthonormal=entry["is_orthonormal"],
        provenance=entry["provenance"],
        neighbours={
            name: Neighbours(tuple(found["unknown"]), tuple(found["known"]))
            for name, found in entry["neighbours"].items()
        },
        elasticity=_elasticity(f"{folder}/elasticity", arrays),
        line=_line(f"{folder}/line/", arrays),
    )


def _line(folder: str, arrays: dict[str, np.ndarray]) -> BeamLine | None:
    found = {where.removeprefix(folder): array for where, array in arrays.items() if where.startswith(folder)}
    if not found:
        return None
    from kanefe.bodies.exact.beam_line import BeamLine

    return BeamLine(**found)


def _elasticity(folder: str, arrays: dict[str, np.ndarray]) -> Elasticity | None:
    found = {f.name: arrays[f"{folder}/{f.name}"] for f in fields(Elasticity) if f"{folder}/{f.name}" in arrays}
    return Elasticity(**found) if found else None
