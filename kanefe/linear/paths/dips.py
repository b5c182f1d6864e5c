"""Stops within a step at which a stiffness may fall through zero and come back, foreseen from its ends.

Between two stops with as many negative stiffnesses a cubic through the stiffnesses at both ends, and their slopes along
the path, foresees how near to zero they come. Where that is near, the path is looked at there.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.linear.paths.arc_length import Stop, stepped, turns_between

if TYPE_CHECKING:
    from kanefe.linear.paths.loaded_scene import LoadedScene

NEAREST = 3
"""Number of stiffnesses on each side of zero that are foreseen."""

NEAR = 0.5
"""Foreseen size of a stiffness, relative to the smaller one at the ends, below which it is looked at."""

FINEST = 1e-3
"""Shortest part relative to the step that is looked into."""

BESIDE = 1e-3
"""Displacements of the differences that give slopes, rad, scene lengths or shares of the range of factors: they err by
the square of it."""


def parted(scene: LoadedScene, begin: Stop, end: Stop) -> list[Stop]:
    """Return a step as stops in order, between which no stiffness is foreseen to pass zero and come back."""
    slopes = cache(partial(_slopes, scene))
    done, rest = [begin], [end]
    while rest:
        low, high = done[-1], rest[-1]
        at = _nearest_to_zero(slopes, low, high) if high.step - low.step > FINEST * end.step else None
        if at is None:
            done.append(rest.pop())
        else:
            rest.append(stepped(scene, begin, low.step + at * (high.step - low.step), near=(low.step, low)))
    return done


def _nearest_to_zero(slopes_at: Callable[[Stop], dict[int, float]], low: Stop, high: Stop) -> float | None:
    """Return at which share between two stops a stiffness comes nearest to zero; None if it does not come near.

    Nor where the factor turns: there a stiffness that only touches zero is another path's, and round-off is its sign.
    """
    if low.negative != high.negative or turns_between(low, high):
        return None
    count, negative = len(low.balance.stiffnesses), low.negative
    length, found = high.step - low.step, None
    for number in range(max(negative - NEAREST, 0), min(negative + NEAREST, count)):
        side = -1.0 if number < negative else 1.0
        ends = side * np.array([stop.balance.stiffnesses[number] for stop in (low, high)])
        least = NEAR * float(ends.min())
        slopes = side * length * np.array([slopes_at(stop)[number] for stop in (low, high)])
        if slopes[0] >= 0.0 or slopes[1] <= 0.0:  # it falls or rises all the way
            continue
        share, value = _lowest(ends, slopes)
        if value < least:
            least, found = value, share
    return found


def _lowest(ends: Vector, slopes: Vector) -> tuple[float, float]:
    """Return where the cubic of two ends and slopes over the unit interval, first falling, is lowest; and its value."""
    rise = ends[1] - ends[0]
    cubic = np.polynomial.Polynomial(
        (ends[0], slopes[0], 3.0 * rise - 2.0 * slopes[0] - slopes[1], slopes[0] + slopes[1] - 2.0 * rise)
    )
    places = [float(x.real) for x in cubic.deriv().roots() if abs(x.imag) < 1e-9 and 0.0 < x.real < 1.0]
    share = min(places, key=lambda x: float(cubic(x)), default=0.5)
    return min(max(share, 0.05), 0.95), float(cubic(share))


def _slopes(scene: LoadedScene, stop: Stop) -> dict[int, float]:
    """Return the slopes of the stiffnesses nearest to zero along the path at a stop, by their numbers.

    By differences of forces: ``phi^T dH/ds phi`` of the shape phi of each, of unit mass.
    """
    balance, found = stop.balance, {}
    shapes = np.linalg.eigh(0.5 * (balance.H + balance.H.T))[1]
    ahead = BESIDE / scene.largest(stop.ahead)
    for number in range(max(stop.negative - NEAREST, 0), min(stop.negative + NEAREST, shapes.shape[1])):
        z = balance.along @ shapes[:, number]
        aside = BESIDE / float(np.abs(scene.weights * z).max())
        total = 0.0
        for a in (-1.0, 1.0):
            for b in (-1.0, 1.0):
                q = scene.moved(stop.q, a * ahead * stop.ahead.z + b * aside * z)
                forces = balance.forces_beside(q, stop.factor + a * ahead * stop.ahead.factor)
                total -= a * b * float(shapes[:, number] @ forces)
        found[number] = total / (4.0 * ahead * aside)
    return found
