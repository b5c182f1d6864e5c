"""Steps of Moreau and Jean of many loose bodies: balls that meet each other and walls, and what impulses make of them.

The equations are those of `kanefe.literal.impact_steps`. Every body turns about its centre of mass, so
that each has an inverse of its own; impulses begin from those of the step before. Which balls may meet is found by a
sweep along x, whose order hardly changes from step to step.
"""

import math
from collections import namedtuple

import numpy as np

from kanefe.kernels.contact.broad_phase import first_from, sift
from kanefe.kernels.contact.contact_shapes import distance_in
from kanefe.kernels.contact.granular_impulses import account, pair_rates, solve
from kanefe.kernels.contact.granular_scene import (
    Balls,
    BodyStates,
    Contacts,
    Control,
    Loose,
    LooseBodies,
    LooseBody,
    Places,
    Steps,
    Wall,
)
from kanefe.kernels.joints.ball import put_turned
from kanefe.kernels.joints.motion import orientation, three
from kanefe.kernels.language import NO_MATRIX, ZERO, Matrix, Vector, beside, cross, dot, entry, inlined, kernel, skew

DONE, TOO_MANY = 0, 1


@entry()
def march_granular(given: Loose, steps: Steps) -> int:
    """Take steps; return `TOO_MANY` before one that has more contacts than there is room for."""
    control = Control(steps.counts, steps.control)
    h = control.step
    while control.steps > 0:
        _advance(steps.q, steps.u, 0.5 * h)
        found = _detect(given, steps)
        if found < 0:
            _advance(steps.q, steps.u, -0.5 * h)
            return TOO_MANY
        _recall(found, steps)
        _accelerate(given, steps, h)
        if found > 0:
            solve(found, steps)
            account(found, steps)
        _keep(found, steps)
        _advance(steps.q, steps.u, 0.5 * h)
        control.touching = found
        control.touched += found
        control.steps -= 1
    return DONE


@kernel
def _advance(q: np.ndarray, u: np.ndarray, h: float) -> None:
    """Move all bodies for a time, turns by the exponential."""
    for i in range(len(q)):
        for k in range(3):
            q[i, k] += h * u[i, k]
        put_turned(q[i], 3, q[i], h * u[i, 3], h * u[i, 4], h * u[i, 5])


@inlined
def _spin_rate(body: LooseBody, w: Vector) -> Vector:
    """Return the rate of the angular velocity of what turns freely: Euler's equations."""
    return -(body.inverse @ cross(w, body.inertia @ w))


@kernel
def _accelerate(given: Loose, steps: Steps, h: float) -> None:
    """Change the speeds as without contacts; by the spins of the middle of the step."""
    bodies, states = LooseBodies(given.bodies), BodyStates(steps.u)
    gravity = Control(steps.counts, steps.control).gravity
    for i in range(len(bodies)):
        body, state = bodies[i], states[i]
        state.v += h * gravity
        state.w += h * _spin_rate(body, state.w + 0.5 * h * _spin_rate(body, state.w))


@kernel
def _detect(given: Loose, steps: Steps) -> int:
    """Write what is closed; return how many, or -1 if there is no room."""
    balls, places, count, found = Balls(given.balls), Places(steps.places), len(given.balls), 0
    largest = 0.0
    for i in range(count):
        ball = balls[i]
        q = steps.q[int(ball.body)]
        places[i].x = three(q, 0) + orientation(q, 3) @ ball.centre
        steps.keys[i], largest = places[i].x.x, max(largest, ball.radius)
    sift(steps.keys, steps.order, count, 1)  # nearly in order: few moves
    for at in range(count):
        found = _meet_walls(given, steps, steps.order[at], found)
        found = _meet_balls(given, steps, at, largest, found)
        if found < 0:
            return -1
    return found


@kernel
def _meet_walls(given: Loose, steps: Steps, i: int, found: int) -> int:
    """Write which walls a ball meets after so many contacts; return how many there are with these, or -1."""
    c, r, count = Places(steps.places)[i].x, Balls(given.balls)[i].radius, len(given.balls)
    for k in range(len(given.walls)):
        wall = Wall(given.shapes, given.walls[k])
        away = distance_in(wall.p, wall.A, wall.shape, 0, c)
        key = i * (count + len(given.walls)) + count + k
        if away.gap <= r and not _is_among(given.left_out, key):
            if found == len(steps.contacts):
                return -1
            _meet(given, steps, Meets(found, key, i, -1, away.gap - r, away.normal))
            found += 1
    return found


