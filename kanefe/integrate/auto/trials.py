"""A trial: a method goes over a stretch of a run that another has done, from the same state."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.integrate.auto.work import WorkCounter
from kanefe.tree.model_data import QUADRATURES

if TYPE_CHECKING:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.methods.kernel_stepper import KernelStepper

SOME_STEPS = 3
"""Steps that a method which has taken none is given for a stretch at first."""

STEPS_AT_ONCE = 4
"""Steps of a trial between looks at what it has cost."""


@dataclass
class Stretch:
    """A part of a run, without events, over which another method will go.

    Attributes
    ----------
    t : float
        Where it begins, s.
    y : ndarray
        The state there.
    work : float
        Of the run up to there.
    restarts : float
        Time of the last restart within compiled code, s.
    samples : list of (float, ndarray)
        Times at which controllers were sampled (s), and the states with what they hold from there on.
    """

    t: float
    y: Vector
    work: float
    restarts: float
    samples: list[tuple[float, Vector]] = field(default_factory=list)


class Trial(NamedTuple):
    """How a method has gone over a stretch.

    Attributes
    ----------
    method : int
        Its number.
    start, end : float
        Of the stretch, s.
    work : float
        Relative to that of the run on the stretch; what it had cost where it was left, if it was.
    off : float
        How far both are apart at the end, relative to what is allowed; infinite where it did not come there.
    steps : int
    is_taken : bool
        Whether the run went on with it.
    """

    method: int
    start: float
    end: float
    work: float
    off: float
    steps: int
    is_taken: bool = False


def went_over(
    rival: KernelStepper, stretch: Stretch, end: tuple[float, Vector], held: slice, most: float, counter: WorkCounter
) -> tuple[Vector | None, dict[str, int | float]]:
    """Let a method go over a stretch; return its state at the end, and what it has counted.

    Parameters
    ----------
    rival : KernelStepper
        It keeps the steps that it has found for the case that it goes on.
    stretch : Stretch
    end : (float, ndarray)
        Where the stretch ends, s, and the state there.
    held : slice
        The internal states within a state, which controllers write to.
    most : float
        Work at which it is left: the state is None then, and where it fails.
    counter : WorkCounter
    """
    before = dict(rival.statistics)

    def counts() -> dict[str, int | float]:
        return {name: value - before.get(name, 0) for name, value in rival.statistics.items()}

    rival.go_on_with(stretch.t, stretch.y)  # nothing jumps there: it keeps the step that it found before
    if rival.step_count == 0:
        rival.step.next_step = min(rival.step.next_step, (end[0] - stretch.t) / SOME_STEPS)
    row = np.empty((1, len(stretch.y)))
    try:
        for t, y in (*stretch.samples, end):
            if t > rival.t:
                rival.aim(t)
            while rival.t < t:
                rival.integrate_through(np.array([t]), row, STEPS_AT_ONCE)
                if counter.work(counts()) > most:
                    return None, counts()
            if t < end[0]:  # also where the stretch begins at a sample
                state = rival.state()
                state[held] = y[held]
                rival.go_on_with(t, state)
    except (KanefeError, np.linalg.LinAlgError, ArithmeticError):
        return None, counts()
    return rival.state(), counts()


def apart(a: Vector, b: Vector, allowed: Vector) -> float:
    """Return how far the coordinates of two states are apart, relative to what is allowed of each."""
    found = float(np.max(np.abs(a[: len(allowed)] - b[: len(allowed)]) / allowed, initial=0.0))
    return found if math.isfinite(found) else math.inf


def energies_apart(dynamics: Dynamics, t: float, a: Vector, b: Vector) -> float:
    """Return the difference of the energies of two states at a time (s), relative to that of motion and deformation.

    A method that steps over vibrations takes their energy away before coordinates show it.
    """
    of_a, of_b = (dynamics.route.energy(t, y[:-QUADRATURES]) for y in (a, b))
    moving = of_b.kinetic + of_b.elastic
    return abs(of_a.total - of_b.total) / moving if moving > 0.0 else 0.0
