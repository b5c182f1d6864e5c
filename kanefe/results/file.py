"""The file of a result: its arrays with names and units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from kanefe.errors import FileError, ModelError
from kanefe.results.channel_tables import FOLDER, Tables, tables_of
from kanefe.results.file_channels import FileChannels
from kanefe.results.reader import Reader
from kanefe.results.saved_shapes import arrays_of_shapes, described
from kanefe.storage.files import ready_path, write_whole
from kanefe.storage.hdf5 import Arrays, decode, encode

FORMAT = "kanefe result"
VERSION = 14
"""Version of the file. Up to version 13 each channel had an array of its own."""
SUFFIXES = ("", ".h5", ".hdf5", ".hdf", ".he5")


class Listed(NamedTuple):
    """Things of one kind in a file.

    Attributes
    ----------
    told : tuple of str
        Attributes of each in the header.
    units : dict of str
        Its arrays, with their units; "": that of the thing.
    """

    told: tuple[str, ...]
    units: dict[str, str]


CONTROLLERS = Listed(("read_names", "drive_names"), {"times": "s", "reads": "by column", "drives": "by column"})
SURFACES = Listed(("name", "body", "interface", "is_endless"), {"vertices": "m", "triangles": "1", "lines": "1"})
LINES = Listed(("name",), {"points": "m", "states": "1"})
RECORDS = Listed(("name", "unit", "is_extremes"), {"times": "s", "values": ""})


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
    arrays: Arrays = {"times": (result.times, "s"), **arrays_of_shapes(shapes)}
    lists = {
        "controllers": _listed("controllers", CONTROLLERS, result.controllers.values(), arrays),
        "surfaces": _listed("surfaces", SURFACES, result.surfaces, arrays),
        "lines": _listed("lines", LINES, result.load_lines(), arrays),
        "records": _listed("records", RECORDS, [one for one in result.records.values() if one.path is None], arrays),
    }
    for name, entry in zip(result.controllers, lists["controllers"], strict=True):
        entry["name"] = name
    tables = tables_of(result, forces, f"reading the channels for {path.name}")
    arrays |= _arrays_of_tables(tables)
    header = {
        "format": FORMAT,
        "version": VERSION,
        "units": "SI: m, kg, s, N, rad; each dataset names its own, 'channels' those of the columns of a table",
        "status": asdict(result.status),
        "events": {name: times.tolist() for name, times in result.events.items()},
        "bodies": [described(shape) for shape in shapes],
        "loops": list(result.loops),
        "gears": result.gears,
        "loads": result.loads,
        "points": result.point_counts,
        **lists,
        "channels": {name: [column._asdict() for column in columns] for name, (columns, _) in tables.items()},
        "statistics": dict(result.statistics),  # with the error of forces, which were read just now
    }
    data = encode(header, arrays)
    write_whole(path, lambda file: file.write(data))


def _listed(folder: str, kind: Listed, items: Iterable[Any], arrays: Arrays) -> list[dict[str, Any]]:
    """Return what the header tells of some things; add their arrays to `arrays`."""
    told = []
    for i, item in enumerate(items):
        told.append({name: getattr(item, name) for name in kind.told})
        arrays |= {
            f"{folder}/{i}/{part}": (getattr(item, part), unit or item.unit) for part, unit in kind.units.items()
        }
    return told


def _arrays_of_tables(tables: Tables) -> Arrays:
    units = {name: {column.unit for column in columns} for name, (columns, _) in tables.items()}
    return {
        FOLDER + name: (arrays, units[name].pop() if len(units[name]) == 1 else "by column")
        for name, (_, arrays) in tables.items()
    }


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
