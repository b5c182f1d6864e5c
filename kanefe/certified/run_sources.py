"""Sources of error of a run itself: steps in time, and how often outputs are taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kanefe.certified.choice import Choice, Source
from kanefe.certified.quantity import Quantity
from kanefe.integrate.options import RunOptions

LOOSEST, TIGHTEST = 1e-3, 1e-12
"""Relative errors of a step between which runs are tried."""

HALVINGS = 8
"""Number of times that a fixed step may be halved."""

DENSER = 9
"""Number of times that output times may be doubled."""


def step_source(options: RunOptions, given: Mapping[str, Any], quantities: Sequence[Quantity]) -> Source:
    """Return the steps of a run: a tenth of the tolerance at each level, or half the fixed step.

    It begins at the tolerance of the user, or at a tenth of the smallest accuracy that is asked for.
    """
    if options.step is not None:
        steps = [options.step / 2**n for n in range(HALVINGS)]
        return Source(
            "steps in time",
            tuple(Choice(f"steps of {step:.4g} s", f"step={step!r}", {"step": step}) for step in steps),
            is_noise=True,
        )
    wanted = min((quantity.relative for quantity in quantities if quantity.relative is not None), default=1e-3)
    first = options.rtol or min(max(0.1 * wanted, TIGHTEST), LOOSEST)
    count = max(1, int(np.floor(np.log10(first / TIGHTEST) + 1e-9)) + 1)
    choices = []
    for level in range(count):
        rtol = float(f"{first / 10**level:.6g}")
        changes = {"rtol": rtol}
        if given.get("atol") is not None:
            changes["atol"] = float(f"{options.atol or 0.0:.6g}") / 10**level
        code = ", ".join(f"{name}={value:.6g}" for name, value in changes.items())
        choices.append(Choice(f"rtol {rtol:.3g}", code, changes))
    return Source("steps in time", tuple(choices), is_noise=True)


def output_source(options: RunOptions) -> Source:
    """Return how often outputs are taken, for what is looked for over time: twice as often at each level."""
    times, choices = options.times, []
    for level in range(DENSER):
        choices.append(Choice(f"{len(times)} outputs", "", {"output_times": times}))
        if level == 0:
            choices[0] = Choice(choices[0].text)
        times = np.union1d(times, 0.5 * (times[1:] + times[:-1]))
    return Source("outputs over time", tuple(choices), is_inner=True)


def looks_over_time(quantities: Sequence[Quantity]) -> bool:
    """Return whether what is asked for may be missed between output times."""
    return any(callable(quantity.what) or quantity.over == "largest" for quantity in quantities)
