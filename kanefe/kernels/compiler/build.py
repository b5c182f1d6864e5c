"""All kernels built ahead of time, side by side: ``kanefe prepare``, or ``make kernels``."""

from __future__ import annotations

import argparse
import importlib
import os
import pkgutil
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType

import kanefe.kernels
from kanefe.errors import FileError, MissingDependency
from kanefe.kernels.compiler._numba_alone import build_alone
from kanefe.kernels.compiler.addresses import compiled_functions_of
from kanefe.kernels.compiler.compiled_functions import (
    BUILT,
    GENERATIONS,
    CompiledFunction,
    can_keep,
    folder_for,
    generations_here,
    linker,
    name_of,
    own_folder,
    write_compiled_function,
)
from kanefe.kernels.compiler.entries import Entry, Pointer
from kanefe.kernels.compiler.side_by_side import BUILDER, Say, batches_of, build_by_name, processors_here
from kanefe.storage.kept_code import is_sound, kept, opened


def all_compiled_functions() -> list[CompiledFunction]:
    """Return all there is to build."""
    found: dict[str, CompiledFunction] = {}
    for module in pkgutil.walk_packages(kanefe.kernels.__path__, "kanefe.kernels."):
        if module.name == BUILDER:
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Entry):
                units = [value.unit(variant) for variant in value.variants]
            elif isinstance(value, Pointer):
                units = [value.unit]
            elif isinstance(value, FunctionType) and hasattr(value, "kinds"):
                units = compiled_functions_of(value, value.kinds)
            else:
                continue
            found |= {unit.name: unit for unit in units}
    return list(found.values())


def build(folder: Path, jobs: int, say: Say, generation: str | None = None, only_first: bool = False) -> int:
    """Build what is missing in a folder; return how many units were built.

    Parameters
    ----------
    folder : Path
    jobs : int
        How many compilers run side by side.
    say : function (str)
        Gets lines of progress.
    generation : str, optional
        A key of `GENERATIONS`; else the processor of this machine.
    only_first : bool
        Whether to build what is marked with `built_first`, and leave the rest to later.

    Raises
    ------
    MissingDependency
        If there is no C compiler; said before anything is built.
    subprocess.CalledProcessError
        If a compiler fails; what it said has been printed.
    """
    missing = [
        unit.name
        for unit in all_compiled_functions()
        if (unit.is_first or not only_first) and not _is_there(folder, unit)
    ]
    if missing and shutil.which(linker()) is None:
        raise MissingDependency(
            f"the C compiler {linker()!r}", "the solver, to be built,", "apt-get install gcc libc6-dev, or CC=..."
        )
    if missing:
        build_by_name(batches_of(missing), folder, jobs, say, () if generation is None else ("--for", generation))
    return len(missing)


def build_into_package(generations: Iterable[str], jobs: int, say: Say) -> None:
    """Build units of generations of processors and lay them into the package, where a wheel takes them from.

    They are kept in the user's cache: what another build made is not made again.
    """
    for generation in generations:
        with _folder_to_build_in(folder_for(generation)) as folder:
            build(folder, jobs, say, generation)
            (BUILT / generation).mkdir(parents=True, exist_ok=True)
            for unit in all_compiled_functions():
                path = kept(folder, name_of(unit))
                if path is None:
                    raise FileError(f"{unit.name} was built and is gone from {folder}. Remedy: build again")
                with opened(path) as (_, content):
                    (BUILT / generation / f"{name_of(unit)}.so").write_bytes(content)


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


def _is_there(folder: Path, unit: CompiledFunction) -> bool:
    """Return whether a folder has a unit, whole."""
    path = kept(folder, name_of(unit))
    return path is not None and is_sound(path)


def write_named(names: set[str], folder: Path, generation: str | None) -> None:
    """Build units in this process, which does nothing else, and print the name of each that is done."""
    if generation is not None:
        os.environ |= {"NUMBA_CPU_NAME": GENERATIONS[generation].compiler_name, "NUMBA_CPU_FEATURES": ""}
    build_alone()
    for unit in all_compiled_functions():
        if unit.name in names:
            write_compiled_function(folder, unit)
            print(unit.name, flush=True)


def main() -> None:
    """Build, as a command."""
    parser = argparse.ArgumentParser(description="Build the kernels ahead of time.")
    parser.add_argument("--folder", type=Path, default=own_folder(), help="where to; else the cache of the user")
    parser.add_argument("--wheel", choices=("here", "all"), help="into the package, for this generation or for all")
    parser.add_argument("--jobs", type=int, default=processors_here(), help="compilers side by side")
    parser.add_argument("--first", action="store_true", help="what trees of flexible bodies need, and no more")
    parser.add_argument("--for", dest="generation", choices=GENERATIONS, help=argparse.SUPPRESS)
    parser.add_argument("--only", nargs="*", help=argparse.SUPPRESS)
    options = parser.parse_args()

    def say(line: str) -> None:
        print(f"kanefe: {line}", flush=True)

    if options.only:
        write_named(set(options.only), options.folder, options.generation)
    elif options.wheel:
        generations = list(GENERATIONS) if options.wheel == "all" else generations_here()[:1]
        build_into_package(generations, options.jobs, say)
    else:
        build(options.folder, options.jobs, say, only_first=options.first)


if __name__ == "__main__":
    main()
