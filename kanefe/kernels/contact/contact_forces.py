"""Contacts: points of some frames against a surface, with laws of normal force and of friction (Eq. 11)."""

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.contact_places import (
    AnchorStates,
    AtState,
    ContactNumbers,
    FrictionStates,
    Place,
    RestNumbers,
    end_of,
    first_state_of,
    point_of,
    softened,
)
from kanefe.kernels.contact.detection import gone_since, turned_since, velocity
from kanefe.kernels.contact.laws import normal_force, rub
from kanefe.kernels.contact.laws.coulomb import CoulombNumbers
from kanefe.kernels.contact.laws.friction_law import Rubbed, Sliding
from kanefe.kernels.contact.laws.normal_law import Pressing
from kanefe.kernels.contact.laws.turning import Turning, couple
from kanefe.kernels.contact.meeting import look, look_up, meet, place_of
from kanefe.kernels.force_elements.coordinate_stop import impact_damping
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends, Wrenches, rates_of
from kanefe.kernels.language import Vector, across, called_by_address, cross, dot, inlined, kernel

TOUCHES, STICKS = 0, 3
"""Numbers of the events of a contact that change its states, beside that of a slip, 2."""

AT_THE_LIMIT = 1e-9
"""Force relative to the normal force within which contact points slip or stick together with the first one."""

EPSILON = float(np.finfo(float).eps)

ROUND_OFF = 10.0 * EPSILON
"""Depth, relative to the coordinates that it is the difference of, below which it has no sign."""

REST = RestNumbers.number_count

Touching = namedtuple("Touching", "along carried rate normal stretch rubbed")
"""Motion of a point that touches. `along, carried`: velocity along the surface, and that of a belt, m/s; `rate`: of the
depth, m/s; `stretch`: of the anchor, m; zero without friction; `rubbed`: all zero without friction."""


