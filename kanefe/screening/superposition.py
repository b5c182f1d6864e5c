"""Superposition of the motion of a scene on its carrier while everything sticks, with iterative correction.

With the matrix A of small motions x = (xi, dxi/dt) on the carrier at rest, and the residual r(t) of the full equations
for an approximate motion, ``x <- x + F^-1 (i w - A)^-1 F (0, r)`` by fast Fourier transforms. From xi = 0 the first
residual is exactly the forcing by the carrier; the second correction contains the second-order terms that small motions
neglect, and each further one is smaller by about the same ratio, which gives an error bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.screening.carrier import Displacement
from kanefe.screening.riders import Motions
from kanefe.screening.small import NotSuperposed, Small
from kanefe.screening.sticking import Sticking

APRON, TAPER = 16, 32
"""Numbers of steps around an interval with the true motion of the carrier, and over which the forcing then decays."""

ROUNDS = 6
"""Largest number of corrections."""

CLOSE = 1e-4
"""Accuracy of the superposition relative to the full equations, relative to the event functions."""

SLOWEST = 0.3
"""Ratio of successive corrections above which the iteration fails."""

SAFETY = 2.0
"""Safety factor on the error bounds."""

LOWEST = 5
"""Number of times at which the exact tension of a rope is evaluated: those with the smallest linearised tension."""

NUDGES = 1e-8, 1e-6
"""Steps of tangents and of their rates for the derivatives of event functions."""


@dataclass(frozen=True, eq=False)
class Superposed:
    """An interval of a run in which everything sticks.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s, at equal steps.
    motions : Motions
        Relative to `place`, without the transient from the start.
    internal : ndarray, shape (T, states)
    place : ndarray
        q on the carrier at rest.
    watched : ndarray, shape (T, events + ropes)
        Event functions, and tensions of ropes, N.
    bound : ndarray, shape (T, events + ropes)
        Error bounds of these.
    begun : ndarray, shape (2 free,)
        Initial values of the transient.
    slopes : ndarray, shape (places, events + ropes, 2 free)
        Derivatives of the watched values by small motions, at some times.
    small : Small
    rounds : int
    """

    times: Vector
    motions: Motions
    internal: Matrix
    place: Vector
    watched: Matrix
    bound: Vector
    begun: Vector
    slopes: np.ndarray
    small: Small
    rounds: int

    def left_of_start(self, times: Vector) -> np.ndarray:
        """Return a bound of the transient part of the watched values, at times in s, (T, events + ropes)."""
        sizes = np.abs(np.einsum("pex,xm->pem", self.slopes, self.small.V)).max(axis=0)
        sizes = sizes * np.abs(self.small.inverse @ self.begun)
        return np.asarray(np.exp(np.multiply.outer(times - self.times[0], self.small.rates.real)) @ sizes.T)


def superposed(sticking: Sticking, t: Vector, y: Vector, known: tuple[float, float]) -> Superposed:
    """Superpose an interval.

    Parameters
    ----------
    sticking : Sticking
    t : ndarray, shape (T,)
        s, at equal steps.
    y : ndarray
        State at t[0].
    known : (float, float)
        Interval in which the carrier's motion is defined, s.

    Raises
    ------
    NotSuperposed
        If the corrections do not converge to the full equations.
    """
    model, riders = sticking.model, sticking.riders
    q, u, z = model.parts(y)
    q, u = riders.relative(sticking.carrier.over(t[:1]), q, u)
    small = Small.about(sticking, q, z)
    step = float(t[1] - t[0])
    before = min(APRON, int((t[0] - known[0]) / step + 1e-9))
    after = min(APRON, int((known[1] - t[-1]) / step + 1e-9))
    times = np.concatenate((t[0] - step * np.arange(before, 0, -1), t, t[-1] + step * np.arange(1, after + 1)))
    inside = slice(before, before + len(t))
    moved = sticking.carrier.over(times)
    path = _Path(sticking, small, moved, times, q, z, before)
    motions, left, rounds = _converged(path, inside, step)
    states = path.states(motions)
    watched = sticking.watched(model, times[inside], states[inside])
    reached = np.unique([before, *(before + np.argmin(np.abs(watched), axis=0))])
    slopes = path.slopes(motions, reached)
    begun = np.concatenate((-motions.xi[before], u - motions.rate[before]))
    tensions, missed, by_motions = path.tensions(motions, states, inside)
    watched, left = np.hstack((watched, tensions)), np.append(left, missed)
    slopes = np.concatenate((slopes, np.repeat(by_motions[None], len(slopes), axis=0)), axis=1)
    bound = SAFETY * (left + _between(watched))
    n = model.coordinate_count + model.free_count
    own = Motions(*(part[inside] for part in motions))
    return Superposed(t, own, states[inside, n:], q, watched, bound, begun, slopes, small, rounds)


def _converged(path: _Path, inside: slice, step: float) -> tuple[Motions, Vector, int]:
    """Return motions that fulfil the full equations, what they leave of the event functions, and the corrections."""
    motions = path.none
    slopes = path.slopes(motions, [inside.start])
    last, ratio = np.zeros(0), 1.0
    for rounds in range(1, ROUNDS + 1):
        correction = path.corrected(motions, step)
        motions = motions + correction
        size = np.abs(np.einsum("pex,tx->pet", slopes, np.hstack(correction[:2])[inside])).max(axis=(0, 2))
        if rounds > 1:
            is_large = last > 1e-6 * last.max(initial=0.0)
            ratio = float((size[is_large] / last[is_large]).max(initial=0.0))
            if not ratio < SLOWEST:
                raise NotSuperposed(f"successive corrections decrease only by the factor {ratio:.2g}")
            left = size * ratio / (1.0 - ratio)
            if np.all(left <= CLOSE * np.maximum(np.abs(path.scale), size)):
                return motions, left, rounds
        last = size
    raise NotSuperposed(f"after {ROUNDS} corrections the residual is too large")


class _Path:
    """Evaluation of the full equations along motions at some times."""

    def __init__(
        self, sticking: Sticking, small: Small, moved: Displacement, times: Vector, q: Vector, z: Vector, first: int
    ) -> None:
        self._sticking, self._small, self._moved, self._times = sticking, small, moved, times
        self._q, self._z, self._first = q, z, first
        self._slid = np.zeros((len(times), len(z)))
        self.scale = sticking.watched(
            sticking.at_rest, np.zeros(1), self._at_rest(np.zeros((1, 2 * sticking.riders.count)))
        )[0]

    @property
    def none(self) -> Motions:
        """Motions of rest on the carrier."""
        zero = np.zeros((len(self._times), self._sticking.riders.count))
        return Motions(zero, zero, zero)

    def states(self, motions: Motions) -> Matrix:
        q, u, _ = self._sticking.riders.absolute(self._moved, self._q, motions)
        return np.hstack((q, u, self._anchored(motions)))

    def _anchored(self, motions: Motions) -> Matrix:
        return np.asarray(self._z + motions.xi @ self._small.W.T + self._slid)

    def corrected(self, motions: Motions, step: float) -> Motions:
        """Return the correction of motions for their residual."""
        sticking, n = self._sticking, self._sticking.model.coordinate_count
        q, u, turns = sticking.riders.absolute(self._moved, self._q, motions)
        states = np.hstack((q, u, self._anchored(motions)))
        rates = sticking.rates(self._times, states)
        m = n + sticking.riders.count
        found = sticking.riders.accelerations(self._moved, self._q, motions, turns, rates[:, n:m])
        left = found - motions.acceleration
        if not np.all(np.isfinite(left)):
            raise NotSuperposed("the residual is not finite")
        # anchors follow by W xi to first order, and by their rates beyond
        beyond = (rates[:, m:] - motions.rate @ self._small.W.T) @ self._small.follows
        if beyond.any():
            slid = _integrated(beyond, step, self._first)
            left += (slid - self._slid) @ self._small.pulls.T
            self._slid = slid
        reached = self._small.response(_extended(left), step)
        return Motions(*(part[TAPER : TAPER + len(left)] for part in reached))

    def slopes(self, motions: Motions, rows: Any) -> np.ndarray:
        """Return the derivatives of event functions by small motions at some of the times, (rows, events, 2 free)."""
        count = self._sticking.riders.count
        nudge = np.repeat(NUDGES, count)
        found = []
        for row in rows:
            x = np.concatenate((motions.xi[row], motions.rate[row]))
            states = self._at_rest(np.vstack((x, x + np.diag(nudge), x - np.diag(nudge))), self._slid[row])
            values = self._sticking.watched(self._sticking.at_rest, np.zeros(len(states)), states)
            up, down = values[1 : 2 * count + 1] - values[0], values[0] - values[2 * count + 1 :]
            found.append((np.where(np.abs(up) > np.abs(down), up, down) / nudge[:, None]).T)
        return np.array(found)

    def tensions(self, motions: Motions, states: Matrix, inside: slice) -> tuple[Matrix, Vector, Matrix]:
        """Return linearised tensions of ropes (T, ropes), their errors where they are smallest, and derivatives."""
        sticking, count = self._sticking, self._sticking.riders.count
        nudge = np.repeat(NUDGES, count)
        states_at_rest = self._at_rest(np.vstack((np.zeros(2 * count), np.diag(nudge))))
        values = sticking.tensions(sticking.at_rest, np.zeros(len(states_at_rest)), states_at_rest)
        slopes = ((values[1:] - values[0]) / nudge[:, None]).T
        found = values[0] + np.hstack((motions.xi, motions.rate))[inside] @ slopes.T
        if not found.shape[1]:
            return found, np.zeros(0), slopes
        rows = np.unique(np.argsort(found, axis=0)[:LOWEST])
        exact = sticking.tensions(sticking.model, self._times[inside][rows], states[inside][rows])
        return found, np.abs(exact - found[rows]).max(axis=0), slopes

    def _at_rest(self, x: Matrix, slid: Vector | float = 0.0) -> Matrix:
        """Return states of the carrier at rest with small motions x (T, 2 free)."""
        count = self._sticking.riders.count
        motions = Motions(x[:, :count], x[:, count:], np.zeros((len(x), count)))
        q, u, _ = self._sticking.riders.absolute(_nowhere(len(x)), self._q, motions)
        return np.hstack((q, u, self._z + motions.xi @ self._small.W.T + slid))


def _nowhere(count: int) -> Displacement:
    none = np.zeros((count, 3))
    return Displacement(none, none, none, np.repeat(np.eye(3)[None], count, axis=0), none, none)


def _extended(left: np.ndarray) -> np.ndarray:
    """Return accelerations with smooth, decaying continuations at both ends."""
    x = np.arange(1, TAPER + 1) / (TAPER + 1.0)
    fading = (1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
    ends = []
    for part in (left[::-1], left):
        back = part[np.maximum(len(part) - 1 - np.arange(1, TAPER + 1), 0)]
        ends.append((2.0 * part[-1] - back) * fading)
    return np.vstack((ends[0][::-1], left, ends[1]))


def _integrated(rates: np.ndarray, step: float, first: int) -> np.ndarray:
    """Return the integral over time of rates at equal steps, zero at step `first`."""
    from scipy.interpolate import CubicSpline

    found = CubicSpline(step * np.arange(len(rates)), rates).antiderivative()(step * np.arange(len(rates)))
    return np.asarray(found - found[first])


def _between(values: np.ndarray) -> Matrix:
    """Return error estimates of splines through values at equal steps, (T, n), between these steps."""
    from scipy.interpolate import CubicSpline
    from scipy.ndimage import maximum_filter1d

    x = np.arange(len(values))
    missed = np.zeros(values.shape)
    for first in (0, 1):  # splines through every other value detect a jump of a rate at the others
        kept, passed = x[first::2], x[first + 1 :: 2]
        passed = passed[passed < kept[-1]]
        missed[passed] = np.abs(CubicSpline(kept, values[kept])(passed) - values[passed])
    # splines with twice the step have sixteen times the error, and twice the error at a jump of a rate
    return np.asarray(0.5 * maximum_filter1d(missed, 7, axis=0))
