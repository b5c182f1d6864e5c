"""Motions in waves from tables of text with a declared convention."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.environment.rao.rao import NAMES, MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention
from kanefe.environment.rao.rao_grid import Rows, number_lines, warn_left_out
from kanefe.errors import FileError
from kanefe.frames import Vector

FREQUENCIES = {
    "omega": lambda x: x,
    "frequency": lambda x: 2.0 * np.pi * x,
    "period": lambda x: 2.0 * np.pi / x,
}
"""Conversion to rad/s of columns of wave frequency in rad/s and Hz and of wave period in s."""


def read_table(
    path: Path, *, symmetric: bool | None = None, convention: RaoConvention | dict[str, str] | None = None
) -> MotionRao:
    """Return the RAO of a table: columns separated by commas or semicolons, named in the first line without ``#``.

    Columns are ``omega`` (rad/s), ``frequency`` (Hz) or ``period`` (s) of the wave; ``heading`` in degrees; ``speed``
    in m/s, zero if it is missing; and for each motion, surge to yaw, ``surge_re`` and ``surge_im``, or
    ``surge_amplitude`` and ``surge_phase`` in degrees. Lines ``# name: value`` above declare the
    convention (`RaoConvention`), and ``# depth:`` the depth of the water if it is finite.

    Raises
    ------
    FileError
        If a column is missing or a cell is not a number.
    ModelError
        If the convention is not completely declared, in the file or by `convention`.
    """
    lines = number_lines(path, "motions in waves")
    declared = dict(_declaration(line) for line in lines if line.lstrip().startswith("#") and ":" in line)
    depth = declared.pop("depth", "inf")
    if not isinstance(convention, RaoConvention):
        convention = RaoConvention.of({**declared, **(convention or {})}, path.name)
    body = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if len(body) < 2:
        raise FileError(f"{path} has no rows below the names of its columns")
    columns = _columns(path, body)
    names = [name for name in FREQUENCIES if name in columns]
    if len(names) != 1 or "heading" not in columns:
        raise FileError(
            f"{path} has columns {', '.join(columns)}. Remedy: heading, and one of omega, frequency and period"
        )
    given = columns[names[0]]
    if np.any(given <= 0.0):
        raise FileError(f"{path}: {names[0]} must be above zero, not {given.min():g}. Remedy: leave such rows out")
    values = np.column_stack([_motion(path, columns, name) for name in NAMES])
    used = {names[0], "heading", "speed", *(f"{name}_{part}" for name in NAMES for part in _parts(columns, name))}
    if more := [name for name in columns if name not in used]:
        warn_left_out(path, f"columns {', '.join(more)}, which are no part of motions")
    rows = Rows(columns.get("speed", np.zeros(len(given))), columns["heading"], FREQUENCIES[names[0]](given), values)
    return rows.rao(path, convention, depth=_depth(path, depth), symmetric=symmetric)


def _declaration(line: str) -> tuple[str, str]:
    name, _, value = line.lstrip("# \t").partition(":")
    return name.strip(), value.strip()


def _depth(path: Path, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise FileError(f"{path}: the depth must be a number, m, not {text!r}") from None


def _columns(path: Path, body: list[str]) -> dict[str, Vector]:
    separator = ";" if ";" in body[0] else ","
    rows = list(csv.reader(body, delimiter=separator))
    names = [name.strip().lower() for name in rows[0]]
    if twice := [name for name in names if names.count(name) > 1]:
        raise FileError(f"{path} has two columns {twice[0]!r}. Remedy: one of them")
    found = np.empty((len(rows) - 1, len(names)))
    for i, row in enumerate(rows[1:]):
        try:
            found[i] = [float(cell) for cell in row]
        except ValueError:
            raise FileError(
                f"{path}: row {i + 1} is no {len(names)} numbers: {separator.join(row)[:80]!r}. Remedy: one for each "
                "column, with decimal points"
            ) from None
    return dict(zip(names, found.T, strict=True))


def _motion(path: Path, columns: dict[str, Any], name: str) -> np.ndarray:
    parts = _parts(columns, name)
    if not parts:
        raise FileError(
            f"{path} has no columns {name}_re and {name}_im, or {name}_amplitude and {name}_phase. Remedy: add them; "
            "zeros where the ship does not have such a motion"
        )
    first, second = (columns[f"{name}_{part}"] for part in parts)
    return np.asarray(first + 1j * second if parts[0] == "re" else first * np.exp(1j * np.radians(second)))


def _parts(columns: dict[str, Any], name: str) -> tuple[str, ...]:
    """Return the two parts by which a motion is given, none if it is not."""
    for parts in (("re", "im"), ("amplitude", "phase")):
        if {f"{name}_{part}" for part in parts} <= set(columns):
            return parts
    return ()
