"""Critical points between two stops of a path: where a stiffness vanishes, or a motion begins to flutter.

At a limit point the factor turns as well, and at a branch point it does not (Seydel, Practical Bifurcation and
Stability Analysis, 2010, chapter 5). Zeros are found along the arc, on which all of this is smooth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from kanefe.linear.paths.arc_length import Stop, stepped, turns_between
from kanefe.linear.paths.dips import parted
from kanefe.linear.paths.loaded_scene import Balance, LoadedScene, Tangent
from kanefe.linear.paths.spectrum import MotionSpectrum
from kanefe.linear.paths.zeros import interpolated_zero, smooth_zero, zero

Kind = Literal["limit", "branch", "flutter"]

ONSET = 1e-10
"""Length of the bracket of an onset of flutter relative to the step: a tenth of the digits that are told; more would
only find the round-off of nearly equal eigenvalues."""

TOGETHER = 1e-6
"""Distance of zeros relative to the step below which they are one point."""

TOUCHES = 1e-3
"""Least stiffness where a path turns, relative to those at the ends of the step, that counts as zero."""

SHARES, FINEST = (0.25, 0.5, 0.75), 1e-3
"""Places between two stops at which a stiffness is taken from both, and length relative to the step of what is looked
at."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """A critical point on a path: its kind, the stop there, and the number of stiffnesses that vanish.

    `before` is the number of growing motions before it: at the point itself the sign of a zero is chance.
    """

    kind: Kind
    stop: Stop
    count: int = 1
    before: int = 0


def crossings(scene: LoadedScene, a: Stop, b: Stop) -> list[Crossing] | None:
    """Return the critical points on the step from a to b, in order; None if the step is too long to tell them apart."""
    begin = replace(a, origin=a, step=0.0)
    if not (a.balance.is_symmetric and b.balance.is_symmetric):
        return _counted(scene, begin, _without_potential(scene, begin, b))
    found: list[Crossing] = []
    for low, high in pairwise(parted(scene, begin, b)):
        part = _with_potential(scene, low, high, b.step)
        if part is None:
            return None
        found += [replace(one, stop=_on_the_way(scene, a, b, one.stop)) for one in part]
    return _counted(scene, begin, found)


def _counted(scene: LoadedScene, begin: Stop, found: list[Crossing]) -> list[Crossing]:
    """Return critical points with the numbers of growing motions before them."""
    ends = [begin, *(crossing.stop for crossing in found)]
    counts = [begin.unstable] if found else []
    for low, high in pairwise(ends[1:]):
        counts.append(stepped(scene, begin, 0.5 * (low.step + high.step)).unstable)
    return [replace(crossing, before=before) for crossing, before in zip(found, counts, strict=True)]


def _with_potential(scene: LoadedScene, low: Stop, high: Stop, step: float) -> list[Crossing] | None:
    """Return the critical points between two stops of a step of which each stiffness passes zero once."""
    turns = turns_between(low, high)
    numbers = range(min(low.negative, high.negative), max(low.negative, high.negative))
    if turns and not numbers:
        crest = smooth_zero(scene, low, high, _factor_turns, step)
        least = (_least(crest.balance), min(_least(low.balance), _least(high.balance)))
        # another path that crosses where this one turns: the stiffness touches zero
        return [Crossing("branch", crest)] if least[0] <= TOUCHES * least[1] else None
    zeros = [_vanishes(scene, low, high, number, step, turns=turns) for number in numbers]
    zeros.sort(key=lambda stop: stop.step)
    limit = None
    if turns:
        at = zero(scene, low, high, _factor_turns, step).step if len(zeros) > 1 else zeros[0].step
        limit = min(zeros, key=lambda stop: abs(stop.step - at))
    found: list[Crossing] = []
    for stop in zeros:
        kind: Kind = "limit" if stop is limit else "branch"
        last = found[-1] if found else None
        if last and last.kind == kind and stop.step - last.stop.step <= TOGETHER * step:
            found[-1] = replace(last, count=last.count + 1)
        else:
            found.append(Crossing(kind, stop))
    return found


def _factor_turns(stop: Stop) -> float:
    """Return what is zero where the factor turns."""
    return stop.ahead.factor


def _vanishes(scene: LoadedScene, low: Stop, high: Stop, number: int, step: float, *, turns: bool) -> Stop:
    """Return the stop between two others at which a stiffness vanishes, by its number from the smallest."""
    search = zero if turns else smooth_zero
    return search(scene, low, high, lambda stop: float(stop.balance.stiffnesses[number]), step)


def _without_potential(scene: LoadedScene, begin: Stop, b: Stop) -> list[Crossing]:
    """Return the critical points on a step where the loads have no potential.

    A stiffness that vanishes changes the sign of the determinant, and the number of growing motions by one; flutter
    changes this number by two. The step is halved until no part has more than one of them, or they are at one place.
    """
    parts = [(begin, b)]
    found: list[Crossing] = []
    while parts:
        low, high = parts.pop()
        length = (high.step - low.step) / b.step
        is_odd = low.spectrum.is_inverted != high.spectrum.is_inverted
        more, oscillating = high.unstable - low.unstable, high.spectrum.oscillating - low.spectrum.oscillating
        turns, change = turns_between(low, high), abs(more)
        flutters = change > 1 and more * oscillating > 0
        is_one = change <= 1 if is_odd else not turns and (change <= 1 or (change == 2 and flutters))
        finest = FINEST if is_one else ONSET if flutters else TOGETHER
        if length > finest and (not is_one or _is_mixed(low.spectrum, high.spectrum)):
            middle = stepped(scene, begin, 0.5 * (low.step + high.step), near=(low.step, low))
            parts += [(low, middle), (middle, high)]
        elif is_odd or turns or change > 1:
            if flutters and not is_odd:
                found.append(Crossing("flutter", _onset(scene, low, high, b.step), 0))
            else:
                kind: Kind = "limit" if is_odd and turns else "branch"
                count = 1 if is_odd else max(change, 1)
                stop = _singular(scene, low, high, b.step, count, turns=turns)
                found.append(Crossing(kind, _on_the_way(scene, begin, b, stop), count))
            parts += _unexplained(scene, low, high, found[-1].stop.step, FINEST * b.step)
    return sorted(found, key=lambda crossing: crossing.stop.step)


def _is_mixed(a: MotionSpectrum, b: MotionSpectrum) -> bool:
    """Return whether more than one thing happens between two stops, as what is linear between them tells."""
    pairs = list(pairwise([a, *(a.between(b, share) for share in SHARES), b]))
    odd = sum(one.is_inverted != other.is_inverted for one, other in pairs)
    return odd + sum(abs(one.unstable - other.unstable) > 1 for one, other in pairs) > 1


def _unexplained(scene: LoadedScene, low: Stop, high: Stop, at: float, gap: float) -> list[tuple[Stop, Stop]]:
    """Return the parts before and after a critical point, by a gap, in which the number of growing motions changes."""
    before, after = low, high
    for end, place in ((low, at - gap), (high, at + gap)):
        if low.step < place < high.step:
            side = stepped(scene, low.origin or low, place, near=(end.step, end))
            before, after = (side, after) if end is low else (before, side)
    if before.unstable == after.unstable:  # round-off: the point is not what changes it
        return []
    return [(one, other) for one, other in ((low, before), (after, high)) if one.unstable != other.unstable]


def _singular(scene: LoadedScene, low: Stop, high: Stop, step: float, count: int, *, turns: bool) -> Stop:
    """Return the stop between two others at which the determinant changes its sign, or several stiffnesses vanish."""
    if low.spectrum.is_inverted == high.spectrum.is_inverted:
        return interpolated_zero(scene, low, lambda stop: stop.spectrum.smallest(count), step)
    search = zero if turns else smooth_zero
    return search(scene, low, high, lambda stop: stop.spectrum.determinant(low.spectrum), step)


def _onset(scene: LoadedScene, low: Stop, high: Stop, step: float) -> Stop:
    """Return the stop between two others at which the number of growing motions changes."""
    fewer, near = min(low.unstable, high.unstable), 0.0j

    def grows(stop: Stop) -> float:
        nonlocal near
        margin, near = stop.spectrum.flutters(fewer, near)
        return margin

    grows(max(low, high, key=lambda stop: stop.unstable))  # which stiffnesses meet
    return zero(scene, low, high, grows, step, ONSET)


def _on_the_way(scene: LoadedScene, a: Stop, b: Stop, stop: Stop) -> Stop:
    """Return a stop with the tangent between two others, where that of the equations is not unique."""
    share = stop.step / b.step
    z = (1.0 - share) * a.ahead.z + share * b.ahead.z
    factor = (1.0 - share) * a.ahead.factor + share * b.ahead.factor
    return replace(stop, ahead=scene.unit(Tangent(z, factor)))


def _least(balance: Balance) -> float:
    """Return the smallest size of a stiffness."""
    return float(np.abs(np.linalg.eigvals(balance.H)).min(initial=np.inf))
