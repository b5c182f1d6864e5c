"""A text and named arrays in one file: an .npz without compression, whose large arrays are memory-mapped.

numpy can read the file as any other .npz. Large arrays begin at multiples of 64 bytes, so that they can be used in
place and shared by processes. All checksums are compared when a file is opened, which takes about half a second per
gigabyte; a process does this once, as long as the file does not change.
"""

from __future__ import annotations

import io
import mmap
import os
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from kanefe.storage.files import write_whole

MAPPED = 1 << 20
"""Size from which an array is mapped, bytes. Smaller arrays are read."""

PIECE = 1 << 24
"""Size of the pieces of a mapped array between which other threads may run, bytes."""

ALIGNMENT = 64
HEADER = "header"
"""Name of the text among the arrays."""

_LOCAL_HEADER = struct.Struct("<4s22xHH")
_PADDING = 0xD935
"""Identifier of an extra field that is used for alignment only."""
_NO_DATE = (1980, 1, 1, 0, 0, 0)
_LARGE = 1 << 30
"""Size from which a member has the 64-bit sizes of the zip format, bytes."""

_compared: set[tuple[int, ...]] = set()
"""Files, by device, inode, size and time, whose large arrays this process has compared with their checksums."""


def write_arrays(path: str | Path, header: str, arrays: Mapping[str, np.ndarray]) -> None:
    """Write a text and arrays to `path`; if that fails, the file is as it was before.

    Equal contents give equal bytes.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full.
    """
    write_whole(path, lambda file: _write(file, {HEADER: np.array(header), **arrays}))


def open_arrays(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    """Return the text and the arrays of a file, the large ones mapped and all of them read-only.

    The sizes of all arrays are compared with that of the file, and their checksums with their content.

    Raises
    ------
    OSError, ValueError, KeyError, zipfile.BadZipFile, struct.error
        If the file is truncated, damaged or of another kind.
    """
    with path.open("rb") as file, zipfile.ZipFile(file) as members:
        status = os.fstat(file.fileno())
        file_as_it_is = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)
        map_of_file: mmap.mmap | None = None
        arrays: dict[str, np.ndarray] = {}
        check_directory(file, members)
        for info in members.infolist():
            if info.compress_type != zipfile.ZIP_STORED:
                raise ValueError(f"{info.filename} is compressed")
            start = _start_of(file, info)
            if info.file_size >= MAPPED:
                map_of_file = map_of_file or mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
                if file_as_it_is not in _compared:
                    _compare_checksum(map_of_file, start, info)
                array = _mapped(file, map_of_file, start, info)
            else:
                array = _read(file, start, info)
            arrays[info.filename.removesuffix(".npy")] = array
    _compared.add(file_as_it_is)
    return str(arrays.pop(HEADER)), arrays


def read_header(path: Path) -> str:
    """Return only the text of a file, which may be compressed; raises the errors of `open_arrays`."""
    with zipfile.ZipFile(path) as members:
        content = members.read(f"{HEADER}.npy")
    return str(np.lib.format.read_array(io.BytesIO(content), allow_pickle=False))


def check_directory(file: BinaryIO, members: zipfile.ZipFile) -> None:
    """Raise a BadZipFile if a file contains data that its directory does not list, as after the loss of an entry."""
    place = 0
    for info in members.infolist():
        if info.header_offset != place:
            raise zipfile.BadZipFile(f"the directory has lost what lies before {info.filename}")
        place = _start_of(file, info) + info.compress_size
    if place != members.start_dir:
        raise zipfile.BadZipFile("the directory has lost what lies before it")


def _write(file: BinaryIO, arrays: Mapping[str, np.ndarray]) -> None:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as members:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            is_large = array.nbytes >= _LARGE
            if array.nbytes >= MAPPED:
                size_of_fields = 20 if is_large else 0  # what zipfile adds for 64-bit sizes
                fixed = file.tell() + 30 + len(info.filename.encode()) + 4 + size_of_fields
                info.extra = struct.pack("<HH", _PADDING, -fixed % ALIGNMENT) + bytes(-fixed % ALIGNMENT)
            with members.open(info, "w", force_zip64=is_large) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def _start_of(file: BinaryIO, info: zipfile.ZipInfo) -> int:
    """Return where the content of a member begins in the file."""
    file.seek(info.header_offset)
    mark, name_length, extra_length = _LOCAL_HEADER.unpack(file.read(_LOCAL_HEADER.size))
    name = file.read(name_length)
    if mark != b"PK\x03\x04" or name != info.filename.encode():
        raise zipfile.BadZipFile(f"{info.filename} is not where the directory has it")
    return file.tell() + int(extra_length)


def _read(file: BinaryIO, start: int, info: zipfile.ZipInfo) -> np.ndarray:
    """Return a small array, checked."""
    file.seek(start)
    content = file.read(info.file_size)
    if zlib.crc32(content) != info.CRC:
        raise zipfile.BadZipFile(f"the checksum of {info.filename} is wrong")
    array = np.asarray(np.lib.format.read_array(io.BytesIO(content), allow_pickle=False))
    array.flags.writeable = False
    return array


def _compare_checksum(map_of_file: mmap.mmap, start: int, info: zipfile.ZipInfo) -> None:
    """Raise a BadZipFile if a large array differs from what was written."""
    found, stop = 0, start + info.file_size
    with memoryview(map_of_file) as content:
        for begin in range(start, min(stop, len(content)), PIECE):
            found = zlib.crc32(content[begin : min(begin + PIECE, stop)], found)
    if found != info.CRC:
        raise zipfile.BadZipFile(f"the checksum of {info.filename} is wrong")


def _mapped(file: BinaryIO, map_of_file: mmap.mmap, start: int, info: zipfile.ZipInfo) -> np.ndarray:
    """Return a large array in place in the file."""
    file.seek(start)
    reader: Any = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    shape, is_fortran, dtype = reader[np.lib.format.read_magic(file)](file)
    offset = file.tell()
    size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
    if dtype.hasobject or offset + size != start + info.file_size or offset + size > len(map_of_file):
        raise ValueError(f"{info.filename} has another size than its header says")
    return np.ndarray(shape, dtype, buffer=map_of_file, offset=offset, order="F" if is_fortran else "C")
