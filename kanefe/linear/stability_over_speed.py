"""Over which speeds a scene is stable, and how that changes with a parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from kanefe.frames import Vector
from kanefe.linear.followed_modes import AnyModes

DIGITS = 1e-12
"""Of a speed, to which a limit is solved for."""


@dataclass(frozen=True, eq=False)
class StabilityOnset:
    """A speed at which a scene begins or ceases to be stable; ``print`` shows a line.

    Attributes
    ----------
    speed : float
        rad/s.
    begins : bool
        Whether it is unstable above that speed, and stable below.
    eigenvalue : complex
        Of the mode that grows on one side, 1/s: its real part is round-off.
    modes : Modes or FloquetModes
        All at that speed.
    number : int
        Which of them it is.
    """

    speed: float
    begins: bool
    eigenvalue: complex
    modes: AnyModes
    number: int

    def __repr__(self) -> str:
        frequency = abs(self.eigenvalue.imag) / (2.0 * np.pi)
        kind = f"a mode of {frequency:.6g} Hz" if frequency > 0.0 else "a mode without oscillation"
        return f"{'unstable' if self.begins else 'stable'} from {self.speed:.6g} rad/s on: {kind}"


def growth_of(modes: AnyModes) -> tuple[float, int]:
    """Return the fastest growth of a mode (1/s, negative if all decay) and its number; rigid motions left out."""
    growths = np.where(modes.is_rigid, -np.inf, modes.eigenvalues.real)
    number = int(growths.argmax())
    return float(growths[number]), number


def stability_onsets(of: Callable[[float], AnyModes], speeds: Vector) -> list[StabilityOnset]:
    """Return where the fastest growth of all modes leaves or reaches zero, between some ascending speeds.

    Growth of round-off counts as none: an undamped scene is stable up to where a mode grows.
    """

    def grows(speed: float) -> bool:
        return bool(of(speed).grows.any())

    found = []
    for a, b in pairwise(speeds.tolist()):
        before, after = grows(a), grows(b)
        if before == after:
            continue
        ends = growth_of(of(a))[0], growth_of(of(b))[0]
        if ends[0] * ends[1] < 0.0:
            size = max(abs(a), abs(b))
            speed = float(brentq(lambda x: growth_of(of(x))[0], a, b, xtol=DIGITS * size, rtol=1e-15))
        else:
            speed = _halved(grows, a, b, before)
        modes = of(speed)
        number = growth_of(modes)[1]
        found.append(StabilityOnset(speed, after, complex(modes.eigenvalues[number]), modes, number))
    return found


def _halved(grows: Callable[[float], bool], a: float, b: float, before: bool) -> float:
    """Return where a scene that does not decay begins to grow."""
    while b - a > DIGITS * max(abs(a), abs(b)):
        middle = 0.5 * (a + b)
        if middle in (a, b):
            break
        a, b = (middle, b) if grows(middle) == before else (a, middle)
    return 0.5 * (a + b)
