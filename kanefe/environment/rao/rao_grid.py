"""Conversion of the rows of a file, one for each speed, heading and frequency, to the arrays of an RAO."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kanefe.environment.rao.rao import MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention
from kanefe.errors import AccuracyWarning, FileError, outside
from kanefe.frames import Vector
from kanefe.storage.files import regular_file

DIGITS = 9
"""Number of significant digits in which headings and frequencies of rows are compared."""

ROWS = 20
"""Number of last rows of a file whose digits are compared with those of the last row."""

FULL_CIRCLE = 360.0
"""Largest heading, degrees: files give headings of 0 to 360 or of -180 to 180, and larger values are errors of the
file."""


@dataclass(frozen=True)
class Rows:
    """The rows of a file, in its own convention.

    Attributes
    ----------
    speeds, headings, frequencies : ndarray, shape (n,)
        m/s, degrees, rad/s.
    values : ndarray, shape (n, 6)
    """

    speeds: Vector
    headings: Vector
    frequencies: Vector
    values: np.ndarray

    def rao(
        self, path: Path, convention: RaoConvention, *, depth: float = math.inf, symmetric: bool | None = None
    ) -> MotionRao:
        """Return the RAO in the convention of kanefe.

        Raises
        ------
        FileError
            If a heading is beyond a full circle, or a combination of speed, heading and frequency is missing or given
            twice.
        """
        beyond = ~(np.abs(self.headings) <= FULL_CIRCLE)
        if np.any(beyond):
            raise FileError(
                f"{path}: heading {self.headings[beyond][0]:g} is not a direction from -360 to 360 degrees. Remedy: "
                "check the column of headings"
            )
        turned = convention.headings(self.headings)
        axes, places = zip(
            *(np.unique(_rounded(given), return_inverse=True) for given in (self.speeds, turned, self.frequencies)),
            strict=True,
        )
        shape = tuple(len(axis) for axis in axes)
        values = np.full((*shape, 6), np.nan, dtype=complex)
        at = tuple(np.ravel(place) for place in places)
        counts = np.zeros(shape, dtype=int)
        np.add.at(counts, at, 1)
        # 0 and 360 degrees are one heading, which files may give twice
        twice = np.argwhere(counts > np.where(axes[1] == 0.0, 2, 1)[None, :, None])
        for found, what in ((np.argwhere(counts == 0), "missing"), (twice, "given twice")):
            if len(found):
                s, h, f = found[0]
                raise FileError(
                    f"{path}: the motions at {axes[0][s]:g} m/s, heading {axes[1][h]:g} (0: head, 90: from port) and "
                    f"{axes[2][f]:.6g} rad/s are {what}. Remedy: one row for each speed, heading and frequency"
                )
        values[at] = self.values
        values = convention.values(values, axes[2], depth)
        return MotionRao(axes[2], axes[1], axes[0], values, path.name, convention.reference, depth, symmetric)


def warn_left_out(path: Path, what: str) -> None:
    """Warn of content of a file that is left out."""
    warnings.warn(f"{path}: {what}, are left out", AccuracyWarning, stacklevel=outside())


def number_lines(path: Path, what: str) -> list[str]:
    """Return the lines of a text file.

    Raises
    ------
    FileError
        If it does not exist, cannot be read, is empty or binary, or ends within a number.
    """
    path = regular_file(path, f"of {what}")
    try:
        text = path.read_text(encoding="latin-1")
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}. Remedy: check the file") from error
    if not text.strip() or "\0" in text[:4096]:
        raise FileError(f"{path} is empty or not text, where {what} were expected. Remedy: export it again")
    lines = text.splitlines()
    if not text.endswith(("\n", "\r")) and _is_cut(lines):
        raise FileError(
            f"{path} seems to end within a number, {_words(lines[-1])[-1]!r} in line {len(lines)}: its last line has "
            "no line end, and this number fewer digits than those above it. Remedy: export it again, or end the line"
        )
    return lines


def _is_cut(lines: list[str]) -> bool:
    """Return whether the last number of a table has fewer digits than the last numbers of the rows above."""
    last = _words(lines[-1])
    above = [len(words[-1].partition(".")[2]) for words in map(_words, lines[-ROWS:-1]) if len(words) == len(last)]
    return bool(last and above) and len(last[-1].partition(".")[2]) < min(above)


def _words(line: str) -> list[str]:
    return line.replace(",", " ").replace(";", " ").split()


def numbers_of(line: str, count: int, where: str) -> list[float]:
    """Return the numbers of a line, at least `count`.

    Raises
    ------
    FileError
        If it has fewer, or something that is not a number.
    """
    try:
        found = [float(word.translate(_EXPONENTS)) for word in line.split()]
    except ValueError:
        found = []
    if len(found) < count:
        raise FileError(f"{where}: {count} numbers were expected, not {line.strip()!r}. Remedy: export it again")
    return found


_EXPONENTS = str.maketrans({"D": "E", "d": "e"})


def _rounded(given: Vector) -> Vector:
    given = np.asarray(given, dtype=float)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(np.where(given == 0.0, 1.0, abs(given)))))
    return np.round(given * scale) / scale
