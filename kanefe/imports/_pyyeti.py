"""Door to pyyeti: Nastran's op2 files. The only file that imports pyyeti."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import scipy.sparse as sp

from kanefe.errors import FileError, MissingDependency
from kanefe.storage.files import regular_file

_DAMAGE = (OSError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, AttributeError, RuntimeError)
"""Exceptions that pyyeti raises on a damaged file."""


def matrices(path: Path) -> dict[str, sp.csr_matrix]:
    """Return the matrices of an op2 file by upper-case name."""
    nastran = _import_pyyeti()
    regular_file(path, "for the matrices")
    try:
        found = nastran.op2.rdmats(str(path))
    except _DAMAGE as error:
        raise FileError(f"{path} is truncated or no op2 file ({error}). Remedy: export it again") from error
    return {name.upper(): sp.csr_matrix(matrix) for name, matrix in found.items()}


def _import_pyyeti() -> Any:
    try:
        from pyyeti import nastran
        from pyyeti.nastran import op2  # noqa: F401
    except ImportError as problem:  # pyyeti itself, or what it needs in turn
        missing = (problem.name or "pyyeti").partition(".")[0]
        raise MissingDependency(missing, "read_nastran of op2 files", "pip install 'kanefe[nastran]'") from problem
    return nastran
