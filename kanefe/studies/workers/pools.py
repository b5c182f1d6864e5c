"""Where blocks of cases run: in this process, in processes of this machine, or on an executor of the user."""

from __future__ import annotations

import ast
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from kanefe.errors import ModelError, SimulationError
from kanefe.kernels.compiler.side_by_side import processors_here
from kanefe.storage.functions_by_value import dumps_by_value
from kanefe.studies.workers.work import Work

OWN = ("serial", "processes")
"""Executors by name."""


class Pool(Protocol):
    """What runs blocks.

    Attributes
    ----------
    pickles : bool
        Whether work is sent to other processes.
    by_value : bool
        Whether they do not import the script that asks.
    takes_blocks : bool
        Whether several cases at once save something.
    deaths : tuple of exception types
        Of futures whose worker died.
    """

    pickles: bool
    by_value: bool
    takes_blocks: bool
    deaths: tuple[type[BaseException], ...]

    @property
    def workers(self) -> int:
        """How many blocks run at once."""
        ...

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return a future."""
        ...

    def renew(self) -> bool:
        """Continue after the death of a worker; return whether all that was in flight is lost."""
        ...

    def abandon(self) -> None:
        """Stop what is in flight, where that is possible."""
        ...


@contextmanager
def pool_of(executor: Any, workers: int | None, cases: int) -> Iterator[Pool]:
    """Have the pool of what the user gave: a name, an `Executor`, or a Dask client; no more processes than cases.

    Raises
    ------
    ModelError
        If it is none of these.
    """
    if workers is not None and (isinstance(workers, bool) or not hasattr(workers, "__index__") or workers < 1):
        raise ModelError(f"workers must be a whole number above zero, not {workers!r}")
    if isinstance(executor, str) and executor == "serial":
        yield SerialPool()
    elif isinstance(executor, str) and executor == "processes":
        check_main_can_be_imported()
        pool = ProcessPool(min(workers or processors_here(), cases))
        try:
            yield pool
        finally:
            pool.close()
    elif isinstance(executor, Executor):
        given: int = workers or getattr(executor, "_max_workers", None) or processors_here()
        yield GivenPool(executor, given)
    elif type(executor).__module__.partition(".")[0] == "distributed":
        from kanefe.studies.workers._dask import DaskPool

        yield DaskPool(executor)
    else:
        raise ModelError(
            f"there is no executor {executor!r}. Remedy: 'serial', 'processes', an executor of concurrent.futures, or "
            "dask.distributed.Client(...)"
        )


class SerialPool:
    """Runs a block when it is handed in."""

    workers, pickles, by_value, takes_blocks = 1, False, False, False
    deaths: tuple[type[BaseException], ...] = ()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Return a future that is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:  # noqa: BLE001 - the future hands it on
            future.set_exception(error)
        return future

    def renew(self) -> bool:
        """Return False: there is nobody who could die."""
        return False

    def abandon(self) -> None:
        """Do nothing: nothing is in flight."""


class GivenPool:
    """An executor of the user, who closes it."""

    by_value, takes_blocks = False, True
    deaths: tuple[type[BaseException], ...] = ()

    def __init__(self, executor: Executor, workers: int) -> None:
        self._executor, self.workers = executor, workers
        self.pickles = not isinstance(executor, ThreadPoolExecutor)
        self._futures: set[Future[Any]] = set()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Return the executor's future."""
        future = self._executor.submit(function, *arguments)
        self._futures.add(future)
        future.add_done_callback(self._futures.discard)
        return future

    def renew(self) -> bool:
        """Return False: an executor of the user is not ours to restart."""
        return False

    def abandon(self) -> None:
        """Take back what has not begun."""
        for future in list(self._futures):
            future.cancel()


