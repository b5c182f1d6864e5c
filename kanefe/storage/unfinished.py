"""Parts of long work, kept on the disk until it is done, so that it goes on where it was after it was ended.

The outermost function opens `resumable`; functions at any depth below keep what they have by `keep` and take it up
again by `kept`, without an argument that is passed down. Nothing is written in work that is done within `SECONDS`.
"""

from __future__ import annotations

import contextlib
import shutil
import time
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from pathlib import Path

import numpy as np

from kanefe.errors import FileError
from kanefe.storage.files import write_whole

SECONDS = 30.0
"""Time between two writings, s: as much work is lost at most."""

FORGOTTEN = 7 * 24 * 3600.0
"""Age from which the parts of work that was not taken up again are removed, s."""


class Unfinished:
    """The parts of one work.

    Parameters
    ----------
    folder : Path
        Of this work alone; made when something is written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written = time.monotonic()

    def _path(self, name: str) -> Path:
        return self._folder / f"{name.replace(' ', '_')}.npz"

    def read(self, name: str) -> dict[str, np.ndarray] | None:
        """Return the arrays of a part, None if there are none that can be read."""
        from zipfile import BadZipFile

        try:
            with np.load(self._path(name), allow_pickle=False) as arrays:
                return dict(arrays)
        except (OSError, ValueError, EOFError, KeyError, BadZipFile):
            return None

    def write(self, name: str, arrays: Mapping[str, np.ndarray]) -> None:
        """Write the arrays of a part if it is time; the disk may be full, then they are not kept."""
        if time.monotonic() - self._written < SECONDS:
            return
        with contextlib.suppress(FileError):
            write_whole(self._path(name), lambda file: np.savez(file, **arrays))
        self._written = time.monotonic()


_open: ContextVar[Unfinished | None] = ContextVar("unfinished", default=None)


@contextlib.contextmanager
def resumable(folder: Path) -> Iterator[None]:
    """Keep parts of the work of the block in a folder until it is done.

    Parameters
    ----------
    folder : Path
        Named by all that the work depends on. Others beside it that are older than `FORGOTTEN` are removed.
    """
    for other in folder.parent.iterdir() if folder.parent.is_dir() else ():
        with contextlib.suppress(OSError):
            if time.time() - other.stat().st_mtime > FORGOTTEN:
                shutil.rmtree(other)
    token = _open.set(Unfinished(folder))
    try:
        yield
    finally:
        _open.reset(token)
    shutil.rmtree(folder, ignore_errors=True)  # not reached where the block was ended


def keep(name: str, **arrays: np.ndarray) -> None:
    """Keep the arrays of a part of the work, in the place of those kept before; without effect outside `resumable`."""
    unfinished = _open.get()
    if unfinished is not None:
        unfinished.write(name, arrays)


def kept(name: str) -> dict[str, np.ndarray] | None:
    """Return the arrays of a part that an earlier run kept, None if there are none."""
    unfinished = _open.get()
    return None if unfinished is None else unfinished.read(name)
