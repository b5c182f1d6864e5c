"""Blocks of cases: handed to workers, taken back as they are done, and tried again if a worker dies."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

from kanefe.storage.sealed import sealed
from kanefe.studies.workers.pools import Pool, told
from kanefe.studies.workers.work import Case, Done, Work, failed_row, ready, run_block, stamp

BLOCK_SECONDS = 1.0
"""Work in a block, s: long compared with the milliseconds to hand one over, and little to lose."""

MOST_CASES = 256
"""Largest number of cases in a block."""

DEPTH = 2
"""Number of blocks in flight per worker: one runs, one waits."""

TRIES = 2
"""Deaths of a worker after which the case is at fault: before the second it runs alone."""


@dataclass
class Block:
    """Cases that are handed over together; `deaths` are those of workers that had them."""

    cases: list[Case]
    deaths: int = 0


class Scheduler:
    """Hands the cases that are left to a pool.

    Parameters
    ----------
    pool : Pool
    work : Work or bytes
        As the pool takes it.
    cases : iterator of Case
        Those to be run.
    count : int
        How many they are.
    """

    def __init__(self, pool: Pool, work: Work | bytes, cases: Iterator[Case], count: int) -> None:
        self._pool, self._work, self._cases, self._left = pool, work, cases, count
        self._flying: dict[Any, Block] = {}
        self._landed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: deque[Block] = deque()
        self._seconds = math.inf  # a case takes; the first blocks have one each

    def done(self) -> Iterator[Done]:
        """Yield blocks as they are done, in no order.

        Raises
        ------
        SimulationError
            If the workers are not fit for the work, or the executor fails.
        """
        self._check_workers()
        while True:
            self._fill()
            if not self._flying:
                return
            yield from self._one_back()

    def _check_workers(self) -> None:
        """Have each worker say that it has the functions, and the same kanefe, before there is anything to lose."""
        if not self._pool.pickles:
            return
        futures = [self._pool.submit(check_worker, self._work, stamp()) for _ in range(self._pool.workers)]
        for future in futures:
            try:
                future.result()
            except Exception as error:
                raise told(error) from error

    def _fill(self) -> None:
        """Keep the workers busy; those under suspicion of killing one fly alone."""
        if self._suspects and not self._flying:
            self._launch(self._suspects.popleft())
        if self._suspects or any(block.deaths for block in self._flying.values()):
            return
        most = DEPTH * self._pool.workers if self._pool.takes_blocks else 1
        while len(self._flying) < most and self._left:
            self._launch(Block(self._next_cases()))

    def _next_cases(self) -> list[Case]:
        size = 1
        if self._pool.takes_blocks:
            fair = math.ceil(self._left / (DEPTH * self._pool.workers))  # so that all end together
            size = max(1, min(int(BLOCK_SECONDS / self._seconds), fair, MOST_CASES))
        size = min(size, self._left)
        self._left -= size
        return [next(self._cases) for _ in range(size)]

    def _launch(self, block: Block) -> None:
        try:
            future = self._pool.submit(run_block, self._work, stamp(), block.cases)
        except self._pool.deaths as error:
            future = Future()
            future.set_exception(error)
        except RuntimeError as error:  # the user has shut it down
            raise told(error) from error
        self._flying[future] = block
        future.add_done_callback(self._landed.put)

    def _one_back(self) -> Iterator[Done]:
        future = self._landed.get()
        if future not in self._flying:  # of processes that are gone
            return
        try:
            done: Done = future.result()
        except self._pool.deaths:
            yield from self._died(future)
            return
        except Exception as error:
            raise told(error) from error
        each = max(done.seconds / done.cases, 1e-6)
        del self._flying[future]
        self._seconds = each if math.isinf(self._seconds) else 0.5 * (self._seconds + each)
        yield done

    def _died(self, future: Any) -> Sequence[Done]:
        """Take in the death of a worker: what was in flight is tried again, one case at a time."""
        block = self._flying[future]
        unfinished = [each for each in self._flying if not _is_done(each)]
        lost = [self._flying.pop(each) for each in (unfinished if self._pool.renew() else [future])]
        if block.deaths + 1 < TRIES:
            self._suspects.extend(Block([case], 1) for each in lost for case in each.cases)
            return []
        reason = (
            "its worker process died, and another one that had nothing but this case: out of memory, a crash, or code "
            "that did not heed most_seconds="
        )
        return [Done(f"{sealed(failed_row(block.cases[0], reason))}\n", 1, 1, 0.0)]


def _is_done(future: Any) -> bool:
    return bool(future.done() and not future.cancelled() and future.exception() is None)


def check_worker(work: bytes, expected: str) -> None:
    """Raise what would keep a worker from running a case."""
    ready(work, expected)