class ProcessPool:
    """Processes of this machine, started as new ones (not forked, which is impossible with threads).

    Parameters
    ----------
    workers : int
    """

    pickles, by_value, takes_blocks = True, False, True
    deaths: tuple[type[BaseException], ...] = (BrokenExecutor,)

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._executor = self._made()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Return the future of one of the processes."""
        with _without_file_that_is_none():
            return self._executor.submit(function, *arguments)

    def renew(self) -> bool:
        """Start other processes: with one, all of them are gone."""
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._executor = self._made()
        return True

    def abandon(self) -> None:
        """End the processes."""
        for process in list((getattr(self._executor, "_processes", None) or {}).values()):
            process.terminate()

    def close(self) -> None:
        """Let the processes go."""
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _made(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self.workers, mp_context=get_context("spawn"), initializer=_begin_worker)


def _script() -> str | None:
    """Return the file of the script that asks; None of what is typed in, or comes by a pipe."""
    path = getattr(sys.modules.get("__main__"), "__file__", None)
    return None if path is None or path.startswith("<") else str(path)


@contextmanager
def _without_file_that_is_none() -> Iterator[None]:
    """Keep workers from importing what was piped into Python, which calls its file "<stdin>"."""
    main = sys.modules.get("__main__")
    path = getattr(main, "__file__", None)
    if path is None or _script() is not None:
        yield
        return
    del main.__file__  # type: ignore[union-attr]
    try:
        yield
    finally:
        main.__file__ = path  # type: ignore[union-attr]


def _begin_worker() -> None:
    """Leave Ctrl-C to the process that asks, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    asking = parent_process()
    if asking is not None:

        def end_with_it() -> None:
            connection.wait([asking.sentinel])
            os._exit(1)

        threading.Thread(target=end_with_it, daemon=True).start()


def check_main_can_be_imported() -> None:
    """Refuse a script that would run the study again in each worker, which imports it for its functions.

    Raises
    ------
    ModelError
        If the script calls from outside ``if __name__ == "__main__":``.
    """
    main, path = sys.modules.get("__main__"), _script()
    if main is None or path is None or not Path(path).is_file():
        return
    frame: FrameType | None = sys._getframe()
    while frame is not None and not (frame.f_code.co_name == "<module>" and frame.f_globals is vars(main)):
        frame = frame.f_back
    if frame is None:
        return
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    guards = (node for node in tree.body if isinstance(node, ast.If) and "__name__" in ast.unparse(node.test))
    if not any(node.lineno <= frame.f_lineno <= (node.end_lineno or 0) for node in guards):
        raise ModelError(
            f"worker processes import {Path(path).name} for its functions, and would run the study again. Remedy: put "
            "what runs it under if __name__ == '__main__':, or executor='serial'"
        )


def pickled(work: Work, by_value: bool) -> bytes:
    """Return the work as it is sent to other processes.

    Functions of scripts and notebooks are sent whole by cloudpickle where workers cannot import them; others by their
    names.

    Parameters
    ----------
    work : Work
    by_value : bool
        Whether the workers do not import the script that asks.

    Raises
    ------
    ModelError
        If it cannot be sent; the message names what.
    """
    is_typed_in = _script() is None
    dumps: Callable[[Any], bytes] = pickle.dumps
    if by_value or is_typed_in:
        dumps = dumps_by_value() or pickle.dumps
    for name, part in (("build", work.build), ("outputs", work.outputs), ("the options", work.options)):
        try:
            if dumps is pickle.dumps and is_typed_in and getattr(part, "__module__", None) == "__main__":
                raise pickle.PicklingError("it was typed in, and no file has it")
            pickle.loads(dumps(part))
        except Exception as error:
            raise ModelError(
                f"{name} cannot be sent to other processes: {error}. Remedy: define it with def at the top of a file, "
                "make what it needs inside it, or executor='serial'"
            ) from error
    return dumps(work)


def told(error: BaseException) -> SimulationError:
    """Return what a worker's trouble means, which is none of a case."""
    if isinstance(error, SimulationError):
        return error
    if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "kanefe":
        return SimulationError("a worker has no kanefe. Remedy: pip install it there, in the same version")
    if isinstance(error, (ImportError, AttributeError)):
        return SimulationError(
            f"a worker cannot import what build and outputs are of: {error}. Remedy: install the module there, or with "
            "Dask client.upload_file(...)"
        )
    if isinstance(error, BrokenExecutor):
        return SimulationError(
            f"processes of the executor died ({error}): as they started, and then they have said why, or out of memory."
            " What is done is in the store: run the study again to continue"
        )
    return SimulationError(
        f"the executor failed: {type(error).__name__}: {error}. What is done is in the store: run the "
        "study again to go on"
    )
