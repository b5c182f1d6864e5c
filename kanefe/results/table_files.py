"""Files of channels: comma-separated text, and MATLAB's MAT files."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.results.tables import Channel
from kanefe.storage.files import ready_path, write_whole

LONGEST_NAME = 63
"""Largest number of characters of a name in MATLAB."""


_OF_MATLAB = (
    "break case catch classdef continue else elseif end for function global if otherwise parfor persistent return spmd "
    "switch try while"
)
_OF_OCTAVE_ALONE = (
    "do until end_try_catch end_unwind_protect endarguments endclassdef endenumeration endevents endfor endfunction "
    "endif endmethods endparfor endproperties endspmd endswitch endwhile unwind_protect unwind_protect_cleanup"
)
KEYWORDS = frozenset(f"{_OF_MATLAB} {_OF_OCTAVE_ALONE}".split())
"""Words that MATLAB or GNU Octave load as names of variables and cannot use."""


def write_csv(times: np.ndarray, channels: Sequence[Channel], path: str | Path) -> Path:
    """Write times and channels as text, a line for each time; numbers have all digits."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [f"{name} [{unit}]" for channel in channels for name, unit, _ in channel.each()]
    writer.writerow(["time [s]", *names])
    writer.writerows(np.column_stack([times, *(channel.values for channel in channels)]).tolist())
    return _written(path, ".csv", text.getvalue().encode())


def write_matlab(times: np.ndarray, channels: Sequence[Channel], path: str | Path) -> Path:
    """Write times and channels as the variables of a MAT file, with their columns and units."""
    from scipy.io import savemat

    variables: dict[str, Any] = {"time": times[:, None]}
    columns: dict[str, Any] = {}
    units: dict[str, Any] = {"time": "s"}
    for channel in channels:
        name = _identifier(channel.name, variables)
        variables[name] = channel.values
        columns[name] = np.array(channel.columns, dtype=object)
        units[name] = np.array(channel.units, dtype=object)
    buffer = BytesIO()
    savemat(buffer, variables | {"columns": columns, "units": units}, long_field_names=True, do_compression=True)
    return _written(path, ".mat", buffer.getvalue())


def _identifier(name: str, taken: Mapping[str, Any]) -> str:
    """Return a name of MATLAB: letters, digits and underscores, beginning with a letter, and no keyword."""
    found = re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_")
    is_name = found[:1].isalpha() and len(found) <= LONGEST_NAME and found not in KEYWORDS
    if not is_name or found in (*taken, "columns", "units"):
        raise ModelError(
            f"the channel {name!r} would be {found!r} in MATLAB, which is taken, too long, a keyword or no name there. "
            "Remedy: a mapping with a name of your own, {'tip': 'position arm/tip'}"
        )
    return found


def _written(path: str | Path, suffix: str, data: bytes) -> Path:
    target = ready_path(path)
    if target.suffix.lower() != suffix:
        raise ModelError(f"cannot write a {suffix} file to {path}. Remedy: a path that ends in {suffix}")
    write_whole(target, lambda file: file.write(data))
    return target
