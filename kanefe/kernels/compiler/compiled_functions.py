"""Machine code of kernels: loaded from files of libraries, which are built when a function of them is first needed.

Files lie in the package, where a wheel brought them, for processors of two generations, or in the user's cache, for
this one: see `kanefe.kernels.compiler.libraries` for what a library has.
"""

import ctypes
import itertools
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from kanefe.errors import FileError
from kanefe.kernels.compiler._numba import timed
from kanefe.kernels.compiler.libraries import PACKAGE, Library, library_of
from kanefe.kernels.compiler.processors import generations_here, own_folder, processors_here
from kanefe.storage.files import make_folder
from kanefe.storage.kept_code import Damaged, check_folder, kept, opened

BUILT = PACKAGE / "built"
"""Folder of the libraries in a wheel, with a subfolder for each generation of processors."""


class CompiledFunction(NamedTuple):
    """A C function to be built.

    Attributes
    ----------
    name : str
    module : str
        Where its kernel is.
    compile : function () -> Translated
        See `kanefe.kernels.compiler._numba_module`.
    is_complex : bool
        Whether it is of complex numbers.
    """

    name: str
    module: str
    compile: Callable[[], Any]
    is_complex: bool = False

    @property
    def library(self) -> Library:
        """What has it."""
        return library_of(self.module, self.is_complex)

    @property
    def symbol(self) -> str:
        """Its name in the library."""
        return f"kanefe_{self.name.replace('-', '_')}"


class MachineCode(NamedTuple):
    """A C function that can be called.

    Attributes
    ----------
    address : int
    call : function
        For ctypes, with two arrays; of an entry.
    keeps : object
        What has the memory of the function.
    path : Path or None
        The file that it was loaded from.
    symbol : str
        Its name there.
    """

    address: int
    call: Any
    keeps: object
    path: Path | None = None
    symbol: str = ""


_loaded: dict[tuple[str, str], MachineCode] = {}
_libraries: dict[str, tuple[ctypes.CDLL, Path]] = {}
_lock = threading.RLock()
_opens = itertools.count()
_foreseen: list[Callable[[], Iterable[CompiledFunction]]] = []
_asked: list[dict[str, Library]] = []  # what a build is to have, while that is asked for
_failures: list[str] = []  # of builds: none is tried again in this process


def machine_code(unit: CompiledFunction) -> MachineCode:
    """Return a function from the file of its library; it is built where there is none."""
    key = unit.module, unit.name
    if key not in _loaded:
        with _lock:
            if key not in _loaded:
                _loaded[key] = _from_file(unit) or _in_memory(unit)
    return _loaded[key]


def _from_file(unit: CompiledFunction) -> MachineCode | None:
    """Return a function from a file, or None where none can be kept."""
    opened_library = _opened_library(unit)
    if opened_library is None:
        return None
    library, path = opened_library
    function = getattr(library, unit.symbol)
    function.restype = None
    return MachineCode(ctypes.cast(function, ctypes.c_void_p).value or 0, function, library, path, unit.symbol)


def _opened_library(unit: CompiledFunction) -> tuple[ctypes.CDLL, Path] | None:
    """Return the library of a function and its file, or None where none can be kept; a damaged one is built again."""
    if not _is_kept(unit):
        return None
    name = unit.library.file_name
    for _ in range(2):
        if name in _libraries:
            break
        expect([unit])
        path = path_of(unit.library)
        if path is None:
            return None
        try:
            _libraries[name] = _opened(path), path
        except Damaged:
            _tell(f"{path} is damaged: it is built again")
    return _libraries.get(name)


def _opened(path: Path) -> ctypes.CDLL:
    if path.is_relative_to(BUILT):  # trusted as the package's own files in Python are
        return ctypes.CDLL(str(path))
    with opened(path) as (descriptor, _):
        return ctypes.CDLL(_name_to_open(descriptor, path))


def _name_to_open(descriptor: int, path: Path) -> str:
    """Return a name of an open file for the linker, so that what was checked is what is loaded.

    It takes two libraries of one name for one, and descriptors come again: each has more slashes than the one before.
    """
    if sys.platform != "linux" or not os.path.isdir("/proc/self/fd"):
        return str(path)
    return f"/proc/self/fd/{'/' * next(_opens)}{descriptor}"


