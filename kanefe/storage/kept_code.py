"""Machine code in the cache: opened only where nobody but its owner can have written it, and only if it is whole.

The name of such a file ends in the size and the digest of what it has and of what it is called, so that they are put in
place with it, by whoever may write its folder. Two processes that make one file at once leave two, each sound.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from kanefe.errors import FileError
from kanefe.storage.files import cache_folder, write_whole

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
"""Mode bits that let the group or all users write."""

CACHE = "KANEFE_CACHE_DIR"
"""Environment variable with the folder of the cache."""

_checked: set[Path] = set()
_names: dict[Path, dict[str, str]] = {}


class Damaged(Exception):
    """A file is not what its name says."""


def keep(folder: Path, name: str, content: bytes) -> Path:
    """Put a file into a folder, and return it.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    path = folder / f"{name}-{len(content)}-{_digest(name, content)}.so"
    write_whole(path, lambda file: file.write(content))
    return path


def kept(folder: Path, name: str) -> Path | None:
    """Return the file of a name, which is not read yet, or None.

    Raises
    ------
    FileError
        If the folder or what it lies in belongs to others, or others may write it.
    """
    if name not in _names.get(folder, {}):
        if not os.path.isdir(folder):
            return None
        check_folder(folder)
        with suppress(OSError):
            _names[folder] = {file.rsplit("-", 2)[0]: file for file in os.listdir(folder) if file.endswith(".so")}
    file = _names.get(folder, {}).get(name)
    return None if file is None else folder / file


@contextmanager
def opened(path: Path) -> Iterator[tuple[int, bytes]]:
    """Open a kept file: give its descriptor, and what it has, which is what its name says.

    Raises
    ------
    Damaged
        If it is not; it has been removed.
    FileError
        If it belongs to others, or others may write it.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        _forget(path)
        raise Damaged from error
    try:
        about = os.fstat(descriptor)
        _check(path, about, path.parent)
        name, size, digest = path.stem.rsplit("-", 2)
        if not stat.S_ISREG(about.st_mode) or str(about.st_size) != size:
            _forget(path)
            raise Damaged
        content = _read(descriptor, about.st_size)
        if _digest(name, content) != digest:
            _forget(path)
            raise Damaged
        yield descriptor, content
    finally:
        os.close(descriptor)


def is_sound(path: Path) -> bool:
    """Return whether a kept file is whole; if not it has been removed."""
    try:
        with opened(path):
            return True
    except Damaged:
        return False


def check_folder(folder: Path, variable: str = CACHE) -> None:
    """Refuse a folder that others can have written; of the cache's own folders what is too open is shut.

    Parameters
    ----------
    folder : Path
    variable : str
        Of the environment, that names another folder.

    Raises
    ------
    FileError
        If it, or one that it lies in, belongs to others than this user and root, or may be written by others. That it
        lies in a folder where each removes only what is his, as /tmp, is no fault.
    """
    if folder in _checked:
        return
    cache = Path(os.path.realpath(cache_folder()))
    real = Path(os.path.realpath(folder))
    for place in (real, *real.parents):
        about = place.stat()
        is_own = place.is_relative_to(cache) and hasattr(os, "geteuid") and about.st_uid == os.geteuid()
        is_shared = place == cache and about.st_mode & stat.S_ISVTX  # as /tmp, which stays as it is
        if is_own and about.st_mode & OTHERS_WRITE and not is_shared:
            place.chmod(stat.S_IRWXU)
        elif place == real or not about.st_mode & stat.S_ISVTX or not _is_trusted(about.st_uid):
            _check(place, about, place, variable)
    _checked.add(folder)


def check_entry(path: Path, variable: str = CACHE) -> None:
    """Refuse a file that others own or may write, or a link, or what it leads to; errors as of `check_folder`."""
    about = path.lstat()
    if stat.S_ISLNK(about.st_mode) and _is_trusted(about.st_uid):
        about = path.stat()
    _check(path, about, path, variable)


def _check(path: Path, about: os.stat_result, to_remove: Path, variable: str = CACHE) -> None:
    if os.name != "posix":  # modes tell nothing there
        return
    if not _is_trusted(about.st_uid):
        raise FileError(
            f"compiled code is not taken from {path}: it belongs to user {about.st_uid}, who could run code "
            f"here. Remedy: {variable}=a folder of your own, or remove {to_remove} if it is yours to remove"
        )
    if _others_write(about):
        raise FileError(
            f"compiled code is not taken from {path}: others may write it (mode {stat.S_IMODE(about.st_mode):o}) "
            f"and could run code here. Remedy: {f'chmod go-w {path}' if path == to_remove else f'rm -r {to_remove}'}, "
            f"or {variable}=a folder that only you write"
        )


def _is_trusted(user: int) -> bool:
    return not hasattr(os, "geteuid") or user in (0, os.geteuid())


def _others_write(about: os.stat_result) -> bool:
    """Return whether others than the owner may write; the group that a user has alone is no other."""
    if about.st_mode & stat.S_IWOTH or not about.st_mode & stat.S_IWGRP:
        return bool(about.st_mode & stat.S_IWOTH)
    import grp
    import pwd

    try:
        owner, group = pwd.getpwuid(about.st_uid), grp.getgrgid(about.st_gid)
    except KeyError:
        return True
    is_private = (
        owner.pw_gid == group.gr_gid and group.gr_name == owner.pw_name and set(group.gr_mem) <= {owner.pw_name}
    )
    return not is_private


def _read(descriptor: int, size: int) -> bytes:
    """Return the bytes of an open file, at most as many as its name states."""
    parts = []
    while size > 0 and (part := os.read(descriptor, size)):
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def _digest(name: str, content: bytes) -> str:
    return hashlib.sha256(name.encode() + b"\0" + content).hexdigest()[:32]


def _forget(path: Path) -> None:
    _names.pop(path.parent, None)
    with suppress(OSError):
        path.unlink()
