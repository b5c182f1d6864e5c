"""The door to pandas: columns as a DataFrame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import Any

from kanefe.errors import MissingDependency

try:
    import pandas
except ImportError as _error:
    raise MissingDependency("pandas", "a table as a DataFrame", "pip install 'kanefe[study]'") from _error


def frame_of(columns: Mapping[str, Sequence[Any]], index: str, units: Mapping[str, str] | None = None) -> Any:
    """Return columns as a DataFrame with one of them as index; units are its attribute ``attrs["units"]``."""
    frame = pandas.DataFrame(dict(columns)).set_index(index)
    if units is not None:
        frame.attrs["units"] = dict(units)
    return frame


def parquet_of(columns: Mapping[str, Sequence[Any]], index: str) -> bytes:
    """Return the bytes of a Parquet file.

    Raises
    ------
    MissingDependency
        If neither pyarrow nor fastparquet is installed.
    """
    buffer = BytesIO()
    try:
        frame_of(columns, index).to_parquet(buffer)
    except ImportError as error:
        raise MissingDependency("pyarrow", "StudyTable.save", "pip install pyarrow") from error
    return buffer.getvalue()
