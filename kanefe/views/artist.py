"""The process that draws pictures of meshes. It is kept for the next ones, as it takes a second to start.

It reads names of folders with jobs, a line each, and answers each when it is done; when nothing has come for a while,
or nobody is left to ask, it ends.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

SECONDS = 300
"""Time after which drawing is given up, s."""

IDLE_SECONDS = 60
"""Time after which an idle drawing process ends, s."""

DONE = "done"
"""Reply of the drawing process."""


class Artist:
    """A process that draws, started where none is at hand that can be asked."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._errors: IO[bytes] | None = None
        self._owner = 0
        self._lock = threading.Lock()

    def draw(self, folder: Path) -> str:
        """Draw the job in a folder; return what is wrong, or nothing."""
        with self._lock:
            if self._process is not None and self._is_ours() and self._asked(self._process, folder):
                return ""
            self.end()
            process = self._started()
            if self._asked(process, folder):
                return ""
            said = self._said(process)
            self.end()
            return said

    def end(self) -> None:
        """End the process, if there is one of our own."""
        process, self._process = self._process, None
        if process is None or not self._is_ours():
            return
        for stream in (process.stdin, process.stdout, self._errors):
            if stream is not None:
                with _unheard(), contextlib.suppress(OSError):  # a broken pipe
                    stream.close()
        process.kill()
        process.wait()

    def _is_ours(self) -> bool:
        return self._owner == os.getpid()  # and not that of the process from which this one was forked

    def _started(self) -> subprocess.Popen[str]:
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = {**os.environ, "PYTHONPATH": path, "PYVISTA_OFF_SCREEN": "true"}
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - it lives as long as the process
        self._process = subprocess.Popen(
            [sys.executable, "-m", "kanefe.views._pyvista"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment,
            cwd=tempfile.gettempdir(),
            text=True,
        )
        self._owner = os.getpid()
        return self._process

    def _asked(self, process: subprocess.Popen[str], folder: Path) -> bool:
        """Return whether the process has drawn a job."""
        if process.stdin is None or process.stdout is None:
            raise TypeError("the process has pipes")
        late = threading.Timer(SECONDS, process.kill)
        late.start()
        try:
            with _unheard():
                process.stdin.write(f"{folder}\n")
                process.stdin.flush()
            return process.stdout.readline().strip() == DONE
        except (OSError, ValueError):  # it has ended
            return False
        finally:
            late.cancel()

    def _said(self, process: subprocess.Popen[str]) -> str:
        """Return the last line of what a process that stopped has said."""
        process.wait()
        if self._errors is None:
            return ""
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it stopped without a message"


@contextlib.contextmanager
def _unheard() -> Iterator[None]:
    """Keep the signal of a broken pipe from this thread: Python ignores it, PETSc ends the process on it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    try:
        yield
    finally:
        if signal.SIGPIPE not in before:
            if signal.SIGPIPE in signal.sigpending():
                signal.sigwait({signal.SIGPIPE})
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


ARTIST = Artist()
"""The drawing process of this process."""

atexit.register(ARTIST.end)


def serve(draw: Callable[[Path], None]) -> None:
    """Draw what is asked for on the standard input, and answer, until nothing comes any more."""
    for folder in _asked_for():
        draw(folder)
        print(DONE, flush=True)


def _asked_for() -> Iterator[Path]:
    lines: queue.Queue[str] = queue.Queue()

    def listen() -> None:
        for line in sys.stdin:
            lines.put(line)
        lines.put("")

    threading.Thread(target=listen, daemon=True).start()
    while True:
        try:
            line = lines.get(timeout=IDLE_SECONDS)
        except queue.Empty:
            return
        if not line:
            return
        yield Path(line.rstrip("\n"))
