"""Dry friction along joint coordinates, with an anchor that holds, under given caps or a joint's load (Eq. 11)."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends, Wrenches, rates_of
from kanefe.kernels.language import Columns, Record, Vector, called_by_address, cross, dot, inlined

MOST_DIRECTIONS = 3


class Rubbing(Record):
    """How the load of a joint comes of its reaction: what `kanefe.joints.joint_friction.RubbingSurfaces` has of it."""

    kind: float
    per_length: float
    thrust: float
    twist: float


class FrictionNumbers(Record):
    """Numbers of friction along coordinates, in the words of `kanefe.loads.coordinate_friction.CoordinateFriction`.

    `follows` tells whether it follows the load of a joint, of which the next ones are: see
    `kanefe.joints.joint_friction.RubbingSurfaces`. `is_at_rest`: stretches follow from the coordinates, beside `rest`.
    """

    directions: float
    has_memory: float
    sliding: float
    static: float
    stiffness: float
    damping: float
    base: float
    follows: float
    load_time: float
    rubbing: Rubbing
    arms: Annotated[Any, Columns(MOST_DIRECTIONS)]
    is_at_rest: float
    rest: Annotated[Any, Columns(MOST_DIRECTIONS)]
    stribeck_speed: float


PADS, BALL, THREAD = 0.0, 1.0, 2.0
"""Values for the kinds of joint load."""


@called_by_address(*SIGNATURE)
def coordinate_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    own = FrictionNumbers(numbers)
    friction_along(own, ends, states, share_kept(own, ends, states), Done(out))


@inlined
def friction_along(own: FrictionNumbers, ends: Any, states: Any, kept: Any, done: Done) -> None:
    """Write the same, with the share of the pull that friction keeps."""
    count, mobility, on = int(own.directions), 1.0 / own.damping, Wrenches(done.wrenches)
    for i in range(count):
        w, v = stretch(own, ends, states, i), slipping(own, ends, i)
        elastic = own.stiffness * w
        friction_force = kept * (elastic + own.damping * v)
        stretching = mobility * (friction_force - elastic)
        done.potential += 0.5 * elastic * w
        done.taken += friction_force * v - elastic * stretching
        on[i].force = Vector(-own.arms[i] * friction_force, 0.0, 0.0)
        if own.is_at_rest == 0.0:
            rates_of(done, count)[i] = stretching


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and above that at which it sticks."""
    own = FrictionNumbers(numbers)
    size, load, held = pull_size(own, ends, states), load_on(own, states), is_held(own, states)
    out[0] = size - own.static * load if held else own.static
    out[1] = own.static if held and own.has_memory > 0.0 else size - own.sliding * load


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that it slips from now on, by its first event, or sticks, by its second one."""
    out[1 + int(FrictionNumbers(numbers).directions)] = inputs[0]


@inlined
def is_held(own: FrictionNumbers, states: Any) -> bool:
    """Return whether it sticks, as far as that is remembered."""
    return own.has_memory == 0.0 or states[int(own.directions)].real > 0.5


@inlined
def load_state(own: FrictionNumbers) -> int:
    """Return the index of the load that determines friction among the states."""
    return int(own.directions) + int(own.has_memory)


@inlined
def load_on(own: FrictionNumbers, states: Any) -> Any:
    """Return what the coefficients are multiplied by."""
    load = 0.0 * states[0] + own.base
    if own.follows > 0.0:
        felt = states[load_state(own)]
        if felt.real > 0.0:
            load = load + felt
    return load


@inlined
def slipping(own: FrictionNumbers, ends: Any, i: int) -> Any:
    """Return a speed of the surface."""
    return own.arms[i] * Ends(ends)[i].v.x


@inlined
def stretch(own: FrictionNumbers, ends: Any, states: Any, i: int) -> Any:
    """Return a stretch of the anchor's spring."""
    if own.is_at_rest > 0.0:
        return states[i] + own.arms[i] * (Ends(ends)[i].p.x - own.rest[i])
    return states[i]


@inlined
def pull(own: FrictionNumbers, ends: Any, states: Any, i: int) -> Any:
    """Return what spring and damper ask for in a direction."""
    return own.stiffness * stretch(own, ends, states, i) + own.damping * slipping(own, ends, i)


@inlined
def pull_size(own: FrictionNumbers, ends: Any, states: Any) -> Any:
    """Return the size of what spring and damper ask for."""
    count, first = int(own.directions), pull(own, ends, states, 0)
    if count == 1:
        return first if first.real >= 0.0 else -first
    third = pull(own, ends, states, 2) if count > 2 else 0.0 * first
    return norm(Vector(first, pull(own, ends, states, 1), third))


@inlined
def norm(a: Vector) -> Any:
    """Return the length of a vector."""
    return np.sqrt(dot(a, a))


@inlined
def share_kept(own: FrictionNumbers, ends: Any, states: Any) -> Any:
    """Return the share of the pull that friction can take, at most 1."""
    size, held = pull_size(own, ends, states), is_held(own, states)
    cap = (own.static if held else own.sliding) * load_on(own, states)
    if own.has_memory > 0.0 and own.is_at_rest == 0.0 and held:  # an event ends the sticking
        cap = HELD_BEYOND * cap
    if size.real <= cap.real:
        return 0.0 * size + 1.0
    return cap / size


@inlined
def put_load_rates(
    own: FrictionNumbers, axis: Vector, reaction: tuple[Vector, Vector], ends: Any, states: Any, rates: Any
) -> None:
    """Write the rates of the load of friction, from a reaction about the origin of the body's frame, and the axis."""
    if own.is_at_rest > 0.0:
        return
    at, friction_force = load_state(own), 0.0 * reaction[0].x
    if own.rubbing.kind == THREAD:
        friction_force = share_kept(own, ends, states) * pull(own, ends, states, 0)
    behind = load_of(own.rubbing, axis, reaction[0], reaction[1], friction_force) - states[at]
    rates[at] = (states[at + 1] + 2.0 * behind) / own.load_time
    rates[at + 1] = behind / own.load_time


@inlined
def load_of(law: Rubbing, axis: Vector, force: Vector, moment: Vector, friction_force: Any) -> Any:
    """Return the load of a reaction, N, and of the friction of a thread."""
    per_length, thrust, twist = law.per_length, law.thrust, law.twist
    if law.kind == BALL:
        return norm(force)
    along = dot(force, axis)
    if law.kind == PADS:
        across = force - along * axis
        load = norm(across)
        if per_length > 0.0:
            half, tilt = 0.5 * across, per_length * cross(moment, axis)
            load = norm(half + tilt) + norm(half - tilt)
        if thrust > 0.0:
            load += thrust * (along if along.real >= 0.0 else -along)
        if twist > 0.0:
            about = dot(moment, axis)
            load += twist * (about if about.real >= 0.0 else -about)
        return load
    load = thrust * along + twist * friction_force
    return load if load.real >= 0.0 else -load
