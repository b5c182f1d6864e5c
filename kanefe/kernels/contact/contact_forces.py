"""Contacts: points of some frames against a surface, with laws of normal force and of friction (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.contact.contact_places import (
    AT,
    OF_POINT,
    POINT_NUMBERS,
    POINTS,
    REST_NUMBERS,
    SLIP,
    TURNED,
    WORK,
)
from kanefe.kernels.contact.detection import gone_since, located, met_by, turned_since, velocity
from kanefe.kernels.contact.laws import normal_force, rub
from kanefe.kernels.contact.laws.turning import couple
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.coordinate_stop import impact_damping
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WATCH_SIGNATURE,
    WRENCH,
    WRENCHES,
    A,
    P,
    W,
)

TOUCHES, STICKS = 0, 3
"""Numbers of the events of a contact that change its states, beside that of a slip, 2."""

AT_THE_LIMIT = 1e-9
"""Force relative to the normal force within which contact points slip or stick together with the first one."""

EPSILON = float(np.finfo(float).eps)

ROUND_OFF = 10.0 * EPSILON
"""Depth, relative to the coordinates that it is the difference of, below which it has no sign."""


@called_by_address(*SIGNATURE)
def contact(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the surface, the first end, and on the others, and the rates of the states."""
    put_points(located, met_by(numbers, ends), numbers, ends, states, out)


@inlined
def put_points(placed: Any, met: Any, numbers: Any, ends: Any, states: Any, out: Any) -> None:
    """Add what all points do.

    `placed` returns the place of a point, as `located` does, from what is known of all of them, `met`.
    """
    A_s = nine(ends, A)
    for i in range(int(numbers[AT.points])):
        put_point(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, out)


@inlined
def put_point(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any, out: Any) -> None:
    """Add what a point does at its place, see `located`; without a share of the stiffness it does not touch.

    What touches to round-off touches: the slip of what just touches would begin and end with the sign of that, in each
    step anew.
    """
    depth, normal, _, share = place
    rates, first = WRENCHES + WRENCH * int(numbers[AT.ends]), first_state_of(numbers, i)
    has_friction, moves = numbers[AT.friction] > 0.0, numbers[AT.rests_at] == 0.0
    own = POINTS + POINT_NUMBERS * i
    if share.real <= 0.0 or (numbers[AT.softness] == 0.0 and is_apart(numbers, i, place, ends)):
        if has_friction and moves:
            let_go(numbers, share, first, states, out, rates)
            if numbers[AT.turning] > 0.0:
                turned(numbers, i, normal, share, A_s, ends, 0.0 * depth, states, out)
        return
    arms, along, carried, rate, pressed, rubbed = touching(numbers, i, place, A_s, ends, states)
    force, elastic, energy, branch_rate = pressed
    out[POTENTIAL] += energy
    out[TAKEN] += (force - elastic) * rate
    if numbers[AT.branches] > 0.0 and moves:
        out[rates + first + int(numbers[AT.each]) - 1] = branch_rate
    total = times(force, normal)
    if has_friction:
        w, tangential, w_rate, k, slip, _ = rubbed
        out[POTENTIAL] += 0.5 * k * dot(w, w)
        out[TAKEN] += dot(tangential, along) - k * dot(w, w_rate)
        out[GIVEN] -= dot(tangential, carried)
        if moves:
            out[rates + SLIP] += share * slip
            out[rates + WORK] += dot(tangential, minus(along, w_rate))
            in_surface = rotated_back(A_s, w_rate)
            for j in range(3):
                out[rates + first + j] = in_surface[j]
        total = minus(total, tangential)
    moment, moment_s = cross(arms[0], total), cross(arms[1], total)
    if numbers[AT.turning] > 0.0:
        against = turned(numbers, i, normal, share, A_s, ends, force, states, out)
        moment, moment_s = minus(moment, against), minus(moment_s, against)
    row = WRENCHES + WRENCH * int(numbers[own + OF_POINT.end])
    for j in range(3):
        out[row + j] += total[j]
        out[row + 3 + j] += moment[j]
        out[WRENCHES + j] -= total[j]
        out[WRENCHES + 3 + j] -= moment_s[j]


@inlined
def blur_of(numbers: Any, i: int, place: Any, ends: Any) -> float:
    """Return how far round-off of where things are blurs the depth of a point at its place, m."""
    end, size = end_of(numbers, i), 0.0
    for j in range(3):
        size = max(size, abs(place[2][j].real) + abs(ends[P + j].real) + abs(ends[end + P + j].real))
    return ROUND_OFF * size


@inlined
def is_apart(numbers: Any, i: int, place: Any, ends: Any) -> bool:
    """Return whether a point at its place is off the surface by more than round-off."""
    return place[0].real <= 0.0 and place[0].real <= -blur_of(numbers, i, place, ends)


@inlined
def end_of(numbers: Any, i: int) -> int:
    """Return where the motion of the end of a point begins."""
    return END_NUMBERS * int(numbers[POINTS + POINT_NUMBERS * i + OF_POINT.end])


