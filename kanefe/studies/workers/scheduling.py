"""Blocks of cases: submitted to workers, collected when done, and repeated if a worker dies."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

from kanefe.storage.sealed import sealed
from kanefe.studies.workers.pools import Pool, executor_error
from kanefe.studies.workers.work import Case, Done, Work, failed_row, ready, run_block, stamp

BLOCK_SECONDS = 1.0
"""Duration of a block, s: long compared with the milliseconds of its transfer, and little to lose."""

MOST_CASES = 256
"""Largest number of cases in a block."""

DEPTH = 2
"""Number of submitted blocks per worker: one runs, one waits."""

TRIES = 2
"""Number of deaths of workers after which a case counts as the cause; after the first it runs alone."""


@dataclass
class Block:
    """Cases that are submitted together; `deaths` counts the workers that died with them."""

    cases: list[Case]
    deaths: int = 0


class Scheduler:
    """Submits the remaining cases to a pool.

    Parameters
    ----------
    pool : Pool
    work : Work or bytes
        In the form that the pool takes.
    cases : iterator of Case
        The cases to run.
    count : int
        Number of cases.
    """

    def __init__(self, pool: Pool, work: Work | bytes, cases: Iterator[Case], count: int) -> None:
        self._pool, self._work, self._cases, self._left = pool, work, cases, count
        self._flying: dict[Any, Block] = {}
        self._landed: SimpleQueue[Any] = SimpleQueue()
        self._suspects: deque[Block] = deque()
        self._seconds = math.inf  # mean time of a case; the first blocks have one case each

    def done(self) -> Iterator[Done]:
        """Yield blocks as they are done, in any order.

        Raises
        ------
        SimulationError
            If the workers cannot run the work, or the executor fails.
        """
        self._check_workers()
        while True:
            self._fill()
            if not self._flying:
                return
            yield from self._one_back()

    def _check_workers(self) -> None:
        """Check that each worker has the functions and the same kanefe before the first case."""
        if not self._pool.pickles:
            return
        futures = [self._pool.submit(check_worker, self._work, stamp()) for _ in range(self._pool.workers)]
        for future in futures:
            try:
                future.result()
            except Exception as error:
                raise executor_error(error) from error

    def _fill(self) -> None:
        """Keep the workers busy; blocks suspected of killing a worker run alone."""
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
            fair = math.ceil(self._left / (DEPTH * self._pool.workers))  # so that all workers end together
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
            raise executor_error(error) from error
        self._flying[future] = block
        future.add_done_callback(self._landed.put)

    def _one_back(self) -> Iterator[Done]:
        future = self._landed.get()
        if future not in self._flying:  # of processes that have ended
            return
        try:
            done: Done = future.result()
        except self._pool.deaths:
            yield from self._died(future)
            return
        except Exception as error:
            raise executor_error(error) from error
        each = max(done.seconds / done.cases, 1e-6)
        del self._flying[future]
        self._seconds = each if math.isinf(self._seconds) else 0.5 * (self._seconds + each)
        yield done

    def _died(self, future: Any) -> Sequence[Done]:
        """Handle the death of a worker: the running cases are repeated one at a time."""
        block = self._flying[future]
        unfinished = [each for each in self._flying if not _is_done(each)]
        lost = [self._flying.pop(each) for each in (unfinished if self._pool.renew() else [future])]
        if block.deaths + 1 < TRIES:
            self._suspects.extend(Block([case], 1) for each in lost for case in each.cases)
            return []
        reason = (
            "two worker processes died, the second with this case alone: out of memory, a crash, or code that did not "
            "end at most_seconds="
        )
        return [Done(f"{sealed(failed_row(block.cases[0], reason))}\n", 1, 1, 0.0)]


def _is_done(future: Any) -> bool:
    return bool(future.done() and not future.cancelled() and future.exception() is None)


def check_worker(work: bytes, expected: str) -> None:
    """Raise an error if this worker cannot run cases."""
    ready(work, expected)
