"""Ranges of speed in which a scene is stable, also over a parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.frames import Vector
from kanefe.linear.over_speed.followed_modes import DIGITS, STILL, AnyModes, root_of

if TYPE_CHECKING:
    from kanefe.views.plots import Figure


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
        Of the mode that grows on one side, 1/s; its real part is round-off.
    modes : Modes or FloquetModes
        All modes at that speed.
    number : int
        Number of the mode among them.
    """

    speed: float
    begins: bool
    eigenvalue: complex
    modes: AnyModes
    number: int

    def __repr__(self) -> str:
        frequency = abs(self.eigenvalue.imag) / (2.0 * np.pi)
        turns = abs(self.eigenvalue.imag) > STILL * abs(self.modes.eigenvalues).max()
        kind = f"a mode of {frequency:.6g} Hz" if turns else "a mode without oscillation"
        return f"{'unstable' if self.begins else 'stable'} from {self.speed:.6g} rad/s on: {kind}"


def growth_of(modes: AnyModes) -> tuple[float, int]:
    """Return the fastest growth of a mode (1/s, negative if all decay) and its number; without rigid motions."""
    growths = np.where(modes.is_rigid, -np.inf, modes.eigenvalues.real)
    number = int(growths.argmax())
    return float(growths[number]), number


def stability_onsets(of: Callable[[float], AnyModes], speeds: Vector) -> list[StabilityOnset]:
    """Return the speeds at which the fastest growth of all modes leaves or reaches zero, between ascending speeds.

    Growth within round-off counts as zero: an undamped scene is stable as long as no mode grows.
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
            speed = root_of(lambda x: growth_of(of(x))[0], a, b)
        else:
            speed = _halved(grows, a, b, before)
        modes = of(speed)
        number = growth_of(modes)[1]
        found.append(StabilityOnset(speed, after, complex(modes.eigenvalues[number]), modes, number))
    return found


def _halved(grows: Callable[[float], bool], a: float, b: float, before: bool) -> float:
    """Return the speed at which an undamped scene begins to grow, by bisection."""
    while b - a > DIGITS * max(abs(a), abs(b)):
        middle = 0.5 * (a + b)
        if middle in (a, b):
            break
        a, b = (middle, b) if grows(middle) == before else (a, middle)
    return 0.5 * (a + b)


@dataclass(frozen=True, eq=False)
class StabilityMap:
    """Ranges of speed in which a scene is stable over a parameter, from `stability_map`; ``print`` shows them.

    Attributes
    ----------
    speeds : ndarray, shape (S,)
        Speeds that were evaluated for each value, rad/s.
    values : ndarray, shape (P,)
        Values of the parameter.
    growth : ndarray, shape (P, S)
        Growth of the fastest mode, 1/s; negative: all decay.
    onsets : tuple of tuples of StabilityOnset
        For each value the speeds at which a mode begins or ceases to grow, ascending.
    """

    speeds: np.ndarray
    values: np.ndarray
    growth: np.ndarray
    onsets: tuple[tuple[StabilityOnset, ...], ...]

    def __str__(self) -> str:
        lines = [f"stable speeds from {self.speeds[0]:g} to {self.speeds[-1]:g} rad/s"]
        for value, found, growth in zip(self.values, self.onsets, self.growth, strict=True):
            edges = [float(self.speeds[0]), *(one.speed for one in found), float(self.speeds[-1])]
            first_is_stable = found[0].begins if found else growth[0] <= 0.0
            kept = pairwise(edges[0 if first_is_stable else 1 :])
            ranges = ", ".join(f"{a:.6g} to {b:.6g}" for i, (a, b) in enumerate(kept) if i % 2 == 0)
            lines.append(f"{value:12.6g}  {ranges or 'none'}")
        return "\n".join(lines)

    @checked
    def plot(self, path: str | Path | None = None, *, name: str = "parameter") -> Figure:
        """Draw growth over speed and parameter with the limits of stability, and write the picture to `path` if given.

        Parameters
        ----------
        path : path, optional
        name : str
            Name of the parameter, for its axis.

        Raises
        ------
        ModelError, MissingDependency
            If the kind of file is unknown, or matplotlib is not installed.
        """
        from kanefe.views.stability_picture import stability_picture

        limits = [[one.speed for one in found] for found in self.onsets]
        return stability_picture(self.speeds, self.values, self.growth, limits, name, path)
