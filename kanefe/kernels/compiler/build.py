"""All kernels built ahead of time, side by side: ``kanefe prepare``, or ``make kernels``."""

import argparse
import importlib
import os
import pkgutil
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue
from types import FunctionType

import kanefe.kernels
from kanefe.errors import FileError, MissingDependency
from kanefe.kernels.compiler._numba_alone import build_alone
from kanefe.kernels.compiler._numba_objects import SUPPORT
from kanefe.kernels.compiler.addresses import compiled_functions_of
from kanefe.kernels.compiler.compiled_functions import BUILT, CompiledFunction, can_keep, linker
from kanefe.kernels.compiler.entries import Entry, Pointer
from kanefe.kernels.compiler.libraries import Library
from kanefe.kernels.compiler.processors import (
    GENERATIONS,
    folder_for,
    generations_here,
    own_folder,
    processors_here,
)
from kanefe.kernels.compiler.side_by_side import BUILDER, Say, build_libraries
from kanefe.kernels.compiler.watched import end_with_parent
from kanefe.storage.kept_code import is_sound, keep, kept, opened

SHARE_OF_TRANSLATION = 0.55
"""Translation, relative to the time that building a library takes; the rest is optimisation."""


def all_compiled_functions() -> list[CompiledFunction]:
    """Return all there is to build."""
    found: dict[str, CompiledFunction] = {}
    for module in pkgutil.walk_packages(kanefe.kernels.__path__, "kanefe.kernels."):
        if module.name == BUILDER or ".compiler._numba" in module.name:  # without numba there are libraries too
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, (Entry, Pointer)):
                units = value.units
            elif isinstance(value, FunctionType) and hasattr(value, "kinds"):
                units = compiled_functions_of(value, value.kinds)
            else:
                continue
            found |= {unit.name: unit for unit in units}
    return list(found.values())


def all_libraries() -> dict[Library, list[CompiledFunction]]:
    """Return all libraries with their functions, those that take longest to translate first in each."""
    found: dict[Library, list[CompiledFunction]] = {}
    for unit in all_compiled_functions():
        found.setdefault(unit.library, []).append(unit)
    return found


def build(folder: Path, jobs: int, say: Say, generation: str | None = None) -> list[str]:
    """Build what is missing in a folder; return the names of the libraries that were built.

    Parameters
    ----------
    folder : Path
    jobs : int
        How many compilers run side by side.
    say : function (str)
        Gets lines of progress.
    generation : str, optional
        A key of `GENERATIONS`; else the processor of this machine.

    Raises
    ------
    MissingDependency
        If there is no C compiler; said before anything is built.
    subprocess.CalledProcessError
        If a compiler fails; what it said has been printed.
    """
    missing = [library for library in all_libraries() if not _is_there(folder, library)]
    if missing and shutil.which(linker()) is None:
        raise MissingDependency(
            f"the C compiler {linker()!r}", "the solver, to be built,", "apt-get install gcc libc6-dev, or CC=..."
        )
    if not missing:
        return []
    return build_libraries(missing, folder, jobs, say, () if generation is None else ("--for", generation))


def build_into_package(generations: Iterable[str], jobs: int, say: Say) -> None:
    """Build libraries for generations of processors and lay them into the package, where a wheel takes them from.

    They are kept in the user's cache: what another build made is not made again.
    """
    for generation in generations:
        with _folder_to_build_in(folder_for(generation)) as folder:
            build(folder, jobs, say, generation)
            (BUILT / generation).mkdir(parents=True, exist_ok=True)
            for library in all_libraries():
                path = kept(folder, library.file_name)
                if path is None:
                    raise FileError(f"{library.name} was built and is gone from {folder}. Remedy: build again")
                with opened(path) as (_, content):
                    (BUILT / generation / f"{library.file_name}.so").write_bytes(content)


