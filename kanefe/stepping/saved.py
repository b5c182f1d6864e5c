"""The state of a simulation at some time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.status import RunStatus


class SavedSimulation(NamedTuple):
    """The state of a simulation at some time, for `Simulation.restore`; it can be restored any number of times.

    Attributes
    ----------
    time : float
        s.
    """

    time: float
    inputs: Vector
    pieces: tuple[Vector, ...]
    stepper: Mapping[str, np.ndarray]
    watch: Mapping[str, np.ndarray] | None
    sampler: tuple[Any, ...] | None
    status: RunStatus
    has_begun: bool