def loaded_files() -> dict[int, tuple[Path, str]]:
    """Return file and symbol of all functions that were loaded from files so far, by their addresses."""
    return {code.address: (code.path, code.symbol) for code in _loaded.values() if code.path is not None}


def content_of(path: Path) -> bytes:
    """Return what a file of `loaded_files` has, checked as when it is loaded.

    Raises
    ------
    FileError
        If it has changed since.
    """
    if path.is_relative_to(BUILT):
        return path.read_bytes()
    try:
        with opened(path) as (_, content):
            return content
    except Damaged as error:
        raise FileError(f"{path} has changed since it was loaded. Remedy: run this again, in a new process") from error


def expect(units: Iterable[CompiledFunction]) -> None:
    """Have libraries that are missing built now, side by side, where files can be kept, with what is foreseen."""
    missing = _missing(units)
    if _asked:  # by what is foreseen, while it is looked through: built with the rest
        _asked[-1].update(missing)
    elif missing and not _failures and can_keep(own_folder()):
        import subprocess

        from kanefe.kernels.compiler.side_by_side import build_libraries

        _asked.append(missing)
        try:
            while _foreseen:  # asked once, and only now: what is there already costs nothing
                missing.update(_missing(_foreseen.pop()()))
        finally:
            _asked.pop()
        with timed():
            try:
                build_libraries([*missing.values()], own_folder(), processors_here(), _tell)
            except (OSError, subprocess.SubprocessError) as error:  # each is built for this process alone
                _failures.append(str(error) if isinstance(error, OSError) else "a builder failed, as is told above")


def _missing(units: Iterable[CompiledFunction]) -> dict[str, Library]:
    """Return the libraries of functions that have no file, by their names."""
    found: dict[str, Library] = {}
    for unit in units:
        if (unit.module, unit.name) in _loaded or not _is_kept(unit):
            continue
        library = unit.library
        if library.name not in found and path_of(library) is None:
            found[library.name] = library
    return found


@contextmanager
def foreseen(units: Callable[[], Iterable[CompiledFunction]]) -> Iterator[None]:
    """Have what a function gives built with the first that is missing meanwhile, so that there is one build."""
    _foreseen.append(units)
    try:
        yield
    finally:
        if units in _foreseen:
            _foreseen.remove(units)


def _tell(text: str) -> None:
    print(f"kanefe: {text}", file=sys.stderr, flush=True)


@cache
def can_keep(folder: Path) -> bool:
    """Return whether there is a compiler to link libraries with, and whether they can be put into a folder.

    Raises
    ------
    FileError
        If others could put files there.
    """
    import shutil

    if shutil.which(linker()) is None:
        return False
    try:
        make_folder(folder)
    except OSError:
        return False
    check_folder(folder)
    return os.access(folder, os.W_OK)


def linker() -> str:
    """Return the C compiler."""
    return os.environ.get("CC", "cc")


def path_of(library: Library) -> Path | None:
    """Return the file of a library, or None where it is to be built.

    Raises
    ------
    FileError
        If it would be of the cache, and others could put files there.
    """
    name = library.file_name
    for folder in _built_folders():
        if (folder / f"{name}.so").is_file():
            return folder / f"{name}.so"
    return kept(own_folder(), name)


def _is_kept(unit: CompiledFunction) -> bool:
    """Return whether there are files of a function: its kernel is one of the package."""
    return unit.module.startswith("kanefe.kernels.")


@cache
def _built_folders() -> tuple[Path, ...]:
    """Return where a wheel has libraries for this processor, best first."""
    if not BUILT.is_dir():
        return ()
    return tuple(BUILT / name for name in generations_here() if (BUILT / name).is_dir())


def _in_memory(unit: CompiledFunction) -> MachineCode:
    if _is_kept(unit):
        why = [*_failures, f"{own_folder()} cannot be written, or there is no compiler {linker()}"][0]
        _tell(f"preparing the solver: one more part, some 10 s, in each process ({unit.name}): {why}")
    made = unit.compile()
    address = made.address()
    return MachineCode(address, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address), made)
