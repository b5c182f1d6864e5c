"""A path from its first stop to its end: stops, critical points among them, and why it ended."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kanefe.linear.paths.arc_length import PathLost, Stop
from kanefe.linear.paths.crossings import Crossing, crossings
from kanefe.linear.paths.loaded_scene import LoadedScene, Tangent
from kanefe.linear.paths.walk import Walk
from kanefe.linear.paths.zeros import crossing_of_factor

FINEST = 1e-3
"""Step relative to the longest at which a path ends if the critical points on it cannot be told apart."""


FEWEST, BESIDE = 4, 0.1
"""Number of points above which a path may have closed, and its distance from its start relative to the step."""


class Traced(NamedTuple):
    """The stops of a path, its critical points with the numbers of their stops, and why it ended.

    `is_whole`: whether it ended at the bounds of the factor, or has closed.
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
        except PathLost as lost:
            return Traced(stops, found, f"lost at {here.factor:.6g} times the loads: {lost}", False)
        is_first = on_branch and len(stops) == 1
        try:
            between = [] if is_first else crossings(scene, here, there)
        except PathLost:
            between = None
        if between is None:
            if there.step > FINEST * longest / scene.largest(here.ahead):
                walk.shorter(0.5 * there.step)
                continue
            return Traced(stops, found, f"lost at {here.factor:.6g} times the loads: a critical point there", False)
        for crossing in between:
            found.append((len(stops), crossing))
            stops.append(crossing.stop)
            crossing.stop.balance.release()
        stops.append(there)
        here.balance.release()
        if len(stops) > FEWEST and _passes(scene, here, there, start):
            return Traced(stops, found, "where it began: it is closed", True)
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


def _passes(scene: LoadedScene, here: Stop, there: Stop, start: Stop) -> bool:
    """Return whether a step passes the start of the path, in the sense in which it left."""
    if abs(there.factor - start.factor) > 2.0 * there.step * scene.span or scene.dot(there.ahead, start.ahead) <= 0.0:
        return False
    to, along = [], []
    for stop in (here, there):
        z = scene.between(stop.q, start.q, there.balance)
        to.append(Tangent(z, start.factor - stop.factor))
        along.append(scene.dot(to[-1], start.ahead))
    if not along[0] > 0.0 >= along[1]:
        return False
    share = along[0] / (along[0] - along[1])
    aside = Tangent(to[0].z + share * (to[1].z - to[0].z), to[0].factor + share * (to[1].factor - to[0].factor))
    return scene.norm(aside) <= BESIDE * there.step


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