@inlined
def first_state_of(numbers: Any, i: int) -> int:
    """Return the first of the internal states of a point."""
    return int(numbers[AT.first]) + int(numbers[AT.each]) * i


@inlined
def let_go(numbers: Any, share: Any, first: int, states: Any, out: Any, rates: int) -> None:
    """Have the stretch of a point in the air come back; what its spring gives up is taken."""
    relaxation, k = numbers[AT.relaxation], share * numbers[AT.spring]
    for j in range(3):
        stretch = states[first + j]
        out[rates + first + j] = -relaxation * stretch
        out[POTENTIAL] += 0.5 * k * stretch * stretch
        out[TAKEN] += k * relaxation * stretch * stretch


@inlined
def touching(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any) -> Any:
    """Return what a point does that touches at its place.

    Returns
    -------
    arms : tuple
        From the origins of its end and of that of the surface, m.
    along, carried : tuple
        Velocity along the surface, and that of a belt, m/s.
    rate : float
        Of the depth, m/s.
    pressed : tuple
        What `normal_force` returns.
    rubbed : tuple
        Stretch of the anchor (m), and what `rub` returns; all zero without friction.
    """
    depth, normal, point, share = place
    first, end = first_state_of(numbers, i), end_of(numbers, i)
    arm, arm_s = minus(point, three(ends, end + P)), minus(point, three(ends, P))
    v = velocity(ends, end, arm, arm_s)
    rate = -dot(v, normal)
    zero = 0.0 * rate
    more, branch = zero, zero
    if numbers[AT.impact] >= 0.0:
        more = zero + states[int(numbers[AT.impact])]
    if numbers[AT.branches] > 0.0:
        branch = zero + states[first + int(numbers[AT.each]) - 1]
    pressed = softened(numbers, depth)
    least = EPSILON * blur_of(numbers, i, place, ends)
    if pressed.real < least:  # laws are for depths above zero, see `is_apart`
        pressed = least + 0.0 * pressed
    law = normal_force(numbers[AT.normal], numbers, int(numbers[AT.normal_at]), share, pressed, rate, more, branch)
    none = (zero, zero, zero)
    along, carried, w, tangential, w_rate, k, slip, beyond = none, none, none, none, none, 0.0, zero, zero
    if numbers[AT.friction] > 0.0:
        rests = numbers[AT.rests_at] > 0.0
        w = rotated(A_s, three(states, first))
        if rests:
            w = plus(w, gone_since(numbers, int(numbers[AT.rests_at]) + REST_NUMBERS * i, ends, end))
        belt = rotated(A_s, three(numbers, AT.belt))
        carried = minus(belt, times(dot(belt, normal), normal))
        along = minus(plus(v, times(rate, normal)), carried)
        held = is_held(numbers, first, states)
        tangential, w_rate, k, slip, beyond = rub(
            numbers[AT.friction],
            numbers,
            int(numbers[AT.friction_at]),
            share,
            law[0],
            normal,
            A_s,
            along,
            w,
            held,
            held and numbers[AT.has_memory] > 0.0 and not rests,
            rests,
        )
    return (arm, arm_s), along, carried, rate, law, (w, tangential, w_rate, k, slip, beyond)


@inlined
def is_held(numbers: Any, first: int, states: Any) -> bool:
    """Return whether a point sticks, as far as that is remembered."""
    return numbers[AT.has_memory] == 0.0 or states[first + 3].real > 0.5


@inlined
def softened(numbers: Any, depth: Any) -> Any:
    """Return the depth that the normal law is given: ``s ln(1 + exp(depth / s))``, without overflow."""
    softness = numbers[AT.softness]
    if softness > 0.0:
        x = depth / softness
        depth = softness * (x + np.log(1.0 + np.exp(-x)) if x.real > 0.0 else np.log(1.0 + np.exp(x)))
    return depth


@kernel
def turned(
    numbers: Any, i: int, normal: Numbers, share: Any, A_s: Numbers, ends: Any, pressed: Any, states: Any, out: Any
) -> Numbers:
    """Return the moment against turning of a point; write the rates of its states, and add what else it does."""
    own, moves = POINTS + POINT_NUMBERS * i, numbers[AT.rests_at] == 0.0
    end, rates = end_of(numbers, i), WRENCHES + WRENCH * int(numbers[AT.ends])
    zero = 0.0 * pressed
    gone = (zero, zero, zero)
    if not moves:
        gone = turned_since(numbers, int(numbers[AT.rests_at]) + REST_NUMBERS * i + TURNED, ends, end)
    first = first_state_of(numbers, i) + int(numbers[AT.each]) - int(numbers[AT.branches]) - int(numbers[AT.turning])
    moment, energy, taken, work = couple(
        numbers,
        int(numbers[AT.friction_at]),
        share,
        numbers[own + OF_POINT.radius] + max(numbers[own + OF_POINT.ring], 0.0),
        pressed,
        normal,
        A_s,
        minus(three(ends, end + W), three(ends, W)),
        gone,
        states,
        first,
        out,
        rates + first,
    )
    out[POTENTIAL] += energy
    out[TAKEN] += taken
    if moves:
        out[rates + WORK] += work
    else:
        for j in range(int(numbers[AT.turning])):
            out[rates + first + j] = zero
    return moment


