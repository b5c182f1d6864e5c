"""Files that a deck includes: where they are looked for."""

from __future__ import annotations

from pathlib import Path

from kanefe.errors import FileError
from kanefe.storage.files import named_file


def included_file(name: str, by: Path, *, top: Path, trusted: bool, reader: str) -> Path:
    """Return a file that another one includes, which may be in its folder or in that of the deck.

    Programs differ: CalculiX 2.20 looks in the folder in which the job runs, at any depth; others in that of the file
    that includes it.

    Parameters
    ----------
    name : str
        As it is written in the deck.
    by : Path
        The file that includes it.
    top : Path
        The deck that the user named.
    trusted : bool
        Whether it may be outside the folder of the deck.
    reader : str
        The function that the user called.

    Raises
    ------
    FileError
        If there is no such file, or there are two that differ; or if it is elsewhere and the deck is not trusted.
    """
    beside = by.parent / name
    places = [place for place in dict.fromkeys((top.parent / name, beside)) if place.is_file()]
    found = [
        named_file(place, by, top=top, trusted=trusted, reader=reader) for place in dict.fromkeys(places or [beside])
    ]
    if len(found) == 2 and found[0].read_bytes() != found[1].read_bytes():
        raise FileError(
            f"{by.name} includes {name}, which is both {found[0]} and {found[1]}, and they differ. Remedy: one of them "
            "with another name"
        )
    return found[0]
