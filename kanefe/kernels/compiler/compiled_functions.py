"""Machine code of kernels: built ahead of time, or when it is first needed, and kept in files.

A *unit* is one C function. Its file is named by a stamp of what it was made from: the files of kernels that its own
imports, directly or not, so that an edit makes again what depends on it and nothing else; and of the processor. Files
lie in the package, where a wheel brought them, for processors of two generations, or in the user's cache, for this one.
"""

from __future__ import annotations

import ctypes
import hashlib
import itertools
import os
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from kanefe.errors import FileError
from kanefe.kernels.compiler._numba import timed
from kanefe.kernels.compiler._numba_objects import SUPPORT
from kanefe.storage.files import cache_folder, make_folder
from kanefe.storage.kept_code import Damaged, check_folder, keep, kept, opened

PACKAGE = Path(__file__).parents[1]
BUILT = PACKAGE / "built"
"""Folder of the compiled functions in a wheel, with a subfolder for each generation of processors."""

ALWAYS = tuple(f"compiler/{name}.py" for name in ("_numba", "_numba_alone", "_numba_objects", "arrays", "signatures"))
"""Files of kernels on which every compiled function depends."""

NEVER = tuple(f"compiler/{name}.py" for name in ("entries", "compiled_functions", "side_by_side"))
"""Files that call machine code and are not part of it."""


class Generation(NamedTuple):
    """Processors that a wheel has units for.

    Attributes
    ----------
    features : str
        What they need of those features that `/proc/cpuinfo` tells.
    compiler_name : str
        What the compiler calls them.
    """

    features: str
    compiler_name: str


GENERATIONS = {
    "x86-64-v3": Generation("avx avx2 bmi1 bmi2 f16c fma movbe", "haswell"),
    "x86-64": Generation("sse2", "x86-64"),
}
"""Processor generations for which wheels are made, best first."""

IMPORT = b"\nfrom kanefe.kernels"


class ObjectCode(Protocol):
    """What a compiler gives: see `kanefe.kernels.compiler._numba_objects`."""

    code: bytes
    symbol: str

    def address(self) -> int:
        """Return where the function is in this process."""
        ...


class CompiledFunction(NamedTuple):
    """A C function to be built.

    Attributes
    ----------
    name : str
        Of its file.
    module : str
        Where its kernel is.
    compile : function () -> ObjectCode
    is_first : bool
        Whether the first build makes it: see `kanefe.kernels.compiler.entries.built_first`.
    """

    name: str
    module: str
    compile: Callable[[], Any]
    is_first: bool = False


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
    """

    address: int
    call: Any
    keeps: object
    path: Path | None = None


_loaded: dict[tuple[str, str], MachineCode] = {}
_lock = threading.RLock()
_opens = itertools.count()
_foreseen: list[Callable[[], Iterable[CompiledFunction]]] = []


def machine_code(unit: CompiledFunction) -> MachineCode:
    """Return the function of a unit, from its file; it is built where there is none."""
    key = unit.module, unit.name
    if key not in _loaded:
        with _lock:
            if key not in _loaded:
                _loaded[key] = _from_file(unit) or _in_memory(unit)
    return _loaded[key]


def _from_file(unit: CompiledFunction) -> MachineCode | None:
    """Return the function of a unit from its file, or None where none can be kept; a damaged file is built again."""
    for _ in range(2):
        expect([unit])
        path = path_of(unit)
        if path is None:
            return None
        if path.is_relative_to(BUILT):  # trusted as the package's own files in Python are
            return _opened(str(path), path)
        try:
            with opened(path) as (descriptor, _):
                return _opened(_name_to_open(descriptor, path), path)
        except Damaged:
            _tell(f"{path} is damaged: it is built again")
    return None


def _name_to_open(descriptor: int, path: Path) -> str:
    """Return a name of an open file for the linker, so that what was checked is what is loaded.

    It takes two libraries of one name for one, and descriptors come again: each has more slashes than the one before.
    """
    if sys.platform != "linux" or not os.path.isdir("/proc/self/fd"):
        return str(path)
    return f"/proc/self/fd/{'/' * next(_opens)}{descriptor}"


def loaded_files() -> dict[int, Path]:
    """Return the files of all functions that were loaded from files so far, by their addresses."""
    return {code.address: code.path for code in _loaded.values() if code.path is not None}


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
    """Have what is missing of units built now, side by side, where their files can be kept, with what is foreseen."""
    missing = _missing(units)
    if missing and can_keep(own_folder()):
        import subprocess

        from kanefe.kernels.compiler.side_by_side import batches_of, build_by_name, processors_here

        while _foreseen:  # asked once, and only now: what is there already costs nothing
            missing += _missing(_foreseen.pop()())
        names = batches_of(list(dict.fromkeys(unit.name for unit in missing)))
        with timed(), suppress(OSError, subprocess.SubprocessError):  # then each is built for this process alone
            build_by_name(names, own_folder(), processors_here(), _tell)


def _missing(units: Iterable[CompiledFunction]) -> list[CompiledFunction]:
    return [
        unit for unit in units if _is_kept(unit) and (unit.module, unit.name) not in _loaded and path_of(unit) is None
    ]


@contextmanager
def foreseen(units: Callable[[], Iterable[CompiledFunction]]) -> Iterator[None]:
    """Have what a function gives built with the first unit that is missing meanwhile, so that there is one count."""
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
    """Return whether there is a compiler to link files of units with, and whether they can be put into a folder.

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


