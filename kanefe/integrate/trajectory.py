"""What a run leaves behind: states at the output times, how it ended and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kanefe.integrate.status import RunStatus


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of a run at its output times.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s. Those wanted up to where the run came; the last one is that time if the run ended before the span.
    coordinates : ndarray, shape (T, coordinates)
    speeds : ndarray, shape (T, free)
    dissipated, work : ndarray, shape (T,)
        Energy taken by damping and given by loads, drives and actions of events since the start, J.
    statistics : dict
        Method, why it was chosen, steps, rejected steps, evaluations and what else the method counts; "seconds" in
        all, and "seconds_by_part".
    accelerations : ndarray, shape (T, free), or None
        du, kept of scenes with unreduced bodies, where it costs more than it takes room.
    status : RunStatus or None
        How the run ended; None of states that come from elsewhere.
    events : mapping of str to ndarray
        Times at which each event happened, s.
    """

    times: np.ndarray
    coordinates: np.ndarray
    speeds: np.ndarray
    dissipated: np.ndarray
    work: np.ndarray
    statistics: dict[str, Any]
    accelerations: np.ndarray | None = None
    status: RunStatus | None = None
    events: Mapping[str, np.ndarray] = field(default_factory=dict)

    def raise_for_status(self) -> None:
        """Raise a SimulationError if the run failed.

        Raises
        ------
        SimulationError
        """
        if self.status is not None:
            self.status.raise_if_failed()
