"""Units built in processes of their own, side by side, with a line of progress every few seconds."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

STILL = 5.0
"""Time after which a line reports that the build continues, s."""

BUILDER = "kanefe.kernels.compiler.build"
"""Module whose command builds compiled functions by their names."""

STEPS = "advance_", "interpolate_", "integrate"
"""First parts of the names of compiled functions that make steps: they share little with evaluations."""

Say = Callable[[str], None]


def processors_here() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def build_by_name(
    batches: Sequence[Sequence[str]], folder: Path, jobs: int, say: Say, options: Sequence[str] = ()
) -> None:
    """Build units in a folder; those of a batch share a process, and what they have in common is compiled once.

    Parameters
    ----------
    batches : sequence of sequences of str
        Names of units, those that take longest first.
    folder : Path
    jobs : int
        How many processes run side by side.
    say : function (str)
        Gets lines of progress.
    options : sequence of str, optional
        More of the command.

    Raises
    ------
    subprocess.CalledProcessError
        If one fails; what it said has been printed.
    """
    count, waiting = sum(map(len, batches)), list(batches)
    began, done = time.monotonic(), 0
    failed: list[subprocess.CalledProcessError] = []
    last_said, lock = began, threading.Lock()

    def tell(text: str = "") -> None:
        nonlocal last_said
        last_said = time.monotonic()
        say(f"preparing the solver: {done} of {count} parts, {last_said - began:.0f} s, once{text}")

    def work() -> None:
        nonlocal done
        while True:
            with lock:
                if not waiting or failed:
                    return
                names = waiting.pop(0)
            command = [sys.executable, "-m", BUILDER, "--folder", str(folder), *options, "--only", *names]
            with subprocess.Popen(command, env=_environment(), stdout=subprocess.PIPE, text=True) as process:
                for line in process.stdout or ():
                    with lock:
                        done += 1
                        tell(f" ({line.strip()})")
            if process.returncode:
                failed.append(subprocess.CalledProcessError(process.returncode, command))

    tell()
    threads = [threading.Thread(target=work) for _ in range(min(jobs, len(batches)))]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        time.sleep(0.05)
        with lock:
            if time.monotonic() - last_said > STILL:
                tell()
    if failed:
        raise failed[0]


def _environment() -> dict[str, str]:
    """Return what the processes see: this package first, wherever this process found it."""
    package = str(Path(__file__).parents[3])
    paths = os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))
    return os.environ | {"PYTHONPATH": paths, "KANEFE_JIT": "1", "NUMBA_NUM_THREADS": "1"}


def batches_of(names: Sequence[str]) -> list[list[str]]:
    """Return names of units in batches that have most of what they call in common, those that take longest first."""
    kinds: dict[tuple[bool, bool, bool], list[str]] = {}
    for name in names:
        kind = "complex" in name, "flexible" in name, name.startswith(STEPS)
        kinds.setdefault(kind, []).append(name)
    order = [(False, True, False), (True, True, False), (False, False, False), (False, False, True)]
    return [kinds[kind] for kind in sorted(kinds, key=lambda kind: order.index(kind) if kind in order else len(order))]
