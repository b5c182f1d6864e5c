"""Where functions of the time jump: found by bisection, to two times between which there is no other number."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

HALVINGS, LEFT = 4, 0.25
"""Number of halvings of an interval, and the share of its change that is left then if nothing jumps there: a sixteenth
of what is smooth, and more where the function changes by less in the rest."""

STANDS_OUT = 4.0
"""How far a change from one sample to the next differs from those beside it, in multiples of how far these do two and
three samples away, from which on it is looked into."""

ALONE = 0.25
"""How far it differs relative to itself, from which on it is looked into whatever is beside it, as other jumps are."""

LEAST = 1e-6
"""Change from one sample to the next, relative to the size of a function, that is looked into."""

BESIDE = 0.01
"""Change beside a jump that was found, relative to it, in which another is looked for."""

MOST_BETWEEN = 8
"""Largest number of jumps between two samples: noise jumps everywhere, and so it has none."""


_Place = tuple[float, list[float]]  # a time, s, and the values there


class Jumps(NamedTuple):
    """Where a function of the time jumps, k times, ascending.

    Attributes
    ----------
    before, after : ndarray, shape (k,)
        The last time with the value of before, and the first with that of after, s: neighbours among the numbers.
    heights : ndarray, shape (k, values)
    """

    before: Vector
    after: Vector
    heights: Matrix


class Changes(NamedTuple):
    """Where steps end since functions of the time change there; where there are none, both are empty.

    Attributes
    ----------
    ends : ndarray, shape (n,)
        The start of the run, and those times, ascending, s. One at which a function jumps is the first with the value
        from then on.
    before : ndarray, shape (n,)
        The last time with the values of before; where none jumps the same.
    seconds : float
        That it took to find them.
    """

    ends: Vector
    before: Vector
    seconds: float = 0.0

    @property
    def sides(self) -> Vector:
        """All times of both, ascending, s."""
        return np.unique(np.concatenate((self.ends, self.before)))


NO_CHANGES = Changes(np.zeros(0), np.zeros(0))


def jumps_of(function: Callable[[float], Any], times: Vector, rows: Matrix) -> Jumps:
    """Return where a function of the time jumps.

    A jump that is undone within a sample may be missed, and one that is lost among larger changes of the samples.

    Parameters
    ----------
    function : callable
        (t) -> number or numbers.
    times : ndarray, shape (T,)
        s.
    rows : ndarray, shape (T, values)
        What it gives there, up to the first that is no number.
    """
    size = np.abs(rows).max(axis=0, initial=0.0)
    search, found = _JumpSearch(function, size), list[tuple[float, float, list[float]]]()
    with suppress(Exception):  # of the user's function, reported by the run if it gets there
        for i in _that_stand_out(rows / np.where(size > 0.0, size, 1.0)):
            first, last = ((float(times[k]), rows[k].tolist()) for k in (i, i + 1))
            search.found = []
            search.look(first, last, LEAST)
            if len(search.found) > MOST_BETWEEN:
                found = []
                break
            found += search.found
    return Jumps(
        np.array([before for before, _, _ in found]),
        np.array([after for _, after, _ in found]),
        np.array([height for _, _, height in found]).reshape(-1, rows.shape[1]),
    )


def without(jumps: Jumps, times: Vector, rows: Matrix) -> Matrix:
    """Return samples of a function as they were without its jumps."""
    passed = np.searchsorted(jumps.after, times[: len(rows)], side="right")
    sums = np.concatenate((np.zeros((1, rows.shape[1])), np.cumsum(jumps.heights, axis=0)))
    return rows - sums[passed]


def _that_stand_out(rows: Matrix) -> list[int]:
    """Return which changes from one sample to the next differ from those beside them, by the number of the first."""
    changes = np.diff(rows, axis=0)
    if len(changes) < 2:
        return []
    padded = np.concatenate((changes[1:2], changes, changes[-2:-1]))
    off = np.abs(changes - 0.5 * (padded[2:] + padded[:-2])).max(axis=1)
    far = np.pad(off, 3, mode="reflect") if len(off) > 3 else np.pad(off, 3, mode="edge")
    usual = np.min([np.maximum(far[:-6], far[1:-5]), np.maximum(far[5:-1], far[6:])], axis=0)
    is_alone = off > ALONE * np.abs(changes).max(axis=1)
    return np.flatnonzero((off > LEAST) & ((off > STANDS_OUT * usual) | is_alone)).tolist()


class _JumpSearch:
    """A search in one function, whose values are of a size."""

    def __init__(self, function: Callable[[float], Any], size: Vector) -> None:
        self._function = function
        self._shares = [1.0 / x if x > 0.0 else 0.0 for x in size.tolist()]
        self.found: list[tuple[float, float, list[float]]] = []

    def look(self, first: _Place, last: _Place, least: float) -> None:
        """Find the jumps between two times, whose values differ by more than the least; in order."""
        (a, at_a), (b, at_b) = first, last
        sizes = [self._apart(at_a, at_b)]
        if not least < sizes[0] < math.inf or len(self.found) > MOST_BETWEEN:
            return
        while a < (middle := 0.5 * (a + b)) < b:
            at_middle = numbers_of(self._function(middle))
            before, after = self._apart(at_a, at_middle), self._apart(at_middle, at_b)
            if before > after:
                b, at_b = middle, at_middle
            else:
                a, at_a = middle, at_middle
            sizes.append(max(before, after))
            if len(sizes) > HALVINGS and not sizes[-1] > LEFT * sizes[-1 - HALVINGS]:
                return
        self.look(first, (a, at_a), BESIDE * sizes[-1])
        self.found.append((a, b, [after - before for before, after in zip(at_a, at_b, strict=True)]))
        self.look((b, at_b), last, BESIDE * sizes[-1])

    def _apart(self, a: list[float], b: list[float]) -> float:
        largest = 0.0
        for x, y, share in zip(a, b, self._shares, strict=True):
            largest = max(largest, abs(y - x) * share)
        return largest


def numbers_of(value: Any) -> list[float]:
    """Return what a function gives as plain numbers."""
    if type(value) is float:
        return [value]
    if type(value) is tuple:
        return list(map(float, value))
    found: list[float] = np.array(value, dtype=float).ravel().tolist()
    return found
