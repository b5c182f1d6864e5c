"""Dry friction along joint coordinates, with an anchor that holds, under given caps or a joint's load (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, norm, plus, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WATCH_SIGNATURE,
    WRENCH,
    WRENCHES,
    P,
    V,
)

FrictionNumbers = namedtuple(
    "FrictionNumbers",
    "directions has_memory sliding static stiffness damping base follows load_time "
    "kind per_length thrust twist arms is_at_rest rest stribeck_speed",
)
"""Numbers of friction along coordinates, in the words of `kanefe.loads.coordinate_friction.CoordinateFriction`.

`follows` tells whether it follows the load of a joint, of which the next ones are: see
`kanefe.joints.joint_friction.RubbingSurfaces`. `is_at_rest`: stretches follow from the coordinates, beside `rest`.
"""

MOST_DIRECTIONS = 3
AT = places(FrictionNumbers, arms=MOST_DIRECTIONS, rest=MOST_DIRECTIONS)

PADS, BALL, THREAD = 0.0, 1.0, 2.0
"""Values for the kinds of joint load."""


@called_by_address(*SIGNATURE)
def coordinate_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    friction_along(numbers, ends, states, share_kept(numbers, ends, states), out)


@inlined
def friction_along(numbers: Any, ends: Any, states: Any, kept: Any, out: Any) -> None:
    """Write the same, with the share of the pull that friction keeps."""
    count, k, c = int(numbers[AT.directions]), numbers[AT.stiffness], numbers[AT.damping]
    mobility = 1.0 / c
    rates = WRENCHES + WRENCH * count
    for i in range(count):
        w, v = stretch(numbers, ends, states, i), slipping(numbers, ends, i)
        elastic = k * w
        friction_force = kept * (elastic + c * v)
        stretching = mobility * (friction_force - elastic)
        out[POTENTIAL] += 0.5 * elastic * w
        out[TAKEN] += friction_force * v - elastic * stretching
        out[WRENCHES + WRENCH * i] = -numbers[AT.arms + i] * friction_force
        if numbers[AT.is_at_rest] == 0.0:
            out[rates + i] = stretching


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and above that at which it sticks."""
    size, load = pull_size(numbers, ends, states), load_on(numbers, states)
    held = is_held(numbers, states)
    out[0] = size - numbers[AT.static] * load if held else numbers[AT.static]
    out[1] = numbers[AT.static] if held and numbers[AT.has_memory] > 0.0 else size - numbers[AT.sliding] * load


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that it slips from now on, by its first event, or sticks, by its second one."""
    out[1 + int(numbers[AT.directions])] = inputs[0]


@inlined
def is_held(numbers: Any, states: Any) -> bool:
    """Return whether it sticks, as far as that is remembered."""
    return numbers[AT.has_memory] == 0.0 or states[int(numbers[AT.directions])].real > 0.5


@inlined
def waits_for_its_event(numbers: Any, states: Any) -> bool:
    """Return whether an event ends the sticking: see `kanefe.kernels.constraints.tolerances.HELD_BEYOND`."""
    return numbers[AT.has_memory] > 0.0 and numbers[AT.is_at_rest] == 0.0 and is_held(numbers, states)


@inlined
def load_state(numbers: Any) -> int:
    """Return the index of the load that determines friction among the states."""
    return int(numbers[AT.directions]) + int(numbers[AT.has_memory])


@inlined
def load_on(numbers: Any, states: Any) -> Any:
    """Return what the coefficients are multiplied by."""
    load = 0.0 * states[0] + numbers[AT.base]
    if numbers[AT.follows] > 0.0:
        felt = states[load_state(numbers)]
        if felt.real > 0.0:
            load = load + felt
    return load


@inlined
def slipping(numbers: Any, ends: Any, i: int) -> Any:
    """Return a speed of the surface."""
    return numbers[AT.arms + i] * ends[END_NUMBERS * i + V]


@inlined
def stretch(numbers: Any, ends: Any, states: Any, i: int) -> Any:
    """Return a stretch of the anchor's spring."""
    w = states[i]
    if numbers[AT.is_at_rest] > 0.0:
        w = w + numbers[AT.arms + i] * (ends[END_NUMBERS * i + P] - numbers[AT.rest + i])
    return w


@inlined
def pull(numbers: Any, ends: Any, states: Any, i: int) -> Any:
    """Return what spring and damper ask for in a direction."""
    return numbers[AT.stiffness] * stretch(numbers, ends, states, i) + numbers[AT.damping] * slipping(numbers, ends, i)


@inlined
def pull_size(numbers: Any, ends: Any, states: Any) -> Any:
    """Return the size of what spring and damper ask for."""
    count, first = int(numbers[AT.directions]), pull(numbers, ends, states, 0)
    if count == 1:
        return first if first.real >= 0.0 else -first
    second, third = pull(numbers, ends, states, 1), 0.0 * first
    if count > 2:
        third = pull(numbers, ends, states, 2)
    return norm((first, second, third))


@inlined
def share_kept(numbers: Any, ends: Any, states: Any) -> Any:
    """Return the share of the pull that friction can take, at most 1."""
    size = pull_size(numbers, ends, states)
    cap = (numbers[AT.static] if is_held(numbers, states) else numbers[AT.sliding]) * load_on(numbers, states)
    if waits_for_its_event(numbers, states):
        cap = HELD_BEYOND * cap
    if size.real <= cap.real:
        return 0.0 * size + 1.0
    return cap / size


@inlined
def put_load_rates(
    numbers: Any, axis: Numbers, force: Numbers, moment: Numbers, ends: Any, states: Any, rates: Any
) -> None:
    """Write the rates of the load of friction, from a reaction about the origin of the body's frame, and the axis."""
    if numbers[AT.is_at_rest] > 0.0:
        return
    at, friction_force = load_state(numbers), 0.0 * force[0]
    if numbers[AT.kind] == THREAD:
        friction_force = share_kept(numbers, ends, states) * pull(numbers, ends, states, 0)
    law = numbers[AT.kind], numbers[AT.per_length], numbers[AT.thrust], numbers[AT.twist]
    behind = load_of(law, axis, force, moment, friction_force) - states[at]
    rates[at] = (states[at + 1] + 2.0 * behind) / numbers[AT.load_time]
    rates[at + 1] = behind / numbers[AT.load_time]


@inlined
def load_of(law: Numbers, axis: Numbers, force: Numbers, moment: Numbers, friction_force: Any) -> Any:
    """Return the load of a reaction, N: see `kanefe.joints.joint_friction.RubbingSurfaces`.

    `law` is its kind, what is per length of two pads, and what thrust and twist count for; drag that of a thread.
    """
    kind, per_length, thrust, twist = law
    if kind == BALL:
        return norm(force)
    along = dot(force, axis)
    if kind == PADS:
        across = minus(force, times(along, axis))
        load = norm(across)
        if per_length > 0.0:
            half, tilt = times(0.5, across), times(per_length, cross(moment, axis))
            load = norm(plus(half, tilt)) + norm(minus(half, tilt))
        if thrust > 0.0:
            load += thrust * (along if along.real >= 0.0 else -along)
        if twist > 0.0:
            about = dot(moment, axis)
            load += twist * (about if about.real >= 0.0 else -about)
        return load
    load = thrust * along + twist * friction_force
    return load if load.real >= 0.0 else -load
