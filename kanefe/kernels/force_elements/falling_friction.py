"""Dry friction along joint coordinates that falls with the speed of slipping (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.coordinate_friction import (
    DAMPING,
    REST,
    SLIDING,
    STATIC,
    drag_along,
    is_held,
    load_on,
    pull_size,
    share_kept,
)
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE

SPEED = REST + 3
"""Of its numbers, beside those of `coordinate_friction`: the speed in which it falls."""
MOST_TRIALS = 60


@called_by_address(*SIGNATURE)
def falling_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    size = pull_size(numbers, ends, states)
    kept = share_kept(numbers, ends, states)
    if not is_held(numbers, states):
        slips = slip_force(numbers, size, ends, states)
        kept = 1.0 - slips / size if slips.real > 0.0 else 0.0 * size + 1.0
    drag_along(numbers, ends, states, kept, out)


@called_by_address(*WATCH_SIGNATURE)
def falling_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and what of it slips."""
    size, held = pull_size(numbers, ends, states), is_held(numbers, states)
    out[0] = size - numbers[STATIC] * load_on(numbers, states) if held else numbers[STATIC]
    out[1] = numbers[STATIC] if held else slip_force(numbers, size, ends, states)


@kernel
def slip_force(numbers: Any, size: Any, ends: Any, states: Any) -> Any:
    """Return what friction leaves of a pull, N: see `kanefe.loads.falling_friction.slip_speed`; below 0 it holds."""
    load, c = load_on(numbers, states), numbers[DAMPING]
    below = size - numbers[STATIC] * load
    if is_held(numbers, states):
        return below
    least, fall, speed = numbers[SLIDING] * load, (numbers[STATIC] - numbers[SLIDING]) * load, numbers[SPEED]
    s = size / c
    if s.real <= 0.0:
        return below
    for _ in range(MOST_TRIALS):
        share = np.exp(-s * s / (speed * speed))
        value = c * s + least + fall * share - size
        slope = c - 2.0 * fall * share * s / (speed * speed)
        step = value / slope if slope.real > 0.0 else 0.5 * s
        if abs(step.real) <= 1e-15 * s.real:
            s = s - step
            break
        s = s - step if (s - step).real > 0.5 * s.real else 0.5 * s
        if s.real * c < 1e-12 * size.real:
            return below
    return c * s
