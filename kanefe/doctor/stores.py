"""The folders of kernels and cached bodies, how many there are, and whether more can be stored."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from kanefe.bodies import cache
from kanefe.kernels.compiler import _numba
from kanefe.kernels.compiler.build import all_libraries
from kanefe.kernels.compiler.compiled_functions import BUILT, path_of
from kanefe.storage.files import cache_folder


@dataclass(frozen=True)
class BuiltKernels:
    """The compiled kernels.

    Attributes
    ----------
    count, built : int
        Number of libraries of kernels, and of those with a file that this processor can run.
    from_wheel : int
        Number of files that came with the package.
    is_on : bool
        Whether kernels are compiled at all: unless ``KANEFE_JIT=0``.
    missing : tuple of str
        Names of libraries that are not built.
    """

    count: int
    built: int
    from_wheel: int
    is_on: bool
    missing: tuple[str, ...] = ()

    @property
    def are_ready(self) -> bool:
        """Whether all kernels are built."""
        return self.is_on and self.built == self.count


@dataclass(frozen=True)
class CacheStore:
    """A folder of the cache.

    Attributes
    ----------
    what : str
    folder : Path
    files : int
    size : int
        Bytes.
    can_be_written : bool
    """

    what: str
    folder: Path
    files: int
    size: int
    can_be_written: bool


def kernels() -> BuiltKernels:
    """Return how many libraries of kernels are built; this builds none."""
    paths = {library.name: path_of(library) for library in all_libraries()}
    built = [path for path in paths.values() if path is not None]
    from_wheel = sum(path.is_relative_to(BUILT) for path in built)
    missing = tuple(name for name, path in paths.items() if path is None)
    return BuiltKernels(len(paths), len(built), from_wheel, _numba.IS_COMPILED, missing)


def stores() -> list[CacheStore]:
    """Return the folders of kernels and of bodies in the cache."""
    return [_store("kernels", cache_folder() / "kernels"), _store("bodies and models", cache.bodies_folder())]


def _store(what: str, folder: Path) -> CacheStore:
    files = [path for path in folder.rglob("*") if path.is_file()]
    there = next(path for path in (folder, *folder.parents) if path.exists())
    can_be_written = there.is_dir() and os.access(there, os.W_OK)
    return CacheStore(what, folder, len(files), sum(path.stat().st_size for path in files), can_be_written)
