"""The rows of states that a run writes: all of them, or a window of them that moves with the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.stepper import Stepper, gives_accelerations

WINDOW_BYTES = 2**20
"""Size of a window, bytes."""

SHORTEST_WINDOW = 64
"""Least number of rows in a window."""


class TakesStates(Protocol):
    """What takes the states of a run as it goes on, and what happened at its events."""

    @property
    def events(self) -> Sequence[str]:
        """Names of the events at which it takes a state."""
        ...

    def take(self, times: np.ndarray, states: np.ndarray, accelerations: np.ndarray | None) -> None:
        """Take states (T, state) at some times, each time once, and accelerations (T, free) where they are kept."""
        ...

    def happened(self, name: str, t: float, y: Vector) -> None:
        """Take the state before an event at time t, s."""
        ...


def rows_at(times: np.ndarray, own: np.ndarray) -> np.ndarray | slice:
    """Return which of some times are in `own`, all of which are among them in their span: a slice where all are."""
    first, last = np.searchsorted(own, times[0]), np.searchsorted(own, times[-1], side="right")
    if last - first == len(times):
        return slice(None)
    return np.searchsorted(times, own[first:last])


def merged(times: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Return all of two ascending sequences of times, each time once; the first itself if it has all."""
    at = np.searchsorted(times, more)
    is_new = (at == len(times)) | (times[np.minimum(at, len(times) - 1)] != more) if len(times) else at == 0
    return np.insert(times, at[is_new], more[is_new]) if is_new.any() else times


class StateRows:
    """States at wanted times, of which a window is in memory if something takes them.

    Parameters
    ----------
    times : ndarray, shape (T,)
        Times wanted; the last one is the end of the run.
    width, free : int
        Number of entries of a state, and of its free speeds.
    stepper : Stepper
        At the start. Where it gives accelerations, they are stored too.
    taker : TakesStates, optional

    Attributes
    ----------
    times : ndarray, shape (W,)
        Of the window.
    states : ndarray, shape (W, state)
    accelerations : ndarray, shape (W, free), or None
    stored : int
        Rows of the window filled so far.
    """

    def __init__(
        self, times: np.ndarray, width: int, free: int, stepper: Stepper, taker: TakesStates | None = None
    ) -> None:
        self.end, self._all, self._taker, self._first = float(times[-1]), times, taker, 0
        self._reports = stepper if gives_accelerations(stepper) else None
        rows = self._usual = len(times)
        if taker is not None:
            rows = self._usual = min(rows, max(SHORTEST_WINDOW, WINDOW_BYTES // (8 * width)))
        self.states = np.empty((rows, width))
        self.accelerations = np.empty((rows, free)) if self._reports is not None else None
        self.times, self.stored = times[:rows], 0

    @property
    def is_full(self) -> bool:
        """Whether all rows of the window are filled."""
        return self.stored == len(self.times)

    @property
    def is_ready(self) -> bool:
        """Whether so many rows are filled as a window usually has."""
        return self.stored >= self._usual

    @property
    def is_last(self) -> bool:
        """Whether no window follows."""
        return self._first + len(self.times) == len(self._all)

    @property
    def is_empty(self) -> bool:
        """Whether nothing was stored at all."""
        return not self.stored and not self._first

    def count_finite(self) -> int:
        """Return how many of the stored rows are before the first that is not finite."""
        finite = np.isfinite(self.states[: self.stored]).all(axis=1)
        return self.stored if finite.all() else int(np.argmin(finite))

    def aim(self, stop: float) -> None:
        """Store only the state at a later time, s."""
        self.end, self.times, self.stored = stop, np.array([stop]), 0
        self._all, self._first, self._usual, self.states = self.times, 0, 1, self.states[:1]

    def has_room(self) -> bool:
        """Return whether a row is to be filled; the rows of a full window are given away before.

        Its last row is the first of the next window: it may still change, by a sample or an event at its time.
        """
        if self.is_ready and not self.is_last:
            last = self.stored - 1
            self._give(last)
            self.states[0] = self.states[last]
            if self.accelerations is not None:
                self.accelerations[0] = self.accelerations[last]
            self._first, self.stored = self._first + last, 1
            self.times = self._all[self._first : self._first + len(self.states)]
        return not self.is_full

    def cover(self, stepper: Stepper) -> None:
        """Make room for all rows within the last step, and fill them: an event in it may be before any of them."""
        if not self.is_full or self.is_last:
            return
        first, self.stored = self.stored, int(np.searchsorted(self._all, stepper.t, side="right")) - self._first
        self.times = self._all[self._first : self._first + self.stored + 1]
        more = max(0, len(self.times) - len(self.states))
        self.states = np.vstack((self.states, np.empty((more, self.states.shape[1]))))
        self.states[first : self.stored] = stepper.states(self.times[first : self.stored])
        if self.accelerations is not None:
            self.accelerations = np.vstack((self.accelerations, np.empty((more, self.accelerations.shape[1]))))
        self.store_accelerations(first, self.stored)

    def give_rest(self) -> None:
        """Give away what is stored."""
        self._give(self.stored)

    def _give(self, count: int) -> None:
        if self._taker is not None and count:
            rates = None if self.accelerations is None else self.accelerations[:count]
            self._taker.take(self.times[:count], self.states[:count], rates)

    @property
    def events(self) -> Sequence[str]:
        """Names of the events at which a state is taken."""
        return () if self._taker is None else self._taker.events

    def happened(self, name: str, t: float, y: Vector) -> None:
        """Tell of one of `events` and the state before it."""
        if self._taker is not None:
            self._taker.happened(name, t, y)

    def store_to(self, t: float) -> None:
        """Let the rows end at a time of the last step, s: later ones do not count."""
        self.stored = int(np.searchsorted(self.times, t, side="right"))

    def store_accelerations(self, first: int, last: int) -> None:
        """Store accelerations of some rows, in the last step."""
        if self.accelerations is not None:
            self.accelerations[first:last] = self.accelerations_at(self.times[first:last])

    def accelerations_at(self, times: np.ndarray) -> np.ndarray | None:
        """Return the accelerations (T, free) at times in the last step; None where they are not stored."""
        return None if self._reports is None else self._reports.accelerations(times)
