"""The file of an object: a header with format and version, and memory-mapped arrays."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kanefe.errors import FileError
from kanefe.storage.array_file import open_arrays, read_header, write_arrays
from kanefe.storage.files import regular_file
from kanefe.storage.serialise import OtherVersion, decoded, encoded


@dataclass(frozen=True)
class FileKind:
    """A kind of files.

    Attributes
    ----------
    format : str
        Its name in the header.
    version : int
        The version that can be read.
    cls : type
        Class of the object.
    key : str
        Name of the object in the header, and its short name in messages.
    name : str
        Full name in messages.
    writer : str
        The function that writes such files, for messages.
    """

    format: str
    version: int
    cls: type
    key: str
    name: str
    writer: str


DAMAGE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    ImportError,
    EOFError,
    OverflowError,
    MemoryError,
    RuntimeError,  # of zipfile: encrypted; RecursionError: a header of brackets; NotImplementedError
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
)
"""Exceptions that may be raised by reading a file that is truncated, damaged or of another kind."""


def write_object(path: str | Path, value: object, kind: FileKind) -> None:
    """Write an object to `path`; if that fails, the file is as it was before.

    The file is an .npz without compression. An array that the object contains twice is written once.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full.
    """
    text, arrays = encoded(value)
    header = {"format": kind.format, "version": kind.version, kind.key: json.loads(text)}
    write_arrays(path, json.dumps(header), arrays)


def read_object(path: str | Path, kind: FileKind) -> Any:
    """Read an object that was written by `write_object`; arrays above a mebibyte are memory-mapped.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or of another format or version.
    """
    key = kind.key
    path = regular_file(path, remedy=f"check the path, or make the {key} again and save it", whole=False)
    try:
        header = _checked(read_header(path), path, kind)
        _, arrays = open_arrays(path)
        value = decoded(json.dumps(header[key]), arrays)
    except OtherVersion as error:
        raise FileError(
            f"{path} was written by another version of kanefe ({error}). Remedy: make the {key} again with this version"
        ) from error
    except DAMAGE as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path} is truncated or not a saved {key} ({error}). Remedy: save the {key} again") from error
    if not isinstance(value, kind.cls):
        raise FileError(f"{path} is truncated or not a saved {key}. Remedy: save the {key} again")
    return value


def _checked(text: str, path: Path, kind: FileKind) -> dict[str, Any]:
    """Return the header of a file of this kind and version."""
    header = json.loads(text)
    if not isinstance(header, dict) or header.get("format") != kind.format:
        raise FileError(f"{path} is not a saved {kind.name}. Remedy: give the file that {kind.writer} wrote")
    if header.get("version") != kind.version:
        raise FileError(
            f"{path} has format version {header.get('version')}, this kanefe reads version {kind.version}. "
            f"Remedy: make the {kind.key} again with this version"
        )
    return dict(header)
