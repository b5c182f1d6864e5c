"""The impulse of an impact at one contact by Stronge's law: friction followed through it, restitution of energy.

With p the normal impulse so far and ``s = v_T / |v_T|``,

    dv/dp = G (1, -mu s)  of what slips,    v_T = 0 as long as friction can hold it,    dU/dp = -v_N

U is stored while v_N < 0; where that ends, ``e^2`` of what came in is left, and the impact ends where that is given
back. So it takes ``(1 - e^2)`` of the energy stored and the work of friction, and never gives any (W. J. Stronge, Proc.
R. Soc. Lond. A 431 (1990) 169-181; "Impact Mechanics", 2000, chapters 4 and 5). In space a slip turns: then
``dp = |v_T| dx`` keeps the equations of its direction regular up to its end (the hodograph: J. A. Batlle, J. Appl.
Mech. 63 (1996) 168-172).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.impacts.tolerances import BRANCHES, CLOSELY, IMPACT_ENDS, SETTLED, STRAIGHT_SLIP, TURNS_AT, WEAK


class Rubs(NamedTuple):
    """Friction of a contact in an impact; what slips has one coefficient from one change of its state to the next.

    Attributes
    ----------
    coefficient : function (speed) -> float
        Of a slip that begins so fast, m/s.
    holding : float
        Up to which it sticks; zero: there is no friction.
    """

    coefficient: Callable[[float], float]
    holding: float


def struck(G: Matrix, rates: Vector, e: float, rubs: Rubs, rtol: float = CLOSELY) -> Vector | None:
    """Return the impulse of an impact at a contact, (3,): along the normal and two directions of the surface, N s.

    Parameters
    ----------
    G : ndarray, shape (3, 3)
        What unit impulses do to the rates.
    rates : ndarray, shape (3,)
        Before it, m/s. A contact that does not approach is struck only if its own friction presses it in.
    e : float
        Restitution: the square root of the share of the stored energy that is given back.
    rubs : Rubs
    rtol : float
        Of a slip that turns.

    Returns
    -------
    ndarray or None
        None where no impulse ends the impact, which round-off alone can do.
    """
    size, unit = float(np.abs(rates).max()), float(G[0, 0])
    if size == 0.0 or unit <= 0.0:
        return np.zeros(3)
    return _Impact(G / unit, rates / size, e, rubs, size, rtol).impulse(size / unit)


class _Impact:
    def __init__(self, G: Matrix, rates: Vector, e: float, rubs: Rubs, size: float, rtol: float) -> None:
        self.G, self.first, self.v, self.p = G, rates, rates.copy(), np.zeros(3)
        self.e, self.rubs, self.size, self.rtol = e, rubs, size, rtol
        self.stored = self.kept = 0.0
        self.is_loading, self.is_held = True, False

    def impulse(self, unit: float) -> Vector | None:
        for _ in range(BRANCHES):
            slip = float(np.hypot(*self.v[1:]))
            rests = slip <= IMPACT_ENDS
            x = self._rubbed(slip, rests)
            c, a = self.G[0, 0] + self.G[0, 1:] @ x, self.G[1:, 0] + self.G[1:, 1:] @ x
            # where loading ends with a slip, as in what moves in one way alone, round-off decides which is first
            is_over = self.is_loading and self.v[0] >= 0.0 and c >= 0.0
            if is_over and (self.stored <= self.kept or self._turned(False)):
                return unit * self.p
            across = 0.0 if rests else abs(self.v[1] * a[1] - self.v[2] * a[0]) / slip
            if self.rubs.holding == 0.0 or across <= STRAIGHT_SLIP * (1.0 + float(np.abs(a).sum())):
                slows = not rests and self.rubs.holding > 0.0
                done = self._straight(float(c), x, slip, float(a @ self.v[1:]) / slip if slows else 0.0)
            else:
                done = self._turning(slip)
            if done is None:
                return None
            if done:
                return unit * self.p
        return None

    def _rubbed(self, slip: float, rests: bool) -> Vector:
        """Return friction for a unit of the normal force."""
        self.is_held = False
        if self.rubs.holding == 0.0:
            return np.zeros(2)
        if not rests:
            return np.asarray(-self.rubs.coefficient(self.size * slip) / slip * self.v[1:])
        x, self.is_held = held_by(self.G, self.rubs.holding)
        return x if self.is_held else held_by(self.G, self.rubs.coefficient(0.0))[0]

    def _straight(self, c: float, x: Vector, slip: float, slowing: float) -> bool | None:
        """Go on to what ends a slip in one direction, or the impact; return whether it is over."""
        v, stored = self.v[0], self.stored
        to_stop = slip / -slowing if slowing < 0.0 else np.inf
        if self.is_loading:
            to_turn, is_end = (-v / c if c > 0.0 else np.inf), False
        else:
            root = v * v + 2.0 * c * stored
            is_end = root >= 0.0
            to_turn = 2.0 * stored / (v + np.sqrt(root)) if is_end else -v / c
        step = min(to_stop, to_turn)
        if not np.isfinite(step):
            return None
        self.p += step * np.array((1.0, *x))
        self.stored -= step * (v + 0.5 * c * step)
        self.v = self.first + self.G @ self.p
        if self.is_held or to_stop <= to_turn:
            self.v[1:] = 0.0
        return self._turned(is_end) if to_turn <= to_stop else False

    def _turned(self, is_end: bool) -> bool:
        """Change from loading to unloading or back, where that is not the end; return whether it is."""
        if is_end:
            return True
        self.v[0] = 0.0
        if self.is_loading:
            self.stored = self.kept + self.e**2 * (self.stored - self.kept)
        else:
            self.kept = self.stored
        self.is_loading = not self.is_loading
        return not self.is_loading and self.stored <= 0.0

    def _turning(self, slip: float) -> bool | None:
        """Follow a slip that turns to its end, or to that of the impact; return whether that is over."""
        from scipy.integrate import solve_ivp

        G, mu = self.G, self.rubs.coefficient(self.size * slip)

        def rates(_: float, y: Vector) -> Vector:
            speed, s = np.exp(y[1]), np.array((np.cos(y[2]), np.sin(y[2])))
            a = G[1:, 0] - mu * G[1:, 1:] @ s
            c = G[0, 0] - mu * G[0, 1:] @ s
            grows, turns = a @ s, a[1] * s[0] - a[0] * s[1]
            return np.array((speed * c, grows, turns, speed, *(-mu * speed * s), -speed * y[0]))

        def ends(_: float, y: Vector) -> float:
            return float(y[6])

        def turns(_: float, y: Vector) -> float:
            return float(y[0])

        def stops(_: float, y: Vector) -> float:
            return float(y[1] - np.log(IMPACT_ENDS))

        error = SETTLED * self.rtol * (1.0 + mu) * float(np.abs(G).sum())

        def settles(_: float, y: Vector) -> float:
            return abs(float(rates(_, y)[2])) - error

        ends.terminal = turns.terminal = stops.terminal = True  # type: ignore[attr-defined]
        settles.terminal, settles.direction = True, -1.0  # type: ignore[attr-defined]
        turns.direction, ends.direction = (1.0 if self.is_loading else -1.0), -1.0  # type: ignore[attr-defined]
        start = np.array((self.v[0], np.log(slip), np.arctan2(self.v[2], self.v[1]), *self.p, self.stored))
        events = [settles, stops, turns] if self.is_loading else [settles, stops, turns, ends]
        run = solve_ivp(rates, (0.0, TURNS_AT), start, "DOP853", events=events, rtol=self.rtol, atol=0.01 * self.rtol)
        if run.status != 1:
            return None
        y = run.y[:, -1]
        self.p, self.stored = y[3:6].copy(), float(y[6])
        self.v = self.first + G @ self.p
        if len(run.t_events[0]):
            # it goes on in the direction to which it is bound; where nothing is left of its rates, nothing ends it
            changes, speed, across = rates(0.0, y), float(np.exp(y[1])), np.array((-np.sin(y[2]), np.cos(y[2])))
            slope = -changes[1] - mu * across @ G[1:, 1:] @ across
            if slope < 0.0:  # a step of Newton's method
                changes = rates(0.0, y - changes[2] / slope * np.eye(len(y))[2])
            c, slowing = changes[0] / speed, float(changes[1])
            if max(abs(c), abs(slowing)) <= error:
                return None
            return self._straight(c, changes[4:6] / speed, speed, slowing)
        if len(run.t_events[1]):
            self.v[1:] = 0.0
            return False
        return self._turned(len(run.t_events[-1]) > 0 and not self.is_loading and not len(run.t_events[2]))


def held_by(G: Matrix, mu: float) -> tuple[Vector, bool]:
    """Return the friction of a contact at rest for a unit of its normal force, and whether that holds it.

    What cannot hold it is on the cone, against the slip that it leaves: the least of
    ``x G_TT x / 2 + G_TN x`` with ``|x| <= mu``, of which there is one.
    """
    values, axes = np.linalg.eigh(G[1:, 1:])
    b = axes.T @ G[1:, 0]
    moves = values > WEAK * G[0, 0]
    free = np.where(moves, -b / np.where(moves, values, 1.0), 0.0)
    if np.hypot(*free) <= mu:
        return np.asarray(axes @ free), True
    low, high = 0.0, float(np.hypot(*b)) / mu if mu > 0.0 else 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        longer = np.hypot(*(b / (np.maximum(values, 0.0) + middle))) > mu
        low, high = (middle, high) if longer else (low, middle)
    x = -b / (np.maximum(values, 0.0) + high) if mu > 0.0 else np.zeros(2)
    return np.asarray(axes @ x), False
