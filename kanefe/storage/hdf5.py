"""The door to h5py: named arrays with units to HDF5 and back.

A file begins with HDF5's user block, which has a digest of all following bytes. It is compared before HDF5 reads them,
so that damaged data are never read and cannot crash HDF5. Each array also has HDF5's checksum, by which other programs
detect damage.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from kanefe.errors import FileError, MissingDependency
from kanefe.storage.files import regular_file
from kanefe.storage.watched import is_watched, long_work

SMALLEST_COMPRESSED = 1024
"""Number of values in an array below which compression costs more than it saves."""

SMALL_FILE = 2**25
"""Size of all arrays of a file up to which none is compressed, bytes: that takes ten times as long as to write them,
and longer than many runs."""

WHOLE_CHUNK = 2**20
"""Size of an array up to which it is one chunk, bytes: HDF5's cache of chunks."""

MOST_COMPRESSED = 1100
"""Largest ratio of an array to its bytes in the file: deflate achieves at most 1032."""

HEAD = 512
"""Size of the user block, bytes: the smallest that HDF5 permits."""

PIECE = 1 << 20

DEEPEST = 32
"""Largest number of nested groups; the package writes five."""

COARSEST_TIME = 2 * 10**9
"""Longest time, ns, between two changes of a file that may have the same date: a younger file is compared each time."""

Arrays = dict[str, tuple[np.ndarray | list[np.ndarray], str]]
"""Arrays with units by path in a file; a list of arrays becomes one, with their columns side by side."""

_compared: set[tuple[int, ...]] = set()
"""Files, by device, inode, size and time, whose bytes this process has compared with their digests."""


def come_first() -> None:
    """Load h5py, if it is installed, before a library that exposes an HDF5 of its own to what is loaded later."""
    with contextlib.suppress(MissingDependency, FileError):
        h5py_for("kanefe.storage")


def encode(header: Mapping[str, Any], arrays: Arrays) -> memoryview:
    """Return the bytes of an HDF5 file.

    The file is made in memory, because HDF5 can crash on a full disk.

    Parameters
    ----------
    header : mapping
        Attributes of the file: texts and whole numbers unchanged, anything else as JSON.
    arrays : dict of str to (array, unit)
        See `Arrays`; columns are put together one array at a time.

    Raises
    ------
    MissingDependency
        If h5py is not installed.
    """
    h5py = h5py_for("Result.save")
    buffer = io.BytesIO()
    given = (one for array, _ in arrays.values() for one in (array if isinstance(array, list) else [array]))
    is_small = sum(one.nbytes for one in given) <= SMALL_FILE
    # "v110" keeps attributes above 64 KiB, such as a long provenance, which older layouts refuse
    with h5py.File(buffer, "w", libver=("v110", "v110"), userblock_size=HEAD) as file:
        _put_header(h5py, file, header)
        put = _writer(h5py, file, is_small)
        for path, (array, unit) in long_work("packing arrays", arrays.items()):
            put(path, np.concatenate(array, axis=1) if isinstance(array, list) else array, unit)
    data = buffer.getbuffer()
    data[:HEAD] = _head(hashlib.sha256(data[HEAD:]).hexdigest())
    return data


def _put_header(h5py: Any, file: Any, header: Mapping[str, Any]) -> None:
    """Write attributes of an open file: texts and whole numbers unchanged, anything else as JSON."""
    put_text = _text_writer(h5py)
    for name, value in header.items():
        if isinstance(value, int):
            file.attrs[name] = value
        else:
            put_text(file.id, name.encode(), as_text(value))


def _text_writer(h5py: Any) -> Callable[[Any, bytes, str], None]:
    """Return a function that writes a text as an attribute: by HDF5 itself, as h5py takes three times as long."""
    text, one = h5py.h5t.py_create(h5py.string_dtype(), logical=True), h5py.h5s.create(h5py.h5s.SCALAR)

    def put_text(place: Any, name: bytes, value: str) -> None:
        h5py.h5a.create(place, name, text, one).write(np.array(value, dtype=object))

    return put_text


