"""Several steppers of a run that go on one after the other: what they have in common is asked of the present one."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.stepper import Stepper


class SteppersInTurn(ABC):
    """A stepper that is another from some time on: see `Stepper`.

    Parameters
    ----------
    dynamics : Dynamics
    """

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics

    @property
    @abstractmethod
    def _now(self) -> Stepper:
        """The present stepper."""

    @property
    def t(self) -> float:
        """Time reached in s."""
        return self._now.t

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return self._now.t_old

    @property
    def worst(self) -> int:
        """Component of the state whose error was the largest at the last step."""
        return int(getattr(self._now, "worst", 0))

    def state(self) -> Vector:
        """Return the state at t."""
        return self._now.state()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        return self._now.states(times)

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        self._now.go_on_with(t, y)

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state."""
        self._now.restart(t, y)

    def step_again(self, t: float) -> bool:
        """Take the last step again, to just behind a time within it (s); return whether that is of use."""
        return self._now.step_again(t)

    def _passed_by_failing(self, times: np.ndarray, states: np.ndarray, first: int) -> int:
        """Return how many times the present stepper has passed that failed, with their states from a number on closed.

        One that fails leaves the closing to who asks it.
        """
        passed = int(np.searchsorted(times, self._now.t, side="right"))
        for i in range(first, passed):
            states[i] = self._dynamics.projected(float(times[i]), states[i])
        return passed
