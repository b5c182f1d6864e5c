"""Internal states of loads at the end of a step of an implicit method: load by load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.integrate.stepper import StepFailure
from kanefe.loads.action import End
from kanefe.loads.base import Load

if TYPE_CHECKING:
    from kanefe.tree.scene_state import SceneState

ITERATIONS = 20
CONVERGED = 1e-12
"""Size of a correction relative to the state and its change in a step below which the iteration has converged."""

PROBE = 1e-6
"""Increment for slopes relative to the state and its change in a step."""


class FollowedStates:
    """The internal states z of a scene's loads through the steps of an implicit method.

    ``z1 = ((1 + r)^2 z0 - r^2 z_before + (1 + r) h dz1/dt) / (1 + 2 r)`` with r the ratio of this step to the one
    before: of second order, and what relaxes faster than a step is forgotten at once. The first step, and the one after
    an event, is Euler's.
    """

    def __init__(self) -> None:
        self._before: Vector | None = None
        self._h = 0.0

    def forget(self) -> None:
        """Continue from other states."""
        self._before = None

    def keep(self, before: Vector, h: float) -> None:
        """Remember z at the start of a step that was taken, and its length, s."""
        self._before, self._h = before, h

    def reached(self, state: SceneState, z: Vector, h: float) -> Vector:
        """Return z at the end of a step of h (s), (states,).

        Parameters
        ----------
        state : SceneState
            With q and u at the end of the step.
        z : ndarray, shape (states,)
            At its start.

        Raises
        ------
        StepFailure
            If the iteration of a load does not converge: a smaller step may.
        """
        ratio = 0.0 if self._before is None else h / self._h
        before = z if self._before is None else self._before
        share = (1.0 + ratio) * h / (1.0 + 2.0 * ratio)
        known = ((1.0 + ratio) ** 2 * z - ratio**2 * before) / (1.0 + 2.0 * ratio)
        after = z.copy()
        for i, (load, where) in enumerate(zip(state.model.loads, state.model.load_states, strict=True)):
            if load.has_rates:
                after[where] = _end(load, state, state.load_ends(i), known[where], share)
        return after


def _end(load: Load, state: SceneState, ends: Sequence[End], known: Vector, share: float) -> Vector:
    """Return the states z of a load with ``z = known + share rates(z)`` by Newton's method."""
    z, size = known, np.abs(known)
    for _ in range(ITERATIONS):
        rates = load.action(state.time, ends, z).rates
        left = known + share * rates - z
        size = np.maximum(size, share * np.abs(rates))
        if np.all(np.abs(left) <= CONVERGED * size):
            return z
        z = z + np.linalg.solve(np.eye(len(z)) - share * _slopes(load, state, ends, z, rates, size), left)
    raise StepFailure(
        f"the internal states of {load.kind} {load.name!r} are not found at t = {state.time:.6g} s: in a step of "
        "fixed length what it holds begins or ends too suddenly",
        "method='radau5' or 'auto' without step, whose steps end where that happens",
    )


def _slopes(load: Load, state: SceneState, ends: Sequence[End], z: Vector, rates: Vector, size: Vector) -> Matrix:
    """Return the derivatives of the rates of a load's states by the states."""
    slopes = np.zeros((len(z), len(z)))
    for k in np.flatnonzero(size):
        moved = z.copy()
        moved[k] += PROBE * size[k]
        slopes[:, k] = (load.action(state.time, ends, moved).rates - rates) / (moved[k] - z[k])
    return slopes