def as_text(value: object) -> str:
    """Return a value of a header as a text: a text unchanged, anything else as JSON."""
    return value if isinstance(value, str) else json.dumps(value, default=_plain)


def safe_name(name: str) -> str:
    """Return a name with the characters escaped that HDF5 reads as parts of a path."""
    kept = name.replace("%", "%25").replace("/", "%2F")
    return kept.replace(".", "%2E") if set(kept) <= {"."} else kept


def _writer(h5py: Any, file: Any, is_small: bool) -> Callable[[str, np.ndarray, str], None]:
    """Return a function that writes an array with its unit.

    By the calls of HDF5 itself: those of h5py take three times as long.
    """
    folders = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    folders.set_create_intermediate_group(True)
    put_text, one = _text_writer(h5py), h5py.h5s.create(h5py.h5s.SCALAR)

    def put(path: str, array: np.ndarray, unit: str) -> None:
        if "\0" in path:
            raise FileError(f"{path!r} has a null character, which names in a file cannot have. Remedy: another name")
        array = np.ascontiguousarray(array).reshape(array.shape)
        packed = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        packed.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        if array.size and array.ndim:  # others have no chunks
            packed.set_chunk(array.shape if array.nbytes <= WHOLE_CHUNK else _chunk(array))
            if array.size >= SMALLEST_COMPRESSED and not is_small:
                packed.set_shuffle()
                packed.set_deflate(4)
            packed.set_fletcher32()
        space = h5py.h5s.create_simple(array.shape) if array.ndim else one
        kind = h5py.h5t.py_create(array.dtype)
        found = h5py.h5d.create(file.id, path.encode(), kind, space, packed, folders)
        found.write(h5py.h5s.ALL, h5py.h5s.ALL, array)
        put_text(found, b"unit", unit)

    return put


