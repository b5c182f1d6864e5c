"""Contacts: points of some frames against a surface, with friction by anchors (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.contact.contact_boxes import box_slot, boxes_meet
from kanefe.kernels.contact.contact_laws import pressed
from kanefe.kernels.contact.contact_places import (
    ALONG,
    ANCHOR_DAMPING,
    ANCHOR_STIFFNESS,
    ANCHORED,
    AXIS,
    BELT,
    BRISTLES,
    END,
    ENDS,
    HAS_FRICTION,
    HAS_MEMORY,
    HAS_RESTITUTION,
    MU_ACROSS,
    MU_ALONG,
    POINT,
    POINT_REPORTS,
    PROBE,
    PROBE_NUMBERS,
    PROBES,
    RADIUS,
    REST_NUMBERS,
    RESTS_AT,
    RING,
    ROLLING,
    SHAPE,
    SHARE,
    SLIP,
    SOFTNESS,
    STATIC_RATIO,
    STIFFNESS,
    STRIBECK_SPEED,
    TORSIONAL,
    TURNED,
    VISCOUS,
    WORK,
)
from kanefe.kernels.contact.contact_shapes import PLANE, distance, norm
from kanefe.kernels.contact.contact_turning import braked, put_rolling, spins, turned_since
from kanefe.kernels.force_elements.bushing import nine
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
    V,
    W,
)

ON_ITS_AXIS, MOST_TURNS, SAME_NORMAL = 1e-9, 100, 1e-15
"""Constants of the same names in `kanefe.contact.contact`."""

MOST_TRIALS = 60

AT_THE_LIMIT = 1e-9
"""Constant of the same name in `kanefe.contact.contact_events`."""


@called_by_address(*SIGNATURE)
def contact(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the surface, the first end, and on the others, and the rates of the anchors."""
    has_friction = numbers[HAS_FRICTION] > 0.0
    rates = WRENCHES + WRENCH * int(numbers[ENDS])
    k_all, c_all = numbers[ANCHOR_STIFFNESS], numbers[ANCHOR_DAMPING]
    A_s = nine(ends, A)
    met = met_by(numbers, ends)
    for i in range(int(numbers[PROBES])):
        probe = PROBE + PROBE_NUMBERS * i
        place, share = place_of(numbers, i), numbers[probe + SHARE]
        depth, normal, point = located(numbers, probe, ends, met)
        if depth.real <= 0.0 and numbers[SOFTNESS] == 0.0:
            for j in range(3 if has_friction and numbers[RESTS_AT] == 0.0 else 0):
                stretch = states[place + j]
                out[rates + place + j] = -k_all / c_all * stretch
                if numbers[HAS_FRICTION] == ANCHORED:
                    out[POTENTIAL] += 0.5 * share * k_all * stretch * stretch
                    out[TAKEN] += share * k_all * k_all / c_all * stretch * stretch
            if numbers[HAS_FRICTION] == ANCHORED and numbers[RESTS_AT] == 0.0:
                turned(numbers, i, A_s, normal, ends, 0.0 * depth, states, out)
            continue
        end = END_NUMBERS * int(numbers[probe + END])
        arm, arm_s = minus(point, three(ends, end + P)), minus(point, three(ends, P))
        v = velocity(ends, end, arm, arm_s)
        rate = -dot(v, normal)
        press, elastic, energy = pressed(numbers, share, depth, rate, states)
        out[POTENTIAL] += energy
        out[TAKEN] += (press - elastic) * rate
        force = times(press, normal)
        if has_friction:
            k, c = share * k_all, share * c_all
            w = rotated(A_s, three(states, place))
            if numbers[RESTS_AT] > 0.0:
                w = plus(w, gone_since(numbers, int(numbers[RESTS_AT]) + REST_NUMBERS * i, ends, end))
            along, carried, pull = pulled(numbers, A_s, normal, v, rate, w, k, c)
            if numbers[HAS_FRICTION] == BRISTLES:
                drag, w_rate = bent(numbers, normal, along, w, press)
                k, slipping = 0.0, share * norm(minus(along, w_rate))
            else:
                is_held = numbers[HAS_MEMORY] == 0.0 or states[place + 3].real > 0.5
                share_left = kept(numbers, pull, normal, A_s, press, c, is_held)
                drag = times(share_left, pull)
                w_rate = times(1.0 / c, minus(drag, times(k, w)))
                slipping = share * (1.0 - share_left) * norm(pull) / c
            out[POTENTIAL] += 0.5 * k * dot(w, w)
            out[TAKEN] += dot(drag, along) - k * dot(w, w_rate)
            out[GIVEN] -= dot(drag, carried)
            if numbers[RESTS_AT] == 0.0:
                out[rates + SLIP] += slipping
                out[rates + WORK] += dot(drag, minus(along, w_rate))
            in_surface = rotated_back(A_s, w_rate)
            for j in range(3 if numbers[RESTS_AT] == 0.0 else 0):
                out[rates + place + j] = in_surface[j]
            force = minus(force, drag)
        moment, moment_s = cross(arm, force), cross(arm_s, force)
        if numbers[HAS_FRICTION] == ANCHORED and (numbers[TORSIONAL] > 0.0 or numbers[ROLLING] > 0.0):
            couple = turned(numbers, i, A_s, normal, ends, press, states, out)
            moment, moment_s = minus(moment, couple), minus(moment_s, couple)
        row = WRENCHES + WRENCH * int(numbers[probe + END])
        for j in range(3):
            out[row + j] += force[j]
            out[row + 3 + j] += moment[j]
            out[WRENCHES + j] -= force[j]
            out[WRENCHES + 3 + j] -= moment_s[j]


