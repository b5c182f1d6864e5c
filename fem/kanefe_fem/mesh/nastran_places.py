"""Coordinate systems of grid points in a Nastran deck: meshes are read where all points are in the basic system."""

from __future__ import annotations

from pathlib import Path

from kanefe.errors import FileError
from kanefe.imports.text import read_text

CARDS = {"GRID": slice(16, 24), "GRDSET": slice(16, 24), "GRID*": slice(24, 40), "GRDSET*": slice(24, 40)}
"""Columns of the number of the system in which a point is given, in cards of small and of large fields."""


def check_nastran_places(path: Path) -> None:
    """Refuse a deck with points in a system of their own, which its reader takes for the basic one.

    Raises
    ------
    FileError
        Naming the line.
    """
    for number, line in enumerate(read_text(path, "Nastran deck").splitlines(), 1):
        line = line.expandtabs(8)
        name = line[:8].partition(",")[0].strip().upper()
        if name in CARDS:
            fields = line.split(",")
            system = (fields[2:3] or [""])[0] if len(fields) > 1 else line[CARDS[name]]
            if system.strip() not in ("", "0"):
                raise FileError(
                    f"{path.name} has points in coordinate system {system.strip()} (line {number}), and is read in the "
                    "basic one alone. Remedy: write the deck with all points in the basic system"
                )
