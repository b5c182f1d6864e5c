"""The folder of dolfinx's compiled forms: only the user can write to it, and libraries are checked before import.

The size and digest of the library of a form are stored beside it when it is complete. A library that has changed since
is removed, so that dolfinx compiles it again. The files of a process that was ended while it compiled are removed too,
since dolfinx would wait for its library. Processes that share a folder are synchronised by locks.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import stat
import sys
import sysconfig
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import BinaryIO

from kanefe.errors import FileError, outside
from kanefe.storage.files import make_folder, write_whole
from kanefe.storage.kept_code import OTHERS_WRITE, check_entry, check_folder

VARIABLE = "XDG_CACHE_HOME"
"""Environment variable with the folder of caches, by default ~/.cache."""

OPTIONS = ("dolfinx_jit_options.json", "dolfinx_jit_parameters.json", "ffcx_options.json", "ffcx_parameters.json")
"""Files of the working directory from which dolfinx reads the compiler options and the folder of libraries."""

READY = ".c.cached"
"""Suffix of the file that FFCx writes when a library is complete."""

LOOKED_AT, COMPILED = ".looked_at", ".compiled"
"""Lock files: one held by the process that checks the libraries, one by all processes that compile."""

SECONDS = 60
"""Time for which dolfinx waits for a form that another process compiles, s."""

_sound: set[Path] = set()
"""Files with the suffix `READY` whose libraries this process has checked."""


def refuse_options() -> None:
    """Refuse compiler options in the working directory, which may come from others.

    Raises
    ------
    FileError
        If there is such a file; the message names it and the remedy.
    """
    for name in OPTIONS:
        if os.path.lexists(name):
            package = name.partition("_")[0]
            raise FileError(
                f"dolfinx would take options from {Path.cwd() / name}, which can have its compiler run any program. "
                f"Remedy: start in another folder; options of your own go to ~/.config/{package}/{name}"
            )


@cache
def forms_folder() -> Path:
    """Return the folder of compiled forms of this Python, or one for this process only if it cannot be written."""
    caches = Path(os.environ.get(VARIABLE) or Path("~/.cache").expanduser())
    folder = caches / "kanefe" / "forms" / str(sysconfig.get_config_var("SOABI"))
    try:
        make_folder(folder, is_own=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as problem:
        spare = tempfile.mkdtemp(prefix="kanefe-forms-")  # its random name keeps others from preparing it
        atexit.register(shutil.rmtree, spare, ignore_errors=True)
        warnings.warn(
            f"the cache of compiled forms {folder} cannot be written ({problem}); this process compiles its own. "
            f"Set {VARIABLE} to a folder of yours to keep them",
            UserWarning,
            stacklevel=outside(),
        )
        return Path(spare)


def check_forms(folder: Path) -> None:
    """Remove the forms of a folder that are damaged, or whose process was ended while it compiled.

    Raises
    ------
    FileError
        If others than the user could have put code into it; the message names the remedy.
    """
    if not os.path.isdir(folder):
        return
    about = folder.stat()
    if hasattr(os, "geteuid") and about.st_uid == os.geteuid():
        if not about.st_mode & (stat.S_IXGRP | stat.S_IXOTH):  # nobody else can have written its files
            _shut(folder.iterdir())
        _check_entries(folder)  # before the folder itself is changed, so that a refusal is repeated
    check_folder(folder, VARIABLE)
    _check_entries(folder)
    keep_digests(folder)


def keep_digests(folder: Path) -> None:
    """Write the size and digest of each library that has none yet; remove those that have changed since."""
    if not (_not_looked_at(folder) or _without_library(folder)):
        return
    with _lock(folder, LOOKED_AT, alone=True):
        for ready in _not_looked_at(folder):
            name = ready.name.removesuffix(READY)
            note, found = folder / f"{name}.digest", _digest(folder, name)
            if found and not note.exists():
                write_whole(note, partial(_write, found))
                _shut(folder.glob(f"{name}.*"))
            if found and found == note.read_bytes():
                _sound.add(ready)
                continue
            print(f"kanefe: {folder / name} is damaged: it is compiled again", file=sys.stderr, flush=True)
            _remove(folder, name)
        if folder == forms_folder():  # other programs may compile in another folder without these locks
            with _lock(folder, COMPILED, alone=True, wait=False) as nobody_compiles:
                for file in _without_library(folder) if nobody_compiles else ():
                    _remove(folder, file.stem)


def _not_looked_at(folder: Path) -> set[Path]:
    return set(folder.glob(f"*{READY}")) - _sound


def _without_library(folder: Path) -> list[Path]:
    """Return the sources of forms without a library: being compiled, or left by a process that was ended."""
    return [file for file in folder.glob("*.c") if not file.with_suffix(READY).exists()]


@contextmanager
def being_compiled(folder: Path) -> Iterator[None]:
    """Hold the lock for compiling forms of a folder, and write the digests of the new forms at the end."""
    with _lock(folder, COMPILED, alone=False):
        yield
    keep_digests(folder)


@contextmanager
def _lock(folder: Path, name: str, alone: bool, wait: bool = True) -> Iterator[bool]:
    """Hold a lock, which ends with this process at the latest; yield whether it was acquired."""
    try:
        import fcntl

        file = os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o600)
    except (ImportError, OSError):  # another operating system, or a read-only folder
        yield False
        return
    try:
        is_held = True
        try:
            fcntl.flock(file, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | (0 if wait else fcntl.LOCK_NB))
        except OSError:  # another process holds it, or it is a network disk without locks
            is_held = False
        yield is_held
    finally:
        os.close(file)


def _check_entries(folder: Path) -> None:
    for entry in folder.iterdir():
        with suppress(FileNotFoundError):  # another process has removed it meanwhile
            check_entry(entry, VARIABLE)


def _shut(files: Iterable[Path]) -> None:
    """Remove write access of others, which the umask may have given, from files of this user."""
    for file in files:
        with suppress(FileNotFoundError, PermissionError):
            about = file.lstat()
            if stat.S_ISREG(about.st_mode) and about.st_mode & OTHERS_WRITE:
                file.chmod(stat.S_IMODE(about.st_mode) & ~OTHERS_WRITE)


def _remove(folder: Path, name: str) -> None:
    for file in sorted(folder.glob(f"{name}.*")):  # the one with suffix .c first, for which dolfinx waits
        file.unlink(missing_ok=True)


def _digest(folder: Path, name: str) -> bytes:
    """Return the size and digest of the library of a form, empty if there is none."""
    for suffix in EXTENSION_SUFFIXES:
        if (folder / f"{name}{suffix}").is_file():
            content = (folder / f"{name}{suffix}").read_bytes()
            return f"{len(content)} {hashlib.sha256(content).hexdigest()}\n".encode()
    return b""


def _write(content: bytes, file: BinaryIO) -> None:
    file.write(content)
