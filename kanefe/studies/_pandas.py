"""The door to pandas: columns of a study as a DataFrame."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from typing import Any

from kanefe.errors import MissingDependency

try:
    import pandas
except ImportError as _error:
    raise MissingDependency("pandas", "StudyTable.frame", "pip install 'kanefe[study]'") from _error


def frame_of(columns: Mapping[str, list[Any]]) -> Any:
    """Return columns as a DataFrame, with the numbers of the cases as index."""
    return pandas.DataFrame(dict(columns)).set_index("case")


def parquet_of(columns: Mapping[str, list[Any]]) -> bytes:
    """Return the bytes of a Parquet file.

    Raises
    ------
    MissingDependency
        If neither pyarrow nor fastparquet is installed.
    """
    buffer = BytesIO()
    try:
        frame_of(columns).to_parquet(buffer)
    except ImportError as error:
        raise MissingDependency("pyarrow", "StudyTable.save", "pip install pyarrow") from error
    return buffer.getvalue()
