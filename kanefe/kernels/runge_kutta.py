"""The classical Runge-Kutta method of order 4, one stage at a time, and the check of what it comes to."""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import inlined

NO_INERTIA, NOT_FINITE = -1, -2
"""What kernels return in place of a number of steps."""


@inlined
def finish_stage(stage: int, h: float, y: np.ndarray, slope: np.ndarray, at: np.ndarray, sums: np.ndarray) -> None:
    """Go from the slope at a stage (0 to 3) to the state `at` of the next one; after the last, `y` is a step further.

    Before the first stage, `at` and `sums` equal `y`.
    """
    weight = h / 6.0 if stage == 0 or stage == 3 else h / 3.0
    if stage == 3:
        for i in range(len(y)):
            sums[i] += weight * slope[i]
            at[i] = y[i] = sums[i]
        return
    reach = h if stage == 2 else 0.5 * h
    for i in range(len(y)):
        sums[i] += weight * slope[i]
        at[i] = y[i] + reach * slope[i]


@inlined
def stage_time(evaluation: int) -> float:
    """Return the time of an evaluation since the start, in steps."""
    stage = evaluation % 4
    return evaluation // 4 + (0.0 if stage == 0 else 1.0 if stage == 3 else 0.5)


@inlined
def is_finite(x: np.ndarray) -> bool:
    """Tell whether no number of x is infinite or not a number."""
    total = 0.0
    for i in range(len(x)):
        total += abs(x[i])
    return total < np.inf
