"""The process that draws pictures of meshes. It stays for the next jobs, because it takes a second to start.

It reads names of folders with jobs, one a line, and replies to each when it is done. It ends when no job has come for a
while, or when its parent has ended.
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
    """A process that draws; it is started if none is running."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._errors: IO[bytes] | None = None
        self._owner = 0
        self._lock = threading.Lock()

    def draw(self, folder: Path) -> str:
        """Draw the job in a folder; return an error message, empty if all went well."""
        with self._lock:
            if self._process is not None and self._is_ours() and self._has_drawn(self._process, folder):
                return ""
            self.end()
            process = self._started()
            if self._has_drawn(process, folder):
                return ""
            message = self._last_error(process)
            self.end()
            return message

    def end(self) -> None:
        """End the process, if this one has started it."""
        process, self._process = self._process, None
        if process is None or not self._is_ours():
            return
        for stream in (process.stdin, process.stdout, self._errors):
            if stream is not None:
                with _without_sigpipe(), contextlib.suppress(OSError):  # a broken pipe
                    stream.close()
        process.kill()
        process.wait()

    def _is_ours(self) -> bool:
        return self._owner == os.getpid()  # a forked process does not own the one of its parent

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

    def _has_drawn(self, process: subprocess.Popen[str], folder: Path) -> bool:
        """Send a job; return whether the process has drawn it."""
        if process.stdin is None or process.stdout is None:
            raise TypeError("the process has pipes")
        late = threading.Timer(SECONDS, process.kill)
        late.start()
        try:
            with _without_sigpipe():
                process.stdin.write(f"{folder}\n")
                process.stdin.flush()
            return process.stdout.readline().strip() == DONE
        except (OSError, ValueError):  # the process has ended
            return False
        finally:
            late.cancel()

    def _last_error(self, process: subprocess.Popen[str]) -> str:
        """Return the last line of the errors of a process that stopped."""
        process.wait()
        if self._errors is None:
            return ""
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it stopped without a message"


@contextlib.contextmanager
def _without_sigpipe() -> Iterator[None]:
    """Block SIGPIPE in this thread: Python ignores it, but PETSc ends the process on it."""
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
    """Draw the jobs named on the standard input and reply to each, until none comes any more."""
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
        draw(Path(line.rstrip("\n")))
        print(DONE, flush=True)
