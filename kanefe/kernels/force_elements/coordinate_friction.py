"""Dry friction along joint coordinates, with an anchor that holds, under given caps or a joint's load (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.contact.contact_shapes import norm
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

# Numbers: see `kanefe.loads.coordinate_friction.CoordinateFriction.kernel`
(
    COUNT,
    HAS_MEMORY,
    SLIDING,
    STATIC,
    STIFFNESS,
    DAMPING,
    BASE,
    FOLLOWS,
    LOAD_TIME,
    KIND,
    PER_LENGTH,
    THRUST,
    TWIST,
    ARMS,
) = range(14)
AT_REST = ARMS + 3
REST = AT_REST + 1
# Kinds of the load, as in `kanefe.joints.joint_friction`
PADS, BALL = 0.0, 1.0


@called_by_address(*SIGNATURE)
def coordinate_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    drag_along(numbers, ends, states, share_kept(numbers, ends, states), out)


@inlined
def drag_along(numbers: Any, ends: Any, states: Any, kept: Any, out: Any) -> None:
    """Write the same, with the share of the pull that friction keeps."""
    count, k, c = int(numbers[COUNT]), numbers[STIFFNESS], numbers[DAMPING]
    mobility = 1.0 / c
    rates = WRENCHES + WRENCH * count
    for i in range(count):
        w, v = stretch(numbers, ends, states, i), slipping(numbers, ends, i)
        elastic = k * w
        drag = kept * (elastic + c * v)
        stretching = mobility * (drag - elastic)
        out[POTENTIAL] += 0.5 * elastic * w
        out[TAKEN] += drag * v - elastic * stretching
        out[WRENCHES + WRENCH * i] = -numbers[ARMS + i] * drag
        if numbers[AT_REST] == 0.0:
            out[rates + i] = stretching


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and above that at which it sticks."""
    size, load = pull_size(numbers, ends, states), load_on(numbers, states)
    held = is_held(numbers, states)
    out[0] = size - numbers[STATIC] * load if held else numbers[STATIC]
    out[1] = numbers[STATIC] if held and numbers[HAS_MEMORY] > 0.0 else size - numbers[SLIDING] * load


@inlined
def is_held(numbers: Any, states: Any) -> bool:
    """Tell whether it sticks, as far as that is remembered."""
    return numbers[HAS_MEMORY] == 0.0 or states[int(numbers[COUNT])].real > 0.5


@inlined
def waits_for_its_event(numbers: Any, states: Any) -> bool:
    """Tell whether an event ends the sticking: see `kanefe.kernels.constraints.tolerances.HELD_BEYOND`."""
    return numbers[HAS_MEMORY] > 0.0 and numbers[AT_REST] == 0.0 and is_held(numbers, states)


@inlined
def load_state(numbers: Any) -> int:
    """Return where the load that is felt is among the states."""
    return int(numbers[COUNT]) + int(numbers[HAS_MEMORY])


@inlined
def load_on(numbers: Any, states: Any) -> Any:
    """Return what the coefficients are multiplied by."""
    load = 0.0 * states[0] + numbers[BASE]
    if numbers[FOLLOWS] > 0.0:
        felt = states[load_state(numbers)]
        if felt.real > 0.0:
            load = load + felt
    return load


@inlined
def slipping(numbers: Any, ends: Any, i: int) -> Any:
    """Return a speed of the surface."""
    return numbers[ARMS + i] * ends[END_NUMBERS * i + V]


@inlined
def stretch(numbers: Any, ends: Any, states: Any, i: int) -> Any:
    """Return a stretch of the anchor's spring."""
    w = states[i]
    if numbers[AT_REST] > 0.0:
        w = w + numbers[ARMS + i] * (ends[END_NUMBERS * i + P] - numbers[REST + i])
    return w


@inlined
def pull(numbers: Any, ends: Any, states: Any, i: int) -> Any:
    """Return what spring and damper ask for in a direction."""
    return numbers[STIFFNESS] * stretch(numbers, ends, states, i) + numbers[DAMPING] * slipping(numbers, ends, i)


@inlined
def pull_size(numbers: Any, ends: Any, states: Any) -> Any:
    """Return the size of what spring and damper ask for."""
    count, first = int(numbers[COUNT]), pull(numbers, ends, states, 0)
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
    cap = (numbers[STATIC] if is_held(numbers, states) else numbers[SLIDING]) * load_on(numbers, states)
    if waits_for_its_event(numbers, states):
        cap = HELD_BEYOND * cap
    if size.real <= cap.real:
        return 0.0 * size + 1.0
    return cap / size


@inlined
def put_load_rates(
    numbers: Any, axis: Numbers, force: Numbers, moment: Numbers, ends: Any, states: Any, rates: Any
) -> None:
    """Write the rates of the load that is felt, from a reaction about the origin of the body's frame, and the axis."""
    if numbers[AT_REST] > 0.0:
        return
    at = load_state(numbers)
    behind = load_of(numbers, axis, force, moment, ends, states) - states[at]
    rates[at] = (states[at + 1] + 2.0 * behind) / numbers[LOAD_TIME]
    rates[at + 1] = behind / numbers[LOAD_TIME]


@inlined
def load_of(numbers: Any, axis: Numbers, force: Numbers, moment: Numbers, ends: Any, states: Any) -> Any:
    """Return the load of a reaction, N: see `kanefe.joints.joint_friction.RubbingSurfaces.load`."""
    if numbers[KIND] == BALL:
        return norm(force)
    along = dot(force, axis)
    if numbers[KIND] == PADS:
        across = minus(force, times(along, axis))
        load = norm(across)
        if numbers[PER_LENGTH] > 0.0:
            half, tilt = times(0.5, across), times(numbers[PER_LENGTH], cross(moment, axis))
            load = norm(plus(half, tilt)) + norm(minus(half, tilt))
        if numbers[THRUST] > 0.0:
            load += numbers[THRUST] * (along if along.real >= 0.0 else -along)
        if numbers[TWIST] > 0.0:
            about = dot(moment, axis)
            load += numbers[TWIST] * (about if about.real >= 0.0 else -about)
        return load
    drag = share_kept(numbers, ends, states) * pull(numbers, ends, states, 0)
    load = numbers[THRUST] * along + numbers[TWIST] * drag
    return load if load.real >= 0.0 else -load
