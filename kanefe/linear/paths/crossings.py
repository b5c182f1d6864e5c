"""Critical points between two stops of a path: where a stiffness vanishes, or a motion begins to flutter.

At a limit point the factor turns as well, and at a branch point it does not (Seydel, Practical Bifurcation and
Stability Analysis, 2010, chapter 5). Zeros are found along the arc, on which all of this is smooth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from kanefe.linear.paths.arc_length import Stop, stepped
from kanefe.linear.paths.continuity import check_continuity
from kanefe.linear.paths.loaded_scene import Balance, LoadedScene, Tangent

Kind = Literal["limit", "branch", "flutter"]

DIGITS = 1e-11
"""Length of the bracket of a zero relative to the step."""

ONSET = 1e-10
"""Length of the bracket of an onset of flutter relative to the step: a tenth of the digits that are told; more would
only find the round-off of nearly equal eigenvalues."""

TOGETHER = 1e-6
"""Distance of zeros relative to the step below which they are one point."""

TOUCHES = 1e-3
"""Least stiffness where a path turns, relative to those at the ends of the step, that counts as zero."""

BESIDE, NODES = 0.01, np.array((-1.5, -0.5, 0.5, 1.5))
"""Distance of stops beside a branch point relative to the step, and their places: at the point itself the corrector is
singular."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """A critical point on a path: its kind, the stop there, and the number of stiffnesses that vanish."""

    kind: Kind
    stop: Stop
    count: int = 1


def crossings(scene: LoadedScene, a: Stop, b: Stop) -> list[Crossing] | None:
    """Return the critical points on the step from a to b, in order; None if the step is too long to tell them apart."""
    turns = (a.ahead.factor < 0.0) != (b.ahead.factor < 0.0)
    has_potential = a.balance.is_symmetric and b.balance.is_symmetric
    change = b.negative - a.negative
    numbers = range(min(a.negative, b.negative), max(a.negative, b.negative)) if has_potential else range(change % 2)
    if turns and not numbers:
        crest = _smooth_zero(scene, a, b, lambda stop: stop.ahead.factor)
        least = (_least(crest.balance), min(_least(a.balance), _least(b.balance)))
        # another path that crosses where this one turns: the stiffness touches zero
        return [Crossing("branch", crest)] if least[0] <= TOUCHES * least[1] else None
    search = _zero if turns else _smooth_zero
    zeros = [search(scene, a, b, lambda stop, number=number: stop.balance.signed(number)) for number in numbers]  # type: ignore[misc]
    zeros.sort(key=lambda stop: stop.step)
    limit = None
    if turns:
        at = _zero(scene, a, b, lambda stop: stop.ahead.factor).step if len(zeros) > 1 else zeros[0].step
        limit = min(zeros, key=lambda stop: abs(stop.step - at))
    found: list[Crossing] = []
    for stop in zeros:
        kind: Kind = "limit" if stop is limit else "branch"
        last = found[-1] if found else None
        if last and last.kind == kind and stop.step - last.stop.step <= TOGETHER * b.step:
            found[-1] = replace(last, count=last.count + 1)
        else:
            found.append(Crossing(kind, replace(stop, ahead=_between(scene, a, b, stop.step)), 1))
    if not has_potential and b.balance.unstable - a.balance.unstable not in {0, change if numbers else 0}:
        found.append(Crossing("flutter", _onset(scene, a, b), 0))
    return sorted(found, key=lambda crossing: crossing.stop.step)


def crossing_of_factor(scene: LoadedScene, a: Stop, b: Stop, factor: float) -> Stop:
    """Return the stop between a stop and one that it led to at which the loads have a factor."""
    origin, first = (a, 0.0) if b.origin is a or b.origin is None else (b.origin, a.step)
    return _zero(scene, origin, b, lambda stop: stop.factor - factor, first, a)


def _between(scene: LoadedScene, a: Stop, b: Stop, length: float) -> Tangent:
    """Return the tangent between two stops, where that of the equations is not unique."""
    share = length / b.step
    return scene.unit(
        Tangent(
            (1.0 - share) * a.ahead.z + share * b.ahead.z,
            (1.0 - share) * a.ahead.factor + share * b.ahead.factor,
        )
    )


def _zero(
    scene: LoadedScene,
    a: Stop,
    b: Stop,
    function: Callable[[Stop], float],
    first: float = 0.0,
    low: Stop | None = None,
    digits: float = DIGITS,
) -> Stop:
    """Return the stop at the zero of a function on the way from a to b."""
    known = {first: low or a, b.step: b}

    def value(length: float) -> float:
        if length not in known:
            at = min(known, key=lambda x: abs(x - length))
            known[length] = stepped(scene, a, length, near=(at, known[at]))
        return function(known[length])

    if value(first) == 0.0:
        return replace(known[first], origin=a, step=first)
    if value(b.step) == 0.0:
        return b
    return known[float(brentq(value, first, b.step, xtol=digits * b.step, rtol=1e-15))]


def _smooth_zero(scene: LoadedScene, a: Stop, b: Stop, function: Callable[[Stop], float]) -> Stop:
    """Return the stop at a zero where the stiffness of the corrector vanishes as well: interpolated from beside it."""
    zero = _zero(scene, a, b, function, digits=0.1 * BESIDE)
    about = zero.step
    places = about + BESIDE * b.step * NODES
    stops = [stepped(scene, a, float(place), near=(about, zero)) for place in places]
    check_continuity(scene, stops[0], stops[-1])  # two paths that are near to each other have no common point
    values = np.array([function(stop) for stop in stops])
    roots = np.roots(np.polyfit(NODES, values, 3))
    root = float(min(roots[np.abs(roots.imag) < 1e-6].real, key=abs, default=0.0))
    shares = [float(np.prod([(root - y) / (x - y) for y in NODES if y != x])) for x in NODES]
    here = stops[1]
    z = [scene.between(here.q, stop.q, here.balance) for stop in stops]
    q = scene.moved(here.q, np.einsum("i,ij->j", shares, z))
    balance = scene.balance(q, float(np.dot(shares, [stop.factor for stop in stops])))
    return Stop(balance, a.ahead, a, about + BESIDE * b.step * root)


def _least(balance: Balance) -> float:
    """Return the smallest size of a stiffness."""
    return float(np.abs(np.linalg.eigvals(balance.H)).min(initial=np.inf))


def _onset(scene: LoadedScene, a: Stop, b: Stop) -> Stop:
    """Return the stop at which the number of growing motions changes."""
    ends = (a.balance, b.balance)
    fewer, near = min(end.unstable for end in ends), 0.0j

    def grows(stop: Stop) -> float:
        nonlocal near
        margin, near = stop.balance.flutters(fewer, near)
        return margin

    grows(max(a, b, key=lambda stop: stop.balance.unstable))  # which stiffnesses meet
    return _zero(scene, a, b, grows, digits=ONSET)
