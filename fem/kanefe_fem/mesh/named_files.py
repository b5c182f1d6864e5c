"""Check of the files that a mesh file refers to, before meshio reads them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

from kanefe.errors import FileError
from kanefe.storage.files import named_file

MOST = 10
"""Largest number of nested includes; a deeper file includes itself."""


def check_named_files(path: Path, trusted: bool, top: Path | None = None, depth: int = 0) -> None:
    """Refuse a mesh file that refers to itself, or to a file that is missing, in another folder or no regular file.

    Raises
    ------
    FileError
        If there is such a file; the message names both files.
    """
    if depth > MOST:
        raise FileError(f"{path} includes itself, or too many files in files. Remedy: check its *INCLUDE")
    top = top or path
    for name in dict.fromkeys(_names(path)):
        other = named_file(name, path, top=top, trusted=trusted, reader="read_mesh")
        check_named_files(other, trusted, top, depth + 1)


def _names(path: Path) -> Iterator[Path]:
    """Yield the paths of the files that a file refers to, as meshio resolves them."""
    suffix = path.suffix.lower()
    if suffix in (".xdmf", ".xmf"):
        for item in xml_elements(path, "DataItem"):
            text = (item.text or "").strip()
            if item.get("Format", "").upper().startswith("HDF"):
                yield path.parent / text.partition(":")[0]
            elif item.get("Format", "").upper() == "BINARY":
                yield Path(text)


def xml_elements(path: Path, tag: str) -> Iterator[ElementTree.Element]:
    """Yield the elements of an XML file with a given tag.

    Raises
    ------
    FileError
        If the file is not XML.
    """
    try:
        yield from ElementTree.parse(path).iter(tag)
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # the last two: an unknown encoding
        raise FileError(f"{path} is not XML: {error}. Remedy: write it again") from error
