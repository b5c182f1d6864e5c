"""Two methods one after the other: one that steps over vibrations, and one that follows them once they ask for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.auto.in_turn import SteppersInTurn
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.stepper import StepFailure, Stepper
from kanefe.tree.bending import Bent


class HandingOver(SteppersInTurn):
    """A stepper of the first method, until its error or an event asks for a step below the least one: see `Stepper`.

    From there on it is one of the second method, to the end of the run.

    Parameters
    ----------
    dynamics : Dynamics
    first : KernelStepper
    least : float
        s.
    second : function
        Returns a stepper at the start of the run.

    Attributes
    ----------
    name : str
        Of the method, or of both.
    """

    def __init__(self, dynamics: Dynamics, first: KernelStepper, least: float, second: Callable[[], Stepper]) -> None:
        super().__init__(dynamics)
        self.name = first.name
        self._first, self._make_second = first, second
        self._second: KernelStepper | None = None
        self._aim: float | None = None
        first.step.smallest = max(first.step.smallest, least)

    @property
    def _now(self) -> Stepper:
        return self._first if self._second is None else self._second

    @property
    def second_name(self) -> str:
        """Name of the method that takes over."""
        return (self._make_second() if self._second is None else self._second).name

    @property
    def step_count(self) -> int:
        """How many steps both have accepted so far."""
        return self._first.step_count + (0 if self._second is None else self._second.step_count)

    @property
    def statistics(self) -> dict[str, int | float]:
        """What both have counted."""
        counts = dict(self._first.statistics)
        if self._second is not None:
            # evaluations are counted by the dynamics of both where they are made from Python
            for name, value in self._second.statistics.items():
                counts[name] = counts.get(name, 0) + value
        return counts

    @property
    def unanswered(self) -> list[str]:
        """What functions of the user gave no number for."""
        return [*self._first.unanswered, *(() if self._second is None else self._second.unanswered)]

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Time and state where rejected steps of either have clustered the most."""
        return self._first.hardest or (None if self._second is None else self._second.hardest)

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most by either."""
        return self._first.bent + ([] if self._second is None else self._second.bent)

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int, is_cut: bool = False) -> int:
        """Continue until all times are passed or so many steps are taken: see `KernelStepper.integrate_through`."""
        if self._second is not None:
            return self._second.integrate_through(times, states, most_steps, is_cut)
        first, begun = self._first, self._first.step_count
        try:
            return first.integrate_through(times, states, most_steps, is_cut)
        except StepFailure:
            passed = self._passed_by_failing(times, states, 0)
        second = self._hand_over()
        second.restart(first.t, first.state())
        left = most_steps - (first.step_count - begun)
        return passed + second.integrate_through(times[passed:], states[passed:], max(left, 1), is_cut)

    def _hand_over(self) -> KernelStepper:
        self._second = cast("KernelStepper", self._make_second())
        if self._aim is not None:
            self._second.aim(self._aim)
        self.name = f"{self._first.name}, then {self._second.name}"
        return self._second

    def aim(self, stop: float) -> None:
        """Let a step end at a time, s."""
        self._aim = stop
        self._now.aim(stop)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the data that both need to continue."""
        kept = {f"first {name}": array for name, array in self._first.snapshot().items()}
        if self._second is not None:
            kept |= {f"second {name}": array for name, array in self._second.snapshot().items()}
        return kept

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self._first.resume(_part(snapshot, "first "))
        self._second, self.name = None, self._first.name
        if second := _part(snapshot, "second "):
            self._hand_over().resume(second)


def _part(snapshot: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {name.removeprefix(prefix): array for name, array in snapshot.items() if name.startswith(prefix)}
