"""Critical speeds: the frequency of a mode is a multiple of the frequency of rotation."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Vector
from kanefe.linear.modes.eigenvalues import GROWTH
from kanefe.linear.modes.floquet_modes import FloquetModes
from kanefe.linear.modes.modes import Modes
from kanefe.linear.over_speed.followed_modes import THINNEST, AnyModes, Curves, root_of
from kanefe.linear.over_speed.whirl import whirl_of

FOUND = 1e-7
"""Distance from the line, relative to the highest frequency, below which a crossing is real; above it is a jump."""

BESIDE = 1e-9
"""Distance to either side of a jump at which it is examined, relative to the interval of speeds."""

POINT = 1e-6
"""Growth, relative to the highest frequency, below which the two speeds between which a mode grows count as one."""

ROUND = 1e-3
"""Whirl below which orbits count as lines, neither forward nor backward."""


@dataclass(frozen=True, eq=False)
class CriticalSpeed:
    """A speed at which the frequency of a mode is a multiple of that of rotation; ``print`` shows a line.

    Attributes
    ----------
    speed : float
        rad/s.
    order : float
        The multiple; 0: the mode is at rest in the frame of the scene.
    column : int
        Column of the Campbell diagram; without damping, number of the mode among the undamped ones.
    eigenvalue : complex
        Of the mode at that speed, 1/s.
    modes : Modes or FloquetModes
        All modes at that speed.
    number : int
        Number of the mode among them.
    """

    speed: float
    order: float
    column: int
    eigenvalue: complex
    modes: AnyModes
    number: int

    @property
    def damping_ratio(self) -> float:
        """``-Re lambda / |lambda|``, 1 for critical damping; negative: it grows. Zero for order 0."""
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size > 0.0 and self.order > 0.0 else 0.0

    @property
    def whirl(self) -> float:
        """Whirl about the axis of the fastest spin: 1 forward on circles, -1 backward on circles, 0 neither.

        In the frame of the scene; 0 for order 0, and NaN for scenes that change with the azimuth.
        """
        if self.order == 0.0:
            return 0.0
        return float(whirl_of(self.modes)[self.number]) if isinstance(self.modes, Modes) else float("nan")

    @property
    def sense(self) -> str:
        """'forward', 'backward', or '' if orbits are lines or unknown."""
        return "forward" if self.whirl > ROUND else "backward" if self.whirl < -ROUND else ""

    def shape(self, body: str, interface: str = "") -> np.ndarray:
        """Return the motion of a frame: displacement (m) and rotation (rad) in N, complex, shape (6,): `Modes.shape`.

        Raises
        ------
        ModelError
            If there is no such body or interface, or the scene changes with the azimuth.
        """
        if isinstance(self.modes, FloquetModes):
            raise ModelError(
                "a mode of a scene that changes with the azimuth has several frequencies. Remedy: modes.tangents, the "
                "shape of each harmonic"
            )
        return np.asarray(self.modes.shape(body, interface)[self.number])

    def __repr__(self) -> str:
        sense = f" {self.sense}" if self.sense else ""
        damping = 100.0 * self.damping_ratio if abs(self.damping_ratio) > GROWTH else 0.0
        return (
            f"{self.speed:.6g} rad/s ({30.0 / np.pi * self.speed:.6g} rpm): order {self.order:g}, mode "
            f"{self.column + 1}{sense}, damping {damping:.3g} %"
        )


def critical_speeds(curves: Curves, order: float) -> list[CriticalSpeed]:
    """Return the critical speeds of followed modes, ascending.

    Parameters
    ----------
    curves : Curves
        Refined.
    order : float
        Multiple of the rotation, zero or more.
    """
    if order == 0.0:
        return sorted(_standing(curves), key=lambda found: found.speed)
    speeds = curves.speeds
    found = []
    for column in range(len(curves.born)):

        def above(speed: float, column: int = column) -> float:
            return abs(curves.at(speed).values[column].imag) - order * abs(speed)

        at = speeds[speeds >= curves.born[column]]
        for (a, at_a), (b, at_b) in pairwise(_looked_at(above, at, THINNEST * curves.height)):
            if (at_a > 0.0) != (at_b > 0.0):
                speed = root_of(above, a, b)
                if speed == 0.0:
                    continue  # zero frequency at zero speed is on every line
                if abs(above(speed)) <= FOUND * curves.height:
                    found.append(_critical(curves, speed, order, column))
                else:
                    _warn_of_jump(column, speed)
    return sorted(found, key=lambda one: one.speed)


def _critical(curves: Curves, speed: float, order: float, column: int) -> CriticalSpeed:
    at = curves.at(speed)
    return CriticalSpeed(speed, order, column, complex(at.values[column]), at.modes, int(at.numbers[column]))


def _warn_of_jump(column: int, speed: float) -> None:
    warnings.warn(
        f"mode {column + 1} cannot be followed through {speed:.6g} rad/s, where it may cross the order: it jumps. "
        "Remedy: more speeds about it",
        AccuracyWarning,
        stacklevel=outside(),
    )


def _looked_at(above: Callable[[float], float], speeds: Vector, thin: float) -> list[tuple[float, float]]:
    """Return speeds and values of a function, including its extrema that are within `thin` of zero."""
    values = np.array([above(speed) for speed in speeds])
    points = dict(zip(speeds.tolist(), values.tolist(), strict=True))
    for i, value in enumerate(values):
        low, high = max(i - 1, 0), min(i + 1, len(speeds) - 1)
        beside = np.sign(value) * values[low : high + 1]
        if 0.0 < abs(value) <= thin and beside.min() == abs(value):
            sign = float(np.sign(value))
            least = minimize_scalar(
                lambda x, sign=sign: sign * above(x), bounds=(speeds[low], speeds[high]), method="bounded"
            )
            points[float(least.x)] = sign * float(least.fun)
    return sorted(points.items())


def _standing(curves: Curves) -> Iterator[CriticalSpeed]:
    """Yield the critical speeds of order 0: a whirl reverses, or a real eigenvalue passes through zero."""
    looked_at = set(curves.speeds.tolist())
    thin = THINNEST * curves.height
    for column, born in enumerate(curves.born):

        def turns(speed: float, column: int = column) -> float:
            return float(curves.at(speed).values[column].imag)

        points = _looked_at(turns, curves.speeds[curves.speeds >= born], thin)
        looked_at |= {a for a, _ in points}
        for (a, at_a), (b, at_b) in pairwise((a, at_a) for a, at_a in points if at_a != 0.0):
            if at_a * at_b > 0.0:
                continue
            speed = root_of(turns, a, b)
            if abs(turns(speed)) > FOUND * curves.height:
                # a mode with straight orbits has either sign, which may alternate
                sizes = [abs(turns(at)) for at in (max(a, speed - BESIDE * (b - a)), min(b, speed + BESIDE * (b - a)))]
                if abs(sizes[1] - sizes[0]) > THINNEST * curves.height:
                    _warn_of_jump(column, speed)
                continue
            size = abs(curves.at(speed).values[column])
            if _determinant(curves.at(speed).modes)[0] < 0.0 and size > POINT * curves.height:
                looked_at.add(speed)  # the mode grows between two speeds of zero frequency
            else:
                yield _critical(curves, speed, 0.0, column)
    for a, b in pairwise(sorted(looked_at)):
        sign_a, size_a = _determinant(curves.at(a).modes)
        if sign_a * _determinant(curves.at(b).modes)[0] < 0.0:

            def beside(speed: float, size: float = size_a) -> float:
                sign, own = _determinant(curves.at(speed).modes)
                return sign * float(np.exp(min(own - size, 100.0)))

            speed = root_of(beside, a, b)
            yield _critical(curves, speed, 0.0, int(np.abs(curves.at(speed).values).argmin()))


def _determinant(modes: AnyModes) -> tuple[float, float]:
    """Return sign and logarithm of the product of all eigenvalues but rigid motions; 1 and 0 for Floquet modes.

    The product changes sign where a real eigenvalue passes through zero.
    """
    if isinstance(modes, FloquetModes):
        return 1.0, 0.0
    values = modes.eigenvalues[~modes.is_rigid]
    is_real = values.imag == 0.0
    sizes = np.log(np.maximum(np.abs(values), 1e-300)) * np.where(is_real, 1.0, 2.0)
    return float(np.prod(np.sign(values.real[is_real]))), float(sizes.sum())