@kernel
def _meet_balls(given: Loose, steps: Steps, at: int, largest: float, found: int) -> int:
    """Write which balls behind it in the order a ball meets, likewise."""
    if found < 0:
        return found
    balls, places, count = Balls(given.balls), Places(steps.places), len(given.balls)
    i = steps.order[at]
    c, r, body = places[i].x, balls[i].radius, balls[i].body
    for k in range(at + 1, count):
        j = steps.order[k]
        away, reach = places[j].x - c, r + balls[j].radius
        if away.x > r + largest:
            break
        square = dot(away, away)
        if square > reach * reach or body == balls[j].body:
            continue
        probe, other = (i, j) if i < j else (j, i)
        key = probe * (count + len(given.walls)) + other
        if _is_among(given.left_out, key):
            continue
        if found == len(steps.contacts):
            return -1
        length = math.sqrt(square)
        n = (1.0 / length) * (places[probe].x - places[other].x) if length > 0.0 else Vector(0.0, 0.0, 1.0)
        _meet(given, steps, Meets(found, key, probe, int(balls[other].body), length - reach, n))
        found += 1
    return found


@inlined
def _is_among(numbers: np.ndarray, one: int) -> bool:
    at = first_from(numbers, one)
    return at < len(numbers) and numbers[at] == one


Meets = namedtuple("Meets", "at key ball other gap normal")
"""A contact that is found: its place among them, the number of the pair, ball and other body, gap and normal."""


@kernel
def _meet(given: Loose, steps: Steps, found: Meets) -> None:
    """Write a contact of a ball with another body, or a wall."""
    control, ball, n = Control(steps.counts, steps.control), Balls(given.balls)[found.ball], found.normal
    control.deepest = max(control.deepest, -found.gap)
    contact = Contacts(steps.pairs, steps.contacts)[found.at]
    contact.body, contact.other, contact.key = int(ball.body), found.other, found.key
    point, first = Places(steps.places)[found.ball].x - ball.radius * n, beside(n)
    second = cross(n, first)
    contact.axes = Matrix(n.x, n.y, n.z, first.x, first.y, first.z, second.x, second.y, second.z)
    contact.arms, contact.spins, contact.lightness = _moved_by(given, steps, contact.body, contact.axes, point)
    contact.other_arms, contact.other_spins, contact.other_lightness = NO_MATRIX, NO_MATRIX, 0.0
    if found.other >= 0:
        arms, spins, lightness = _moved_by(given, steps, found.other, contact.axes, point)
        contact.other_arms, contact.other_spins, contact.other_lightness = arms, spins, lightness
    contact.before = pair_rates(contact, BodyStates(steps.u))
    # axes are orthonormal: along them the lightness of both bodies is all that masses add
    turning = contact.arms @ contact.spins.T + contact.other_arms @ contact.other_spins.T
    x, y, z, both = turning.x, turning.y, turning.z, contact.lightness + contact.other_lightness
    contact.inverse_normal, contact.by_normal = 1.0 / (x.x + both), Vector(0.0, x.y, x.z)
    half, b = 0.5 * (y.y - z.z), y.z
    contact.inverse_along = 1.0 / (0.5 * (y.y + z.z) + both + math.sqrt(half * half + b * b))


@kernel
def _moved_by(given: Loose, steps: Steps, i: int, axes: Matrix, point: Vector) -> tuple[Matrix, Matrix, float]:
    """Return the moments about a body of unit forces at a point, the spins that they make, and its lightness."""
    body, q = LooseBodies(given.bodies)[i], steps.q[i]
    A, arm = orientation(q, 3), point - three(q, 0)
    arms = (A.T @ (skew(arm) @ axes.T)).T
    return arms, (body.inverse @ arms.T).T, 1.0 / body.mass


@kernel
def _slot(slots: np.ndarray, key: int) -> int:
    return (key * 2654435761) & (len(slots) - 1)


@kernel
def _recall(found: int, steps: Steps) -> None:
    """Write the impulses that contacts had in the step before, and zero of new ones."""
    slots, keys, kept = steps.slots, steps.kept_keys, Places(steps.kept)
    contacts = Contacts(steps.pairs, steps.contacts)
    for i in range(keys[-1]):
        at = _slot(slots, keys[i])
        while slots[at] >= 0:
            at = (at + 1) & (len(slots) - 1)
        slots[at] = i
    for c in range(found):
        contact = contacts[c]
        at = _slot(slots, contact.key)
        while slots[at] >= 0 and keys[slots[at]] != contact.key:
            at = (at + 1) & (len(slots) - 1)
        contact.impulse = kept[slots[at]].x if slots[at] >= 0 else ZERO
    for i in range(keys[-1]):
        at = _slot(slots, keys[i])
        while slots[at] >= 0:
            slots[at] = -1
            at = (at + 1) & (len(slots) - 1)


@kernel
def _keep(found: int, steps: Steps) -> None:
    """Keep impulses for the next step."""
    contacts, kept = Contacts(steps.pairs, steps.contacts), Places(steps.kept)
    for c in range(found):
        steps.kept_keys[c], kept[c].x = contacts[c].key, contacts[c].impulse
    steps.kept_keys[len(steps.kept_keys) - 1] = found
