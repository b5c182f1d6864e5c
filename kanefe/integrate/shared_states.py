"""States of a run for two: its output times, and what is recorded beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.state_rows import TakesStates, merged, rows_at
from kanefe.integrate.status import RunStatus


class RecordsStates(TakesStates, Protocol):
    """What records a run as it goes on."""

    times: np.ndarray

    def begin(self, events: Sequence[str]) -> None:
        """Begin, with the names of all events of the run."""
        ...

    def leave(self) -> None:
        """Close what is open: the run was not begun, or an error ended it."""
        ...

    def end(self, status: RunStatus) -> Mapping[str, Any]:
        """End, and return what was recorded."""
        ...


class SharedStates:
    """Keeps states at the output times, and gives those at the times of a recorder away.

    Parameters
    ----------
    outputs : ndarray, shape (T,)
        Output times, the last one the end of the run, s.
    width : int
        Number of entries of a state.
    recorder : RecordsStates

    Attributes
    ----------
    times : ndarray, shape (U,)
        All times, ascending, s.
    states : ndarray, shape (T, state)
    accelerations : ndarray, shape (T, free), or None
    stored : int
        Number of output times so far.
    """

    def __init__(self, outputs: np.ndarray, width: int, recorder: RecordsStates) -> None:
        self._outputs, self._recorder = outputs, recorder
        self.times = merged(recorder.times[recorder.times <= outputs[-1]], outputs)
        self.events: Sequence[str] = recorder.events
        self.stored = 0
        self.states = np.empty((len(outputs), width))
        self.accelerations: np.ndarray | None = None

    def take(self, times: np.ndarray, states: np.ndarray, accelerations: np.ndarray | None) -> None:
        """Take states (T, state) at some times, each time once."""
        if accelerations is not None and self.accelerations is None:
            self.accelerations = np.empty((len(self._outputs), accelerations.shape[1]))
        of_outputs = rows_at(times, self._outputs)
        first, self.stored = self.stored, self.stored + len(times[of_outputs])
        self.states[first : self.stored] = states[of_outputs]
        if self.accelerations is not None and accelerations is not None:
            self.accelerations[first : self.stored] = accelerations[of_outputs]
        self._recorder.take(times, states, accelerations)

    def happened(self, name: str, t: float, y: Vector) -> None:
        """Take the state before an event at time t, s."""
        self._recorder.happened(name, t, y)