@contextmanager
def _folder_to_build_in(wanted: Path) -> Iterator[Path]:
    """Give a folder of the cache, or one for this build alone where the cache is not the user's to write."""
    try:
        is_ours = can_keep(wanted)
    except FileError:
        is_ours = False
    if is_ours:
        yield wanted
    else:
        with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
            yield Path(folder)


def _is_there(folder: Path, library: Library) -> bool:
    """Return whether a folder has a library, whole."""
    path = kept(folder, library.file_name)
    return path is not None and is_sound(path)


def build_what_is_asked(folder: Path, generation: str | None) -> None:
    """Build libraries in this process, which does nothing else; print how far it is.

    Each line that comes has the name of one, and on how many cores it is optimised.
    """
    end_with_parent()
    if generation is not None:
        os.environ |= {"NUMBA_CPU_NAME": GENERATIONS[generation].compiler_name, "NUMBA_CPU_FEATURES": ""}
    names: SimpleQueue[str | None] = SimpleQueue()
    is_building = threading.Event()

    def listen() -> None:
        for line in sys.stdin:
            names.put(line.strip())
        if is_building.is_set():  # who asked for it is gone
            os._exit(1)
        names.put(None)

    threading.Thread(target=listen, daemon=True).start()
    build_alone()
    libraries = {library.name: (library, units) for library, units in all_libraries().items()}
    while (line := names.get()) is not None:
        name, parts = line.split()
        is_building.set()
        write_library(folder, *libraries[name], int(parts))
        is_building.clear()
        print("done", flush=True)


def write_library(folder: Path, library: Library, units: Sequence[CompiledFunction], parts: int = 1) -> None:
    """Build a library and put its file into a folder; print the share that is done, and that after the next step.

    Raises
    ------
    OSError, subprocess.SubprocessError
        If there is no C compiler.
    FileError
        If the file cannot be written.
    """
    from kanefe.kernels.compiler._numba_alone import is_alone
    from kanefe.kernels.compiler._numba_module import object_codes

    made = []
    for i, unit in enumerate(units):
        shares = [SHARE_OF_TRANSLATION * k / len(units) for k in (i, i + 1)]
        print(*shares, flush=True)
        made.append((unit.symbol, unit.compile()))
    print(SHARE_OF_TRANSLATION, 1.0, flush=True)
    codes = object_codes(made, parts)
    with tempfile.TemporaryDirectory(prefix="kanefe-") as work:
        places, whole = [Path(work) / f"{i}.o" for i in range(len(codes))], Path(work) / "whole.so"
        for place, code in zip(places, codes, strict=True):
            place.write_bytes(code)
        if not is_alone():
            places.append(Path(work) / "support.c")
            places[-1].write_text(SUPPORT)
        options = "-shared", "-fPIC", "-O2", "-Wl,-z,notext", "-Wl,-z,defs", "-Wl,-s", "-lm"
        command = [linker(), *map(str, places), *options, "-o", str(whole)]
        subprocess.run(command, check=True)
        keep(folder, library.file_name, whole.read_bytes())


def main() -> None:
    """Build, as a command."""
    parser = argparse.ArgumentParser(description="Build the kernels ahead of time.")
    parser.add_argument("--folder", type=Path, default=own_folder(), help="where to; else the cache of the user")
    parser.add_argument("--wheel", choices=("here", "all"), help="into the package, for this generation or for all")
    parser.add_argument("--jobs", type=int, default=processors_here(), help="compilers side by side")
    parser.add_argument("--for", dest="generation", choices=GENERATIONS, help=argparse.SUPPRESS)
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()

    def say(line: str) -> None:
        print(f"kanefe: {line}", flush=True)

    if options.worker:
        build_what_is_asked(options.folder, options.generation)
    elif options.wheel:
        generations = list(GENERATIONS) if options.wheel == "all" else generations_here()[:1]
        build_into_package(generations, options.jobs, say)
    else:
        options.folder.mkdir(parents=True, exist_ok=True)
        build(options.folder, options.jobs, say)


if __name__ == "__main__":
    main()
