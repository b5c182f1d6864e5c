"""What steppers written in Python have in common: their clock, their counts, and the way through the output times."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run_checks.bending_check import Bends
from kanefe.tree.bending import Bent


class PythonStepper(ABC):
    """A method in the middle of a run that takes its steps one by one: see `Stepper`.

    A subclass takes a step in `_advance`, moves `_t_old` and `_t`, and counts `_steps`, `_rejected`; the rest of
    `Stepper` is its own.

    Parameters
    ----------
    name : str
        Of the method.
    dynamics : Dynamics
    """

    def __init__(self, name: str, dynamics: Dynamics) -> None:
        self.name = name
        self._dynamics = dynamics
        self._t = self._t_old = 0.0
        self._steps = self._rejected = 0
        self._stop = np.inf
        self._bends = Bends(dynamics.model)

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        self._stop = stop

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue from a state with other drives."""
        self.restart(t, y)

    def step_again(self, t: float) -> bool:
        """Return that no step is taken again: where the last one began is not known any more."""
        return False

    @abstractmethod
    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state."""

    @property
    def t(self) -> float:
        """Time reached in s."""
        return self._t

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return self._t_old

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most."""
        return self._bends.seen

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far."""
        return self._steps

    @property
    def statistics(self) -> dict[str, int | float]:
        """Accepted steps, tries that were rejected, evaluations, and what else the method counts."""
        counts = {"steps": self._steps, "rejected": self._rejected, "evaluations": self._dynamics.evaluations}
        return counts | self._counted()

    @property
    def unanswered(self) -> list[str]:
        """Nothing: what functions of the user do not answer ends the run, or is dealt with by the solver."""
        return []

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Nothing: a solver does not tell where."""
        return None

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Continue until all times are passed or so many steps are taken: see `Stepper.integrate_through`."""
        passed = 0
        while passed < len(times) and most_steps > 0:
            if self._bends:
                self._bends.keep(self.t, self.state())
            self._advance(float(times[passed]))
            most_steps -= 1
            reached = passed + int(np.searchsorted(times[passed:], self.t, side="right"))
            if reached > passed:
                states[passed:reached] = self.states(times[passed:reached])
                passed = reached
        return passed

    @abstractmethod
    def state(self) -> Vector:
        """Return the state at t."""

    @abstractmethod
    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""

    @abstractmethod
    def _advance(self, target: float) -> None:
        """Take one accepted step; a method without dense output of its own does not go beyond the target, s."""

    def _counted(self) -> dict[str, int | float]:
        """Return what else the method counts, by name."""
        return {}
