"""A child that is forked while another thread holds a lock of the package does not wait for that thread."""

from __future__ import annotations

import os
import sys
import threading
import time
import warnings
from collections.abc import Callable
from functools import cached_property
from types import ModuleType

import numpy as np
import pytest

import kanefe  # noqa: F401

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks")


class Slow:
    """What a thread computes, for as long as it takes."""

    def __init__(self, wait: Callable[[], object]) -> None:
        self._wait = wait

    @cached_property
    def value(self) -> float:
        self._wait()
        return 1.0


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return a module of the package with a class, and a lock."""
    made = ModuleType("kanefe.slow")
    made.Slow, made.lock = Slow, threading.RLock()  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "kanefe.slow", made)
    return made


def ends(work: Callable[[], object]) -> bool:
    """Return whether a forked child ends its work within some seconds."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks beside threads, Python 3.12
        child = os.fork()
    if child == 0:
        work()
        os._exit(0)
    last = time.monotonic() + 5.0
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if time.monotonic() > last:
            os.kill(child, 9)
            os.waitpid(child, 0)
            return False
        time.sleep(0.005)
    return True


@pytest.mark.parametrize("what", ["a property", "a lock"])
def test_a_child_does_not_wait_for_a_thread_that_it_has_not(what: str, module: ModuleType) -> None:
    begun, may_end = threading.Event(), threading.Event()

    def held() -> None:
        begun.set()
        may_end.wait()

    def in_thread() -> None:
        if what == "a property":
            assert Slow(held).value == 1.0
        else:
            with module.lock:
                held()

    def in_child() -> None:
        if what == "a property":
            assert Slow(lambda: None).value == 1.0
        else:
            with module.lock:
                pass

    thread = threading.Thread(target=in_thread)
    thread.start()
    try:
        assert begun.wait(5.0)
        assert ends(in_child)
    finally:
        may_end.set()
        thread.join()


def test_a_child_does_not_wait_for_a_thread_within_hdf5() -> None:
    pytest.importorskip("h5py")
    from kanefe.storage.hdf5 import encode, h5py_for

    phil = h5py_for("a test")._objects.phil
    begun = threading.Event()

    def in_thread() -> None:
        with phil:
            begun.set()
            time.sleep(0.1)  # the fork waits for it

    thread = threading.Thread(target=in_thread)
    thread.start()
    assert begun.wait(5.0)
    assert ends(lambda: encode({"a": 1}, {"x": (np.zeros(3), "m")}))
    thread.join()
