"""Files of a deck: that which the user named, and those which it includes."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError
from kanefe.imports.text import read_text
from kanefe.storage.files import named_file

DEEPEST = 10
"""Number of files within each other, at most: by a link to a folder above one file has ever new names."""


class DeckWarning(UserWarning):
    """Lines of a deck that are left out, or that later ones override."""


class DeckFile(NamedTuple):
    """A file of a deck.

    Attributes
    ----------
    path : Path
    top : Path
        The one that the user named.
    trusted : bool
        Whether files may be outside its folder.
    reader : str
        The function that the user called.
    above : tuple of Path
        The files that this one is included by, the first one first.
    """

    path: Path
    top: Path
    trusted: bool
    reader: str
    above: tuple[Path, ...] = ()

    def text(self, what: str) -> str:
        """Return its text; a FileError as of `kanefe.imports.text.read_text`."""
        return read_text(self.path, what)

    def included(self, name: str, at: int) -> DeckFile:
        """Return a file that this one includes, which may be in its folder or in that of the deck.

        Programs differ: CalculiX 2.20 looks in the folder in which the job runs, at any depth; others in that of the
        file that includes it.

        Parameters
        ----------
        name : str
            As it is written in the deck.
        at : int
            Number of the line that it is written in.

        Raises
        ------
        FileError
            If there is no such file, or there are two that differ; if files include themselves; or if it is elsewhere
            and the deck is not trusted.
        """
        if not name:
            raise FileError(f"{self.path.name} includes a file without a name (line {at}). Remedy: its name")
        beside = self.path.parent / name
        places = [place for place in dict.fromkeys((self.top.parent / name, beside)) if place.is_file()]
        if not places and not beside.exists():
            raise FileError(
                f"there is no file {beside} that {self.path.name} reads (line {at}). Remedy: put it there, or in the "
                "folder of the deck"
            )
        found = [
            named_file(place, self.path, top=self.top, trusted=self.trusted, reader=self.reader)
            for place in dict.fromkeys(places or [beside])
        ]
        if len(found) == 2 and found[0].read_bytes() != found[1].read_bytes():
            raise FileError(
                f"{self.path.name} includes {name} (line {at}), which is both {found[0]} and {found[1]}, and they "
                "differ. Remedy: one of them with another name"
            )
        above = (*self.above, self.path)
        if found[0] in above or len(above) > DEEPEST:
            raise FileError(f"{found[0]} includes itself (by {self.path.name}, line {at}). Remedy: check what includes")
        return self._replace(path=found[0], above=above)
