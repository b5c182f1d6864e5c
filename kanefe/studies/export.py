"""Files of a table: comma-separated text, HDF5, Parquet."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.storage.files import ready_path, write_whole

KINDS = (".csv", ".h5", ".parquet")


def save_table(columns: dict[str, list[Any]], header: dict[str, Any], path: str | Path) -> Path:
    """Write columns, in HDF5 also the header of the study, as `StudyTable.save` describes."""
    kind = Path(path).suffix.lower()
    if kind not in KINDS:
        raise ModelError(f"cannot write a table to {path}. Remedy: one of the suffixes {', '.join(KINDS)}")
    if kind == ".csv":
        data = _csv(columns)
    elif kind == ".h5":
        data = _hdf5(columns, header)
    else:
        from kanefe.storage._pandas import parquet_of

        data = parquet_of(columns, "case")
    target = ready_path(path)
    write_whole(target, lambda file: file.write(data))
    return target


def _csv(columns: dict[str, list[Any]]) -> bytes:
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def _hdf5(columns: dict[str, list[Any]], header: dict[str, Any]) -> bytes:
    from kanefe.storage.hdf5 import encode, safe_name

    return bytes(encode(header, {safe_name(name): (_writable(values), "") for name, values in columns.items()}))


def _writable(values: list[Any]) -> np.ndarray:
    """Return numbers as an array with NaN for gaps, arrays of one shape as one array, and anything else as text.

    Truth values are 0 and 1: HDF5 has none, and GNU Octave leaves out the enumeration that h5py writes for them.
    """
    if all(isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.int8)
    if all(value is None or isinstance(value, (bool, int, float)) for value in values):
        return np.array([np.nan if value is None else value for value in values])
    if all(isinstance(value, (list, tuple)) for value in values):
        try:
            return np.array(values, dtype=float)
        except (TypeError, ValueError):  # of different lengths
            pass
    return np.array([str(value).encode() for value in values])
