"""Names of the markers of a mesh of SU2, of which meshio keeps numbers only."""

from __future__ import annotations

from pathlib import Path

from kanefe.errors import FileError


def marker_names(path: Path) -> dict[int, str]:
    """Return the names of markers by the numbers that meshio gives them: the name, if it is one, or the next.

    Raises
    ------
    FileError
        If two markers would have one number, or the file has fewer or more markers than it says.
    """
    found: dict[int, str] = {}
    number, stated, count = 0, None, 0
    for at, line in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
        key, _, value = (part.strip() for part in line.partition("="))
        if key == "NMARK":
            stated = value
        if key != "MARKER_TAG":
            continue
        count += 1
        try:
            number = int(value)
        except ValueError:
            number += 1
        if found.setdefault(number, value) != value:
            raise FileError(
                f"{path.name}: markers {found[number]!r} and {value!r} (line {at}) cannot be told apart. Remedy: give "
                "all markers names, or all numbers"
            )
    if stated is not None and stated != str(count):
        raise FileError(f"{path.name} says that it has {stated} markers, and has {count}. Remedy: write it again")
    return found
