"""Check of the numbers of vertices and cells in the header of a mesh file, which meshio trusts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from kanefe.errors import FileError
from kanefe_fem.mesh.named_files import xml_elements

LONGEST_HEAD = 1 << 16
"""Largest size of the header of a .ply file, bytes."""


def check_counts(path: Path) -> None:
    """Refuse a file whose header claims more than the file holds: meshio would leave the rest uninitialised.

    Raises
    ------
    FileError
        If a count is larger than the file can hold; the message names both numbers.
    """
    for what, claimed, found in _counts(path):
        if claimed > found:
            raise FileError(
                f"{path.name} claims {claimed} of {what}, and has {found} at most: it is cut or damaged. Remedy: write "
                "it again"
            )


def _counts(path: Path) -> Iterator[tuple[str, int, int]]:
    """Yield what is counted, the number that the file claims, and the largest number that it can hold."""
    suffix = path.suffix.lower()
    if suffix == ".ply":
        with path.open("rb") as file:
            head = file.read(LONGEST_HEAD).partition(b"end_header")[0]
        for name, count in re.findall(rb"^element +(\w+) +(\d+)", head, re.MULTILINE):
            yield name.decode(), int(count), path.stat().st_size  # each takes a byte at least
    elif suffix == ".xml":
        for tag in ("vertices", "cells"):
            for element in xml_elements(path, tag):
                size = element.get("size", "0")
                yield tag, int(size) if size.isdecimal() else 0, len(element)
