"""Forces of rigid contacts at an event, and what they decide: which of what is at rest sticks, and how slips begin.

The law is that of `kanefe.kane.rigid_contacts.stick_or_slip`, which is independent of this.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, copy, matrix, plus, rotated_back, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.falling import steady_coefficient
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, HOLDING, MET, OF_POINT
from kanefe.kernels.impacts.cones import LEAST, MU, ConeMemory, is_given, largest_of
from kanefe.kernels.impacts.decision import (
    ACCELERATIONS,
    ACTIVE,
    AFTER,
    BEGINS,
    FOUND,
    FREE_ACCELERATIONS,
    IS_CLOSED,
    IS_NEW,
    OPEN,
    OTHER,
    POINTS_LATER,
    RATES_OF_POINTS,
    SLIP_OF,
    SLIPS,
    STICKS,
    TAKES,
    TURNING,
    Asking,
    Decision,
    Moment,
    X,
    look,
    solve,
)
from kanefe.kernels.impacts.impulses import is_at_rest, put_active
from kanefe.kernels.impacts.tolerances import (
    AHEAD,
    HOLDS,
    NOT_DETERMINED,
    ROUND_OFF_OF_ACCELERATIONS,
    ROUND_OFF_OF_FORCES,
)

Ahead = tuple[float, np.ndarray, float, float]
"""Time and state of an event, span and end of the run."""


@kernel
def put_statuses(asking: Asking, decision: Decision, count: int, event: Ahead) -> bool:
    """Write accelerations, and the status of each point that takes part with its slip; return whether they are known.

    What is at rest sticks, unless the accelerations say that it slips; where these are at the limit of friction, those
    a moment later. Each round lets a point more slip, and none stick again, so that they end.
    """
    flags, vectors = decision.flags, decision.vectors
    points, problem, now, x, k = asking.points, decision.problem, decision.now, vectors[X], 0
    for a in range(count):
        p = flags[TAKES, a]
        if flags[IS_CLOSED, p] != 0:
            flags[ACTIVE, k] = p
            k += 1
    put_active(decision, k)
    for a in range(k):
        p = flags[ACTIVE, a]
        along, across = vectors[RATES_OF_POINTS, 3 * p + 1], vectors[RATES_OF_POINTS, 3 * p + 2]
        problem.of_each[LEAST, a] = problem.of_each[MU, a] = flags[BEGINS, a] = 0
        problem.slips[a, 0] = problem.slips[a, 1] = 0.0
        copy(now.b[3 * p : 3 * p + 3], problem.b[3 * a : 3 * a + 3])
        if points.places[p, HAS_FRICTION] == 0:
            continue
        speed = np.hypot(along, across)
        if is_at_rest(decision, p):
            problem.of_each[MU, a] = points.numbers[p, HOLDING]
            problem.slips[a, 0] = problem.slips[a, 1] = np.nan
        else:
            problem.of_each[MU, a] = steady_coefficient(points.numbers[p], OF_POINT.friction, speed)
            problem.slips[a, 0], problem.slips[a, 1] = along / speed, across / speed
    while True:
        if not _follow(asking, decision, k):
            return False
        if not _find_slipping(problem, k, x, decision):
            known, is_any = _find_slipping_soon(asking, decision, count, k, event)
            if not known:
                return False
            if not is_any:
                break
        for a in range(k):
            if flags[IS_NEW, a] != 0:
                flags[BEGINS, a] = 1
                copy(decision.directions[FOUND, a], problem.slips[a])
                problem.of_each[MU, a] = steady_coefficient(points.numbers[flags[ACTIVE, a]], OF_POINT.friction, 0.0)
    if not _turn(asking, decision, count, k, event):
        return False
    _put_found(decision, count, k)
    return True


@kernel
def _put_found(decision: Decision, count: int, k: int) -> None:
    """Write the accelerations by the forces that were found, and what they say of each point."""
    flags, vectors = decision.flags, decision.vectors
    now, x, y, problem = decision.now, vectors[X], vectors[ACCELERATIONS], decision.problem
    largest, biggest = 0.0, largest_of(x, 3 * k)  # by what forces do: to hold what moves more takes a pull that counts
    for a in range(count):
        p = flags[TAKES, a]
        flags[AFTER, p] = OPEN
        for i in range(3 * p, 3 * p + 3):
            y[i] = now.b[i]
            for b in range(k):
                for j in range(3):
                    y[i] += now.G[i, 3 * flags[ACTIVE, b] + j] * x[3 * b + j]
            largest = max(largest, abs(y[i] - now.b[i]))
    least = ROUND_OFF_OF_FORCES * largest if biggest > 0.0 else -1.0
    for a in range(k):
        p, slips = flags[ACTIVE, a], is_given(problem, a)
        moved = largest_of(y[3 * p :], 1 if slips else 3)
        # what others carry for it stays closed where it would not move either
        if x[3 * a] <= ROUND_OFF_OF_FORCES * biggest and moved > least:
            continue
        flags[AFTER, p] = SLIPS if slips else STICKS
        if slips:
            copy(problem.slips[a], decision.directions[SLIP_OF, p])


@inlined
def _is_at_limit(cones: ConeMemory, a: int, x: np.ndarray, biggest: float) -> bool:
    """Return whether a contact sticks by all that its friction can hold."""
    normal = x[3 * a]
    is_full = np.hypot(x[3 * a + 1], x[3 * a + 2]) >= HOLDS * cones.of_each[MU, a] * normal
    return not is_given(cones, a) and normal > ROUND_OFF_OF_FORCES * biggest and is_full


@kernel
def _find_slipping(cones: ConeMemory, k: int, x: np.ndarray, decision: Decision) -> bool:
    """Write which contacts should stick and do not, and along what their accelerations are; return if there are any."""
    flags, directions = decision.flags, decision.directions
    n, biggest, found = 3 * k, largest_of(x, 3 * k), False
    largest = 0.0
    for i in range(n):
        moved = 0.0
        for j in range(n):
            moved += cones.G[i, j] * x[j]
        largest = max(largest, abs(moved))
    least = ROUND_OFF_OF_FORCES * largest
    for a in range(k):
        flags[IS_NEW, a] = 0
        if not _is_at_limit(cones, a, x, biggest):
            continue
        along, across = cones.b[3 * a + 1], cones.b[3 * a + 2]
        for j in range(n):
            along += cones.G[3 * a + 1, j] * x[j]
            across += cones.G[3 * a + 2, j] * x[j]
        size = np.hypot(along, across)
        if size > least:
            flags[IS_NEW, a], found = 1, True
            directions[FOUND, a, 0], directions[FOUND, a, 1] = along / size, across / size
    return found


@kernel
def _find_slipping_soon(asking: Asking, decision: Decision, count: int, k: int, event: Ahead) -> tuple[bool, bool]:
    """Write in which directions begins to slip what is held by all that friction can hold.

    Returns
    -------
    is_known, is_any : bool
    """
    flags, vectors = decision.flags, decision.vectors
    problem, later, x, other = decision.problem, decision.ahead, vectors[X], vectors[OTHER]
    biggest, is_any = largest_of(x, 3 * k), False
    for a in range(k):
        is_any = is_any or _is_at_limit(problem, a, x, biggest)
    if not is_any or event[2] <= 0.0:
        return True, False
    for share in AHEAD:
        if not _go_ahead(asking, decision, count, k, share, event):
            return False, False
        copy(x[: 3 * k], other)
        if not solve(asking, True, k, OTHER, True):
            continue
        _find_slipping(later, k, other, decision)
        found = stays = False
        height = largest_of(other, 3 * k)
        for a in range(k):
            was = _is_at_limit(problem, a, x, biggest)
            flags[IS_NEW, a] = flags[IS_NEW, a] if was else 0
            found = found or flags[IS_NEW, a] != 0
            stays = stays or (was and _is_at_limit(later, a, other, height))
        if found or not stays:
            return True, found
    return True, False


@kernel
def _go_ahead(asking: Asking, decision: Decision, count: int, k: int, share: float, event: Ahead) -> bool:
    """Write the problem of the forces a fraction of the span later; return whether there is one."""
    flags, motion = decision.flags, decision.motion
    t, y, span, stop = event
    now, problem, later = decision.now, decision.problem, decision.ahead
    h, du, step, state = min(share * span, stop - t), motion[0], motion[1], decision.state
    if not look(asking, decision, FREE_ACCELERATIONS, t, count):
        return False
    free = len(du)
    first = asking.first_state - free
    for a in range(k):
        for i in range(3):
            for c in range(free):
                du[c] += decision.vectors[X, 3 * a + i] * now.responses[3 * flags[ACTIVE, a] + i, c]
    copy(y[: len(state)], state)
    for c in range(free):
        step[c] = h * (y[first + c] + 0.5 * h * du[c])
        state[first + c] = y[first + c] + h * du[c]
    if not look(asking, decision, POINTS_LATER, t + h, count):
        return False
    for a in range(k):
        p = flags[ACTIVE, a]
        later.of_each[MU, a], later.of_each[LEAST, a] = problem.of_each[MU, a], problem.of_each[LEAST, a]
        copy(problem.slips[a], later.slips[a])
        for i in range(3):
            later.b[3 * a + i] = decision.later.b[3 * p + i]
            for b in range(k):
                for j in range(3):
                    later.G[3 * a + i, 3 * b + j] = decision.later.G[3 * p + i, 3 * flags[ACTIVE, b] + j]
    return True


@kernel
def _turn(asking: Asking, decision: Decision, count: int, k: int, event: Ahead) -> bool:
    """Write the rates of the directions of slips that begin, in the axes of the surfaces; return if they are known."""
    flags, vectors, directions = decision.flags, decision.vectors, decision.directions
    directions[TURNING][:, :] = 0.0
    is_any, later, other, h = (
        False,
        decision.ahead,
        vectors[OTHER],
        min(AHEAD[-1] * event[2], event[3] - event[0]),
    )
    for a in range(k):
        is_any = is_any or flags[BEGINS, a] != 0
    if not is_any or h <= 0.0:
        return True
    if not _go_ahead(asking, decision, count, k, AHEAD[-1], event):
        return False
    for a in range(k):
        if flags[BEGINS, a] != 0:
            later.slips[a, 0] = later.slips[a, 1] = np.nan
    copy(vectors[X][: 3 * k], other)
    if not solve(asking, True, k, OTHER, True):
        return True
    for a in range(k):
        size = np.hypot(other[3 * a + 1], other[3 * a + 2])
        if flags[BEGINS, a] != 0 and size > 0.0:
            p, slip = flags[ACTIVE, a], decision.problem.slips[a]
            before = on_surface(decision.now, p, slip[0], slip[1])
            after = on_surface(decision.later, p, -other[3 * a + 1] / size, -other[3 * a + 2] / size)
            for c in range(3):
                directions[TURNING, p, c] = (after[c] - before[c]) / h
    return True


@inlined
def on_surface(moment: Moment, p: int, along: float, across: float) -> Numbers:
    """Return a direction along a surface in its axes, from its parts along both directions at a point."""
    first, second = times(along, vector(moment.met, p, MET.first)), times(across, vector(moment.met, p, MET.second))
    return rotated_back(matrix(moment.axes, p, 0), plus(first, second))


@kernel
def _follow(asking: Asking, decision: Decision, k: int) -> bool:
    """Write the forces, with slips that begin against the friction of what is free to choose its direction.

    That is known also where it is all but balanced, and accelerations are the difference of large numbers. Returns
    whether there are forces: in Painleve's paradox there are none, or several.
    """
    flags, vectors, directions = decision.flags, decision.vectors, decision.directions
    problem, other, is_any = decision.problem, vectors[OTHER], False
    for a in range(k):
        if flags[BEGINS, a] != 0:
            is_any = True
            copy(problem.slips[a], directions[FOUND, a])
            problem.slips[a, 0] = problem.slips[a, 1] = np.nan
    if is_any:
        is_free = solve(asking, False, k, OTHER, False)
        for a in range(k):
            if flags[BEGINS, a] != 0:
                size = np.hypot(other[3 * a + 1], other[3 * a + 2]) if is_free else 0.0
                for c in range(2):
                    problem.slips[a, c] = -other[3 * a + 1 + c] / size if size > 0.0 else directions[FOUND, a, c]
    for a in range(k):
        if is_given(problem, a):
            row, at = problem.G[3 * a], 3 * a
            rubbed = row[at + 1] * problem.slips[a, 0] + row[at + 2] * problem.slips[a, 1]
            if row[at] - problem.of_each[MU, a] * rubbed <= NOT_DETERMINED * row[at]:
                return False
    if not solve(asking, False, k, X, False):
        return False
    x, noise = vectors[X], 0.0
    for a in range(k):
        own = decision.now.G[3 * flags[ACTIVE, a], 3 * flags[ACTIVE, a]]
        if own > 0.0:
            noise = max(noise, ROUND_OFF_OF_ACCELERATIONS * decision.now.accelerated[flags[ACTIVE, a]] / own)
    if largest_of(x, 3 * k) <= noise:  # what falls freely presses on nothing
        x[: 3 * k] = 0.0
    return True