@called_by_address(*WATCH_SIGNATURE)
def contact_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write its event values: see `kanefe.contact.contact_events.Watched`."""
    deepest = shallowest = first = last = 0.0
    is_any = has_held = has_slipping = False
    A_s, has_memory = nine(ends, A), numbers[HAS_MEMORY] > 0.0
    count, met = int(numbers[PROBES]), met_by(numbers, ends)
    has_anchors, reports_points = numbers[HAS_FRICTION] == ANCHORED, numbers[POINT_REPORTS] > 0.0
    each = 4 if has_anchors else 2
    for i in range(count):
        probe = PROBE + PROBE_NUMBERS * i
        depth, normal, point = located(numbers, probe, ends, met)
        at = each * (i + 1)  # after those of the contact
        deepest = depth if i == 0 else max(deepest, depth)
        shallowest = depth if i == 0 else min(shallowest, depth)
        if reports_points:
            out[at] = out[at + 1] = depth
            if has_anchors:
                out[at + 2], out[at + 3] = depth * numbers[STIFFNESS], -depth * numbers[STIFFNESS]
        if depth <= 0.0 or not has_anchors:
            continue
        is_any = True
        place, share = place_of(numbers, i), numbers[probe + SHARE]
        end = END_NUMBERS * int(numbers[probe + END])
        arm, arm_s = minus(point, three(ends, end + P)), minus(point, three(ends, P))
        v = velocity(ends, end, arm, arm_s)
        rate = -dot(v, normal)
        press = pressed(numbers, share, depth, rate, states)[0]
        k, c = share * numbers[ANCHOR_STIFFNESS], share * numbers[ANCHOR_DAMPING]
        pull = pulled(numbers, A_s, normal, v, rate, rotated(A_s, three(states, place)), k, c)[2]
        is_held = not has_memory or states[place + 3] > 0.5
        reserve = above_the_most(numbers, pull, normal, A_s, press, c, is_held)
        if reports_points:
            near = AT_THE_LIMIT * press if has_memory else 0.0
            if is_held:
                out[at + 2] = reserve + near
            if not (is_held and has_memory):
                out[at + 3] = reserve - near
        if is_held:
            first = reserve if not has_held else max(first, reserve)
            has_held = True
        if not has_memory:
            last = first
        elif not is_held:
            last = reserve if not has_slipping else min(last, reserve)
            has_slipping = True
    out[0] = out[1] = deepest
    if has_anchors:
        out[2] = first if has_held else shallowest * numbers[STIFFNESS]
        out[3] = -deepest * numbers[STIFFNESS]
        if is_any:
            out[3] = last if has_slipping or not has_memory else 1.0


@inlined
def place_of(numbers: Any, i: int) -> int:
    """Return the first of the internal states of a contact point."""
    if numbers[HAS_FRICTION] == 0.0:
        return 0
    own = 3 if numbers[HAS_RESTITUTION] > 0.0 else 2
    return own + states_of(numbers) * i


@inlined
def states_of(numbers: Any) -> int:
    """Return how many internal states a contact point has."""
    count = 4 if numbers[HAS_MEMORY] > 0.0 else 3
    if numbers[HAS_FRICTION] == BRISTLES:
        return count
    if numbers[TORSIONAL] > 0.0:
        count += 1
    if numbers[ROLLING] > 0.0:
        count += 3
    return count


@kernel
def bent(numbers: Any, normal: Numbers, v: Numbers, z: Numbers, press: Any) -> tuple[Numbers, Numbers]:
    """Return the friction of bristles and the rate of their deflection: see `kanefe.contact.laws.bristles.LuGre`."""
    stiffness, speed = numbers[ANCHOR_STIFFNESS], norm(v)
    ratio, mu = speed / numbers[STRIBECK_SPEED], numbers[MU_ALONG]
    g = mu * (1.0 + (numbers[STATIC_RATIO] - 1.0) * np.exp(-ratio * ratio))
    rate = v
    if numbers[RESTS_AT] == 0.0:
        rate = minus(v, times(stiffness * speed / g, z))
    flat, flat_rate = minus(z, times(dot(z, normal), normal)), minus(rate, times(dot(rate, normal), normal))
    drag = plus(times(stiffness, flat), plus(times(numbers[ANCHOR_DAMPING], flat_rate), times(numbers[VISCOUS], v)))
    return times(press, drag), rate


@kernel
def turned(
    numbers: Any, i: int, A_s: Numbers, normal: Numbers, ends: Any, press: Any, states: Any, out: Any
) -> Numbers:
    """Return the moment against turning of a contact point; write the rates of its states and what else it adds."""
    probe, end = PROBE + PROBE_NUMBERS * i, int(numbers[PROBE + PROBE_NUMBERS * i + END])
    k = numbers[probe + SHARE] * numbers[ANCHOR_STIFFNESS]
    c = numbers[probe + SHARE] * numbers[ANCHOR_DAMPING]
    place, rates = place_of(numbers, i), WRENCHES + WRENCH * int(numbers[ENDS])
    moves = numbers[RESTS_AT] == 0.0
    zero = 0.0 * press
    moment, gone = (zero, zero, zero), (zero, zero, zero)
    if not moves:
        gone = turned_since(numbers, int(numbers[RESTS_AT]) + REST_NUMBERS * i + TURNED, ends, end)
    about, over = spins(ends, end, normal)
    along = dot(gone, normal)
    # the states end with those of turning; what is told of slipping is not where they do not move
    last, work = place + states_of(numbers), rates + WORK
    arm = numbers[TORSIONAL]
    if arm > 0.0:
        at = last - (4 if numbers[ROLLING] > 0.0 else 1)
        twist = times(states[at] + along, normal)
        most = max(numbers[MU_ALONG], numbers[MU_ACROSS]) * arm * press
        drag, given = braked(twist, twist, about, k * arm * arm, c * arm * arm, most, out, work)
        moment = plus(moment, drag)
        if moves:
            out[rates + at] = dot(given, normal)
    if numbers[ROLLING] > 0.0:
        arm = numbers[probe + RADIUS] + max(numbers[probe + RING], 0.0)
        twist = plus(rotated(A_s, three(states, last - 3)), minus(gone, times(along, normal)))
        flat = minus(twist, times(dot(twist, normal), normal))
        most = numbers[ROLLING] * press
        drag, given = braked(twist, flat, over, k * arm * arm, c * arm * arm, most, out, work)
        moment = plus(moment, drag)
        if moves:
            put_rolling(A_s, given, out, rates + last - 3)
    if not moves:
        out[work] = zero
    return moment


@inlined
def met_by(numbers: Any, ends: Any) -> Any:
    """Return how boxes meet, where a box touches one: see `boxes_meet`."""
    zero = 0.0 * ends[P]
    if numbers[PROBE + RING] >= 0.0:
        return zero, zero, zero, zero, -1, -1
    return boxes_meet(
        ends,
        END_NUMBERS * int(numbers[PROBE + END]),
        three(numbers, PROBE + AXIS),
        times(0.5, three(numbers, int(numbers[SHAPE]) + 1)),
    )


@inlined
def located(numbers: Any, probe: int, ends: Any, met: Numbers) -> Any:
    """Return depth, normal and position of a contact point."""
    if numbers[probe + RING] < 0.0:
        own, other = three(numbers, probe + AXIS), times(0.5, three(numbers, int(numbers[SHAPE]) + 1))
        end, slot = END_NUMBERS * int(numbers[probe + END]), -1 - int(numbers[probe + RING])
        found = box_slot(met, slot, ends, end, own, other)
        return found[0], (met[0], met[1], met[2]), (found[1], found[2], found[3])
    shape, at = int(numbers[SHAPE]), END_NUMBERS * int(numbers[probe + END])
    A_s, p_s, A_p = nine(ends, A), three(ends, P), nine(ends, at + A)
    centre = plus(three(ends, at + P), rotated(A_p, three(numbers, probe + POINT)))
    if int(numbers[shape]) == PLANE and numbers[probe + RING] == 0.0:  # most often
        normal = rotated(A_s, three(numbers, shape + 1))
        phi, radius = dot(normal, minus(centre, p_s)), numbers[probe + RADIUS]
        return radius - phi, normal, minus(centre, times(radius, normal))
    found = distance(numbers, shape, rotated_back(A_s, minus(centre, p_s)))
    normal, phi = rotated(A_s, (found[1], found[2], found[3])), found[0]
    ring = numbers[probe + RING]
    if ring > 0.0:
        axis, middle = rotated(A_p, three(numbers, probe + AXIS)), centre
        for _ in range(1 if int(numbers[shape]) == PLANE else MOST_TURNS):
            down = minus(times(dot(axis, normal), axis), normal)
            length = norm(down)
            if length.real <= ON_ITS_AXIS:
                break
            before, centre = normal, plus(middle, times(ring / length, down))
            found = distance(numbers, shape, rotated_back(A_s, minus(centre, p_s)))
            normal, phi = rotated(A_s, (found[1], found[2], found[3])), found[0]
            turned = minus(normal, before)
            if dot(turned, turned).real <= SAME_NORMAL * SAME_NORMAL:
                break
    radius = numbers[probe + RADIUS]
    return radius - phi, normal, minus(centre, times(radius, normal))


@inlined
def velocity(ends: Any, end: int, arm: Numbers, arm_s: Numbers) -> Numbers:
    """Return the velocity of what touches, seen from what is touched, where they meet."""
    own = plus(three(ends, end + V), cross(three(ends, end + W), arm))
    return minus(own, plus(three(ends, V), cross(three(ends, W), arm_s)))


@inlined
def gone_since(numbers: Any, at: int, ends: Any, end: int) -> Numbers:
    """Return how far a point of what touches has gone along with what is touched since a state of rest."""
    material, mark = three(numbers, at), three(numbers, at + 3)
    point = plus(three(ends, end + P), rotated(nine(ends, end + A), material))
    return minus(minus(point, three(ends, P)), rotated(nine(ends, A), mark))


@inlined
def pulled(
    numbers: Any, A_s: Numbers, normal: Numbers, v: Numbers, rate: Any, w: Numbers, k: float, c: float
) -> tuple[Numbers, Numbers, Numbers]:
    """Return the velocity along the surface, that of a belt, and what the spring and damper of an anchor ask for."""
    belt = rotated(A_s, three(numbers, BELT))
    carried = minus(belt, times(dot(belt, normal), normal))
    along = minus(plus(v, times(rate, normal)), carried)
    return along, carried, plus(times(k, minus(w, times(dot(w, normal), normal))), times(c, along))


@inlined
def weighed(numbers: Any, pull: Numbers, normal: Numbers, A_s: Numbers) -> Any:
    """Return the size of a pull and the coefficient it is measured by; of two coefficients both as of one."""
    mu = numbers[MU_ALONG]
    if numbers[MU_ACROSS] == mu:
        return norm(pull), mu
    first = rotated(A_s, three(numbers, ALONG))
    first = minus(first, times(dot(first, normal), normal))
    first = times(1.0 / norm(first), first)
    x, y = dot(pull, first) / mu, dot(pull, cross(normal, first)) / numbers[MU_ACROSS]
    return np.sqrt(x * x + y * y), 1.0


@inlined
def above_the_most(numbers: Any, pull: Numbers, normal: Numbers, A_s: Numbers, press: Any, c: float, held: bool) -> Any:
    """Return how far a pull is above what friction can take; of falling friction that slips what is not taken."""
    size, mu = weighed(numbers, pull, normal, A_s)
    if held:
        return size - mu * numbers[STATIC_RATIO] * press
    if numbers[STRIBECK_SPEED] > 0.0:
        return size * (1.0 - kept(numbers, pull, normal, A_s, press, c, held))
    return size - mu * press


@kernel
def kept(numbers: Any, pull: Numbers, normal: Numbers, A_s: Numbers, press: Any, c: float, is_held: bool) -> Any:
    """Return the share of the pull of an anchor's spring and damper that friction can take, at most 1."""
    ratio = numbers[STATIC_RATIO]
    size, mu = weighed(numbers, pull, normal, A_s)
    one = 0.0 * size + 1.0
    if size.real <= 0.0:
        return one
    if is_held:
        most = mu * ratio * press
        if numbers[HAS_MEMORY] > 0.0 and numbers[RESTS_AT] == 0.0:
            most = HELD_BEYOND * most
        return one if size.real <= most.real else most / size
    speed = numbers[STRIBECK_SPEED]
    if speed == 0.0:
        most = mu * press
        return one if size.real <= most.real else most / size
    fall, s = (ratio - 1.0) * mu * press, size / c
    for _ in range(MOST_TRIALS):
        share = np.exp(-s * s / (speed * speed))
        value = c * s + mu * press + fall * share - size
        slope = c - 2.0 * fall * share * s / (speed * speed)
        step = value / slope if slope.real > 0.0 else 0.5 * s
        s = s - step if (s - step).real > 0.5 * s.real else 0.5 * s
        if s.real * c < 1e-12 * size.real:
            return one
        if abs(step.real) <= 1e-15 * s.real:
            break
    return 1.0 - c * s / size
