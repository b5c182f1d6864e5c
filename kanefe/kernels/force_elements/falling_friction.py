"""Dry friction along joint coordinates that falls with the speed of slipping (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.coordinate_friction import (
    AT,
    drag_along,
    is_held,
    load_on,
    pull_size,
    share_kept,
)
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE

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
    out[0] = size - numbers[AT.static] * load_on(numbers, states) if held else numbers[AT.static]
    out[1] = numbers[AT.static] if held else slip_force(numbers, size, ends, states)


@kernel
def slip_force(numbers: Any, size: Any, ends: Any, states: Any) -> Any:
    """Return what friction leaves of a pull, N; below 0 it holds."""
    load, c = load_on(numbers, states), numbers[AT.damping]
    below = size - numbers[AT.static] * load
    if is_held(numbers, states):
        return below
    fall = (numbers[AT.static] - numbers[AT.sliding]) * load
    s = slip_speed(size, numbers[AT.sliding] * load, fall, c, numbers[AT.stribeck_speed])
    return c * s if s.real > 0.0 else below


@inlined
def slip_speed(pull: Any, least: Any, fall: Any, damping: Any, speed: Any) -> Any:
    """Return how fast an anchor slips (m/s): the root of ``c s + F(s) = pull``, 0 if there is none.

    ``F(s) = least + fall exp(-(s/speed)^2)``, N: friction of fast slipping, and how much more it is at rest; c is the
    damping of the anchor, N s/m. Newton's method from above, halved where it would leave.
    """
    s = pull / damping
    if s.real <= 0.0:
        return 0.0 * s
    for _ in range(MOST_TRIALS):
        share = np.exp(-s * s / (speed * speed))
        value = damping * s + least + fall * share - pull
        slope = damping - 2.0 * fall * share * s / (speed * speed)
        step = value / slope if slope.real > 0.0 else 0.5 * s
        if abs(step.real) <= 1e-15 * s.real:
            s = s - step
            break
        s = s - step if (s - step).real > 0.5 * s.real else 0.5 * s
        if s.real * damping < 1e-12 * pull.real:
            return 0.0 * s
    return s
