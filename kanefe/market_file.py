"""One sparse matrix in one Matrix Market file."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError

# newer ones return sparse arrays unless they are told not to
_OPTIONS = {"spmatrix": True} if "spmatrix" in inspect.signature(scipy.io.mmread).parameters else {}


def read_market(path: str | Path, what: str) -> sp.csr_matrix:
    """Return the matrix of one file.

    Raises
    ------
    FileError
        If the file is not there, truncated, complex or no Matrix Market file.
    """
    if not Path(path).is_file():
        raise FileError(f"there is no file {path} for the {what}. Remedy: check the path")
    try:
        matrix = scipy.io.mmread(str(path), **_OPTIONS)
    except (OSError, ValueError, EOFError, IndexError) as error:
        raise FileError(
            f"cannot read the {what} from {path}: it is truncated or no Matrix Market file ({error}). "
            "Remedy: export it again"
        ) from error
    if np.iscomplexobj(matrix.data):
        raise ModelError(f"the {what} in {path} is complex. Remedy: export it without structural damping")
    return sp.csr_matrix(matrix, dtype=float)
