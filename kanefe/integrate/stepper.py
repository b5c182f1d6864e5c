"""What a method of time integration is to the run loop: a stepper, and its failure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeGuard

import numpy as np

from kanefe.errors import KanefeError, SimulationError
from kanefe.frames import Vector
from kanefe.tree.bending import Bent

if TYPE_CHECKING:
    from kanefe.integrate.jumps import Changes
    from kanefe.integrate.sampling import Sampler
    from kanefe.kernels.events.watched_run import WatchedRun

BESIDE = 1e-6
"""Distance from the time at which the equations had no solution, relative to the span, within which a run that ends is
ended by this."""

LEAST_STEPS = 30
"""Least number of steps of a run with functions as loads or drives: these are then sampled at least a hundred times,
since no method skips more than a third of a step or, for order 5, half of it."""


MOST_SPEEDS = 150
"""Largest number of speeds for which systems over all of them are solved unasked: their work grows with its cube."""


class StepFailure(SimulationError):
    """A stepper cannot continue from the time it has reached; the run loop makes a status of it.

    Parameters
    ----------
    reason : str
        What fails, without the time.
    remedy : str
        What to try.
    component : int, optional
        Index into y of what is worst; the run loop names it.
    """

    def __init__(self, reason: str, remedy: str, component: int | None = None) -> None:
        super().__init__(f"{reason}. Remedy: {remedy}")
        self.reason, self.remedy, self.component = reason, remedy, component


def beyond(error: KanefeError) -> StepFailure:
    """Return the failure of a fixed step that leads to where the equations do not hold, or what says more itself."""
    if isinstance(error, StepFailure):
        return error
    reason, _, remedy = str(error).partition(". Remedy: ")
    return StepFailure(f"the fixed step is too long: {reason}", f"a smaller step{', or ' + remedy if remedy else ''}")


class Unconverged(NamedTuple):
    """Fixed steps whose iteration was left before it had converged.

    Attributes
    ----------
    steps : int
    first, last : float
        Ends of the first and the last of them, s.
    largest : float
        Largest displacement by which an iteration still changed, relative to the size of the bodies.
    """

    steps: int
    first: float
    last: float
    largest: float


class Stepper(Protocol):
    """A method in the middle of a run, with state ``y = (q, u, dissipated energy, work)``.

    What it computes does not depend on how a run is cut into calls of `integrate_through`.
    """

    @property
    def name(self) -> str:
        """Of the method."""
        ...

    @property
    def t(self) -> float:
        """Time reached in s."""
        ...

    @property
    def t_old(self) -> float:
        """Start of the last step in s; `t` before the first one and after a restart."""
        ...

    @property
    def step_count(self) -> int:
        """How many steps were accepted so far."""
        ...

    @property
    def statistics(self) -> dict[str, int | float]:
        """What was done so far: "steps", "rejected", "evaluations"; "factorisations", "jacobians" where there are."""
        ...

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most, of the starts of all steps; none that was not bent."""
        ...

    @property
    def unanswered(self) -> list[str]:
        """What functions of the user gave no number for, where the step was tried again."""
        ...

    @property
    def hardest(self) -> tuple[float, Vector] | None:
        """Time (s) and state where rejected steps have clustered the most, if they did and somebody may ask why."""
        ...

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Continue until all `times` are passed, or `most_steps` steps are accepted.

        Parameters
        ----------
        times : ndarray, shape (T,)
            Ascending, all after `t`, s.
        states : ndarray, shape (T, state)
            Its first rows are filled with the states at the times passed.
        most_steps : int

        Returns
        -------
        int
            How many times were passed.

        Raises
        ------
        StepFailure
            If there is no next step; the stepper then stands where the last accepted one ended.
        """
        ...

    def state(self) -> Vector:
        """Return y at t."""
        ...

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times from t_old to t, shape (T, state)."""
        ...

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state, also an earlier one, as after an event."""
        ...

    def aim(self, stop: float) -> None:
        """Let a step end at a time (s) and none pass it, until another time is set."""
        ...

    def step_again(self, t: float) -> bool:
        """Take the last step again, to just behind a time within it (s); return whether that is of use."""
        ...

    def go_on_with(self, t: float, y: Vector) -> None:
        """Continue where a step has ended, from a state with other drives held: with steps as long as they were."""
        ...

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return copies of all that is needed to continue to the bit, but for `states` of the last step."""
        ...

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from what another stepper of the same run gave as its `snapshot`."""
        ...


class GivesAccelerations(Protocol):
    """A stepper of a scene whose accelerations are kept, because they cost more than they take room."""

    def accelerations(self, times: np.ndarray) -> np.ndarray:
        """Return du at times from t_old to t, shape (T, free)."""
        ...


class LooksOut(Protocol):
    """A stepper that continues over events of loads in compiled code."""

    @property
    def can_look_out(self) -> bool:
        """Whether it can do so in this scene."""
        ...

    def integrate_over_events(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, watched: WatchedRun
    ) -> tuple[int, bool]:
        """Continue as `integrate_through` does, but no further than a step in which an event needs Python.

        Parameters
        ----------
        times, states, most_steps
            As there.
        passed : int
            How many of the times are passed: where a call has ended with `IS_CUT`, those of its last step too.
        watched : WatchedRun
            The events, and what is known of them; in the end before the last step, or after it if that is done.

        Returns
        -------
        passed : int
            How many times were passed.
        is_done : bool
            Whether all that happened in the last step is dealt with.
        """
        ...

    @property
    def has_values(self) -> bool:
        """Whether it provides event values without states that would have to be closed first."""
        ...

    def values_at(self, t: float) -> Vector:
        """Return event values at a time of the last step, if it provides them."""
        ...


class PassesSamples(Protocol):
    """A stepper that continues over samples of controllers in compiled code, in scenes that are autonomous."""

    def integrate_over_samples(
        self, times: np.ndarray, states: np.ndarray, passed: int, most_steps: int, sampler: Sampler
    ) -> int:
        """Continue as `integrate_through` does, over samples, until drives have grown so that Python has to look.

        `passed` of the times are passed before; returned is how many are in the end.
        """
        ...


class KeepsTime(Protocol):
    """A stepper of fixed steps for what has to keep up with the wall clock."""

    @property
    def step_seconds(self) -> list[float]:
        """Wall time that 99.9 % of fixed steps did not exceed, and the longest, s; empty where steps are free."""
        ...

    @property
    def unconverged(self) -> Unconverged | None:
        """Fixed steps whose iteration was left early."""
        ...


class ReportsWorst(Protocol):
    """A stepper that knows which component of the state held its last step down."""

    @property
    def worst(self) -> int:
        """Index into y."""
        ...


class TriesOthers(Protocol):
    """A stepper that tries other methods in the run."""

    @property
    def told(self) -> list[str]:
        """What was tried, in words."""
        ...

    @property
    def tried_share(self) -> float:
        """Work of all trials, relative to that of the run without them."""
        ...


def gives_accelerations(stepper: Stepper) -> TypeGuard[GivesAccelerations]:
    """Return whether a stepper keeps that protocol: asked of its class, which takes less time than `isinstance`."""
    return hasattr(type(stepper), "accelerations")


def looks_out(stepper: Stepper) -> TypeGuard[LooksOut]:
    """Return whether a stepper keeps that protocol."""
    return hasattr(type(stepper), "integrate_over_events")


def passes_samples(stepper: Stepper) -> TypeGuard[PassesSamples]:
    """Return whether a stepper keeps that protocol."""
    return hasattr(type(stepper), "integrate_over_samples")


def keeps_time(stepper: Stepper) -> TypeGuard[KeepsTime]:
    """Return whether a stepper keeps that protocol."""
    return hasattr(type(stepper), "step_seconds")


def reports_worst(stepper: Stepper) -> TypeGuard[ReportsWorst]:
    """Return whether a stepper keeps that protocol."""
    return hasattr(type(stepper), "worst")


def tries_others(stepper: Stepper) -> TypeGuard[TriesOthers]:
    """Return whether a stepper keeps that protocol."""
    return hasattr(type(stepper), "tried_share")


ATOL_SHARE = 0.1
"""Absolute tolerance, relative to rtol, where none is given."""


@dataclass(frozen=True)
class StepControl:
    """How a stepper chooses its steps.

    Attributes
    ----------
    rtol, atol : float
        Error allowed for a step; without meaning where the step is fixed.
    step : float or None
        Fixed step, s.
    changes : Changes or None
        What `kanefe.integrate.breakpoints.changes_of` has found for the run, where somebody has asked.
    """

    rtol: float
    atol: float
    step: float | None
    changes: Changes | None = None

    @property
    def looseness(self) -> float:
        """By how much the absolute tolerance that goes with rtol is larger than the one given, at least 1."""
        return max(ATOL_SHARE * self.rtol / self.atol, 1.0) if self.atol > 0.0 else 1.0
