"""The impulse of an impact at one contact by Stronge's law: see `kanefe.kane.rigid_contacts.stronge`."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.falling import steady_coefficient
from kanefe.kernels.contact.rigid_points import HOLDING, OF_POINT
from kanefe.kernels.impacts.tolerances import BRANCHES, IMPACT_ENDS, SETTLED, STRAIGHT_SLIP, WEAK

OF_NORMAL, OF_SIZE, OF_ANGLE, OF_P, OF_STORED = 0, 1, 2, 3, 6
"""Places of a slip that turns: normal speed, logarithm and angle of the slip, three impulses, stored energy."""
TURNING_NUMBERS = 7

STATE, TRIED = 7, 8
TURNING_ROWS = 9
"""Rows of the memory of a slip that turns, after those of the stages of a step."""

FIRST_TURN, MOST_STEPS, HALVINGS = 0.1, 20000, 60
"""First angle of a slip that turns, rad; largest number of steps, of which some hundreds are common; and number of
halvings that find where it ends."""

GOES_ON, STOPS, TURNS, ENDS, FAILS = range(5)
"""Numbers of what a slip that turns comes to: its end, that of loading or unloading, that of the impact."""

Six = tuple[float, float, float, float, float, float]
"""Responses to unit impulses: nn, n1, n2, 11, 12, 22."""


@kernel
def strike_one(
    G: Six, rates: tuple[float, float, float], numbers: np.ndarray, rubs: bool, closely: float, work: np.ndarray
) -> tuple[bool, float, float, float]:
    """Return whether an impact at a contact ends, and its impulses.

    Parameters
    ----------
    G : tuple of 6 floats
    rates : tuple of 3 floats
        m/s.
    numbers : ndarray, shape (POINT_CONSTANTS,)
        Of the point.
    rubs : bool
        Whether it has friction.
    closely : float
        Error of a step, relative to the numbers of a slip that turns.
    work : ndarray, shape (TURNING_ROWS, TURNING_NUMBERS)
    """
    size, unit = max(abs(rates[0]), max(abs(rates[1]), abs(rates[2]))), G[0]
    if size == 0.0 or unit <= 0.0:
        return True, 0.0, 0.0, 0.0
    A = (1.0, G[1] / unit, G[2] / unit, G[3] / unit, G[4] / unit, G[5] / unit)
    f0, f1, f2, e = rates[0] / size, rates[1] / size, rates[2] / size, numbers[OF_POINT.restitution]
    v0, v1, v2, p0, p1, p2, stored, kept, loads = f0, f1, f2, 0.0, 0.0, 0.0, 0.0, 0.0, True
    holding = numbers[HOLDING] if rubs else 0.0
    for _ in range(BRANCHES):
        slip = np.hypot(v1, v2)
        rests = slip <= IMPACT_ENDS
        x1, x2, mu, is_held = 0.0, 0.0, 0.0, False
        if holding > 0.0 and rests:
            is_held, x1, x2 = _held_by(A, holding)
            if not is_held:
                _, x1, x2 = _held_by(A, steady_coefficient(numbers, OF_POINT.friction, 0.0))
        elif holding > 0.0:
            mu = steady_coefficient(numbers, OF_POINT.friction, size * slip)
            x1, x2 = -mu * v1 / slip, -mu * v2 / slip
        c, a1, a2 = A[0] + A[1] * x1 + A[2] * x2, A[1] + A[3] * x1 + A[4] * x2, A[2] + A[4] * x1 + A[5] * x2
        unit_impulse = size / unit
        if loads and v0 >= 0.0 and c >= 0.0:
            # where loading ends with a slip, as in what moves in one way alone, round-off decides which is first
            is_pressed = stored > kept
            if is_pressed:
                v0, loads, stored = 0.0, False, kept + e * e * (stored - kept)
            if not is_pressed or stored <= 0.0:
                return True, unit_impulse * p0, unit_impulse * p1, unit_impulse * p2
        across = 0.0 if rests else abs(v1 * a2 - v2 * a1) / slip
        if holding == 0.0 or across <= STRAIGHT_SLIP * (1.0 + abs(a1) + abs(a2)):
            slowing = 0.0 if rests or holding == 0.0 else (a1 * v1 + a2 * v2) / slip
            step, found, stops = _straight(loads, v0, c, stored, slip, slowing)
            if found == FAILS:
                return False, 0.0, 0.0, 0.0
            p0, p1, p2 = p0 + step, p1 + step * x1, p2 + step * x2
            stored -= step * (v0 + 0.5 * c * step)
            stops = is_held or stops
        else:
            state = work[STATE]
            state[OF_NORMAL], state[OF_SIZE], state[OF_ANGLE] = v0, np.log(slip), np.arctan2(v2, v1)
            state[OF_P], state[OF_P + 1], state[OF_P + 2], state[OF_STORED] = p0, p1, p2, stored
            found = _turn(A, mu, loads, closely, work)
            if found == FAILS:
                return False, 0.0, 0.0, 0.0
            p0, p1, p2, stored = state[OF_P], state[OF_P + 1], state[OF_P + 2], state[OF_STORED]
            stops = found == STOPS
        v0 = f0 + A[0] * p0 + A[1] * p1 + A[2] * p2
        v1 = 0.0 if stops else f1 + A[1] * p0 + A[3] * p1 + A[4] * p2
        v2 = 0.0 if stops else f2 + A[2] * p0 + A[4] * p1 + A[5] * p2
        if found == ENDS:
            return True, unit_impulse * p0, unit_impulse * p1, unit_impulse * p2
        if found == TURNS:
            v0 = 0.0
            if loads:
                stored = kept + e * e * (stored - kept)
            else:
                kept = stored
            loads = not loads
            if not loads and stored <= 0.0:
                return True, unit_impulse * p0, unit_impulse * p1, unit_impulse * p2
    return False, 0.0, 0.0, 0.0


@inlined
def _held_by(A: Six, mu: float) -> tuple[bool, float, float]:
    """Return whether friction holds a contact at rest, and the friction for a unit of its normal force."""
    mean, half, b = 0.5 * (A[3] + A[5]), 0.5 * (A[3] - A[5]), A[4]
    spread = np.hypot(half, b)
    first, second = mean + spread, max(mean - spread, 0.0)
    turn = 0.5 * np.arctan2(b, half)
    x, y = np.cos(turn), np.sin(turn)
    b1, b2 = x * A[1] + y * A[2], x * A[2] - y * A[1]
    free1 = -b1 / first if first > WEAK else 0.0
    free2 = -b2 / second if second > WEAK else 0.0
    is_held = np.hypot(free1, free2) <= mu
    if not is_held:
        free1 = free2 = 0.0
        if mu > 0.0:
            low, high = 0.0, np.hypot(b1, b2) / mu
            middle = 0.5 * high
            while low < middle and middle < high:
                if np.hypot(b1 / (first + middle), b2 / (second + middle)) > mu:
                    low = middle
                else:
                    high = middle
                middle = 0.5 * (low + high)
            free1, free2 = -b1 / (first + high), -b2 / (second + high)
    return is_held, x * free1 - y * free2, y * free1 + x * free2


@inlined
def _straight(loads: bool, v: float, c: float, stored: float, slip: float, slowing: float) -> tuple[float, int, bool]:
    """Return the impulse up to the end of a slip in one direction, what that is, and whether the slip stops there."""
    to_stop, to_turn, is_end = slip / -slowing if slowing < 0.0 else np.inf, np.inf, False
    if loads:
        to_turn = -v / c if c > 0.0 else np.inf
    else:
        root = v * v + 2.0 * c * stored
        is_end = root >= 0.0
        to_turn = 2.0 * stored / (v + np.sqrt(root)) if is_end else -v / c
    found = STOPS if to_stop < to_turn else ENDS if is_end else TURNS
    step = min(to_stop, to_turn)
    return step, found if step < np.inf else FAILS, to_stop <= to_turn


@kernel
def _settled(A: Six, mu: float, loads: bool, closely: float, work: np.ndarray) -> int:
    """Follow a slip that no longer turns to what ends it, if it does not: of its steps there could be any number.

    Where what is left of its rates is their error, as of a point that moves along one line alone, nothing ends it.
    """
    state, rates = work[STATE], work[0]
    _put_rates(A, mu, state, rates)
    error = SETTLED * closely * (1.0 + mu) * (A[0] + abs(A[1]) + abs(A[2]) + A[3] + 2.0 * abs(A[4]) + A[5])
    if abs(rates[OF_ANGLE]) > error:
        return GOES_ON
    x, z = np.cos(state[OF_ANGLE]), np.sin(state[OF_ANGLE])
    slope = -rates[OF_SIZE] - mu * (A[3] * z * z - 2.0 * A[4] * x * z + A[5] * x * x)
    if slope < 0.0:  # to where it is bound: a step of Newton's method
        state[OF_ANGLE] -= rates[OF_ANGLE] / slope
        _put_rates(A, mu, state, rates)
    slip = np.exp(state[OF_SIZE])
    c, slowing = rates[OF_NORMAL] / slip, rates[OF_SIZE]
    if abs(c) <= error and abs(slowing) <= error:
        return FAILS
    step, found, _ = _straight(loads, state[OF_NORMAL], c, state[OF_STORED], slip, slowing)
    if found != FAILS:
        state[OF_STORED] -= step * (state[OF_NORMAL] + 0.5 * c * step)
        for i in range(3):
            state[OF_P + i] += step * rates[OF_P + i] / slip
    return found


@kernel
def _turn(A: Six, mu: float, loads: bool, closely: float, work: np.ndarray) -> int:
    """Follow a slip that turns to what ends it, in steps of Dormand and Prince; return what that is."""
    state, tried, h = work[STATE], work[TRIED], FIRST_TURN
    for _ in range(MOST_STEPS):
        error = _step(A, mu, h, work) / closely
        if not error <= 1.0:
            h *= max(0.2, 0.9 * error**-0.2) if error < np.inf else 0.2
            continue
        found = _passed(tried, loads)
        if found != GOES_ON:
            low, high = 0.0, h
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                _step(A, mu, middle, work)
                if _passed(tried, loads) != GOES_ON:
                    high = middle
                else:
                    low = middle
            _step(A, mu, high, work)
            found = _passed(tried, loads)
        copy(tried, state)
        if found == GOES_ON:
            found = _settled(A, mu, loads, closely, work)
        if found != GOES_ON:
            return found
        h *= min(5.0, 0.9 * max(error, 1e-10) ** -0.2)
    return FAILS


@inlined
def _passed(y: np.ndarray, loads: bool) -> int:
    """Return what a slip that turns has come to."""
    found = GOES_ON
    if y[OF_SIZE] <= np.log(IMPACT_ENDS):
        found = STOPS
    elif loads:
        found = TURNS if y[OF_NORMAL] >= 0.0 else GOES_ON
    elif y[OF_STORED] <= 0.0:
        found = ENDS
    elif y[OF_NORMAL] < 0.0:
        found = TURNS
    return found


@inlined
def _put_rates(A: Six, mu: float, y: np.ndarray, rates: np.ndarray) -> None:
    """Write the rates of a slip that turns over its logarithm."""
    speed, x, z = np.exp(y[OF_SIZE]), np.cos(y[OF_ANGLE]), np.sin(y[OF_ANGLE])
    a1, a2 = A[1] - mu * (A[3] * x + A[4] * z), A[2] - mu * (A[4] * x + A[5] * z)
    rates[OF_NORMAL] = speed * (A[0] - mu * (A[1] * x + A[2] * z))
    rates[OF_SIZE], rates[OF_ANGLE] = a1 * x + a2 * z, a2 * x - a1 * z
    rates[OF_P], rates[OF_P + 1], rates[OF_P + 2] = speed, -mu * speed * x, -mu * speed * z
    rates[OF_STORED] = -speed * y[OF_NORMAL]


STAGES = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0),
    (44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
"""Coefficients of the stages of Dormand and Prince (J. Comput. Appl. Math. 6 (1980) 19-26); the last is the step."""
ERRORS = 71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40


@kernel
def _step(A: Six, mu: float, h: float, work: np.ndarray) -> float:
    """Write a step; return its error relative to the numbers, from 1 on."""
    state, tried, worst = work[STATE], work[TRIED], 0.0
    for i in range(7):
        for n in range(TURNING_NUMBERS):
            tried[n] = state[n]
            for j in range(i):
                tried[n] += h * STAGES[i][j] * work[j, n]
        _put_rates(A, mu, tried, work[i])
    for n in range(TURNING_NUMBERS):
        error = 0.0
        for i in range(7):
            error += h * ERRORS[i] * work[i, n]
        size = abs(error) / (1.0 + abs(tried[n]))
        worst = size if size > worst or np.isnan(size) else worst
    return worst
