"""Outputs of contacts: of each as a whole, and of each of its points."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, norm, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.contact.contact_forces import end_of, first_state_of, touching
from kanefe.kernels.contact.contact_places import AT, SLIP, WORK
from kanefe.kernels.contact.detection import located, met_by, velocity
from kanefe.kernels.contact.output_places import OPEN, POINT_OUTPUTS, SLIPS, STICKS
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import WATCH_SIGNATURE, A


@called_by_address(*WATCH_SIGNATURE)
def contact_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what `kanefe.contact.contact.Contact.columns` name."""
    tell_whole(located, met_by(numbers, ends), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def contact_point_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write `POINT_OUTPUTS` of each point."""
    tell_points(located, met_by(numbers, ends), numbers, ends, states, out)


@inlined
def tell_whole(placed: Any, met: Any, numbers: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the outputs of a contact; for `placed` and `met` see `kanefe.kernels.contact.contact_forces.put_points`."""
    A_s, seen = nine(ends, A), nothing_told()
    for i in range(int(numbers[AT.points])):
        seen = with_point(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, seen)
    put_told(numbers, states, seen, out)


@inlined
def tell_points(placed: Any, met: Any, numbers: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the outputs of each point, likewise."""
    A_s = nine(ends, A)
    for i in range(int(numbers[AT.points])):
        tell_point(numbers, i, placed(numbers, i, ends, met), A_s, ends, states, out)


@inlined
def nothing_told() -> Any:
    """Return the sums before a point is looked at: see `put_told`."""
    none = (0.0, 0.0, 0.0)
    return none, none, none, 0.0, -np.inf, none, -np.inf, False


@inlined
def with_point(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any, seen: Any) -> Any:
    """Return the sums with those of a point."""
    depth, normal, point, share = place
    force, rubbed, moved, pressed, deepest, nearest, margin, is_any = seen
    if depth > deepest:
        deepest, nearest = depth, point
    if depth > 0.0 and share > 0.0:
        found = touching(numbers, i, place, A_s, ends, states)
        own, friction = found[4][0], found[5][1]
        force, rubbed = plus(force, times(own, normal)), plus(rubbed, friction)
        moved, pressed = plus(moved, times(own, point)), pressed + own
        margin, is_any = max(margin, found[5][5]), True
    return force, rubbed, moved, pressed, deepest, nearest, margin, is_any


@inlined
def put_told(numbers: Any, states: Any, seen: Any, out: Any) -> None:
    """Write the outputs of a contact.

    `seen`: sums of the normal forces, of friction, of places weighted by the normal forces, and of these; of the
    deepest point depth and place; the largest pull beyond what friction holds; and whether a point touches.
    """
    force, rubbed, moved, pressed, deepest, nearest, margin, is_any = seen
    has_friction, total = numbers[AT.friction] > 0.0, minus(force, rubbed)
    place = times(1.0 / pressed, moved) if pressed > 0.0 else nearest
    for c in range(3):
        out[c], out[7 + c] = total[c], place[c]
    out[3], out[4], out[5] = pressed, norm(rubbed), deepest
    out[6] = states[SLIP] if has_friction else 0.0
    out[10] = states[WORK] if has_friction else 0.0
    out[11] = 0.0 + OPEN
    if is_any:
        out[11] = 0.0 + (SLIPS if not has_friction or margin > 0.0 else STICKS)


@inlined
def tell_point(numbers: Any, i: int, place: Any, A_s: Numbers, ends: Any, states: Any, out: Any) -> None:
    """Write the outputs of a point."""
    depth, normal, _, share = place
    at, has_friction = POINT_OUTPUTS * i, numbers[AT.friction] > 0.0
    for c in range(POINT_OUTPUTS):
        out[at + c] = 0.0
    out[at + 4] = depth
    if depth <= 0.0 or share <= 0.0:
        if has_friction and numbers[AT.rests_at] == 0.0:
            stretch = along_surface(rotated(A_s, three(states, first_state_of(numbers, i))), normal, A_s)
            out[at + 5], out[at + 6], out[at + 7] = stretch[0], stretch[1], stretch[2]
        return
    arms, along, _, _, pressed, (w, tangential, w_rate, _, _, beyond) = touching(numbers, i, place, A_s, ends, states)
    sticks = has_friction and beyond <= 0.0
    passed = minus(along, w_rate) if has_friction else velocity(ends, end_of(numbers, i), arms[0], arms[1])
    rubbed, stretch = rotated_back(A_s, tangential), along_surface(w, normal, A_s)
    slip = along_surface(passed, normal, A_s)
    out[at] = pressed[0]
    for c in range(3):
        out[at + 1 + c], out[at + 5 + c] = -rubbed[c], stretch[c]
        if not (sticks and numbers[AT.holds] > 0.0):  # bristles creep; of what sticks there is round-off alone
            out[at + 8 + c] = slip[c]
    out[at + 11] = 0.0 + (STICKS if sticks else SLIPS)


@inlined
def along_surface(x: Numbers, n: Numbers, A_s: Numbers) -> Numbers:
    """Return the part of a vector across a unit normal, in axes of the surface."""
    return rotated_back(A_s, minus(x, times(dot(x, n), n)))
