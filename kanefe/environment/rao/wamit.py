"""Motions of WAMIT: files .4."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from kanefe.environment.rao.rao import MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention
from kanefe.environment.rao.rao_grid import Rows, number_lines, numbers_of, warn_left_out
from kanefe.errors import FileError, ModelError

COLUMNS = 7
"""Number of columns: period, heading, motion, modulus, phase, real and imaginary part."""


def read_wamit(
    path: Path,
    *,
    symmetric: bool | None = None,
    length: float | None = None,
    depth: float = math.inf,
    reference: str = "axes of the body in WAMIT",
) -> MotionRao:
    """Return the RAO of a file: rows of period (s), heading, motion, modulus, phase, real and imaginary part.

    Motions are the real parts of ``exp(+i omega t)``, per wave amplitude, rotations times the length ULEN; headings are
    those to which waves propagate, from x, which points forward, to port. Periods for zero and infinite frequency are
    left out. The ship has no speed.

    Raises
    ------
    FileError
        If the file is truncated or of another kind.
    ModelError
        If the length is missing.
    """
    if length is None or not (math.isfinite(length) and length > 0.0):
        raise ModelError(
            f"{path.name}: the motions of WAMIT are made dimensionless by ULEN, which the file does not give. Remedy: "
            "length=..., that of the .gdf, m"
        )
    lines = number_lines(path, "motions of WAMIT")
    if not lines[0].split()[0].lstrip("+-").replace(".", "", 1)[:1].isdigit():
        lines = lines[1:]  # a line of text, NUMHDR = 1
    rows = [numbers_of(line, COLUMNS, f"{path}, {line[:40]!r}") for line in lines if line.strip()]
    table = np.array([row[:COLUMNS] for row in rows])
    table = table[table[:, 0] > 0.0] if len(table) else table
    more = sorted({int(row[2]) for row in table if row[2] > 6})
    if more:
        warn_left_out(path, f"motions {more[0]} to {more[-1]}, generalised modes or those of another body")
        table = table[table[:, 2] <= 6]
    if len(table) % 6 or not len(table) or np.any(table[:, 2].reshape(-1, 6) != np.arange(1, 7)):
        raise FileError(
            f"{path}: motions 1 to 6 of each period and heading were expected. Remedy: WAMIT's .4 of one body, whole"
        )
    first = table[::6]
    values = (table[:, 5] + 1j * table[:, 6]).reshape(-1, 6)
    values[:, 3:] /= length
    convention = RaoConvention("exp(+iwt)", "following", "starboard", "forward", "port", "up", "rad/m", reference)
    found = Rows(np.zeros(len(first)), first[:, 1], 2.0 * np.pi / first[:, 0], values)
    return found.rao(path, convention, depth=depth, symmetric=symmetric)
