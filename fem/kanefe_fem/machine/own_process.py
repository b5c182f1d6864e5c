"""Work of a library in a process of its own: it can be stopped, has a state of its own, and may crash.

The child answers requests one after the other and keeps its state between them; it ends with its parent.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator
from importlib import import_module
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import IO, Any, NoReturn

from kanefe.errors import FileError, MeshError, outside
from kanefe.storage.watched import is_watched, progress_bar

START = "import sys; sys.path[:] = {path!r}; from kanefe_fem.machine.own_process import serve; serve({module!r}, {end})"
TAIL = 600
"""Last characters of what a crashed child wrote that its error quotes."""


class ProcessEnded(FileError):
    """A process ended while it worked: it crashed, was killed, or a library in it gave up."""


class OwnProcess:
    """A process in which the functions of a module work on a state of their own.

    Parameters
    ----------
    module : str
        Its functions take what its context manager ``opened()`` yields, then the arguments of `ask`, and last a
        function that they tell each stage of their work.
    what : str
        What the process works on, for messages.
    most_seconds : float, optional
        Time after which it is stopped.
    """

    def __init__(self, module: str, what: str, most_seconds: float | None = None) -> None:
        self._module, self._what = module, what
        self._most = most_seconds
        self._end = None if most_seconds is None else time.monotonic() + most_seconds
        self._stage = "start"

    def __enter__(self) -> OwnProcess:
        self._answers, child_end = Pipe()
        self._said: IO[bytes] = tempfile.TemporaryFile()
        code = START.format(path=sys.path, module=self._module, end=child_end.fileno())
        self._child = subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.PIPE,  # never written to: its end tells the child that the parent is gone
            stdout=self._said,
            stderr=self._said,
            pass_fds=[child_end.fileno()],
            start_new_session=True,  # Ctrl-C reaches the parent alone, which stops the child
        )
        child_end.close()
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()
        self._child.wait()
        if self._child.stdin is not None:
            self._child.stdin.close()
        self._answers.close()
        self._said.close()

    def restart(self) -> None:
        """Start the process again, in its first state."""
        self.__exit__()
        self.__enter__()

    def ask(self, function: str, *args: Any) -> Any:
        """Return the answer of a function of the module; its warnings and errors are those of the caller.

        Raises
        ------
        MeshError
            If the time is over.
        ProcessEnded
            If the process ended; `restart` it to go on.
        """
        self._answers.send((function, args))
        with contextlib.closing(_Bar(self._what)) as bar:
            while True:
                left = None if self._end is None else self._end - time.monotonic()
                if left is not None and (left <= 0.0 or not self._answers.poll(left)):
                    raise MeshError(
                        f"{self._what}: stopped after most_seconds={self._most:g} while it was at: {self._stage}. "
                        "Remedy: a larger size, fewer parts, or more time"
                    )
                try:
                    kind, value = self._answers.recv()
                except (EOFError, ConnectionResetError):
                    self._refuse_crash()
                if kind == "stage":
                    self._stage = value
                    bar.tell(value)
                elif kind == "warning":
                    text, category = value
                    warnings.warn(text, category, stacklevel=outside())
                elif kind == "error":
                    raise value
                else:
                    return value

    def _refuse_crash(self) -> NoReturn:
        self._child.wait()
        self._said.seek(0)
        tail = self._said.read()[-TAIL:].decode("utf-8", "replace").strip()
        raise ProcessEnded(
            f"{self._what}: the process that works on it ended with code {self._child.returncode} at: {self._stage}"
            + (f" ({tail})" if tail else "")
            + ". Remedy: memory may be short, so a larger size; or the geometry is damaged: repair it where it was made"
        )


class _Bar:
    """What is done at the moment, on a terminal or in a notebook."""

    def __init__(self, what: str) -> None:
        layout = "{desc} [{elapsed}]"
        self._bar = progress_bar(desc=what, bar_format=layout, leave=False, delay=0.5) if is_watched() else None
        self._what = what

    def tell(self, stage: str) -> None:
        if self._bar is not None:
            self._bar.set_description(f"{self._what}: {stage}")

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


def serve(module: str, descriptor: int) -> None:
    """Answer the requests of the parent until it is gone: the main function of the child."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    answers: Connection = Connection(descriptor)
    work = import_module(module)
    with work.opened() as state, contextlib.suppress(EOFError):
        while True:
            function, args = answers.recv()
            with _told_warnings(answers):
                try:
                    done = getattr(work, function)(state, *args, lambda text: answers.send(("stage", text)))
                    answer = ("answer", done)
                except Exception as problem:  # noqa: BLE001 - it is raised again in the parent
                    answer = ("error", problem)
            answers.send(answer)


@contextlib.contextmanager
def _told_warnings(answers: Connection) -> Iterator[None]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        yield
    for one in found:
        if "kanefe" in one.category.__module__:
            answers.send(("warning", (str(one.message), one.category)))


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(1)
