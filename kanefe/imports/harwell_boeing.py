"""Real, assembled matrices in Harwell-Boeing files, also symmetric ones, which scipy's reader refuses.

A file is five header lines and then column pointers, row numbers and values in Fortran formats of fixed width, so that
numbers may touch (Duff, Grimes & Lewis 1992, "Users' guide for the Harwell-Boeing sparse matrix collection").
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError
from kanefe.imports.labelled import mirrored
from kanefe.imports.text import read_text

_FORMAT = re.compile(r"(?:\d+P,?)?(\d*)[IEDFG](\d+)", re.IGNORECASE)


def read_harwell_boeing(path: str | Path, what: str) -> sp.csr_matrix:
    """Return the full matrix of a file.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, complex, unassembled or not of this format.
    """
    lines = read_text(path, what).splitlines()
    try:
        counts = [int(lines[1][14 * i : 14 * i + 14] or 0) for i in range(5)]
        kind = lines[2][:3].upper()
        size, columns, entries = (int(lines[2][14 * i : 14 * i + 14]) for i in (1, 2, 3))
        formats = [_width(lines[3][a:b]) for a, b in ((0, 16), (16, 32), (32, 52))]
    except (IndexError, ValueError) as error:
        raise FileError(
            f"{path} is not a Harwell-Boeing file of the {what} ({error}). Remedy: HBMAT with Form=ASCII"
        ) from error
    if kind[0] != "R" or kind[2] != "A" or kind[1] not in "SU" or size != columns:
        raise FileError(
            f"{path} is of type {kind} with {size} rows and {columns} columns, where a real, square and assembled "
            f"{what} is needed (RSA or RUA). Remedy: export it without complex damping"
        )
    start = 5 if len(counts) > 4 and counts[4] > 0 else 4  # the fifth line describes right-hand sides, if any
    ends = np.cumsum([start, *counts[1:4]])
    blocks = [lines[a:b] for a, b in pairwise(ends)]
    pointers, rows, values = (
        _fields(block, width, length, path)
        for block, width, length in zip(blocks, formats, (columns + 1, entries, entries), strict=True)
    )
    indices, starts = rows.astype(np.int64) - 1, pointers.astype(np.int64) - 1
    if starts[0] != 0 or starts[-1] != entries or np.any(np.diff(starts) < 0) or not _within(indices, size):
        raise FileError(f"the column pointers of {path} contradict its {entries} entries. Remedy: export it again")
    matrix = sp.csc_matrix((values, indices, starts), (size, size))
    return mirrored(matrix) if kind[1] == "S" else matrix.tocsr()


def _within(indices: np.ndarray, size: int) -> bool:
    return not len(indices) or bool(indices.min() >= 0 and indices.max() < size)


def _width(text: str) -> int:
    """Return the width of a number in a Fortran format such as (4D20.12)."""
    found = _FORMAT.search(text)
    if found is None:
        raise ValueError(f"format {text.strip()!r}")
    return int(found[2])


def _fields(lines: list[str], width: int, length: int, path: str | Path) -> np.ndarray:
    """Return the numbers of fixed width in some lines."""
    parts = [line[i : i + width] for line in lines for i in range(0, len(line.rstrip()), width)]
    try:
        values = np.array([float(part.replace("D", "E").replace("d", "e").replace(",", ".")) for part in parts])
    except ValueError as error:
        raise FileError(f"{path} holds a damaged number ({error}). Remedy: export it again") from error
    if len(values) < length:
        raise FileError(f"{path} is truncated: {len(values)} of {length} numbers. Remedy: export it again")
    return values[:length]
