"""The cache of flexible bodies and of their full-order models: the same input is computed once.

Each is stored in its own file, named by a digest of all its input. Files are written atomically, so that any number of
processes can write and read at once; a killed process leaves at most a temporary file, which is deleted later. Opening
a body costs little more than comparing its checksums: see `kanefe.storage.array_file`.

Bodies that differ only in interfaces, reduction and damping share a model. It takes about a kilobyte for each degree of
freedom.

=======================  =============================================================================================
``KANEFE_CACHE=0``       the cache is off
``KANEFE_CACHE_DIR``     the folder (of the compiled kernels too); default: that of the user's system
``KANEFE_CACHE_GB``      largest size of all files, default 10; those not used for longest are deleted first
=======================  =============================================================================================
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from kanefe.errors import FileError, ModelError, outside
from kanefe.storage.files import cache_folder

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.fe_model.model import FiniteElementModel

Kind = Literal["body", "model"]
Kept = TypeVar("Kept")

DEFAULT_GB = 10.0

LEFT_OVER = 24 * 3600.0
"""Age of an unfinished file from which it counts as left by a killed process, s."""

FRESH = 60.0
"""Age of the last recorded use from which the next use is recorded, s."""


class CacheWarning(UserWarning):
    """A problem with the cache; bodies are made without it."""


@dataclass(frozen=True)
class Entry:
    """A file in the cache.

    Attributes
    ----------
    key : str
        Digest of its input.
    kind : "body", "model" or None
        None if the file cannot be read.
    path : Path
    size : int
        Bytes.
    used : float
        Time of its last use, s since 1970.
    about : dict
        Its provenance; empty if the file cannot be read.
    """

    key: str
    kind: Kind | None
    path: Path
    size: int
    used: float
    about: dict[str, Any]

    @property
    def summary(self) -> str:
        """Its input, in one line."""
        if self.kind is None:
            return "cannot be read; it is made again when it is needed"
        dofs = f"{self.about['dofs']} dofs" if "dofs" in self.about else None
        reduction = self.about.get("reduction")
        method = reduction.get("method") if isinstance(reduction, dict) else reduction
        return ", ".join(str(x) for x in (self.about.get("source"), self.about.get("element"), dofs, method) if x)


def is_on() -> bool:
    """Return whether bodies are cached: unless ``KANEFE_CACHE=0``."""
    return os.environ.get("KANEFE_CACHE", "1") != "0"


def bodies_folder() -> Path:
    """Return the folder of the cached bodies and models."""
    return cache_folder() / "bodies"


def find(key: str) -> FlexibleBody | None:
    """Return the body of a key, or None.

    A file that cannot be read is deleted with a `CacheWarning`.
    """
    from kanefe.bodies.flexible import FlexibleBody

    return _found(key, "body", FlexibleBody.load)


def find_model(key: str) -> FiniteElementModel | None:
    """Return the full-order model of a key, or None; a file that cannot be read is deleted with a `CacheWarning`."""
    from kanefe.fe_model.file import load_model

    return _found(key, "model", load_model)


def keep(key: str, body: FlexibleBody) -> None:
    """Store a body in the cache; if this fails, only a `CacheWarning` is issued."""
    from kanefe.bodies.flexible import FlexibleBody

    _keep(key, "body", body, FlexibleBody.save)


def keep_model(key: str, model: FiniteElementModel) -> None:
    """Store a full-order model in the cache as `keep`, without its function of the geometric stiffness."""
    from kanefe.fe_model.file import save_model

    _keep(key, "model", model, save_model)


def entries() -> list[Entry]:
    """Return the files in the cache, last used first."""
    found = []
    for path in bodies_folder().glob("*.npz"):
        with contextlib.suppress(FileNotFoundError):  # another process may have deleted it
            status = path.stat()
            kind, about = _about(path)
            found.append(Entry(path.stem, kind, path, status.st_size, status.st_mtime, about))
    return sorted(found, key=lambda entry: -entry.used)


def clear() -> tuple[int, int]:
    """Delete all bodies, models and what killed processes left; return the number of files and of bytes."""
    count = freed = 0
    left = (cache_folder() / "unfinished").glob("*/*")
    for path in [*bodies_folder().glob("*.npz"), *bodies_folder().glob(".*.npz.*"), *left]:
        with contextlib.suppress(FileNotFoundError):
            size = path.stat().st_size
            path.unlink()
            count, freed = count + 1, freed + size
    return count, freed


def clear_kernels() -> int:
    """Delete the compiled kernels, which are compiled again when they are needed; return the number of bytes."""
    folder = cache_folder() / "kernels"
    freed = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    shutil.rmtree(folder, ignore_errors=True)
    return freed


def limit() -> float:
    """Return the largest size of all files in bytes.

    Raises
    ------
    ModelError
        If ``KANEFE_CACHE_GB`` is not a number.
    """
    text = os.environ.get("KANEFE_CACHE_GB", "")
    try:
        return 1e9 * float(text) if text else 1e9 * DEFAULT_GB
    except ValueError as error:
        raise ModelError(
            f"KANEFE_CACHE_GB={text!r} is not a number of gigabytes. Remedy: KANEFE_CACHE_GB=10"
        ) from error


def _path(key: str) -> Path:
    return bodies_folder() / f"{key}.npz"


def _found(key: str, kind: Kind, load: Callable[[Path], Kept]) -> Kept | None:
    path = _path(key)
    if not os.path.isfile(path):
        return None
    try:
        found = load(path)
    except FileError as error:
        warnings.warn(f"a cached {kind} is removed and made again: {error}", CacheWarning, stacklevel=outside())
        with contextlib.suppress(OSError):
            path.unlink()
        return None
    with contextlib.suppress(OSError):  # the cache may be read-only
        if time.time() - path.stat().st_mtime > FRESH:
            os.utime(path)
    return found


def _keep(key: str, kind: Kind, value: Kept, save: Callable[[Kept, Path], None]) -> None:
    try:
        save(value, _path(key))
    except (FileError, TypeError) as error:
        warnings.warn(
            f"the {kind} is not cached: {error} (KANEFE_CACHE_DIR names another folder, KANEFE_CACHE=0 turns it off)",
            CacheWarning,
            stacklevel=outside(),
        )
        return
    _make_room(_path(key))


def _about(path: Path) -> tuple[Kind | None, dict[str, Any]]:
    """Return the kind of a file's content, and its provenance."""
    from kanefe.storage.array_file import read_header
    from kanefe.storage.object_file import DAMAGE
    from kanefe.storage.serialise import decoded

    try:
        header = json.loads(read_header(path))
        kind: Kind = "model" if "model" in header else "body"
        held = header["model"]["fields"]["model"] if kind == "model" else header["body"]
        return kind, dict(decoded(json.dumps(held["fields"]["provenance"]), {}))
    except DAMAGE:
        return None, {}


def _make_room(newest: Path) -> None:
    """Delete the files not used for longest until the rest fits, and those of killed processes."""
    files = []
    for path in bodies_folder().glob("*.npz"):
        with contextlib.suppress(FileNotFoundError):
            status = path.stat()
            files.append((path != newest, -status.st_mtime, status.st_size, path))
    room = limit()
    for is_older, _, size, path in sorted(files):
        room -= size
        if is_older and room < 0.0:
            path.unlink(missing_ok=True)
    for path in bodies_folder().glob(".*.npz.*"):
        with contextlib.suppress(FileNotFoundError):
            if time.time() - path.stat().st_mtime > LEFT_OVER:
                path.unlink()
