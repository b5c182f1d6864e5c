"""Steps of Moreau and Jean of many loose bodies: balls that meet each other and walls, and what impulses make of them.

The equations are those of `kanefe.kane.rigid_contacts.time_stepping`. Every body turns about its centre of mass, so
that each has an inverse of its own; impulses come from Gauss and Seidel's iteration over the contacts, each with the
speeds that the others have left, from those that it had in the step before. Which balls may meet is found by a sweep
along x, whose order hardly changes from step to step.
"""

from __future__ import annotations

import math

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    matrix,
    minus,
    norm,
    plus,
    put_three,
    rotated,
    rotated_back,
    rotation,
    three,
    times,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.contact.contact_shapes import distance
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.sweeps.advance import put_turned

MASS, INERTIA, INVERSE, BODY_SIZE = 0, 1, 10, 19
"""Columns of bodies: mass in kg, then matrices in the body's axes."""

OF_BODY, CENTRE, RADIUS, BALL_SIZE = 0, 1, 4, 5
"""Columns of balls."""

IS_FLAT, PLACE, OFFSET, WALL_SIZE = 0, 1, 4, 5
"""Columns of walls: 1, normal and distance of a plane from the origin; or 0, and last the index in `shapes`."""

AXES, SHAPE = 3, 12
"""Numbers of a wall in `shapes`: place and axes in N, and its shape."""

NORMAL, ARMS, OTHER_ARMS, SPINS, OTHER_SPINS, LIGHTNESS, IMPULSE, BEFORE = 0, 9, 18, 27, 36, 45, 47, 50
INVERSE_NORMAL, INVERSE_ALONG, CONTACT_SIZE = 53, 54, 55
"""Columns of contacts: normal and two tangential directions in N; the moments of unit forces along these about the body
and about the other body, in their axes, and the angular velocities that unit impulses add; inverses of both masses;
impulses; rates at the start of the step; inverses of their effective inertias. Of a wall what would move is zero.
"""

FIRST, SECOND, KEY = 0, 1, 2
"""Columns of pairs: the body of the ball, the other body (-1: a wall), and a number of the pair."""

STEPS, TOUCHING, SWEEPS, MOST_SWEEPS, TOUCHED = range(5)
"""Indices of counts: remaining steps, contacts of the last step, sweeps in total, most sweeps in a step, contacts of
all steps."""

STEP, GRAVITY, RESTITUTION, FRICTION, ENOUGH, DEEPEST, RESIDUAL, TAKEN, CONTROL_SIZE = 0, 1, 4, 5, 6, 7, 8, 9, 10
"""Indices of control values: s, m/s2, dimensionless fractions, and the change of speeds in a sweep, relative to the
largest, that counts as none; deepest penetration (m), largest relative change of speeds at the end of sweeps, and
energy taken (J)."""

DONE, TOO_MANY = 0, 1

Speeds = tuple[Numbers, Numbers, Numbers, Numbers]
"""Velocity and angular velocity of a body and of another one."""


