"""The impulse of an impact at one contact by Stronge's law: friction followed through it, restitution of energy.

With p the normal impulse so far and ``s = v_T / |v_T|``,

    dv/dp = G (1, -mu s)  of what slips,    v_T = 0 as long as friction can hold it,    dU/dp = -v_N

U is stored while v_N < 0; where that ends, ``e^2`` of what came in is left, and the impact ends where that is given
back. So it takes ``(1 - e^2)`` of the energy stored and the work of friction, and never gives any (W. J. Stronge, Proc.
R. Soc. Lond. A 431 (1990) 169-181; "Impact Mechanics", 2000, chapters 4 and 5). In space a slip turns: then
``dp = |v_T| dx`` keeps the equations of its direction regular up to its end (the hodograph: J. A. Batlle, J. Appl.
Mech. 63 (1996) 168-172).
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.contact.falling import steady_coefficient
from kanefe.kernels.contact.rigid_points import RigidPoint
from kanefe.kernels.impacts.tolerances import SLIDING
from kanefe.kernels.language import Record, Rows, Symmetric, Vector, copy, inlined, kernel, largest_in


class Limits(NamedTuple):
    """How a slip that turns is followed."""

    first_turn: float = 0.1
    most_steps: int = 20000
    halvings: int = 60
    """First angle of a slip that turns, rad; largest number of steps, of which some hundreds are common; and number of
    halvings that find where it ends."""


LIMITS = Limits()


class Ending(IntEnum):
    """What a slip comes to: its end, that of loading or unloading, that of the impact."""

    GOES_ON = 0
    STOPS = 1
    TURNS = 2
    ENDS = 3
    FAILS = 4


class Blow(Record):
    """An impact of one contact, in units of its largest rate and of what a normal impulse does.

    Attributes
    ----------
    loads, is_held : bool
        Whether it is pressed together, and whether friction holds it.
    G : Symmetric
        What unit impulses do to the rates.
    first, v : Vector
        Rates before it, and by now.
    p : Vector
        Impulse so far; on return, N s.
    mu : float
        Friction of what slips.
    stored, kept : float
        Energy that is stored, and that was before it was pressed together again.
    unit : float
        Of rates, m/s.
    closely : float
        Error of a step, relative to the numbers of a slip that turns.
    """

    loads: bool
    is_held: bool
    G: Symmetric
    first: Vector
    v: Vector
    p: Vector
    mu: float
    stored: float
    kept: float
    unit: float
    closely: float


TURNING_ROWS = 9
"""Number of rows of `Turns`."""


class Turned(Record):
    """A slip that turns: normal speed, logarithm and angle of the slip, impulse, stored energy; or their rates."""

    normal: float
    size: float
    angle: float
    p: Vector
    stored: float


Turns = Rows[Turned]
"""Rates at the stages of a step; then, last, where it begins and where it leads."""


@kernel
def strike_one(blow: Blow, given: RigidPoint, turned: np.ndarray) -> bool:
    """Write the impulse of an impact at a contact; return whether it ends, which round-off alone can prevent.

    Parameters
    ----------
    blow : Blow
        With G, rates `first` (m/s) and `closely`.
    given : RigidPoint
    turned : ndarray
        `Turns`.
    """
    size, by = largest_in(blow.first), blow.G.full.x.x
    blow.p, blow.stored, blow.kept, blow.loads, blow.unit = Vector(0.0, 0.0, 0.0), 0.0, 0.0, True, size
    if size == 0.0 or by <= 0.0:
        return True
    blow.G, blow.first = (1.0 / by) * blow.G, (1.0 / size) * blow.first
    blow.v = blow.first
    for _ in range(SLIDING.branches):
        slip = np.hypot(blow.v.y, blow.v.z)
        push = _rubbed(blow, given, slip)
        gains = blow.G @ push
        # where loading ends with a slip, as in what moves in one way alone, round-off decides which is first
        is_over = blow.loads and blow.v.x >= 0.0 and gains.x >= 0.0
        if is_over and (blow.stored <= blow.kept or _turn_round(blow, given)):
            break
        across = 0.0 if slip <= SLIDING.impact_ends else abs(blow.v.y * gains.z - blow.v.z * gains.y) / slip
        if blow.mu == 0.0 or across <= SLIDING.straight_slip * (1.0 + abs(gains.y) + abs(gains.z)):
            found, stops = _go_straight(blow, push, gains, slip)
        else:
            found = _turn(blow, slip, turned)
            stops = found == Ending.STOPS
        if found == Ending.FAILS:
            return False
        v = blow.first + blow.G @ blow.p
        blow.v = Vector(v.x, 0.0, 0.0) if stops else v
        if found == Ending.ENDS or (found == Ending.TURNS and _turn_round(blow, given)):
            break
    else:
        return False
    blow.p = (size / by) * blow.p
    return True


@inlined
def _turn_round(blow: Blow, given: RigidPoint) -> bool:
    """Change from loading to unloading or back, where that is not the end; return whether it is."""
    blow.v = Vector(0.0, blow.v.y, blow.v.z)
    if blow.loads:
        blow.stored = blow.kept + given.restitution**2 * (blow.stored - blow.kept)
    else:
        blow.kept = blow.stored
    blow.loads = not blow.loads
    return not blow.loads and blow.stored <= 0.0


@inlined
def _rubbed(blow: Blow, given: RigidPoint, slip: float) -> Vector:
    """Return the impulse for a unit of the normal one, and write the friction of what slips, 0 of what does not."""
    blow.mu, blow.is_held, holding = 0.0, False, given.friction.holding
    if holding == 0.0:
        return Vector(1.0, 0.0, 0.0)
    if slip > SLIDING.impact_ends:
        blow.mu = mu = steady_coefficient(given.friction, blow.unit * slip)
        return Vector(1.0, -mu * blow.v.y / slip, -mu * blow.v.z / slip)
    is_held, push = held_by(blow.G, holding)
    blow.is_held = is_held
    if not is_held:
        _, push = held_by(blow.G, steady_coefficient(given.friction, 0.0))
    return push


@inlined
def held_by(G: Symmetric, mu: float) -> tuple[bool, Vector]:
    """Return whether friction holds a contact at rest, and the impulse for a unit of the normal one.

    What cannot hold it is on the cone, against the slip that it leaves: the least of
    ``x G_TT x / 2 + G_TN x`` with ``|x| <= mu``, of which there is one.
    """
    A = G.full
    mean, half, b = 0.5 * (A.y.y + A.z.z), 0.5 * (A.y.y - A.z.z), A.y.z
    spread = np.hypot(half, b)
    first, second = mean + spread, max(mean - spread, 0.0)
    turn = 0.5 * np.arctan2(b, half)
    x, y = np.cos(turn), np.sin(turn)
    b1, b2 = x * A.x.y + y * A.x.z, x * A.x.z - y * A.x.y
    weak = SLIDING.weak * A.x.x
    free1 = -b1 / first if first > weak else 0.0
    free2 = -b2 / second if second > weak else 0.0
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
    return is_held, Vector(1.0, x * free1 - y * free2, y * free1 + x * free2)


@inlined
def _go_straight(blow: Blow, push: Vector, gains: Vector, slip: float) -> tuple[Ending, bool]:
    """Go on to what ends a slip in one direction, or rest; return what that is, and whether nothing slips then."""
    slowing = (gains.y * blow.v.y + gains.z * blow.v.z) / slip if blow.mu > 0.0 else 0.0
    step, found, stops = _straight(blow, blow.v.x, gains.x, blow.stored, slip, slowing)
    if found != Ending.FAILS:
        blow.stored -= step * (blow.v.x + 0.5 * gains.x * step)
        blow.p += step * push
    return found, blow.is_held or stops


@kernel
def _straight(blow: Blow, v: float, c: float, stored: float, slip: float, slowing: float) -> tuple[float, Ending, bool]:
    """Return the impulse up to the end of a slip in one direction, what that is, and whether the slip stops there."""
    to_stop, to_turn, is_end = slip / -slowing if slowing < 0.0 else np.inf, np.inf, False
    if blow.loads:
        to_turn = -v / c if c > 0.0 else np.inf
    else:
        root = v * v + 2.0 * c * stored
        is_end = root >= 0.0
        to_turn = 2.0 * stored / (v + np.sqrt(root)) if is_end else -v / c
    found = Ending.STOPS if to_stop < to_turn else Ending.ENDS if is_end else Ending.TURNS
    step = min(to_stop, to_turn)
    return step, found if step < np.inf else Ending.FAILS, to_stop <= to_turn


@kernel
def _turn(blow: Blow, slip: float, turned: np.ndarray) -> Ending:
    """Follow a slip that turns to what ends it, in steps of Dormand and Prince; return what that is."""
    turns = Turns(turned)
    state, tried, h = turns[len(turns) - 2], turns[len(turns) - 1], LIMITS.first_turn
    state.normal, state.size, state.angle = blow.v.x, np.log(slip), np.arctan2(blow.v.z, blow.v.y)
    state.p, state.stored = blow.p, blow.stored
    found = Ending.FAILS
    for _ in range(LIMITS.most_steps):
        error = _step(blow, h, turned) / blow.closely
        if not error <= 1.0:
            h *= max(0.2, 0.9 * error**-0.2) if error < np.inf else 0.2
            continue
        found = _passed(tried, blow.loads)
        if found != Ending.GOES_ON:
            found = _halve(blow, h, turned)
        copy(turned[len(turned) - 1], turned[len(turned) - 2])
        if found == Ending.GOES_ON:
            found = _settled(blow, turned)
        if found != Ending.GOES_ON:
            break
        found = Ending.FAILS
        h *= min(5.0, 0.9 * max(error, 1e-10) ** -0.2)
    blow.p, blow.stored = state.p, state.stored
    return found


@kernel
def _halve(blow: Blow, h: float, turned: np.ndarray) -> Ending:
    """Write a step, of at most h, to what ends a slip that turns; return what that is."""
    low, high, tried = 0.0, h, Turns(turned)[len(turned) - 1]
    for _ in range(LIMITS.halvings):
        middle = 0.5 * (low + high)
        _step(blow, middle, turned)
        if _passed(tried, blow.loads) != Ending.GOES_ON:
            high = middle
        else:
            low = middle
    _step(blow, high, turned)
    return _passed(tried, blow.loads)


@kernel
def _settled(blow: Blow, turned: np.ndarray) -> Ending:
    """Follow a slip that no longer turns to what ends it, if it does not: of its steps there could be any number.

    Where what is left of its rates is their error, as of a point that moves along one line alone, nothing ends it.
    """
    turns, A, mu = Turns(turned), blow.G.full, blow.mu
    rates, state = turns[0], turns[len(turns) - 2]
    _put_rates(blow, state, rates)
    sizes = A.x.x + abs(A.x.y) + abs(A.x.z) + A.y.y + 2.0 * abs(A.y.z) + A.z.z
    error = SLIDING.settled * blow.closely * (1.0 + mu) * sizes
    if abs(rates.angle) > error:
        return Ending.GOES_ON
    x, z = np.cos(state.angle), np.sin(state.angle)
    slope = -rates.size - mu * (A.y.y * z * z - 2.0 * A.y.z * x * z + A.z.z * x * x)
    if slope < 0.0:  # to where it is bound: a step of Newton's method
        state.angle -= rates.angle / slope
        _put_rates(blow, state, rates)
    slip = np.exp(state.size)
    c, slowing = rates.normal / slip, rates.size
    if abs(c) <= error and abs(slowing) <= error:
        return Ending.FAILS
    step, found, _ = _straight(blow, state.normal, c, state.stored, slip, slowing)
    if found != Ending.FAILS:
        state.stored -= step * (state.normal + 0.5 * c * step)
        state.p += (step / slip) * rates.p
    return found


@inlined
def _passed(y: Turned, loads: bool) -> Ending:
    """Return what a slip that turns has come to."""
    found = Ending.GOES_ON
    if y.size <= np.log(SLIDING.impact_ends):
        found = Ending.STOPS
    elif loads:
        found = Ending.TURNS if y.normal >= 0.0 else Ending.GOES_ON
    elif y.stored <= 0.0:
        found = Ending.ENDS
    elif y.normal < 0.0:
        found = Ending.TURNS
    return found


@inlined
def _put_rates(blow: Blow, y: Turned, rates: Turned) -> None:
    """Write the rates of a slip that turns over its logarithm."""
    speed, x, z = np.exp(y.size), np.cos(y.angle), np.sin(y.angle)
    push = Vector(1.0, -blow.mu * x, -blow.mu * z)
    gains = blow.G @ push
    rates.normal, rates.size, rates.angle = speed * gains.x, gains.y * x + gains.z * z, gains.z * x - gains.y * z
    rates.p, rates.stored = speed * push, -speed * y.normal


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
def _step(blow: Blow, h: float, turned: np.ndarray) -> float:
    """Write a step; return its error relative to the numbers, from 1 on."""
    turns, state, tried, worst = Turns(turned), turned[len(turned) - 2], turned[len(turned) - 1], 0.0
    for i in range(7):
        for n in range(len(tried)):
            tried[n] = state[n]
            for j in range(i):
                tried[n] += h * STAGES[i][j] * turned[j, n]
        _put_rates(blow, turns[len(turns) - 1], turns[i])
    for n in range(len(tried)):
        error = 0.0
        for i in range(7):
            error += h * ERRORS[i] * turned[i, n]
        size = abs(error) / (1.0 + abs(tried[n]))
        worst = size if size > worst or np.isnan(size) else worst
    return worst
