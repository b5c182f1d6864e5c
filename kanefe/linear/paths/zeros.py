"""Stops at zeros of functions along a step of a path, on which all of this is smooth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from kanefe.linear.paths.arc_length import SETTLED, PathLost, Stop, stepped
from kanefe.linear.paths.continuity import check_continuity
from kanefe.linear.paths.loaded_scene import LoadedScene

DIGITS = 1e-11
"""Length of the bracket of a zero relative to the step."""

BESIDE, NODES = 0.01, np.arange(-2.5, 3.0)
"""Distance of stops beside a branch point relative to the step, and their places: at the point itself the corrector is
singular."""


def zero(
    scene: LoadedScene, low: Stop, high: Stop, function: Callable[[Stop], float], step: float, digits: float = DIGITS
) -> Stop:
    """Return the stop at the zero of a function between two stops of one origin, in a bracket of digits of a step."""
    origin, known = low.origin or low, {low.step: low, high.step: high}

    def value(length: float) -> float:
        if length not in known:
            at = min(known, key=lambda x: abs(x - length))
            known[length] = stepped(scene, origin, length, near=(at, known[at]))
        return function(known[length])

    for end in (low, high):
        if value(end.step) == 0.0:
            return end
    return known[float(brentq(value, low.step, high.step, xtol=digits * step, rtol=1e-15))]


def smooth_zero(scene: LoadedScene, low: Stop, high: Stop, function: Callable[[Stop], float], step: float) -> Stop:
    """Return the same where the stiffness of the corrector vanishes as well: interpolated from beside it."""
    return interpolated_zero(scene, zero(scene, low, high, function, step, 0.1 * BESIDE), function, step)


def interpolated_zero(scene: LoadedScene, near: Stop, function: Callable[[Stop], float], step: float) -> Stop:
    """Return the stop at the zero of a function near a stop, from what the function is beside it."""
    origin, gap = near.origin or near, BESIDE * step
    stops = [stepped(scene, origin, near.step + gap * float(node), near=(near.step, near)) for node in NODES]
    check_continuity(scene, stops[0], stops[-1])  # two paths that are near to each other have no common point
    values = np.array([function(stop) for stop in stops])
    roots = np.roots(np.polyfit(NODES, values, len(NODES) - 1))
    root = float(min(roots[np.abs(roots.imag) < 1e-6].real, key=abs, default=0.0))
    shares = [float(np.prod([(root - y) / (x - y) for y in NODES if y != x])) for x in NODES]
    here = stops[1]
    z = [scene.between(here.q, stop.q, here.balance) for stop in stops]
    q = scene.moved(here.q, np.einsum("i,ij->j", shares, z))
    balance = scene.balance(q, float(np.dot(shares, [stop.factor for stop in stops])))
    return Stop(balance, origin.ahead, origin, near.step + gap * root)


def crossing_of_factor(scene: LoadedScene, a: Stop, b: Stop, factor: float) -> Stop:
    """Return the stop between two stops of one step, or a stop and one that it led to, at which loads have a factor.

    Raises
    ------
    PathLost
        If it is not found: the factor jumps in between, from one path to another.
    """
    leads = b.origin is None or b.origin.balance is a.balance  # what was found on the step is of a copy of its origin
    low = replace(a, origin=a, step=0.0) if leads else a
    found = zero(scene, low, b, lambda stop: stop.factor - factor, b.step)
    if abs(found.factor - factor) > SETTLED * scene.span:
        raise PathLost("the factor jumps from one path to another")
    return found