def _chunk(array: np.ndarray) -> tuple[int, ...]:
    """Return the shape of chunks of an array that is larger than one: whole rows, or parts of one."""
    row = array.nbytes // len(array)
    rest = array.shape[1:] if row <= WHOLE_CHUNK else _chunk(array[0])
    return max(1, WHOLE_CHUNK // row), *rest


def decode(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return attributes and arrays of an HDF5 file.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or is no HDF5 file.
    MissingDependency
        If h5py is not installed.
    """
    h5py = h5py_for("kanefe.load_result")
    path = regular_file(path)
    try:
        with opened_sealed(path) as file:
            count = _count(h5py, file) if is_watched() else None
            return dict(file.attrs), dict(long_work(f"reading {path.name}", _arrays(h5py, file, "", 0), count))
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
        raise FileError(
            f"{path} is truncated or not an HDF5 file of this kanefe: {error}. Remedy: save the result again"
        ) from error


@contextlib.contextmanager
def opened_sealed(path: Path) -> Iterator[Any]:
    """Open a file whose bytes match its digest.

    The bytes of a file are compared once by a process, as long as the file does not change.

    Raises
    ------
    ValueError
        If they do not match.
    OSError, RuntimeError
        If it cannot be read.
    MissingDependency
        If h5py is not installed.
    """
    h5py = h5py_for("kanefe.load_result")
    status = path.stat()
    file_as_it_is = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)
    if file_as_it_is not in _compared:
        _compare_digest(path)
        if time.time_ns() - status.st_mtime_ns > COARSEST_TIME:
            _compared.add(file_as_it_is)
    with h5py.File(path, "r") as file:
        yield file


def put_digest(file: BinaryIO) -> None:
    """Write the digest of the content of an HDF5 file, which is open for reading and writing, to its user block."""
    file.seek(HEAD)
    digest = _digest_of_rest(file)
    file.seek(0)
    file.write(_head(digest))


def _digest_of_rest(file: BinaryIO) -> str:
    found = hashlib.sha256()
    while piece := file.read(PIECE):
        found.update(piece)
    return found.hexdigest()


def _head(digest: str) -> bytes:
    """Return the user block of a file."""
    text = f"kanefe HDF5: the SHA-256 of all bytes behind these {HEAD} is {digest}\n"
    return text.encode().ljust(HEAD, b" ")


def _compare_digest(path: Path) -> None:
    """Raise a ValueError if the bytes of a file do not match its digest."""
    with path.open("rb") as file:
        head, digest = file.read(HEAD), _digest_of_rest(file)
    if not head.startswith(_head("")[:20]):
        raise ValueError("it has no digest of its content at its head: another program wrote it, or an older kanefe")
    if head != _head(digest):
        raise ValueError("its content does not match its digest: it was damaged, cut, or changed after it was saved")


def _count(h5py: Any, file: Any) -> int:
    """Return the number of arrays of a file."""
    names: list[str] = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return len(names)


def _arrays(h5py: Any, group: Any, place: str, depth: int) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of a group and of those in it, by path; links and external data are refused."""
    if depth > DEEPEST:
        raise ValueError(f"{place} is a group in more than {DEEPEST} others")
    for name in group:
        where = f"{place}{name}"
        item = _member(h5py, group, name, where)
        if isinstance(item, h5py.Group):
            yield from _arrays(h5py, item, f"{where}/", depth + 1)
            continue
        _check_array(h5py, item, where)
        array = np.asarray(item[()])
        array.flags.writeable = False
        yield where, array


def array_at(file: Any, path: str) -> Any:
    """Return an array of an open file, by its path, before its numbers are read.

    Raises
    ------
    ValueError
        If there is none, or if it, or a group on its path, is a link or lies in another file.
    """
    h5py, item = h5py_for("kanefe.load_records"), file
    for name in path.split("/"):
        if not isinstance(item, h5py.Group) or name not in item:
            raise ValueError(f"it has no array {path}")
        item = _member(h5py, item, name, path)
    _check_array(h5py, item, path)
    return item


def _member(h5py: Any, group: Any, name: str, where: str) -> Any:
    """Return a member of a group; a ValueError if it is a link."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise ValueError(f"{where} is a link")
    return group[name]


def _check_array(h5py: Any, item: Any, where: str) -> None:
    """Raise a ValueError if something is no array of numbers that the file itself holds."""
    if not isinstance(item, h5py.Dataset):
        raise ValueError(f"{where} is not an array")
    if item.is_virtual or item.external:
        raise ValueError(f"{where} lies in another file")
    if item.shape is None or item.dtype.kind not in "biufS":
        raise ValueError(f"{where} is not of numbers, but of {item.dtype}")
    if item.nbytes > MOST_COMPRESSED * (item.id.get_storage_size() + SMALLEST_COMPRESSED):
        raise ValueError(f"{where} claims {item.nbytes:.3g} bytes, which the file does not hold")


def h5py_for(needed_by: str) -> Any:
    """Return h5py.

    Raises
    ------
    MissingDependency
        If it is not installed.
    FileError
        If it does not start beside the HDF5 of another library.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingDependency("h5py", needed_by, "pip install h5py") from error
    except ValueError as error:
        raise FileError(
            f"{needed_by}: h5py does not start beside the HDF5 of another library of this program ({error}). "
            "Remedy: import h5py at its head, before dolfinx and petsc4py"
        ) from error
    _keep_whole_in_children()
    return h5py


@cache
def _keep_whole_in_children() -> None:
    """Let no child be forked while another thread is within HDF5: it would wait for h5py's lock for ever."""
    if hasattr(os, "register_at_fork"):
        from h5py._objects import phil

        os.register_at_fork(before=phil.acquire, after_in_parent=phil.release, after_in_child=phil.release)


def _plain(value: Any) -> Any:
    """Convert numpy's numbers and arrays for JSON, anything else to text."""
    if isinstance(value, np.longdouble):  # whose item is one again
        return float(value)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    return str(value)
