"""Matrices of OptiStruct in text: ``OUTPUT,MATRIX,FULL`` writes job.full.mat, with STIFFNESS, MASS and DOFS.

A matrix begins with a line of its name, a number (0, or the subcase), the kind of numbers (1 whole, 2 real, 3 complex),
the kind of matrix (1 dense, 3 sparse), columns, rows, and the format of its numbers. Then come pieces of columns: a
line of column, first row and last row, with the numbers of these rows behind it; a line that begins with 0 ends it.
DOFS has two columns: grid point and component of each row. Layout: Altair's manual (".full.mat file", ".reduced.mat
file"), and public readers of such files.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError
from kanefe.imports.labelled import LabelledMatrix, mirrored
from kanefe.imports.text import number, read_text

STIFFNESS, MASS, FREEDOMS = "STIFFNESS", "MASS", "DOFS"
"""Names of the matrices."""

WHOLE, REAL, COMPLEX = 1, 2, 3
"""Kinds of numbers."""

_HEAD = re.compile(r"\s*([A-Z]+)((?:\s+\d+){5})(?:\s|$)")

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[EeDd][-+]?\d+)?")
"""A number; of fields without blanks between them the signs begin the next one."""


def is_optistruct(head: bytes) -> bool:
    """Return whether a file that begins with some bytes is one of matrices of OptiStruct."""
    found = _HEAD.match(head.partition(b"\n")[0].decode("latin-1"))
    return found is not None and found[1] in (STIFFNESS, MASS, FREEDOMS)


def optistruct_matrices(path: Path) -> dict[str, LabelledMatrix]:
    """Return STIFFNESS and MASS of a file, whose DOFS name the rows.

    Raises
    ------
    FileError
        If a line is not as it should be, or the file ends early.
    ModelError
        If rows have no names: those of ``.reduced.mat`` are modes of a response alone, which move no node.
    """
    found: dict[str, sp.csr_matrix] = {}
    lines = _Lines(path)
    for line in lines:
        if not line.strip():
            continue
        head = _HEAD.match(line)
        if head is None:
            raise lines.refused("where a matrix should begin")
        _, kind, _, columns, rows = (int(text) for text in head[2].split())
        if kind == COMPLEX:
            raise lines.refused(f"where the matrix {head[1]} is complex: export it without structural damping")
        found[head[1]] = _matrix(lines, head[1], (rows, columns))
    if FREEDOMS not in found:
        raise ModelError(
            f"{path} names no rows (DOFS): those of .reduced.mat are modes of a response and move no node. Remedy: "
            "OUTPUT,MATRIX,FULL,SPARSE; or a superelement by PARAM,EXTOUT,DMIGPCH"
        )
    freedoms = found.pop(FREEDOMS).toarray().round().astype(np.int64)
    freedoms = freedoms if freedoms.shape[1] == 2 else freedoms.T
    for name, matrix in found.items():
        if matrix.shape != (len(freedoms), len(freedoms)) or freedoms.shape[1] != 2:
            raise FileError(f"{path}: {name} has shape {matrix.shape}, DOFS {freedoms.shape}. Remedy: export it again")
    return {name: LabelledMatrix(freedoms, mirrored(matrix)) for name, matrix in found.items()}


class _Lines:
    """Lines of a file, and the number of the last one."""

    def __init__(self, path: Path) -> None:
        self.path, self.at = path, 0
        self._lines = read_text(path, "matrices").splitlines()

    def __iter__(self) -> Iterator[str]:
        while self.at < len(self._lines):
            yield self.next()

    def next(self) -> str:
        """Return the next line."""
        if self.at >= len(self._lines):
            raise FileError(f"{self.path} ends within a matrix (line {self.at}). Remedy: export it again")
        self.at += 1
        return self._lines[self.at - 1]

    def refused(self, reason: str) -> FileError:
        """Return the error of the last line."""
        text = self._lines[self.at - 1].strip()[:40]
        return FileError(f"{self.path} has {text!r} (line {self.at}) {reason}. Remedy: export it again")


def _matrix(lines: _Lines, name: str, shape: tuple[int, int]) -> sp.csr_matrix:
    """Return a matrix of pieces of columns."""
    rows: list[np.ndarray] = []
    columns: list[np.ndarray] = []
    values: list[float] = []
    while True:
        fields = lines.next().split()
        if fields[:1] == ["0"]:
            break
        if len(fields) != 3 or not all(text.isdigit() for text in fields):
            raise lines.refused(f"where {name} should have a column, its first and its last row")
        column, first, last = (int(text) for text in fields)
        if not (1 <= first <= last <= shape[0] and column <= shape[1]):
            raise lines.refused(f"which is no place in {name} of {shape[0]} rows and {shape[1]} columns")
        end = len(values) + last - first + 1
        while len(values) < end:
            values += [number(text) for text in _NUMBER.findall(lines.next())]
        if len(values) > end:
            raise lines.refused(f"with {len(values) - end} numbers more than rows {first} to {last} of {name}")
        rows.append(np.arange(first - 1, last))
        columns.append(np.full(last - first + 1, column - 1))
    if not rows:
        raise lines.refused(f"where {name} has no entries")
    return sp.csr_matrix((values, (np.concatenate(rows), np.concatenate(columns))), shape)
