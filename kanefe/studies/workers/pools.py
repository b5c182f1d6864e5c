"""Pools that run blocks of cases: in this process, in processes of this machine, or on an executor of the user."""

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
from kanefe.kernels.compiler.processors import processors_here
from kanefe.storage.functions_by_value import dumps_by_value
from kanefe.studies.workers.work import Work

OWN = ("serial", "processes")
"""Executors by name."""


class Pool(Protocol):
    """Runs blocks of cases.

    Attributes
    ----------
    pickles : bool
        Whether work is sent to other processes.
    by_value : bool
        Whether those processes do not import the calling script.
    takes_blocks : bool
        Whether several cases per block save time.
    deaths : tuple of exception types
        Exceptions of futures whose worker died.
    """

    pickles: bool
    by_value: bool
    takes_blocks: bool
    deaths: tuple[type[BaseException], ...]

    @property
    def workers(self) -> int:
        """Number of blocks that run at once."""
        ...

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return a future."""
        ...

    def renew(self) -> bool:
        """Continue after the death of a worker; return whether all running blocks are lost."""
        ...

    def abandon(self) -> None:
        """Stop the running blocks, if possible."""
        ...


@contextmanager
def pool_of(executor: Any, workers: int | None, cases: int) -> Iterator[Pool]:
    """Provide the pool for a name, an `Executor`, or a Dask client; with no more processes than cases.

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
    """Runs each block on submission."""

    workers, pickles, by_value, takes_blocks = 1, False, False, False
    deaths: tuple[type[BaseException], ...] = ()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Run the block; return a future that is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:  # noqa: BLE001 - the future passes it on
            future.set_exception(error)
        return future

    def renew(self) -> bool:
        """Return False: there are no workers."""
        return False

    def abandon(self) -> None:
        """Do nothing: no block is running."""


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
        """Return False: an executor of the user is not restarted."""
        return False

    def abandon(self) -> None:
        """Cancel the blocks that have not begun."""
        for future in list(self._futures):
            future.cancel()


class ProcessPool:
    """Processes of this machine, spawned, because forking is unsafe with threads.

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
        with _without_file_name_of_pipe():
            return self._executor.submit(function, *arguments)

    def renew(self) -> bool:
        """Start new processes: the death of one ends all of them."""
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._executor = self._made()
        return True

    def abandon(self) -> None:
        """End the processes."""
        for process in list((getattr(self._executor, "_processes", None) or {}).values()):
            process.terminate()

    def close(self) -> None:
        """Wait for the processes to end."""
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _made(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self.workers, mp_context=get_context("spawn"), initializer=_begin_worker)


def _script() -> str | None:
    """Return the file of the calling script; None for interactive input or a pipe."""
    path = getattr(sys.modules.get("__main__"), "__file__", None)
    return None if path is None or path.startswith("<") else str(path)


@contextmanager
def _without_file_name_of_pipe() -> Iterator[None]:
    """Keep workers from importing a piped script, whose file name is "<stdin>"."""
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
    """Ignore Ctrl-C, which the calling process handles, and end together with that process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:

        def end_with_it() -> None:
            connection.wait([parent.sentinel])
            os._exit(1)

        threading.Thread(target=end_with_it, daemon=True).start()


def check_main_can_be_imported() -> None:
    """Refuse a script that would run the study again in each worker when it is imported for its functions.

    Raises
    ------
    ModelError
        If the script runs the study outside of ``if __name__ == "__main__":``.
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
    """Return the pickle of the work for other processes.

    Functions of scripts and notebooks that workers cannot import are pickled by value with cloudpickle, others by name.

    Parameters
    ----------
    work : Work
    by_value : bool
        Whether the workers do not import the calling script.

    Raises
    ------
    ModelError
        If a part cannot be sent; the message names it.
    """
    is_typed_in = _script() is None
    dumps: Callable[[Any], bytes] = pickle.dumps
    if by_value or is_typed_in:
        dumps = dumps_by_value() or pickle.dumps
    for name, part in (("build", work.build), ("outputs", work.outputs), ("the options", work.options)):
        try:
            if dumps is pickle.dumps and is_typed_in and getattr(part, "__module__", None) == "__main__":
                raise pickle.PicklingError("it is from interactive input, not from a file")
            pickle.loads(dumps(part))
        except Exception as error:
            raise ModelError(
                f"{name} cannot be sent to other processes: {error}. Remedy: define it with def at the top of a file, "
                "make what it needs inside it, or executor='serial'"
            ) from error
    return dumps(work)


def executor_error(error: BaseException) -> SimulationError:
    """Return the error of the study for an error of a worker that no case has caused."""
    if isinstance(error, SimulationError):
        return error
    if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "kanefe":
        return SimulationError("a worker has no kanefe. Remedy: pip install it there, in the same version")
    if isinstance(error, (ImportError, AttributeError)):
        return SimulationError(
            f"a worker cannot import a module of build or outputs: {error}. Remedy: install the module there, or with "
            "Dask client.upload_file(...)"
        )
    if isinstance(error, BrokenExecutor):
        return SimulationError(
            f"processes of the executor died ({error}): on start-up, with a message of their own, or out of memory. "
            "Finished cases are in the store: run the study again to continue"
        )
    return SimulationError(
        f"the executor failed: {type(error).__name__}: {error}. Finished cases are in the store: run "
        "the study again to continue"
    )
