"""Check of the files that a mesh file refers to, before meshio reads them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

from kanefe.errors import FileError
from kanefe.storage.files import named_file


def check_named_files(path: Path, trusted: bool) -> None:
    """Refuse a mesh file that refers to a file that is missing, in another folder or no regular file.

    Raises
    ------
    FileError
        If there is such a file; the message names both files.
    """
    for name in dict.fromkeys(_names(path)):
        named_file(name, path, top=path, trusted=trusted, reader="read_mesh")


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
