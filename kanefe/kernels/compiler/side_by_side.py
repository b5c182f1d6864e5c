"""Libraries built in processes of their own, side by side: one build at a time in a folder, with its progress told."""

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue

from kanefe.kernels.compiler.libraries import Library
from kanefe.kernels.compiler.progress import BuildProgress
from kanefe.storage.kept_code import kept

BUILDER = "kanefe.kernels.compiler.build"
"""Module whose command builds libraries by their names."""

LOCK = ".building"
"""File in a folder of libraries that the process holds which builds there."""

Say = Callable[[str], None]


def build_libraries(
    libraries: Sequence[Library], folder: Path, jobs: int, say: Say, options: Sequence[str] = ()
) -> list[str]:
    """Build what another process has not built meanwhile; return the names of what was built here.

    Parameters
    ----------
    libraries : sequence of Library
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
    with _alone_in(folder, say):
        missing = [one for one in libraries if kept(folder, one.file_name) is None]
        if missing:
            _build(sorted(missing, key=lambda one: -one.seconds), folder, jobs, say, options)
    return [one.name for one in missing]


def _build(libraries: Sequence[Library], folder: Path, jobs: int, say: Say, options: Sequence[str]) -> None:
    waiting, failed = [*libraries], list[subprocess.CalledProcessError]()
    progress, lock = BuildProgress(libraries, min(jobs, len(libraries)), say), threading.Lock()
    lines: SimpleQueue[tuple[str, str]] = SimpleQueue()
    share = sum(one.seconds for one in libraries) / jobs if hasattr(os, "fork") else float("inf")  # of each core
    command = [sys.executable, "-m", BUILDER, "--folder", str(folder), *options, "--worker"]

    def work() -> None:
        with subprocess.Popen(
            command, env=_environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as process:
            while not failed:
                with lock:
                    library = waiting.pop(0) if waiting else None
                if library is None:
                    break
                lines.put((library.name, ""))
                print(library.name, jobs if library.seconds > share else 1, file=process.stdin, flush=True)
                for line in process.stdout or ():
                    lines.put((library.name, line.strip()))
                    if line.startswith("done"):
                        break
                else:
                    failed.append(subprocess.CalledProcessError(process.wait(), command))
            if failed:
                process.terminate()

    threads = [threading.Thread(target=work, daemon=True) for _ in range(min(jobs, len(libraries)))]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        try:
            progress.note(*lines.get(timeout=0.1))
        except Empty:
            progress.tell()
    if failed:
        raise failed[0]
    progress.end()


@contextmanager
def _alone_in(folder: Path, say: Say) -> Iterator[None]:
    """Wait until no other process builds in a folder; where the system cannot lock files, several may."""
    try:
        import fcntl

        file = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    except (ImportError, OSError):
        yield
        return
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            say("another process is preparing the solver: waiting for it")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
    finally:
        os.close(file)


def _environment() -> dict[str, str]:
    """Return what the processes see: this package first, wherever this process found it."""
    package = str(Path(__file__).parents[3])
    paths = os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))
    return os.environ | {"PYTHONPATH": paths, "KANEFE_JIT": "1", "NUMBA_NUM_THREADS": "1"}
