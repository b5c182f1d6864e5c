"""Columns of a study as arrays over its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def over_parameters(columns: Mapping[str, Sequence[Any]], parameters: Sequence[str], about: Mapping[str, str]) -> Any:
    """Return a data set over the parameters if each combination occurs at most once, else over the cases."""
    from kanefe.storage._xarray import data_set_of

    values = {name: list(dict.fromkeys(columns[name])) for name in parameters}
    cells = list(zip(*(columns[name] for name in parameters), strict=True))
    rest = {name: column for name, column in columns.items() if name not in parameters and _is_number(column)}
    rest["status"] = columns["status"]
    size = int(np.prod([len(found) for found in values.values()]))
    if len(set(cells)) < len(cells) or size > 2 * len(cells):
        coordinates = {name: ("case", np.array(columns[name])) for name in parameters}
        listed = {name: ("case", np.array(column)) for name, column in rest.items() if name != "case"}
        return data_set_of(listed, coordinates | {"case": list(columns["case"])}, about)
    places = tuple(np.array([[found.index(v) for v in columns[name]] for name, found in values.items()], dtype=int))
    arrays: dict[str, Any] = {}
    for name, column in rest.items():
        is_text = name == "status"
        array = np.full([len(found) for found in values.values()], "not run" if is_text else np.nan, dtype=object)
        array[places] = column
        arrays[name] = (tuple(parameters), array.astype(str if is_text else float))
    return data_set_of(arrays, values, about)


def _is_number(column: Sequence[Any]) -> bool:
    return all(value is None or isinstance(value, (bool, int, float)) for value in column)
