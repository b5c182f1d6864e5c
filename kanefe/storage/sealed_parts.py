"""Files of parts that follow each other, each sealed by its length and its checksum.

A part is its head, of number, length and two checksums, and its content. The first checksum is that of the head, the
second that of the content; both go on from the checksum of the part before, so that a part that was changed, lost,
moved or taken from another file is found. What ends within a part is what a writer was about to write: the file is read
up to there.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from io import FileIO
from pathlib import Path
from typing import NamedTuple

MARK = b"kanefe parts, each sealed by its length and checksum\n"
"""First line of a file."""

USUAL = 1 << 24
"""Size of content above which it is better cut into parts, bytes."""

_NUMBERS = struct.Struct("<II")  # number and length
_HEAD = struct.Struct("<IIII")  # the same, and the checksums of head and content


class Part(NamedTuple):
    """Number and content of a part."""

    number: int
    content: bytes


class PartWriter:
    """A file of parts, open for writing; an existing one is replaced.

    Raises
    ------
    OSError
        If it cannot be written, is a device or a pipe, or another writer is at work.
    """

    def __init__(self, path: Path) -> None:
        if path.exists() and not path.is_file():
            raise OSError("it is no file")
        self._file = path.open("ab", buffering=0)
        try:
            _have_alone(self._file)
        except BlockingIOError as error:
            self._file.close()
            raise OSError("another run writes it") from error
        self._file.truncate(0)
        self._seal, self._end = zlib.crc32(MARK), 0
        self._write(MARK)

    def add(self, number: int, content: bytes) -> None:
        """Add a part; one that cannot be written, because the disk is full, leaves nothing behind.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        of_head = zlib.crc32(_NUMBERS.pack(number, len(content)), self._seal)
        seal = zlib.crc32(content, of_head)
        self._write(_HEAD.pack(number, len(content), of_head, seal) + content)
        self._seal = seal

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(self._end)
            raise
        self._end += len(data)


def _have_alone(file: FileIO) -> None:
    """Raise a BlockingIOError if another writer has a file, where that can be known."""
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except (ImportError, OSError):  # Windows, or a disk of a network without locks
        return


def parts_of(path: Path) -> Iterator[Part] | None:
    """Return the parts of a file up to the last one that is whole; None if it is no file of parts.

    The file is opened now: one that takes its place meanwhile is not read.

    Raises
    ------
    ValueError
        In the iteration: if a part is not what was written.
    OSError
        If it cannot be read.
    """
    file = path.open("rb", buffering=0)
    if file.read(len(MARK)) == MARK:
        return _parts_in(file)
    file.close()
    return None


def _parts_in(file: FileIO) -> Iterator[Part]:
    with file:
        end = os.fstat(file.fileno()).st_size
        seal, place = zlib.crc32(MARK), len(MARK)
        while place + _HEAD.size <= end:
            number, length, of_head, of_content = _HEAD.unpack(file.read(_HEAD.size))
            if zlib.crc32(_NUMBERS.pack(number, length), seal) != of_head:
                raise ValueError(f"the part that begins at byte {place} is not the one that was written")
            place += _HEAD.size + length
            if place > end:
                return
            content = file.read(length)
            seal = zlib.crc32(content, of_head)
            if seal != of_content:
                raise ValueError(f"the part that ends at byte {place} does not match its checksum")
            yield Part(number, content)
