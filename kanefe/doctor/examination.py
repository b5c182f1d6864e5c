"""Examination by ``kanefe doctor``, as text and as JSON."""

from __future__ import annotations

import math
import os
import platform
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, TextIO

from kanefe._version import __version__
from kanefe.bodies import cache
from kanefe.checks.table import check_target, write_as_json
from kanefe.doctor.parts import Found, Search
from kanefe.doctor.routes import NEEDED, Solve, solves
from kanefe.doctor.stores import BuiltKernels, CacheStore, kernels, stores
from kanefe.kernels.compiler.processors import processors_here

VARIABLES = "KANEFE_CACHE", "KANEFE_CACHE_DIR", "KANEFE_CACHE_GB", "KANEFE_JIT", "CC", "OMP_NUM_THREADS"
"""Environment variables that are reported if they are set."""

TO_BUILD = "kanefe prepare"
WITH_NUMBA = "Remedy: pip install 'kanefe[compile]'"


@dataclass(frozen=True)
class Examination:
    """Findings of an examination.

    Attributes
    ----------
    parts : list of Found
    kernels : BuiltKernels
    stores : list of CacheStore
    solves : list of Solve
        Those whose kernels are built.
    seconds : float
    """

    parts: list[Found]
    kernels: BuiltKernels
    stores: list[CacheStore]
    solves: list[Solve]
    seconds: float

    @property
    def cannot_build(self) -> bool:
        """Whether kernels are missing and cannot be built."""
        works = any(found.part.module == "numba" and found.state == "works" for found in self.parts)
        return self.kernels.is_on and not self.kernels.are_ready and not works

    @property
    def faults(self) -> list[str]:
        """A sentence for each installed part that does not work."""
        found = [
            f"{_name(part)} is {part.state}: {part.trouble or part.part.command}"
            for part in self.parts
            if part.is_fault
        ]
        if self.cannot_build:
            found.append(f"the kernels are not built, and numba, which builds them, does not work. {WITH_NUMBA}")
        found += [f"{store.folder} cannot be written" for store in self.stores if not store.can_be_written]
        of_solves = [solve for solve in self.solves if solve.is_fault]
        return found + [f"the route {solve.route!r} of {solve.scene!r} {_fault(solve)}" for solve in of_solves]


def doctor(json_path: str | None = None) -> int:
    """Examine the installation and print the findings.

    Parameters
    ----------
    json_path : str, optional
        File for the findings as JSON; "-": JSON goes to the standard output and the text to the standard error.

    Returns
    -------
    int
        Exit code: 1 if an installed part does not work, else 0. A missing optional package is no fault.

    Raises
    ------
    FileError
        If the JSON file cannot be written; checked first.
    """
    check_target(json_path)
    stream = sys.stderr if json_path == "-" else sys.stdout
    began = time.perf_counter()
    search = Search()
    _print_machine(stream)
    of_kernels = kernels()
    done = list(solves(of_kernels.missing)) if of_kernels.is_on else []
    examination = Examination(search.results(), of_kernels, stores(), done, time.perf_counter() - began)
    _print_parts(examination.parts, stream)
    _print_stores(examination, stream)
    _print_solves(examination, stream)
    _print_verdict(examination, stream)
    if json_path is not None:
        write_as_json(_record(examination), json_path)
    return int(bool(examination.faults))


def _print_machine(stream: TextIO) -> None:
    count = processors_here()
    of = f"{platform.system()} {platform.machine()}, {count} processor{'s' if count > 1 else ''}"
    print(f"kanefe {__version__}, Python {platform.python_version()}, {of}", file=stream)
    print(f"{'':9}{sys.executable}", file=stream, flush=True)
    for name in VARIABLES:
        if name in os.environ:
            print(f"{'':9}{name}={os.environ[name]}", file=stream)


def _print_parts(parts: Sequence[Found], stream: TextIO) -> None:
    print("\npackages", file=stream)
    for found in sorted(parts, key=lambda found: ("broken", "works", "missing").index(found.state)):
        note = found.trouble or f"{found.part.brings}{'' if found.state == 'works' else ': ' + found.part.command}"
        version = found.version[:12] if found.part.module != "cc" else ""
        print(f"  {found.state:8} {found.part.module:14} {version:12} {note}", file=stream)


def _print_stores(examination: Examination, stream: TextIO) -> None:
    of = examination.kernels
    where = f", {of.from_wheel} of them came with the package" if of.from_wheel else ""
    print(f"\nkernels\n  {of.built} of {of.count} libraries built for this processor{where}", file=stream)
    if not of.is_on:
        print("  KANEFE_JIT=0: they run as plain Python, some 100 times slower", file=stream)
    elif not of.are_ready and not examination.cannot_build:
        print(f"  the rest is built when a run needs it, or now by: {TO_BUILD}", file=stream)
    print("\ncache", file=stream)
    for store in examination.stores:
        note = "" if store.can_be_written else "   cannot be written: KANEFE_CACHE_DIR names another folder"
        size = f"{store.files} files, {1e-6 * store.size:.1f} MB"
        print(f"  {store.what:18} {size:22} {store.folder}{note}", file=stream)
    state = f"at most {1e-9 * cache.limit():g} GB are kept" if cache.is_on() else "KANEFE_CACHE=0: no bodies are kept"
    print(f"  {'':18} {state}", file=stream)


def _print_solves(examination: Examination, stream: TextIO) -> None:
    print("\nsolves, the first of each kind with what it loads", file=stream)
    if not examination.kernels.is_on:
        print("  none: without compiled kernels there is one route", file=stream)
    elif not NEEDED.isdisjoint(examination.kernels.missing):
        remedy = WITH_NUMBA if examination.cannot_build else f"Remedy: {TO_BUILD}"
        print(f"  none: the kernels are not built. {remedy}", file=stream)
    for solve in examination.solves:
        agreement = f"as {solve.against} to {solve.difference:.0e}" if solve.against else ""
        note = f"   {_fault(solve)}" if solve.is_fault else ""
        print(f"  {solve.route:27} {solve.scene:27} {solve.seconds:6.2f} s  {agreement}{note}".rstrip(), file=stream)


def _print_verdict(examination: Examination, stream: TextIO) -> None:
    faults = examination.faults
    print(
        f"\n{len(faults) or 'no'} fault{'' if len(faults) == 1 else 's'}, in {examination.seconds:.1f} s", file=stream
    )
    for fault in faults:
        print(f"  {fault}", file=stream)


def _name(found: Found) -> str:
    return f"{found.part.module} {found.version}".strip()


def _fault(solve: Solve) -> str:
    if solve.trouble:
        return f"failed: {solve.trouble}"
    return f"differs from {solve.against} by {solve.difference:.1e}, at most {solve.limit:.0e} was expected"


def _record(examination: Examination) -> dict[str, Any]:
    """Return the findings in types of JSON."""
    return {
        "kanefe": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": [
            asdict(found.part) | {"state": found.state, "version": found.version, "trouble": found.trouble}
            for found in examination.parts
        ],
        "kernels": asdict(examination.kernels),
        "cache": [asdict(store) | {"folder": str(store.folder)} for store in examination.stores],
        "solves": [_without_nan(asdict(solve)) for solve in examination.solves],
        "faults": examination.faults,
        "seconds": examination.seconds,
    }


def _without_nan(values: dict[str, Any]) -> dict[str, Any]:
    return {name: None if isinstance(x, float) and math.isnan(x) else x for name, x in values.items()}
