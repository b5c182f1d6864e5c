"""The door to h5py: named arrays with units to HDF5 and back."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import FileError, MissingDependency

SMALLEST_COMPRESSED = 1024
"""Numbers in an array below which compression costs more than it saves."""

MOST_COMPRESSED = 1100
"""Times that an array can be larger than its bytes in the file: deflate makes at most 1032 of one."""


def come_first() -> None:
    """Load h5py, if it is there, ahead of a library that shows an HDF5 of its own to all that is loaded after it."""
    with contextlib.suppress(MissingDependency, FileError):
        _h5py("kanefe.storage")


def encode(header: Mapping[str, Any], arrays: Mapping[str, tuple[np.ndarray, str]]) -> memoryview:
    """Return the bytes of an HDF5 file.

    It is made in memory, because HDF5 itself cannot be trusted to survive a full disk.

    Parameters
    ----------
    header : mapping
        Attributes of the file: texts and numbers as they are, anything else as json.
    arrays : mapping of str to (array, unit)
        By path in the file.

    Raises
    ------
    MissingDependency
        If h5py is not installed.
    """
    h5py = _h5py("Result.save")
    buffer = io.BytesIO()
    # "v110" keeps attributes above 64 KiB, such as a long provenance, which older layouts refuse
    with h5py.File(buffer, "w", libver=("v110", "v110")) as file:
        for name, value in header.items():
            file.attrs[name] = value if isinstance(value, (str, int)) else json.dumps(value, default=_plain)
        for path, (array, unit) in arrays.items():
            packed = {"compression": "gzip", "shuffle": True} if array.size >= SMALLEST_COMPRESSED else {}
            file.create_dataset(path, data=array, **packed).attrs["unit"] = unit
    return buffer.getbuffer()


def decode(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return attributes and arrays of an HDF5 file.

    Raises
    ------
    FileError
        If the file is not there, or is truncated or no HDF5 file.
    MissingDependency
        If h5py is not installed.
    """
    h5py = _h5py("kanefe.load_result")
    if path.is_dir():
        raise FileError(f"{path} is a folder. Remedy: the file in it that Result.save wrote")
    if not path.is_file():
        raise FileError(f"there is no file {path}. Remedy: check the path")
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            if item.nbytes > MOST_COMPRESSED * (item.id.get_storage_size() + SMALLEST_COMPRESSED):
                raise ValueError(f"{name} claims {item.nbytes:.3g} bytes, which the file does not hold")
            arrays[name] = np.asarray(item[()])
            arrays[name].flags.writeable = False

    try:
        with h5py.File(path, "r") as file:
            header = dict(file.attrs)
            file.visititems(collect)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise FileError(f"{path} is truncated or is no HDF5 file ({error}). Remedy: save the result again") from error
    return header, arrays


def _h5py(needed_by: str) -> Any:
    try:
        import h5py
    except ImportError as error:
        raise MissingDependency("h5py", needed_by, "pip install h5py") from error
    except ValueError as error:
        raise FileError(
            f"{needed_by}: h5py does not start beside the HDF5 of another library of this program ({error}). "
            "Remedy: import h5py at its head, before dolfinx and petsc4py"
        ) from error
    return h5py


def _plain(value: Any) -> Any:
    """Return what json can write of numpy's numbers and arrays; anything else by its text."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    return str(value)
