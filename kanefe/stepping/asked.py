"""What `kanefe.System.start` is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from kanefe.errors import ModelError
from kanefe.integrate.options import RunOptions
from kanefe.integrate.trajectory import is_finite_number
from kanefe.scene.targets import Named

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start

STEPS = 100.0
"""Default duration of a simulation relative to the usual step."""

LEAST = 1.0
"""Least default duration of a simulation, s."""


class Asked(NamedTuple):
    """Arguments of `kanefe.System.start`.

    Attributes
    ----------
    start : state or None
    inputs, outputs : names, or None
    every : float
        Usual length of a step, s.
    options : RunOptions
    """

    start: Start
    inputs: Named | None
    outputs: Named | None
    every: float
    options: RunOptions


def stretch(t: float, every: float, duration: float | None) -> tuple[float, float]:
    """Return start and assumed end of a simulation, s; raise a ModelError if a number is not valid."""
    for name, value in (("every", every), ("duration", duration)):
        if value is None and name == "duration":
            continue
        if value is None or not (is_finite_number(value) and value > 0.0):
            raise ModelError(f"{name} of a simulation must be above zero, in s, not {value!r}")
    if not is_finite_number(t):
        raise ModelError(f"t of a simulation must be a finite time in s, not {t!r}")
    return float(t), float(t) + (max(STEPS * every, LEAST) if duration is None else float(duration))
