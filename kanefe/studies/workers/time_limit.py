"""A call with a time limit, in any thread or process."""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from functools import cache
from types import FrameType
from typing import Any, TextIO

GRACE = 5.0
"""Time after its limit in which a case of a worker process may still end, s; then the process is ended."""


class TimeIsUp(BaseException):
    """A call exceeded its time limit; no ``except Exception`` of the user catches it."""


def within(seconds: float | None, call: Callable[[], Any]) -> Any:
    """Return what a call returns.

    In the main thread it is interrupted by an alarm signal, which works for Python code and its waits; a worker process
    that does not respond, because compiled code does not return, is ended. In other threads, as in Dask's workers, a
    call cannot be interrupted: it is abandoned in a separate thread until the process ends.

    Raises
    ------
    TimeIsUp
        If it has not returned after `seconds`; None means no limit.
    """
    if seconds is None:
        return call()
    if threading.current_thread() is threading.main_thread() and hasattr(signal, "setitimer"):
        return _with_alarm(seconds, call)
    return _in_thread(seconds, call)


def _with_alarm(seconds: float, call: Callable[[], Any]) -> Any:
    def ring(number: int, frame: FrameType | None) -> None:
        raise TimeIsUp

    is_worker = multiprocessing.parent_process() is not None
    began, handler = time.monotonic(), signal.signal(signal.SIGALRM, ring)
    before = signal.setitimer(signal.ITIMER_REAL, seconds)[0]
    if is_worker:
        faulthandler.dump_traceback_later(seconds + GRACE, exit=True, file=_nowhere())
    try:
        return call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handler)
        if is_worker:
            faulthandler.cancel_dump_traceback_later()
        if before:  # an alarm of the user
            signal.setitimer(signal.ITIMER_REAL, max(before - (time.monotonic() - began), 1e-3))


@cache
def _nowhere() -> TextIO:
    return open(os.devnull, "w")


def _in_thread(seconds: float, call: Callable[[], Any]) -> Any:
    found: list[Any] = []
    raised: list[BaseException] = []

    def run() -> None:
        try:
            found.append(call())
        except BaseException as error:  # noqa: BLE001 - raised below
            raised.append(error)

    thread = threading.Thread(target=run, name="a case of a study", daemon=True)
    thread.start()
    thread.join(seconds)
    if raised:
        raise raised[0]
    if not found:
        raise TimeIsUp
    return found[0]