@called_by_address(*SIGNATURE)
def contact(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the surface, the first end, and on the others, and the rates of the states."""
    at = AtState(ContactNumbers(numbers), numbers, ends, states)
    met = meet(at, local_numbers(), local_numbers(), local_numbers())
    for i in range(int(at.own.count)):
        put_point(at, i, place_of(at, i, met), Done(out))


@inlined
def put_point(at: AtState, i: int, place: Place, done: Done) -> None:
    """Add what a point does at its place; without a share of the stiffness it does not touch.

    What touches to round-off touches: the slip of what just touches would begin and end with the sign of that, in each
    step anew.
    """
    own, share, normal = at.own, place.share, place.normal
    rates, first = rates_of(done, int(own.ends)), first_state_of(at, i)
    has_friction, moves = own.friction > 0.0, own.rests_at == 0.0
    if share.real <= 0.0 or (own.softness == 0.0 and is_apart(at, i, place)):
        if has_friction and moves:
            let_go(at, share, first, done)
            if own.turning > 0.0:
                turned(at, i, place, 0.0 * place.depth, done)
        return
    found = touching(at, i, place)
    pressed = found.normal
    done.potential += pressed.energy
    done.taken += (pressed.force - pressed.elastic) * found.rate
    if own.branches > 0.0 and moves:
        rates[first + int(own.each) - 1] = pressed.branch_rate
    total = pressed.force * normal
    if has_friction:
        w, rubbed = found.stretch, found.rubbed
        done.potential += 0.5 * rubbed.stiffness * dot(w, w)
        done.taken += dot(rubbed.force, found.along) - rubbed.stiffness * dot(w, rubbed.stretch_rate)
        done.given -= dot(rubbed.force, found.carried)
        if moves:
            path = FrictionStates(rates)
            path.slip += share * rubbed.slip
            path.work += dot(rubbed.force, found.along - rubbed.stretch_rate)
            AnchorStates(rates, first).stretch = Ends(at.ends)[0].A.T @ rubbed.stretch_rate
        total -= rubbed.force
    number = int(point_of(at, i).end)
    moment, moment_s = (
        cross(place.point - Ends(at.ends)[number].p, total),
        cross(place.point - Ends(at.ends)[0].p, total),
    )
    if own.turning > 0.0:
        against = turned(at, i, place, pressed.force, done)
        moment, moment_s = moment - against, moment_s - against
    wrench, opposite = Wrenches(done.wrenches)[number], Wrenches(done.wrenches)[0]
    wrench.force += total
    wrench.moment += moment
    opposite.force -= total
    opposite.moment -= moment_s


@inlined
def size_in(x: Vector) -> Vector:
    """Return the sizes of the components of a vector."""
    return Vector(abs(x.x.real), abs(x.y.real), abs(x.z.real))


@inlined
def blur_of(at: AtState, i: int, place: Place) -> float:
    """Return how far round-off of where things are blurs the depth of a point at its place, m."""
    size = size_in(place.point) + size_in(Ends(at.ends)[0].p) + size_in(end_of(at, i).p)
    return ROUND_OFF * max(size.x, size.y, size.z)  # type: ignore[no-any-return]


@inlined
def is_apart(at: AtState, i: int, place: Place) -> bool:
    """Return whether a point at its place is off the surface by more than round-off."""
    return place.depth.real <= 0.0 and place.depth.real <= -blur_of(at, i, place)


@inlined
def let_go(at: AtState, share: Any, first: int, done: Done) -> None:
    """Have the stretch of a point in the air come back; what its spring gives up is taken."""
    relaxation, k, stretch = at.own.relaxation, share * at.own.spring, AnchorStates(at.states, first).stretch
    square = dot(stretch, stretch)
    AnchorStates(rates_of(done, int(at.own.ends)), first).stretch = -relaxation * stretch
    done.potential += 0.5 * k * square
    done.taken += k * relaxation * square


@inlined
def touching(at: AtState, i: int, place: Place) -> Touching:
    """Return what a point does that touches at its place."""
    own, surface, end = at.own, Ends(at.ends)[0], end_of(at, i)
    normal, share, first = place.normal, place.share, first_state_of(at, i)
    v = velocity(surface, end, place.point)
    rate = -dot(v, normal)
    zero = 0.0 * rate
    more = branch = zero
    if own.impact >= 0.0:
        more = zero + at.states[int(own.impact)]
    if own.branches > 0.0:
        branch = zero + at.states[first + int(own.each) - 1]
    pressed = softened(own, place.depth)
    least = EPSILON * blur_of(at, i, place)
    if pressed.real < least:  # laws are for depths above zero, see `is_apart`
        pressed = least + 0.0 * pressed
    force = normal_force(own.normal, at.numbers, int(own.normal_at), Pressing(share, pressed, rate, more, branch))
    none = Vector(zero, zero, zero)
    along, carried, w, rubbed = none, none, none, Rubbed(none, none, 0.0 * share, zero, zero)
    if own.friction > 0.0:
        rests, A_s = own.rests_at > 0.0, surface.A
        w = A_s @ AnchorStates(at.states, first).stretch
        if rests:
            w += gone_since(RestNumbers(at.numbers, int(own.rests_at) + REST * i), surface, end)
        carried = across(A_s @ own.belt, normal)
        along = v + rate * normal - carried
        held = is_held(at, first)
        waits = held and own.has_memory > 0.0 and not rests
        sliding = Sliding(share, force.force, normal, A_s, along, w, held, waits, rests)
        rubbed = rub(own.friction, at.numbers, int(own.friction_at), sliding)
    return Touching(along, carried, rate, force, w, rubbed)


@kernel
def felt(at: AtState, i: int, place: Place) -> Touching:
    """Return the same, for code that is not called in each evaluation."""
    return touching(at, i, place)


@inlined
def is_held(at: AtState, first: int) -> bool:
    """Return whether a point sticks, as far as that is remembered."""
    return at.own.has_memory == 0.0 or AnchorStates(at.states, first).sticks.real > 0.5


@inlined
def turned(at: AtState, i: int, place: Place, pressed: Any, done: Done) -> Vector:
    """Return the moment against turning of a point; write the rates of its states, and add what else it does."""
    own, point, surface, end = at.own, point_of(at, i), Ends(at.ends)[0], end_of(at, i)
    law, rates = CoulombNumbers(at.numbers, int(own.friction_at)), rates_of(done, int(own.ends))
    moves, count, zero = own.rests_at == 0.0, int(own.turning), 0.0 * pressed
    gone = Vector(zero, zero, zero)
    if not moves:
        gone = turned_since(RestNumbers(at.numbers, int(own.rests_at) + REST * i), surface, end)
    first = first_state_of(at, i) + int(own.each) - int(own.branches) - count
    lever = point.radius + max(point.ring, 0.0)
    turning = Turning(place.share, lever, pressed, place.normal, surface.A, end.w - surface.w, gone)
    held = couple(law, turning, at.states, first)
    done.potential += held.energy
    done.taken += held.taken
    if moves:
        FrictionStates(rates).work += held.work
    if law.torsional > 0.0:
        rates[first] = held.about_rate if moves else zero
    if law.rolling > 0.0:
        rolling = AnchorStates(rates, first + count - 3)
        rolling.stretch = held.rolling_rate if moves else Vector(zero, zero, zero)
    return held.moment


@called_by_address(*WATCH_SIGNATURE)
def contact_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write its event values: see `kanefe.contact.contact_events.Watched`."""
    at, room = AtState(ContactNumbers(numbers), numbers, ends, states), local_numbers()
    met, seen = look(at, room), WatchedSoFar(-np.inf, np.inf, -np.inf, np.inf, False)
    for i in range(int(at.own.count)):
        seen = watched(at, i, look_up(at, i, met), out, seen)
    out[0] = out[1] = seen.deepest
    if at.own.holds > 0.0:
        out[2] = seen.most if seen.most > -np.inf else seen.shallowest * at.own.stiffness
        out[3] = -seen.deepest * at.own.stiffness
        if seen.is_any:
            last = seen.least if at.own.has_memory > 0.0 else seen.most
            out[3] = last if abs(last) < np.inf else 1.0


@called_by_address(*WATCH_SIGNATURE)
def contact_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the states after an event: the damping of an impact, or that points at their limit slip or stick."""
    at, room, event = AtState(ContactNumbers(numbers), numbers, ends, states), local_numbers(), int(inputs[0])
    own, met = at.own, look(at, room)
    if event == TOUCHES:
        deepest, speed = -np.inf, 0.0
        for i in range(int(own.count)):
            place = look_up(at, i, met)
            if place.depth > deepest:
                deepest = place.depth
                speed = -dot(velocity(Ends(at.ends)[0], end_of(at, i), place.point), place.normal)
        out[1 + int(own.impact)] = impact_damping(own.impact_number, own.least_speed, speed)
        return
    to, extreme = 1.0 if event == STICKS else 0.0, -np.inf
    for i in range(int(own.count)):
        extreme = max(extreme, way_past(at, i, look_up(at, i, met), to)[0])
    for i in range(int(own.count)):
        past, force = way_past(at, i, look_up(at, i, met), to)
        if past > -np.inf and past >= min(extreme, -AT_THE_LIMIT * force):
            AnchorStates(out, 1 + first_state_of(at, i)).sticks = to


@inlined
def way_past(at: AtState, i: int, place: Place, to: float) -> tuple[float, float]:
    """Return the force by which a point is past its limit to slip (0) or to stick (1), and its normal force, N.

    Minus infinity: it does not touch, or does so already.
    """
    if is_apart(at, i, place) or (AnchorStates(at.states, first_state_of(at, i)).sticks > 0.5) == (to > 0.5):
        return -np.inf, 0.0
    found = felt(at, i, place)
    return (1.0 - 2.0 * to) * found.rubbed.beyond, found.normal.force


WatchedSoFar = namedtuple("WatchedSoFar", "deepest shallowest most least is_any")
"""State of the points of a contact for its events. `deepest, shallowest`: depths, m; `most, least`: of held
points the largest pull beyond what friction holds, and of slipping ones the least, N; `is_any`: whether there are
any."""


@inlined
def watched(at: AtState, i: int, place: Place, out: Any, seen: WatchedSoFar) -> WatchedSoFar:
    """Write the event values of a point, and return those of all points with it.

    That of a slip rises above zero where it slips that was held, that of a stick falls below where it sticks that
    slipped; both have their sign where it does not touch. It does from where its depth has no sign on, see `is_apart`.
    """
    own, depth = at.own, place.depth + blur_of(at, i, place)
    has_memory, reports_points, holds = own.has_memory > 0.0, own.reports_points > 0.0, own.holds > 0.0
    k = (4 if holds else 2) * (i + 1)  # after those of the contact
    if reports_points:
        out[k] = out[k + 1] = depth
        if holds:
            out[k + 2], out[k + 3] = depth * own.stiffness, -depth * own.stiffness
    deepest, shallowest = max(seen.deepest, depth), min(seen.shallowest, depth)
    if depth <= 0.0 or not holds:
        return WatchedSoFar(deepest, shallowest, seen.most, seen.least, seen.is_any)
    found, held = felt(at, i, place), is_held(at, first_state_of(at, i))
    beyond, force = found.rubbed.beyond, found.normal.force
    if reports_points:
        near = AT_THE_LIMIT * force if has_memory else 0.0
        if held:
            out[k + 2] = beyond + near
        if not (held and has_memory):
            out[k + 3] = beyond - near
    most, least = max(seen.most, beyond) if held else seen.most, seen.least if held else min(seen.least, beyond)
    return WatchedSoFar(deepest, shallowest, most, least, True)
