"""Files that are written completely or not at all, checks of files to be read, and the folder of the cache.

The cache holds what can be computed again: compiled kernels and flexible bodies.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
import tempfile
import time
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from kanefe.errors import FileError

LARGEST_SHARE = 0.5
"""Largest size of a file that is read whole, relative to the memory that the process may use."""

MOST_WAITING = 10.0
"""Longest time that a writer to a pipe waits for a reader, s."""

_NO_FILES = {
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}


def regular_file(
    path: str | Path, what: str = "", *, kind: str = "file", remedy: str = "check the path", whole: bool = True
) -> Path:
    """Return the path of a regular file that fits into memory: the first check of all readers.

    Parameters
    ----------
    path : path
    what : str
        Its content, for messages: "for the nodes".
    kind : str
        Its name in messages.
    remedy : str
        For a file that does not exist.
    whole : bool
        Whether it is read whole, not mapped.

    Raises
    ------
    FileError
        If it does not exist, is a folder, device, pipe or socket, or does not fit into memory.
    """
    path = possible_path(path)
    called = f"{path} {what}".rstrip()
    try:
        status = path.stat()
        if stat.S_ISREG(status.st_mode):
            path.open("rb").close()
    except (FileNotFoundError, NotADirectoryError):
        raise FileError(f"there is no {kind} {called}. Remedy: {remedy}") from None
    except (OSError, ValueError) as error:  # a link to itself, a folder that may not be entered, a name with \0
        if isinstance(error, PermissionError):
            remedy = "have it, and the folders above it, made readable for you"
        raise FileError(f"cannot read the {kind} {called}: {error}. Remedy: {remedy}") from error
    if stat.S_ISDIR(status.st_mode):
        whole_name = f"{path.absolute()} {what}".rstrip()
        raise FileError(f"there is no {kind} {whole_name}: it is a folder. Remedy: the file in it")
    if not stat.S_ISREG(status.st_mode):
        found = _NO_FILES.get(stat.S_IFMT(status.st_mode), "no file")
        raise FileError(f"{called} is {found}, which may never end. Remedy: write its content to a file, and give that")
    if whole and status.st_size > LARGEST_SHARE * usable_memory():
        raise FileError(
            f"{called} has {status.st_size / 2**30:.3g} GiB, of which {LARGEST_SHARE * usable_memory() / 2**30:.3g} "
            "can be read here. Remedy: check that it is what it should be, or a machine with more memory"
        )
    return path


def named_file(path: Path, by: Path, *, top: Path, trusted: bool, reader: str) -> Path:
    """Return a file that another file includes; it must be below the folder of the file that the user named.

    Parameters
    ----------
    path : Path
    by : Path
        The file that includes it.
    top : Path
        The file that the user named.
    trusted : bool
        Whether it may be anywhere.
    reader : str
        The function that the user called.

    Raises
    ------
    FileError
        If it is elsewhere, also by a link; or as `regular_file`.
    """
    regular_file(path, f"that {by.name} reads")
    folder = os.path.realpath(top.parent)
    if not trusted and not Path(os.path.realpath(path)).is_relative_to(folder):
        raise FileError(
            f"{by} reads {path}, which does not lie below {folder}. Remedy: put it there; or, if you know what it is, "
            f"{reader}(..., trusted=True)"
        )
    return path


def usable_memory() -> float:
    """Return the memory that this process can use at most, bytes: that of the machine, or its own limit."""
    found = float("inf")
    if hasattr(os, "sysconf"):
        found = float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES"))
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY:
            found = min(found, float(limit))
    return found


def possible_path(path: str | Path) -> Path:
    """Return the path of a file that may or may not exist.

    Raises
    ------
    FileError
        If it is no text or path, or not valid as a name of a file: it has a null character, a lone surrogate, or is too
        long.
    """
    try:
        possible = Path(path)
        with contextlib.suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            possible.lstat()
    except (OSError, ValueError, TypeError) as error:
        raise FileError(f"no file can have the path {path!r}: {error}. Remedy: another name") from error
    return possible


def ready_path(path: str | Path) -> Path:
    """Return `path` after its folder has been created.

    Raises
    ------
    FileError
        If the folder cannot be created.
    """
    path = possible_path(path)
    try:
        make_folder(path.parent)
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror}. Remedy: choose a folder that can be made") from error
    return path


def make_folder(folder: Path, is_own: bool = False) -> None:
    """Create a folder and its parents: in the cache, or if `is_own`, for the owner only, whatever the umask."""
    if not (is_own or _is_in_cache(folder)):
        folder.mkdir(parents=True, exist_ok=True)
        return
    for missing in reversed([place for place in (folder, *folder.parents) if not os.path.exists(place)]):
        missing.mkdir(mode=0o700, exist_ok=True)
    if not folder.is_dir():
        raise NotADirectoryError(20, "it is not a folder", str(folder))


def _is_in_cache(path: Path) -> bool:
    """Return whether a path is in the cache, whose files are accessible to the owner only."""
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(cache_folder()))


def write_whole(path: str | Path, write: Callable[[BinaryIO], object]) -> None:
    """Call ``write(file)`` on a temporary file beside `path` and put it in place only when it is complete.

    A missing folder is created. A process that is killed leaves a file ``.<name>.<random>`` beside, never an incomplete
    `path`. In the cache, folders and files are accessible to the owner only. A link stays, and its target is replaced.
    The bytes are written directly to a device or pipe, which cannot be replaced.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full; `path` is as it was before.
    """
    path = ready_path(os.path.realpath(possible_path(path)))
    if os.path.exists(path) and not path.is_file():
        _write_through(path, write)
        return
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise FileError(
            f"cannot write {path}: {error.strerror}. Remedy: choose a folder that can be written"
        ) from error
    try:
        with os.fdopen(handle, "w+b") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        if not _is_in_cache(path):
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(name, 0o666 & ~umask)  # mkstemp makes files that only their owner can read
        os.replace(name, path)
    except OSError as error:
        raise FileError(
            f"cannot write {path}: {error.strerror or error}. What was there before is untouched. "
            "Remedy: free some space or choose another folder"
        ) from error
    finally:
        Path(name).unlink(missing_ok=True)


def _write_through(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Call ``write(file)`` on a buffer and write its bytes to a device or pipe."""
    buffer = BytesIO()
    write(buffer)
    try:
        with os.fdopen(_opened_for_writing(path), "wb", buffering=0) as file:
            rest = buffer.getbuffer()
            while rest:
                rest = rest[file.write(rest) :]
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror}. Remedy: the name of a file") from error


def _opened_for_writing(path: Path) -> int:
    """Return the descriptor of a device or pipe; an OSError if a pipe has no reader in time."""
    last = time.monotonic() + MOST_WAITING
    while True:
        try:
            handle = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
        except OSError as error:
            if error.errno != errno.ENXIO or time.monotonic() > last:
                raise
            time.sleep(0.01)
        else:
            os.set_blocking(handle, True)
            return handle


def cache_folder() -> Path:
    """Return the folder of the cache: ``KANEFE_CACHE_DIR``, else kanefe's folder in the cache of the user.

    It may not exist yet.
    """
    chosen = os.environ.get("KANEFE_CACHE_DIR")
    if chosen:
        return Path(chosen).expanduser()
    system: str = sys.platform
    if system == "linux":  # XDG base directories; importing platformdirs would take 3 ms of each new process
        chosen = os.environ.get("XDG_CACHE_HOME", "").strip()
        return (Path(chosen) if chosen else Path("~/.cache").expanduser()) / "kanefe"
    import platformdirs

    return Path(platformdirs.user_cache_dir("kanefe"))
