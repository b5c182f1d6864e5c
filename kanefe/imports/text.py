"""Numbers in text files of Fortran programs, and matrices in Matrix Market files."""

from __future__ import annotations

import inspect
import io
import math
import re
import warnings
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError
from kanefe.storage.files import regular_file

_BLANKS = str.maketrans({",": " "})

_EXPONENT = re.compile(r"(?<=[\d.])([-+]\d+)$")  # 1.5-3 is 1.5e-3


def read_text(path: str | Path, what: str) -> str:
    """Return the text of a file.

    Raises
    ------
    FileError
        If it does not exist, is empty, or is not text.
    """
    path = regular_file(path, f"for the {what}")
    try:
        text = path.read_text(encoding="latin-1")
    except OSError as error:
        raise FileError(f"cannot read the {what} from {path}: {error}. Remedy: check the file") from error
    if not text.strip():
        raise FileError(f"{path} with the {what} is empty. Remedy: export it again")
    if "\0" in text[:4096]:
        raise FileError(f"{path} with the {what} is binary, not text. Remedy: export it as text")
    return text


def with_points(text: str) -> str:
    """Return a text of blank-separated numbers with decimal points instead of the decimal commas of some locales.

    Texts in which commas separate numbers are returned unchanged.
    """
    rows = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("%", "!", "#"))]
    with_commas = [line for line in rows if "," in line]
    if not with_commas or "." in "".join(with_commas):
        return text
    alone = all(_DECIMAL_COMMAS.fullmatch(line.strip()) for line in with_commas)
    return _COMMA.sub(".", text) if alone else text


_NUMBER = r"[-+]?\d+(?:,\d*)?(?:[eEdD][-+]?\d+)?"
_DECIMAL_COMMAS = re.compile(rf"{_NUMBER}(?:\s+{_NUMBER})+|{_NUMBER}")
_COMMA = re.compile(r"(?<=\d),(?=\d|[eEdD\s]|$)")


def number(text: str) -> float:
    """Return a number as Fortran writes it: its exponent may have a D, or no letter. A ValueError if it is none."""
    try:
        value = float(text)
    except ValueError:
        value = float(_EXPONENT.sub(r"e\1", text.upper().replace("D", "E")))
    if not math.isfinite(value) or "_" in text:
        raise ValueError(f"{text!r} is no number")
    return value


def numbers(text: str, source: str | Path) -> np.ndarray:
    """Return the numbers of a text, separated by blanks, commas or lines, each as `number` takes it.

    Raises
    ------
    FileError
        If something is not a number, as in a truncated file.
    """
    plain = text.translate(_BLANKS)
    found = plain_numbers(plain, " ")
    if found is not None:
        return found
    try:
        return np.array([number(part) for part in plain.split()])
    except ValueError as error:
        raise FileError(
            f"{source} holds something that is not a number, or is truncated ({error}). Remedy: export it again"
        ) from error


def plain_numbers(text: str, separator: str) -> np.ndarray | None:
    """Return the numbers of a text at once, or None if something between separators is not plainly a number."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy's warning of text after the numbers
        try:
            found = np.fromstring(text, dtype=float, sep=separator)
        except (DeprecationWarning, ValueError):
            return None
    return found if np.all(np.isfinite(found)) else None


# newer versions of scipy return sparse arrays by default
_OPTIONS = {"spmatrix": True} if "spmatrix" in inspect.signature(scipy.io.mmread).parameters else {}


def read_market(path: str | Path, what: str) -> sp.csr_matrix:
    """Return the matrix of one file.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, complex, or not a Matrix Market file.
    """
    path = regular_file(path, f"for the {what}")
    try:
        matrix = scipy.io.mmread(_market_source(path), **_OPTIONS)
    except (OSError, ValueError, EOFError, IndexError, OverflowError, MemoryError) as error:
        raise FileError(
            f"cannot read the {what} from {path}: it is truncated or not a Matrix Market file ({error}). "
            "Remedy: export it again"
        ) from error
    if np.iscomplexobj(matrix.data):
        raise ModelError(f"the {what} in {path} is complex. Remedy: export it without structural damping")
    return sp.csr_matrix(matrix, dtype=float)


def _market_source(path: Path) -> str | io.BytesIO:
    """Return the source for scipy: the file, or its text with decimal points instead of decimal commas."""
    with path.open("rb") as stream:
        if b"," not in stream.read(100_000):
            return str(path)
    return io.BytesIO(with_points(path.read_text(encoding="latin-1")).encode("latin-1"))
