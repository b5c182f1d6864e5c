"""Steps by pseudo-arc-length: predictor along the tangent, corrector across it.

A step of length s goes along the unit tangent; Newton's corrections are orthogonal to it, so that limit points are
passed (Riks, Int. J. Solids Struct. 15 (1979) 529-551; Keller, in Applications of Bifurcation Theory, 1977).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.linear.paths.loaded_scene import Balance, LoadedScene, Tangent
from kanefe.linear.paths.spectrum import MotionSpectrum

MOST_CORRECTIONS, PATIENCE = 10, 60
"""Largest number of Newton's corrections of one step, and of one beside a branch point, where each only halves the
error."""

SETTLED = 1e-7
"""Correction with which a step ends, rad, scene lengths or shares of the range of factors: Newton's method squares the
error."""

ROUNDED, UNMOVED = 1e-5, 0.9
"""Correction in rad or scene lengths below which one that is not smaller than the given share of the last one is
round-off of a nearly singular stiffness."""

MOST_QUICK, GROWN, QUICKLY_SETTLED = 20, 10.0, 1e-11
"""Largest number of corrections by the stiffness at the last stop, growth of one relative to the smallest before it at
which they end, and the last one, in the unit of `SETTLED`: each is a small part of the one before."""


class PathLost(Exception):
    """A step that does not come to balance; its text says what failed."""


@dataclass(frozen=True, eq=False)
class Stop:
    """A point on a path: where it is, and the stop, direction and length of the step that found it.

    Attributes
    ----------
    balance : Balance
    ahead : Tangent
        Unit tangent of the path in the sense of travel.
    origin : Stop or None
    step : float
        Length of the step from the origin.
    corrected : float
        Length of all corrections of this step.
    """

    balance: Balance
    ahead: Tangent
    origin: Stop | None = None
    step: float = 0.0
    corrected: float = 0.0

    def bend(self, scene: LoadedScene) -> Tangent:
        """Return the curvature of the path across its tangent, from the stop before; 0 for the first stop."""
        if self.origin is None or not self.step:
            return Tangent(0.0 * self.ahead.z, 0.0)
        before = self.origin.ahead
        z, factor = (self.ahead.z - before.z) / self.step, (self.ahead.factor - before.factor) / self.step
        share = scene.dot(Tangent(z, factor), self.ahead)
        return Tangent(z - share * self.ahead.z, factor - share * self.ahead.factor)

    @property
    def q(self) -> Vector:
        """Coordinates."""
        return self.balance.q

    @property
    def factor(self) -> float:
        """Of the loads."""
        return self.balance.factor

    @property
    def negative(self) -> int:
        """Number of negative stiffnesses."""
        return self.balance.negative

    @property
    def spectrum(self) -> MotionSpectrum:
        """Of the small motions."""
        return self.balance.spectrum

    @property
    def unstable(self) -> int:
        """Number of growing motions."""
        return self.balance.unstable


def turns_between(a: Stop, b: Stop) -> bool:
    """Return whether the factor rises at one of two stops and falls at the other."""
    return (a.ahead.factor < 0.0) != (b.ahead.factor < 0.0)


def corrected(scene: LoadedScene, q: Vector, factor: float, row: Tangent, most: float) -> tuple[Balance, float]:
    """Return the balance across a direction from a guess, and the length of the corrections.

    Raises
    ------
    PathLost
        If Newton's method does not converge, or its corrections are longer than `most`.
    """
    total, before = 0.0, np.inf
    try:
        for _ in range(MOST_CORRECTIONS if np.isfinite(most) else PATIENCE):
            balance = scene.balance(q, factor)
            change = balance.solved(balance.forces, row, 0.0)
            size = scene.largest(change)
            total += scene.norm(change)
            if UNMOVED * before < size <= ROUNDED:
                return balance, total
            if not total <= most or size > max(2.0 * before, ROUNDED):
                raise PathLost("the corrections grow")
            q, factor, before = scene.moved(q, change.z), factor + change.factor, size
            if size <= SETTLED:
                return scene.balance(q, factor), total
    except KanefeError as error:
        raise PathLost(str(error)) from error
    raise PathLost("the corrections do not end")


def _quickly_corrected(
    scene: LoadedScene, near: Balance, q: Vector, factor: float, row: Tangent, most: float
) -> tuple[Balance, float] | None:
    """Return the same by the stiffness of a balance near it, which only takes forces; None if they do not vanish."""
    total = smallest = np.inf
    try:
        corrections = near.bordered(row).corrections()
        next(corrections)
        for count in range(MOST_QUICK):
            change = corrections.send(near.forces_beside(q, factor))
            size = scene.largest(change)
            total = scene.norm(change) + (total if count else 0.0)
            if not total <= most or not size < GROWN * smallest:
                return None
            q, factor, smallest = scene.moved(q, change.z), factor + change.factor, min(size, smallest)
            if size <= QUICKLY_SETTLED:
                return scene.balance(q, factor), total
    except (KanefeError, np.linalg.LinAlgError):
        return None
    return None


def stepped(
    scene: LoadedScene, origin: Stop, length: float, most: float = np.inf, near: tuple[float, Stop] | None = None
) -> Stop:
    """Return the stop at a length along the tangent of another one; a PathLost if there is none.

    `near` is a length and the stop there, where the search begins instead of at the origin.
    """
    ahead, (begun, begin) = origin.ahead, near or (0.0, origin)
    bent = origin.bend(scene) if near is None else Tangent(0.0 * ahead.z, 0.0)
    along, across = length - begun, 0.5 * length**2
    factor = begin.factor + along * ahead.factor + across * bent.factor
    try:
        guess = scene.moved(begin.q, along * ahead.z + across * bent.z)
    except KanefeError as error:
        raise PathLost(str(error)) from error
    found = _quickly_corrected(scene, begin.balance, guess, factor, ahead, most)
    balance, total = found or corrected(scene, guess, factor, ahead, most)
    if balance.small.is_singular:
        raise PathLost("the loops are singular there")
    return Stop(balance, balance.tangent(ahead), origin, length, total)


def found_beside(scene: LoadedScene, begin: Stop, q: Vector, factor: float, most: float) -> Balance:
    """Return the balance across the tangent of a stop near it, from a guess; a PathLost if there is none.

    `most` is the largest length of all corrections.
    """
    found = _quickly_corrected(scene, begin.balance, q, factor, begin.ahead, most)
    return (found or corrected(scene, q, factor, begin.ahead, most))[0]
