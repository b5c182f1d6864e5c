"""One file for one flexible body: a header that names format and version, and arrays that are mapped, not read."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

from kanefe.array_file import open_arrays, read_header, write_arrays
from kanefe.errors import FileError
from kanefe.flexible import FlexibleBody
from kanefe.records import OtherVersion, decoded, encoded

FORMAT = "kanefe flexible body"
VERSION = 4
"""1 and 2 were compressed, and so had to be read as a whole; 3 named classes by the files of the code they were in."""

DAMAGE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    ImportError,
    EOFError,
    NotImplementedError,
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
)
"""What reading a file that is truncated, damaged or of another kind may raise."""


def save_body(body: FlexibleBody, path: str | Path) -> None:
    """Write a body to `path`, which then holds either the whole new body or what it held before.

    The file is an .npz without compression. An array that the body holds twice is written once.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full.
    """
    text, arrays = encoded(body)
    header = {"format": FORMAT, "version": VERSION, "body": json.loads(text)}
    write_arrays(path, json.dumps(header), arrays)


def load_body(path: str | Path) -> FlexibleBody:
    """Read a body that `save_body` wrote; arrays of more than a mebibyte stay in the file until they are used.

    Raises
    ------
    FileError
        If the file is not there, truncated, or of another format or version.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError(f"there is no file {path}. Remedy: check the path, or make the body again and save it")
    try:
        header = _checked(read_header(path), path)
        _, arrays = open_arrays(path)
        body = decoded(json.dumps(header["body"]), arrays)
    except OtherVersion as error:
        raise FileError(
            f"{path} was written by another version of kanefe ({error}). Remedy: make the body again with this version"
        ) from error
    except DAMAGE as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path} is truncated or is no saved body ({error}). Remedy: save the body again") from error
    if not isinstance(body, FlexibleBody):
        raise FileError(f"{path} is truncated or is no saved body. Remedy: save the body again")
    return body


def _checked(text: str, path: Path) -> dict[str, Any]:
    """Return the header of a file of this format and version."""
    header: dict[str, Any] = json.loads(text)
    if header.get("format") != FORMAT:
        raise FileError(f"{path} is no saved flexible body. Remedy: give the file that FlexibleBody.save wrote")
    if header.get("version") != VERSION:
        raise FileError(
            f"{path} has format version {header.get('version')}, this kanefe reads version {VERSION}. "
            "Remedy: make the body again with this version"
        )
    return header