@entry()
def march_granular(
    counts: Integers,
    control: Reals,
    bodies: RealRows,
    balls: RealRows,
    walls: RealRows,
    shapes: Reals,
    left_out: Integers,
    q: RealRows,
    u: RealRows,
    order: Integers,
    places: RealRows,
    contacts: RealRows,
    pairs: IntegerRows,
    slots: Integers,
    kept: RealRows,
    kept_keys: Integers,
) -> int:
    """Take steps; return `TOO_MANY` before one that has more contacts than there is room for.

    Parameters
    ----------
    counts, control : ndarray
        See above.
    bodies, balls, walls, shapes : ndarray
        See above.
    left_out : ndarray
        Numbers of pairs that pass through each other, ascending.
    q, u : ndarray, shapes (bodies, 7), (bodies, 6)
        Places and Euler parameters; velocities in N, and angular velocities in axes of the body.
    order : ndarray, shape (balls,)
        By x, as it was last.
    places : ndarray, shape (balls, 3)
        Room for their centres.
    contacts, pairs : ndarray, shapes (c, CONTACT_SIZE), (c, 3)
        Room.
    slots : ndarray, shape (a power of two,)
        Room for a table of the pairs of the step before, -1.
    kept, kept_keys : ndarray, shapes (c, 3), (c + 1,)
        Impulses of those pairs, and their numbers; the last is how many they are.
    """
    h = control[STEP]
    while counts[STEPS] > 0:
        _advance(q, u, 0.5 * h)
        found = _detect(control, bodies, balls, walls, shapes, left_out, q, u, order, places, contacts, pairs)
        if found < 0:
            _advance(q, u, -0.5 * h)
            return TOO_MANY
        _recall(found, contacts, pairs, slots, kept, kept_keys)
        _accelerate(control, bodies, u, h)
        if found > 0:
            counts[SWEEPS] += _solve(found, counts[MOST_SWEEPS], control, u, contacts, pairs)
            _account(found, control, u, contacts, pairs)
        _keep(found, contacts, pairs, kept, kept_keys)
        _advance(q, u, 0.5 * h)
        counts[TOUCHING] = found
        counts[TOUCHED] += found
        counts[STEPS] -= 1
    return DONE


@kernel
def _advance(q: np.ndarray, u: np.ndarray, h: float) -> None:
    """Move all bodies for a time, turns by the exponential."""
    for i in range(len(q)):
        for k in range(3):
            q[i, k] += h * u[i, k]
        put_turned(q[i], 3, q[i], h * u[i, 3], h * u[i, 4], h * u[i, 5])


@kernel
def _spin_rate(bodies: np.ndarray, i: int, w: Numbers) -> Numbers:
    """Return the rate of the angular velocity of what turns freely: Euler's equations."""
    return times(-1.0, rotated(matrix(bodies, i, INVERSE), cross(w, rotated(matrix(bodies, i, INERTIA), w))))


@kernel
def _accelerate(control: np.ndarray, bodies: np.ndarray, u: np.ndarray, h: float) -> None:
    """Change the speeds as without contacts; by the spins of the middle of the step."""
    for i in range(len(u)):
        for k in range(3):
            u[i, k] += h * control[GRAVITY + k]
        w = three(u[i], 3)
        mid = plus(w, times(0.5 * h, _spin_rate(bodies, i, w)))
        after = plus(w, times(h, _spin_rate(bodies, i, mid)))
        u[i, 3], u[i, 4], u[i, 5] = after


@kernel
def _detect(
    control: np.ndarray,
    bodies: np.ndarray,
    balls: np.ndarray,
    walls: np.ndarray,
    shapes: np.ndarray,
    left_out: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    order: np.ndarray,
    places: np.ndarray,
    contacts: np.ndarray,
    pairs: np.ndarray,
) -> int:
    """Write what is closed; return how many, or -1 if there is no room."""
    count, found = len(balls), 0
    largest = 0.0
    for i in range(count):
        body = int(balls[i, OF_BODY])
        c = plus(three(q[body], 0), rotated(rotation(q[body], 3), three(balls[i], CENTRE)))
        places[i, 0], places[i, 1], places[i, 2] = c
        largest = max(largest, balls[i, RADIUS])
    for i in range(1, count):  # nearly in order: few moves
        one, k = order[i], i - 1
        while k >= 0 and places[order[k], 0] > places[one, 0]:
            order[k + 1] = order[k]
            k -= 1
        order[k + 1] = one
    for at in range(count):
        i = order[at]
        c, r = three(places[i], 0), balls[i, RADIUS]
        for w in range(len(walls)):
            place = three(walls[w], PLACE)
            if walls[w, IS_FLAT] == 1.0:
                gap, n = dot(place, c) - walls[w, OFFSET] - r, place
            else:
                gap, n = _beyond(shapes, int(walls[w, OFFSET]), c)
                gap -= r
            key = i * (count + len(walls)) + count + w
            if gap <= 0.0 and not _is_among(left_out, key):
                if found == len(contacts):
                    return -1
                _meet(found, key, i, -1, gap, n, control, bodies, balls, q, u, places, contacts, pairs)
                found += 1
        for k in range(at + 1, count):
            j = order[k]
            if places[j, 0] - c[0] > r + largest:
                break
            reach = r + balls[j, RADIUS]
            if abs(places[j, 1] - c[1]) > reach or abs(places[j, 2] - c[2]) > reach:
                continue
            probe, other = (i, j) if i < j else (j, i)
            away = minus(three(places[probe], 0), three(places[other], 0))
            square = dot(away, away)
            key = probe * (count + len(walls)) + other
            if square > reach * reach or balls[i, OF_BODY] == balls[j, OF_BODY] or _is_among(left_out, key):
                continue
            if found == len(contacts):
                return -1
            length = math.sqrt(square)
            n = times(1.0 / length, away) if length > 0.0 else (0.0, 0.0, 1.0)
            _meet(
                found,
                key,
                probe,
                int(balls[other, OF_BODY]),
                length - reach,
                n,
                control,
                bodies,
                balls,
                q,
                u,
                places,
                contacts,
                pairs,
            )
            found += 1
    return found


