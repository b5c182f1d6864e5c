"""A path from its first stop to its end: stops, critical points among them, and why it ended."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kanefe.linear.paths.arc_length import PathLost, Stop, Walk
from kanefe.linear.paths.crossings import Crossing, crossing_of_factor, crossings
from kanefe.linear.paths.loaded_scene import LoadedScene, Tangent

FINEST = 1e-3
"""Step relative to the longest at which critical points count as one if they cannot be told apart."""


class Traced(NamedTuple):
    """The stops of a path, its critical points with the numbers of their stops, and why it ended.

    `is_whole`: whether it ended at the bounds of the factor.
    """

    stops: list[Stop]
    found: list[tuple[int, Crossing]]
    ended: str
    is_whole: bool


def traced(
    scene: LoadedScene, start: Stop, bounds: tuple[float, float], longest: float, most: int, on_branch: bool
) -> Traced:
    """Follow a path from a stop until the factor leaves its bounds; a branch begins at a critical point."""
    walk = Walk(scene, longest)
    stops: list[Stop] = [start]
    found: list[tuple[int, Crossing]] = []
    while len(stops) < most:
        here = stops[-1]
        try:
            there, leaves = _inside(scene, here, walk.next(here), bounds)
            is_first = on_branch and len(stops) == 1
            between = [] if is_first else crossings(scene, here, there)
        except PathLost as lost:
            return Traced(stops, found, f"lost at {here.factor:.6g} times the loads: {lost}", False)
        if between is None:
            if there.step > FINEST * longest / scene.largest(here.ahead):
                walk.shorter(0.5 * there.step)
                continue
            between = []
        for crossing in between:
            found.append((len(stops), crossing))
            stops.append(crossing.stop)
        stops.append(there)
        if leaves:
            return Traced(stops, found, f"at {there.factor:.6g} times the loads", True)
    return Traced(stops, found, f"after {len(stops)} points, at {stops[-1].factor:.6g} times the loads", False)


def _inside(scene: LoadedScene, here: Stop, there: Stop, bounds: tuple[float, float]) -> tuple[Stop, bool]:
    """Return the next stop within the bounds of the factor, and whether the path leaves them there."""
    low, high = bounds
    if low < there.factor < high:
        return there, False
    bound = high if there.factor >= high else low
    if (here.factor - bound) * (there.factor - bound) >= 0.0:  # a branch that begins on the bound
        return there, True
    return crossing_of_factor(scene, here, there, bound), True


def first_stop(scene: LoadedScene, q: np.ndarray, factor: float, sense: float) -> Stop:
    """Return the stop at a balance from which the factor is raised (sense 1) or lowered (-1)."""
    balance = scene.balance(q, factor)
    return Stop(balance, balance.tangent(Tangent(np.zeros(scene.model.free_count), sense * scene.span)))


def branch_start(scene: LoadedScene, stop: Stop, shape: np.ndarray, side: int) -> Stop:
    """Return the stop at a branch point that leads away from the path it was found on, along a shape."""
    across = Tangent(shape, 0.0)
    share = scene.dot(across, stop.ahead)
    across = scene.unit(Tangent(shape - share * stop.ahead.z, -share * stop.ahead.factor))
    return replace(stop, ahead=Tangent(side * across.z, side * across.factor), origin=None, step=0.0)