@called_by_address(*WATCH_SIGNATURE)
def contact_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write its event values: see `kanefe.contact.contact_events.Watched`."""
    watch_points(located, met_by(numbers, ends), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def contact_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the states after an event: the damping of an impact, or that points at their limit slip or stick."""
    change_points(located, met_by(numbers, ends), int(inputs[0]), numbers, ends, states, out)


@inlined
def watch_points(placed: Any, met: Any, numbers: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the event values of all points and of the contact; for `placed` and `met` see `put_points`."""
    A_s, seen = nine(ends, A), nothing_seen()
    for i in range(int(numbers[AT.points])):
        seen = watched(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, out, seen)
    put_seen(numbers, seen, out)


@inlined
def change_points(placed: Any, met: Any, event: int, numbers: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the states after an event; for `placed` and `met` see `put_points`."""
    A_s, points = nine(ends, A), int(numbers[AT.points])
    if event == TOUCHES:
        deepest, speed = -np.inf, 0.0
        for i in range(points):
            deepest, speed = struck(numbers, i, placed(numbers, i, ends, met), ends, deepest, speed)
        out[1 + int(numbers[AT.impact])] = impact_damping(numbers[AT.impact_number], numbers[AT.least_speed], speed)
        return
    to, extreme = 1.0 if event == STICKS else 0.0, -np.inf
    for i in range(points):
        extreme = max(extreme, way_past(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, to)[0])
    for i in range(points):
        past, force = way_past(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, to)
        if past > -np.inf and past >= min(extreme, -AT_THE_LIMIT * force):
            out[1 + first_state_of(numbers, i) + 3] = to


@inlined
def struck(numbers: Any, i: int, place: Any, ends: Any, deepest: float, speed: float) -> tuple[float, float]:
    """Return the depth of the deepest point up to this one, and the speed into the surface there."""
    depth, normal, point, _ = place
    if depth <= deepest:
        return deepest, speed
    end = end_of(numbers, i)
    v = velocity(ends, end, minus(point, three(ends, end + P)), minus(point, three(ends, P)))
    return depth, -dot(v, normal)


@inlined
def way_past(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any, to: float) -> tuple[float, float]:
    """Return the force by which a point is past its limit to slip (0) or to stick (1), and its normal force, N.

    Minus infinity: it does not touch, or does so already.
    """
    if is_apart(numbers, i, place, ends) or (states[first_state_of(numbers, i) + 3] > 0.5) == (to > 0.5):
        return -np.inf, 0.0
    found = touching(numbers, i, place, A_s, ends, states)
    return (1.0 - 2.0 * to) * found[5][5], found[4][0]


@inlined
def nothing_seen() -> Any:
    """Return the initial values before a point is evaluated: see `put_seen`."""
    return -np.inf, np.inf, -np.inf, np.inf, False


@inlined
def watched(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any, out: Any, seen: Any) -> Any:
    """Write the event values of a point, and return those of all points with it.

    That of a slip rises above zero where it slips that was held, that of a stick falls below where it sticks that
    slipped; both have their sign where it does not touch. It does from where its depth has no sign on, see `is_apart`.
    """
    depth, (deepest, shallowest, most, least, is_any) = place[0] + blur_of(numbers, i, place, ends), seen
    has_memory, reports_points = numbers[AT.has_memory] > 0.0, numbers[AT.reports_points] > 0.0
    holds, stiffness = numbers[AT.holds] > 0.0, numbers[AT.stiffness]
    at = (4 if holds else 2) * (i + 1)  # after those of the contact
    if reports_points:
        out[at] = out[at + 1] = depth
        if holds:
            out[at + 2], out[at + 3] = depth * stiffness, -depth * stiffness
    deepest, shallowest = max(deepest, depth), min(shallowest, depth)
    if depth <= 0.0 or not holds:
        return deepest, shallowest, most, least, is_any
    found = touching(numbers, i, place, A_s, ends, states)
    beyond, force, held = found[5][5], found[4][0], is_held(numbers, first_state_of(numbers, i), states)
    if reports_points:
        near = AT_THE_LIMIT * force if has_memory else 0.0
        if held:
            out[at + 2] = beyond + near
        if not (held and has_memory):
            out[at + 3] = beyond - near
    if held:
        most = max(most, beyond)
    else:
        least = min(least, beyond)
    return deepest, shallowest, most, least, True


@inlined
def put_seen(numbers: Any, seen: Any, out: Any) -> None:
    """Write the event values of the contact.

    `seen`: the largest and the least depth, of held points the largest pull beyond what friction holds, of slipping
    ones the least, and whether there are any.
    """
    deepest, shallowest, most, least, is_any = seen
    out[0] = out[1] = deepest
    if numbers[AT.holds] > 0.0:
        stiffness = numbers[AT.stiffness]
        out[2] = most if most > -np.inf else shallowest * stiffness
        out[3] = -deepest * stiffness
        if is_any:
            last = least if numbers[AT.has_memory] > 0.0 else most
            out[3] = last if abs(last) < np.inf else 1.0