@kernel
def _beyond(shapes: np.ndarray, own: int, c: Numbers) -> tuple[float, Numbers]:
    """Return how far a place is from a wall that is not flat, and the normal there."""
    A = nine(shapes, own + AXES)
    phi, x, y, z = distance(shapes, own + SHAPE, rotated_back(A, minus(c, three(shapes, own))))
    return phi, rotated(A, (x, y, z))


@kernel
def _is_among(numbers: np.ndarray, one: int) -> bool:
    low, high = 0, len(numbers)
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < one:
            low = middle + 1
        else:
            high = middle
    return low < len(numbers) and numbers[low] == one


@kernel
def _meet(
    found: int,
    key: int,
    ball: int,
    other: int,
    gap: float,
    n: Numbers,
    control: np.ndarray,
    bodies: np.ndarray,
    balls: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    places: np.ndarray,
    contacts: np.ndarray,
    pairs: np.ndarray,
) -> None:
    """Write a contact of a ball with another body, or a wall."""
    control[DEEPEST] = max(control[DEEPEST], -gap)
    body = int(balls[ball, OF_BODY])
    pairs[found, FIRST], pairs[found, SECOND], pairs[found, KEY] = body, other, key
    point = minus(three(places[ball], 0), times(balls[ball, RADIUS], n))
    x, y, z = abs(n[0]), abs(n[1]), abs(n[2])
    least = (1.0, 0.0, 0.0) if x <= y and x <= z else (0.0, 1.0, 0.0) if y <= z else (0.0, 0.0, 1.0)
    first = cross(n, least)
    first = times(1.0 / norm(first), first)
    second = cross(n, first)
    row = contacts[found]
    A, arm = rotation(q[body], 3), minus(point, three(q[body], 0))
    for k in range(3):
        e = n if k == 0 else first if k == 1 else second
        about = rotated_back(A, cross(arm, e))
        put_three(row, 3 * k, e)
        put_three(row, ARMS + 3 * k, about)
        put_three(row, SPINS + 3 * k, rotated(matrix(bodies, body, INVERSE), about))
        put_three(row, OTHER_ARMS + 3 * k, (0.0, 0.0, 0.0))
        put_three(row, OTHER_SPINS + 3 * k, (0.0, 0.0, 0.0))
    row[LIGHTNESS], row[LIGHTNESS + 1] = 1.0 / bodies[body, MASS], 0.0
    if other >= 0:
        A, arm = rotation(q[other], 3), minus(point, three(q[other], 0))
        for k in range(3):
            about = rotated_back(A, cross(arm, three(row, 3 * k)))
            put_three(row, OTHER_ARMS + 3 * k, about)
            put_three(row, OTHER_SPINS + 3 * k, rotated(matrix(bodies, other, INVERSE), about))
        row[LIGHTNESS + 1] = 1.0 / bodies[other, MASS]
    both = _speeds(u, body, other)
    for k in range(3):
        row[BEFORE + k] = _rate(row, k, both)
    a, b, c = _answer(row, 1, 1), _answer(row, 1, 2), _answer(row, 2, 2)
    row[INVERSE_NORMAL] = 1.0 / _answer(row, 0, 0)
    row[INVERSE_ALONG] = 1.0 / (0.5 * (a + c) + math.sqrt(0.25 * (a - c) * (a - c) + b * b))


