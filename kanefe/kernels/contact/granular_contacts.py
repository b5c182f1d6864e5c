"""Steps of Moreau and Jean of many loose bodies: balls that meet each other and walls, and what impulses make of them.

The equations are those of `kanefe.kane.rigid_contacts.time_stepping`. Every body turns about its centre of mass, so
that each has an inverse of its own; impulses begin from those of the step before. Which balls may meet is found by a
sweep along x, whose order hardly changes from step to step.
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
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.contact.contact_shapes import distance
from kanefe.kernels.contact.granular_impulses import (
    ARMS,
    BEFORE,
    DEEPEST,
    FIRST,
    GRAVITY,
    IMPULSE,
    INVERSE_ALONG,
    INVERSE_NORMAL,
    KEY,
    LIGHTNESS,
    OTHER_ARMS,
    OTHER_SPINS,
    SECOND,
    SPINS,
    STEP,
    STEPS,
    TOUCHED,
    TOUCHING,
    account,
    answer,
    rate,
    solve,
    speeds,
)
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.joints.ball import put_turned

MASS, INERTIA, INVERSE, BODY_SIZE = 0, 1, 10, 19
"""Columns of bodies: mass in kg, then matrices in the body's axes."""

OF_BODY, CENTRE, RADIUS, BALL_SIZE = 0, 1, 4, 5
"""Columns of balls."""

IS_FLAT, PLACE, OFFSET, WALL_SIZE = 0, 1, 4, 5
"""Columns of walls: 1, normal and distance of a plane from the origin; or 0, and last the index in `shapes`."""

AXES, SHAPE = 3, 12
"""Numbers of a wall in `shapes`: place and axes in N, and its shape."""

DONE, TOO_MANY = 0, 1


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
    groups: IntegerRows,
    sums: RealRows,
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
    contacts, pairs : ndarray, shapes (c, CONTACT_SIZE), (c, PAIR_SIZE)
        Room.
    slots : ndarray, shape (a power of two,)
        Room for a table of the pairs of the step before, -1.
    kept, kept_keys : ndarray, shapes (c, 3), (c + 1,)
        Impulses of those pairs, and their numbers; the last is how many they are.
    groups, sums : ndarray, shapes (bodies, 2), (bodies, SUMS)
        Room.
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
            solve(found, counts, control, u, contacts, pairs, groups, sums)
            account(found, control, u, contacts, pairs)
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
    both = speeds(u, body, other)
    for k in range(3):
        row[BEFORE + k] = rate(row, k, both)
    a, b, c = answer(row, 1, 1), answer(row, 1, 2), answer(row, 2, 2)
    row[INVERSE_NORMAL] = 1.0 / answer(row, 0, 0)
    row[INVERSE_ALONG] = 1.0 / (0.5 * (a + c) + math.sqrt(0.25 * (a - c) * (a - c) + b * b))


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
