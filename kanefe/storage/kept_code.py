"""Machine code in the cache: loaded only if no other user can have written it, and only if it is complete.

The name of such a file ends in its size and the digest of name and content, so that both appear together with the file.
Two processes that write the same file at once leave two complete ones.
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
    """The content of a file does not match the digest in its name."""


def keep(folder: Path, name: str, content: bytes) -> Path:
    """Write a file into a folder, and return its path.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    path = folder / f"{name}-{len(content)}-{_digest(name, content)}.so"
    write_whole(path, lambda file: file.write(content))
    return path


def kept(folder: Path, name: str) -> Path | None:
    """Return the path of the file of a name, or None; the file is not read.

    Raises
    ------
    FileError
        If the folder or one of its parents belongs to others, or others may write it.
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
    """Open a file of the cache; yield its descriptor and its content, which matches its name.

    Raises
    ------
    Damaged
        If the content does not match the name; the file has been removed.
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
    """Return whether a file of the cache is complete; if not it has been removed."""
    try:
        with opened(path):
            return True
    except Damaged:
        return False


def check_folder(folder: Path, variable: str = CACHE) -> None:
    """Refuse a folder that other users can have written; the cache's own folders are restricted to the owner.

    Parameters
    ----------
    folder : Path
    variable : str
        Environment variable that names another folder, for the message.

    Raises
    ------
    FileError
        If it, or one of its parents, belongs to a user other than this one and root, or may be written by others.
        Parents with the sticky bit, such as /tmp, are accepted.
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
    """Refuse a file, a link or its target that others own or may write; errors as `check_folder`."""
    about = path.lstat()
    if stat.S_ISLNK(about.st_mode) and _is_trusted(about.st_uid):
        about = path.stat()
    _check(path, about, path, variable)


def _check(path: Path, about: os.stat_result, to_remove: Path, variable: str = CACHE) -> None:
    if os.name != "posix":  # modes have no meaning there
        return
    if not _is_trusted(about.st_uid):
        raise FileError(
            f"compiled code is not loaded from {path}: it belongs to user {about.st_uid}, who could run code "
            f"here. Remedy: {variable}=a folder of your own, or remove {to_remove} if it is yours to remove"
        )
    if _others_write(about):
        raise FileError(
            f"compiled code is not loaded from {path}: others may write it (mode {stat.S_IMODE(about.st_mode):o}) "
            f"and could run code here. Remedy: {f'chmod go-w {path}' if path == to_remove else f'rm -r {to_remove}'}, "
            f"or {variable}=a folder that only you write"
        )


def _is_trusted(user: int) -> bool:
    return not hasattr(os, "geteuid") or user in (0, os.geteuid())


def _others_write(about: os.stat_result) -> bool:
    """Return whether others than the owner may write; the private group of a user does not count as other."""
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
    """Return at most `size` bytes of an open file."""
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