@inlined
def _speeds(u: np.ndarray, body: int, other: int) -> Speeds:
    """Return velocity and angular velocity of the body of a contact and of the other one; zero of a wall."""
    v, w = three(u[body], 0), three(u[body], 3)
    if other < 0:
        return v, w, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return v, w, three(u[other], 0), three(u[other], 3)


@inlined
def _put_speeds(u: np.ndarray, body: int, other: int, both: Speeds) -> None:
    put_three(u[body], 0, both[0])
    put_three(u[body], 3, both[1])
    if other >= 0:
        put_three(u[other], 0, both[2])
        put_three(u[other], 3, both[3])


@inlined
def _rate(row: np.ndarray, k: int, both: Speeds) -> float:
    """Return the rate of a contact along one of its directions, m/s."""
    v, w, other_v, other_w = both
    turning = dot(three(row, ARMS + 3 * k), w) - dot(three(row, OTHER_ARMS + 3 * k), other_w)
    return dot(three(row, 3 * k), minus(v, other_v)) + turning


@inlined
def _answer(row: np.ndarray, j: int, k: int) -> float:
    """Return by what a unit impulse along one direction changes the rate along another, 1/kg."""
    along = dot(three(row, 3 * j), three(row, 3 * k)) * (row[LIGHTNESS] + row[LIGHTNESS + 1])
    turning = dot(three(row, ARMS + 3 * j), three(row, SPINS + 3 * k))
    return along + turning + dot(three(row, OTHER_ARMS + 3 * j), three(row, OTHER_SPINS + 3 * k))


@inlined
def _pushed(row: np.ndarray, k: int, both: Speeds, impulse: float) -> Speeds:
    """Return the speeds after an impulse along one of the directions of a contact."""
    v, w, other_v, other_w = both
    e = three(row, 3 * k)
    return (
        plus(v, times(impulse * row[LIGHTNESS], e)),
        plus(w, times(impulse, three(row, SPINS + 3 * k))),
        minus(other_v, times(impulse * row[LIGHTNESS + 1], e)),
        minus(other_w, times(impulse, three(row, OTHER_SPINS + 3 * k))),
    )


@kernel
def _solve(found: int, most: int, control: np.ndarray, u: np.ndarray, contacts: np.ndarray, pairs: np.ndarray) -> int:
    """Write impulses, and the speeds that they lead to; return the number of sweeps."""
    e, mu = control[RESTITUTION], control[FRICTION]
    largest = 0.0
    for c in range(found):
        row = contacts[c]
        both = _speeds(u, pairs[c, FIRST], pairs[c, SECOND])
        largest = max(largest, abs(_rate(row, 0, both) + e * row[BEFORE]))
    for c in range(found):  # from the impulses of the step before
        row = contacts[c]
        if row[IMPULSE] != 0.0:
            both = _speeds(u, pairs[c, FIRST], pairs[c, SECOND])
            for k in range(3):
                both = _pushed(row, k, both, row[IMPULSE + k])
            _put_speeds(u, pairs[c, FIRST], pairs[c, SECOND], both)
    change = 0.0
    for sweep in range(most):
        change = 0.0
        for c in range(found):
            change = max(change, _improve(e, mu, u, contacts[c], pairs[c, FIRST], pairs[c, SECOND]))
        if change <= control[ENOUGH] * largest:
            control[RESIDUAL] = max(control[RESIDUAL], change / largest if largest > 0.0 else 0.0)
            return sweep + 1
    control[RESIDUAL] = max(control[RESIDUAL], change / largest if largest > 0.0 else 0.0)
    return most