def path_of(unit: CompiledFunction) -> Path | None:
    """Return the file of a unit, or None where it is to be built.

    Raises
    ------
    FileError
        If it would be of the cache, and others could put files there.
    """
    if not _is_kept(unit):
        return None
    name = name_of(unit)
    for folder in _built_folders():
        if (folder / f"{name}.so").is_file():
            return folder / f"{name}.so"
    return kept(own_folder(), name)


def _is_kept(unit: CompiledFunction) -> bool:
    """Return whether there are files of a unit: its kernel is one of the package."""
    return unit.module.startswith("kanefe.kernels.")


def name_of(unit: CompiledFunction) -> str:
    """Return the first part of the name of a unit's file, which identifies what it was made from."""
    return f"{unit.name}-{stamp(unit.module)}"


@cache
def stamp(module: str) -> str:
    """Return what names the files of kernels that a module of kernels is made from."""
    found, wanted = set(ALWAYS), [module]
    while wanted:
        path = _path_in_package(wanted.pop())
        if path not in found and path not in NEVER:
            found.add(path)
            wanted += _source(path).imports
    lines = [f"{path} {_source(path).digest}\n" for path in sorted(found)]
    return hashlib.sha256("".join(lines).encode()).hexdigest()[:16]


@cache
def _path_in_package(module: str) -> str:
    name = module.removeprefix("kanefe.kernels").lstrip(".").replace(".", "/")
    return f"{name}.py" if os.path.isfile(f"{PACKAGE}/{name}.py") else f"{name}/__init__.py".lstrip("/")


class _Source(NamedTuple):
    """A file of kernels: a digest of it, and the modules of kernels that it imports."""

    digest: str
    imports: tuple[str, ...]


@cache
def _source(path: str) -> _Source:
    with open(f"{PACKAGE}/{path}", "rb") as file:
        text = file.read()
    return _Source(hashlib.sha256(text).hexdigest(), imports_of(text))


def imports_of(text: bytes) -> tuple[str, ...]:
    """Return the modules of kernels that a file imports, each once; a regular expression takes 4 ms for all files."""
    found = (rest.partition(b" import")[0].decode() for rest in text.split(IMPORT)[1:])
    return tuple(dict.fromkeys(f"kanefe.kernels{module}" for module in found))


@cache
def _built_folders() -> tuple[Path, ...]:
    """Return where a wheel has files of units for this processor, best first."""
    if not BUILT.is_dir():
        return ()
    return tuple(BUILT / name for name in generations_here() if (BUILT / name).is_dir())


def generations_here() -> list[str]:
    """Return the generations of processors that this one belongs to, best first."""
    can = set(_features().split())
    return [name for name, of in GENERATIONS.items() if can.issuperset(of.features.split())]


@cache
def own_folder() -> Path:
    """Return the folder of units that are made for this processor."""
    machine = _machine()
    processor = hashlib.sha256(f"{machine} {_features()}".encode()).hexdigest()[:8]
    return folder_for(f"{machine}-{processor}")


def folder_for(processors: str) -> Path:
    """Return the folder of units in the cache that are made for some processors: a generation, or this one."""
    return cache_folder() / "kernels" / processors


def _machine() -> str:
    if hasattr(os, "uname"):
        return os.uname().machine
    import platform  # 2 ms of a new process

    return platform.machine()


@cache
def _features() -> str:
    """Return what the processor has beyond the least of its kind, as Linux names it."""
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            flags = re.search(r"^(?:flags|Features)\s*:(.*)$", file.read(20_000), re.MULTILINE)
    except OSError:
        flags = None
    if flags:
        return flags[1]
    import platform

    return platform.processor()


def _opened(name: str, path: Path) -> MachineCode:
    library = ctypes.CDLL(name)
    function = library.kanefe_unit
    function.restype = None
    return MachineCode(ctypes.cast(function, ctypes.c_void_p).value or 0, function, library, path)


def _in_memory(unit: CompiledFunction) -> MachineCode:
    if _is_kept(unit):
        _tell(
            f"preparing the solver: one more part, some 10 s, in each process ({unit.name}): {own_folder()} cannot be "
            f"written, or there is no compiler {linker()}"
        )
    made = unit.compile()
    address = made.address()
    return MachineCode(address, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address), made)


def write_compiled_function(folder: Path, unit: CompiledFunction) -> None:
    """Build a unit, link it to a library and put it into a folder.

    Raises
    ------
    OSError, subprocess.SubprocessError
        If there is no C compiler.
    FileError
        If the file cannot be written.
    """
    import subprocess
    import tempfile

    made: ObjectCode = unit.compile()
    with tempfile.TemporaryDirectory(prefix="kanefe-") as work:
        of_numba, support, whole = (Path(work) / name for name in ("unit.o", "support.c", "unit.so"))
        of_numba.write_bytes(made.code)
        support.write_text(SUPPORT)
        renamed = f"-Wl,--defsym=kanefe_unit={made.symbol}"
        subprocess.run(
            [
                linker(),
                "-shared",
                "-fPIC",
                "-O2",
                "-Wl,-z,notext",
                "-Wl,-s",
                renamed,
                "-o",
                str(whole),
                str(of_numba),
                str(support),
                "-lm",
            ],
            check=True,
            capture_output=True,
            text=True,
        )
        keep(folder, name_of(unit), whole.read_bytes())
