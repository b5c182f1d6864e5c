"""Clocks: one core, one thread, CPU time, and runs that alternate."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from benchmarks.goals import median, median_ratio

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")

ROUNDS, FEW_ROUNDS = 9, 3
"""Number of rounds of a comparison. With the smaller number the slowest preparations are left out as well."""

AGREEMENT = 1e-6
"""Largest relative difference between the two sides of a comparison, which must compute the same."""


Setting = TypeVar("Setting", int, float)


class Disagreement(Exception):
    """The two sides of a comparison did not compute the same thing."""


def use_one_core(core: int | None = None) -> int | None:
    """Keep this process and those it starts on one core and one thread; to be called before numpy is imported.

    Parameters
    ----------
    core : int, optional
        Default: the last one there is, since systems put their own work on the first.

    Returns
    -------
    int or None
        The core; None where processes cannot be pinned.

    Raises
    ------
    SystemExit
        If there is no such core.
    """
    os.environ.update(ONE_THREAD)
    if not hasattr(os, "sched_setaffinity"):
        return None
    cores = os.sched_getaffinity(0)
    chosen = max(cores) if core is None else core
    if chosen not in cores:
        raise SystemExit(f"there is no core {core}. There are: {sorted(cores)}")
    os.sched_setaffinity(0, {chosen})
    return chosen


@contextmanager
def use_all_cores() -> Iterator[None]:
    """Let this process run on all cores for a while, as for wall times of several threads."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    chosen = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield
    finally:
        os.sched_setaffinity(0, chosen)


def seconds(function: Callable[[], object]) -> float:
    """Return the CPU time of a call: other processes on the core do not count."""
    start = time.process_time()
    function()
    return time.process_time() - start


def repeated(function: Callable[[], object], count: int) -> float:
    """Return the CPU time of one of `count` calls."""
    start = time.process_time()
    for _ in range(count):
        function()
    return (time.process_time() - start) / count


def fill(function: Callable[[], object], wanted: float = 0.05) -> int:
    """Return how many calls take about `wanted` s, at least one."""
    count = 1
    while (taken := count * repeated(function, count)) < 0.1 * wanted:  # of a coarse clock, nothing at first
        count *= 4
    return max(1, round(wanted * count / taken))


class Race:
    """Two clocks read in turn.

    Parameters
    ----------
    ours, theirs : callable
        Each returns the seconds of one run.
    rounds : int
        The first round warms up and is not counted.
    """

    def __init__(self, ours: Callable[[], float], theirs: Callable[[], float], rounds: int) -> None:
        pairs = [(ours(), theirs()) for _ in range(rounds + 1)][1:]
        self._ours, self._theirs = ([pair[i] for pair in pairs] for i in (0, 1))

    @property
    def ours(self) -> float:
        """Median time of ours in s."""
        return median(self._ours)

    @property
    def theirs(self) -> float:
        """Median time of theirs in s."""
        return median(self._theirs)

    @property
    def ratio(self) -> float:
        """Median of the ratios of the pairs."""
        return median_ratio(self._ours, self._theirs)


def coarsest(settings: Sequence[Setting], error: Callable[[Setting], float], limit: float) -> Setting:
    """Return the first setting, of coarse ones first, from which on no error is above a limit; the last, if none is."""
    good = [error(setting) <= limit for setting in settings]
    first = next((i for i in range(len(good)) if all(good[i:])), len(good) - 1)
    return settings[first]


def microseconds(time_in_seconds: float) -> str:
    """Return a time as text."""
    return f"{1e6 * time_in_seconds:.3g} us"


def check_agreement(name: str, ours: Sequence[float], theirs: Sequence[float], tolerance: float = AGREEMENT) -> None:
    """Raise unless two results are the same, so that the times that are compared are those of the same computation.

    Raises
    ------
    Disagreement
        With both results.
    """
    largest = max(abs(x) for x in theirs)
    differences = [abs(a - b) for a, b in zip(ours, theirs, strict=True)]
    # so that NaN does not agree with anything
    if not all(difference <= tolerance * largest for difference in differences):
        difference = max(differences)
        raise Disagreement(f"{name}: the two sides differ by {difference:.2g} ({list(ours)} and {list(theirs)})")