@inlined
def _improve(e: float, mu: float, u: np.ndarray, row: np.ndarray, body: int, other: int) -> float:
    """Set the impulses of a contact by the speeds that the others leave; return by how much rates change, m/s."""
    both = _speeds(u, body, other)
    normal = max(0.0, row[IMPULSE] - row[INVERSE_NORMAL] * (_rate(row, 0, both) + e * row[BEFORE]))
    more = normal - row[IMPULSE]
    if normal == 0.0 and more == 0.0:
        return 0.0  # open, and friction has ended with it
    both = _pushed(row, 0, both, more)
    row[IMPULSE] = normal
    change = abs(more) / row[INVERSE_NORMAL]
    if mu > 0.0:
        s = row[IMPULSE + 1] - row[INVERSE_ALONG] * _rate(row, 1, both)
        t = row[IMPULSE + 2] - row[INVERSE_ALONG] * _rate(row, 2, both)
        size = math.sqrt(s * s + t * t)
        if size > mu * normal:
            s, t = mu * normal / size * s, mu * normal / size * t
        more_s, more_t = s - row[IMPULSE + 1], t - row[IMPULSE + 2]
        both = _pushed(row, 2, _pushed(row, 1, both, more_s), more_t)
        row[IMPULSE + 1], row[IMPULSE + 2] = s, t
        change = max(change, max(abs(more_s), abs(more_t)) / row[INVERSE_ALONG])
    _put_speeds(u, body, other, both)
    return change


@kernel
def _account(found: int, control: np.ndarray, u: np.ndarray, contacts: np.ndarray, pairs: np.ndarray) -> None:
    """Add the energy that contacts took in a step: impulses times the mean of the rates before and after it."""
    for c in range(found):
        row = contacts[c]
        both = _speeds(u, pairs[c, FIRST], pairs[c, SECOND])
        for k in range(3):
            control[TAKEN] -= row[IMPULSE + k] * 0.5 * (row[BEFORE + k] + _rate(row, k, both))


@kernel
def _slot(slots: np.ndarray, key: int) -> int:
    return (key * 2654435761) & (len(slots) - 1)


@kernel
def _recall(
    found: int, contacts: np.ndarray, pairs: np.ndarray, slots: np.ndarray, kept: np.ndarray, kept_keys: np.ndarray
) -> None:
    """Write the impulses that contacts had in the step before, and zero of new ones."""
    count = kept_keys[-1]
    for i in range(count):
        at = _slot(slots, kept_keys[i])
        while slots[at] >= 0:
            at = (at + 1) & (len(slots) - 1)
        slots[at] = i
    for c in range(found):
        at = _slot(slots, pairs[c, KEY])
        while slots[at] >= 0 and kept_keys[slots[at]] != pairs[c, KEY]:
            at = (at + 1) & (len(slots) - 1)
        for k in range(3):
            contacts[c, IMPULSE + k] = kept[slots[at], k] if slots[at] >= 0 else 0.0
    for i in range(count):
        at = _slot(slots, kept_keys[i])
        while slots[at] >= 0:
            slots[at] = -1
            at = (at + 1) & (len(slots) - 1)


@kernel
def _keep(found: int, contacts: np.ndarray, pairs: np.ndarray, kept: np.ndarray, kept_keys: np.ndarray) -> None:
    """Keep impulses for the next step."""
    for c in range(found):
        kept_keys[c] = pairs[c, KEY]
        for k in range(3):
            kept[c, k] = contacts[c, IMPULSE + k]
    kept_keys[len(kept_keys) - 1] = found
