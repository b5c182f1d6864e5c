"""Processes of MPI as threads of one process: what `kanefe_fem.processes.team` needs of a communicator, without MPI."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

LONGEST = 20.0
"""Time in s after which a thread that waits for another has failed."""


class Ended(BaseException):
    """What `Abort` raises, since a thread cannot end its process."""


class _World:
    def __init__(self, size: int) -> None:
        self.size = size
        self.barriers: dict[int, set[int]] = {}
        self.box = {(a, b): queue.Queue[Any]() for a in range(size) for b in range(size)}
        self.aborted: list[int] = []


class _Arrived:
    def __init__(self, here: set[int], world: _World) -> None:
        self.here, self.world = here, world

    def Test(self) -> bool:
        if self.world.aborted:
            raise Ended
        return len(self.here) == self.world.size


class ThreadComm:
    """A communicator of one thread."""

    def __init__(self, world: _World, rank: int) -> None:
        self.world, self.rank, self.size = world, rank, world.size
        self.met = 0

    def Dup(self) -> ThreadComm:
        return self

    def Free(self) -> None:
        pass

    def Ibarrier(self) -> _Arrived:
        self.met += 1
        here = self.world.barriers.setdefault(self.met, set())
        here.add(self.rank)
        return _Arrived(here, self.world)

    def send(self, thing: Any, dest: int) -> None:
        self.world.box[self.rank, dest].put(thing)

    def recv(self, source: int) -> Any:
        return self.world.box[source, self.rank].get(timeout=LONGEST)

    def Send(self, array: np.ndarray, dest: int) -> None:
        self.send(array.copy(), dest)

    def Recv(self, array: np.ndarray, source: int) -> None:
        array[...] = self.recv(source)

    def bcast(self, thing: Any = None) -> Any:
        if self.rank:
            return self.recv(0)
        for other in range(1, self.size):
            self.send(thing, other)
        return thing

    def allgather(self, thing: Any) -> list[Any]:
        for other in range(self.size):
            self.send(thing, other)
        return [self.recv(other) for other in range(self.size)]

    def Abort(self, code: int) -> None:
        self.world.aborted.append(code)
        raise Ended


def on_threads(size: int, work: Callable[[ThreadComm], Any]) -> tuple[list[Any], list[int]]:
    """Return what `work` returns or raises on each thread, and the codes of aborts."""
    world = _World(size)
    found: list[Any] = [None] * size

    def one(rank: int) -> None:
        try:
            found[rank] = work(ThreadComm(world, rank))
        except BaseException as error:  # noqa: BLE001  # SystemExit too
            found[rank] = error

    threads = [threading.Thread(target=one, args=(rank,), daemon=True) for rank in range(size)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(2.0 * LONGEST)
        assert not thread.is_alive(), "a thread waits for ever"
    return found, world.aborted
