"""Contacts of two convex shapes: where they touch is found at each state, and the laws act there as at other points.

For complex numbers, derivatives of places, normals, depths and shares are differences of real ones along the imaginary
part of the pose; what the laws make of them is exact.
"""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, minus, plus, product, rotated, rotated_back, three, transposed
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.contact_forces import change_points, put_points, watch_points
from kanefe.kernels.contact.contact_places import AT
from kanefe.kernels.contact.convex_edges import DEPTH, NORMAL, OF_SLOT, PLACE, SHARE
from kanefe.kernels.contact.convex_patch import put_slots
from kanefe.kernels.contact.convex_shapes import SIZE
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import END_NUMBERS, SIGNATURE, WATCH_SIGNATURE, A, P

OTHER, OWN = 1, 2
"""Indices at `AT.shape`: where the numbers of the other shape begin, after those of the own one."""

DIFFERENCE = 1e-5
"""Change of the pose by which derivatives are found, rad, and relative to the size of the shapes."""


@inlined
def pose_of(ends: Any) -> Any:
    """Return how what touches is turned and moved in the axes of what is touched."""
    A_s = nine(ends, A)
    R = product(transposed(A_s), nine(ends, END_NUMBERS + A))
    return R, rotated_back(A_s, minus(three(ends, END_NUMBERS + P), three(ends, P)))


@kernel
def put_at(numbers: Any, R: Numbers, x: Numbers, turns: Numbers, moves: Numbers, step: float, slots: Any) -> None:
    """Write where the shapes of a contact touch some steps along a change of their pose."""
    shape = int(numbers[AT.shape])
    R_there = (
        R[0].real + step * turns[0],
        R[1].real + step * turns[1],
        R[2].real + step * turns[2],
        R[3].real + step * turns[3],
        R[4].real + step * turns[4],
        R[5].real + step * turns[5],
        R[6].real + step * turns[6],
        R[7].real + step * turns[7],
        R[8].real + step * turns[8],
    )
    there = (x[0].real + step * moves[0], x[1].real + step * moves[1], x[2].real + step * moves[2])
    own, other = shape + OWN, shape + int(numbers[shape + OTHER])
    put_slots(numbers, own, other, R_there, there, int(numbers[AT.points]), slots)


@kernel
def meet(numbers: Any, ends: Any, slots: Any, ahead: Any, behind: Any) -> Any:
    """Write where the shapes touch, ahead and behind a small change of the pose too, if there is one.

    Returns what the difference of ahead and behind is multiplied by, and what was written to: see `slot`.
    """
    R, x = pose_of(ends)
    shape = int(numbers[AT.shape])
    size = numbers[shape + OWN + SIZE] + numbers[shape + int(numbers[shape + OTHER]) + SIZE]
    turns = (R[0].imag, R[1].imag, R[2].imag, R[3].imag, R[4].imag, R[5].imag, R[6].imag, R[7].imag, R[8].imag)
    moves = (x[0].imag, x[1].imag, x[2].imag)
    put_at(numbers, R, x, turns, moves, 0.0, slots)
    most, changed = 0.0, R[0]
    for i in range(9):
        if abs(turns[i]) > most:
            most, changed = abs(turns[i]), R[i]
    for i in range(3):
        if abs(moves[i]) / size > most:
            most, changed = abs(moves[i]) / size, x[i]
    if most == 0.0:
        return changed - changed.real, slots, ahead, behind
    step = DIFFERENCE / most
    put_at(numbers, R, x, turns, moves, step, ahead)
    put_at(numbers, R, x, turns, moves, -step, behind)
    return (changed - changed.real) / (2.0 * step * changed.imag), slots, ahead, behind


@inlined
def slot(numbers: Any, i: int, ends: Any, met: Any) -> Any:
    """Return a place where shapes touch, as `kanefe.kernels.contact.detection.located` does that of a point."""
    at, (factor, slots, ahead, behind) = OF_SLOT * i, met
    if factor.imag == 0.0:
        return posed(
            ends,
            factor + slots[at + DEPTH],
            (factor + slots[at + NORMAL], factor + slots[at + NORMAL + 1], factor + slots[at + NORMAL + 2]),
            (factor + slots[at + PLACE], factor + slots[at + PLACE + 1], factor + slots[at + PLACE + 2]),
            factor + slots[at + SHARE],
        )
    return posed(
        ends,
        moving(at + DEPTH, factor, slots, ahead, behind),
        (
            moving(at + NORMAL, factor, slots, ahead, behind),
            moving(at + NORMAL + 1, factor, slots, ahead, behind),
            moving(at + NORMAL + 2, factor, slots, ahead, behind),
        ),
        (
            moving(at + PLACE, factor, slots, ahead, behind),
            moving(at + PLACE + 1, factor, slots, ahead, behind),
            moving(at + PLACE + 2, factor, slots, ahead, behind),
        ),
        moving(at + SHARE, factor, slots, ahead, behind),
    )


@inlined
def moving(k: int, factor: Any, slots: Any, ahead: Any, behind: Any) -> Any:
    """Return one of the numbers with its derivative."""
    return slots[k] + factor * (ahead[k] - behind[k])


@inlined
def posed(ends: Any, depth: Any, normal: Numbers, place: Numbers, share: Any) -> Any:
    """Return the same with normal and place in N."""
    A_s = nine(ends, A)
    return depth, rotated(A_s, normal), plus(three(ends, P), rotated(A_s, place)), share


@called_by_address(*SIGNATURE)
def convex_contact(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the other shape, the first end, and on the own one, and the rates of the states."""
    slots, ahead, behind = local_numbers(), local_numbers(), local_numbers()
    put_points(slot, meet(numbers, ends, slots, ahead, behind), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def convex_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write its event values: see `kanefe.contact.contact_events.Watched`."""
    slots = local_numbers()
    watch_points(slot, meet(numbers, ends, slots, slots, slots), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def convex_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the states after an event: see `kanefe.kernels.contact.contact_forces.contact_change`."""
    slots = local_numbers()
    change_points(slot, meet(numbers, ends, slots, slots, slots), int(inputs[0]), numbers, ends, states, out)
