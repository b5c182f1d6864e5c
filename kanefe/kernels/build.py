"""All kernels built ahead of time, side by side: ``python -m kanefe.kernels.build``, or ``kanefe kernels``."""

from __future__ import annotations

import argparse
import importlib
import os
import pkgutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import kanefe.kernels
from kanefe.kernels.addresses import units_of
from kanefe.kernels.entries import Entry, Pointer
from kanefe.kernels.units import BUILT, Unit, file_name, own_folder, write_unit

NAME = "kanefe.kernels.build"
STILL = 5.0
"""Seconds after which a line says that it goes on."""

NOT_OF_FLEXIBLE = (
    *("advance_keeping", "interpolate_keeping", "balance-", "close", "evaluate-between", "evaluate_planar"),
    *("bushing", "curve", "rope", "spring"),
)
"""How the names of units begin that trees of flexible bodies do without."""

PROCESSORS = {"x86-64-v3": "haswell", "x86-64": "x86-64"}
"""What the compiler calls the generations of processors that wheels are made for."""


def all_units() -> list[Unit]:
    """Return all there is to build."""
    found: dict[str, Unit] = {}
    for module in pkgutil.walk_packages(kanefe.kernels.__path__, "kanefe.kernels."):
        if module.name == NAME:
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Entry):
                units = [value.unit(variant) for variant in value.variants]
            elif isinstance(value, Pointer):
                units = [value.unit]
            elif hasattr(value, "kinds"):
                units = units_of(value, value.kinds)
            else:
                continue
            found |= {unit.name: unit for unit in units}
    return list(found.values())


def jobs_here() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def build(
    folder: Path, jobs: int, say: Callable[[str], None], processor: str | None = None, is_flexible: bool = False
) -> int:
    """Build what is missing in a folder; return how many units were built.

    Parameters
    ----------
    folder : Path
    jobs : int
        How many compilers run side by side.
    say : function (str)
        Gets lines of progress.
    processor : str, optional
        A key of `PROCESSORS`; else the one of this machine.
    is_flexible : bool
        Whether to build what a tree of flexible bodies needs, and leave the rest to later.

    Raises
    ------
    subprocess.CalledProcessError
        If a compiler fails; what it said has been printed.
    """
    units = [unit for unit in all_units() if not (is_flexible and unit.name.startswith(NOT_OF_FLEXIBLE))]
    missing = [unit for unit in units if not (folder / file_name(unit)).is_file()]
    if not missing:
        return 0
    environment = os.environ | {"KANEFE_JIT": "1", "NUMBA_NUM_THREADS": "1"}
    if processor is not None:
        environment |= {"NUMBA_CPU_NAME": PROCESSORS[processor], "NUMBA_CPU_FEATURES": ""}
    began, done, failed = time.monotonic(), [0], []
    last_said = [began]
    lock = threading.Lock()

    def tell(text: str) -> None:
        last_said[0] = time.monotonic()
        say(f"preparing the solver: {done[0]} of {len(missing)} parts, {last_said[0] - began:.0f} s, once{text}")

    def run(batch: Sequence[Unit]) -> None:
        names = [unit.name for unit in batch]
        command = [sys.executable, "-m", NAME, "--folder", str(folder), "--only", *names]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
            for line in process.stdout or ():
                with lock:
                    done[0] += 1
                    tell(f" ({line.strip()})")
        if process.returncode:
            failed.append(subprocess.CalledProcessError(process.returncode, command))

    def work() -> None:
        while True:
            with lock:
                if not batches or failed:
                    return
                batch = batches.pop(0)
            run(batch)

    batches = _batches(missing)
    tell("")
    threads = [threading.Thread(target=work) for _ in range(min(jobs, len(batches)))]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        time.sleep(0.1)
        with lock:
            if time.monotonic() - last_said[0] > STILL:
                tell("")
    if failed:
        raise failed[0]
    return len(missing)


def _batches(units: Sequence[Unit]) -> list[list[Unit]]:
    """Return units that share most of what they call, those that take longest first."""
    kinds: dict[tuple[bool, bool], list[Unit]] = {}
    for unit in units:
        kinds.setdefault(("complex" in unit.name, "flexible" in unit.name), []).append(unit)
    order = [(False, True), (True, True), (False, False), (True, False)]
    return [kinds[kind] for kind in order if kind in kinds]


def main() -> None:
    """Build, as a command."""
    parser = argparse.ArgumentParser(description="Build the kernels ahead of time.")
    parser.add_argument("--folder", type=Path, help="where to; else the cache of the user")
    parser.add_argument("--processor", choices=PROCESSORS, help="generation of processors; else this machine's own")
    parser.add_argument("--jobs", type=int, default=jobs_here(), help="compilers side by side")
    parser.add_argument("--flexible", action="store_true", help="what trees of flexible bodies need, and no more")
    parser.add_argument("--only", nargs="*", help=argparse.SUPPRESS)
    options = parser.parse_args()
    folder = options.folder or (own_folder() if options.processor is None else BUILT / options.processor)
    if options.only:
        wanted = set(options.only)
        for unit in all_units():
            if unit.name in wanted:
                write_unit(folder / file_name(unit), unit.compile())
                print(unit.name, flush=True)
        return
    build(folder, options.jobs, lambda line: print(f"kanefe: {line}", flush=True), options.processor, options.flexible)


if __name__ == "__main__":
    main()
