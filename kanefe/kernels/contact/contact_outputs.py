"""Outputs of contacts: of each as a whole, and of each of its points."""

from typing import Any

import numpy as np

from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.contact_forces import felt
from kanefe.kernels.contact.contact_places import (
    AnchorStates,
    AtState,
    ContactNumbers,
    FrictionStates,
    Place,
    end_of,
    first_state_of,
)
from kanefe.kernels.contact.detection import velocity
from kanefe.kernels.contact.meeting import look, look_up
from kanefe.kernels.contact.output_places import ContactOutputs, PointOutputs, PointsOutputs, Status
from kanefe.kernels.force_elements.places import WATCH_SIGNATURE, Ends
from kanefe.kernels.language import ZERO, across, called_by_address, inlined, norm


@called_by_address(*WATCH_SIGNATURE)
def contact_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what `kanefe.contact.contact.Contact.columns` name."""
    at, room, told = AtState(ContactNumbers(numbers), numbers, ends, states), local_numbers(), ContactOutputs(out)
    met, has_friction = look(at, room), at.own.friction > 0.0
    force, rubbed, moved, nearest = ZERO, ZERO, ZERO, ZERO
    pressed, deepest, margin, is_any = 0.0, -np.inf, -np.inf, False
    for i in range(int(at.own.count)):
        place = look_up(at, i, met)
        if place.depth > deepest:
            deepest, nearest = place.depth, place.point
        if place.depth > 0.0 and place.share > 0.0:
            found = felt(at, i, place)
            own = found.normal.force
            force, rubbed = force + own * place.normal, rubbed + found.rubbed.force
            moved, pressed = moved + own * place.point, pressed + own
            margin, is_any = max(margin, found.rubbed.beyond), True
    told.force, told.place = force - rubbed, (1.0 / pressed) * moved if pressed > 0.0 else nearest
    told.pressed, told.rubbed, told.depth, told.status = pressed, norm(rubbed), deepest, 0.0 + Status.OPEN.value
    told.slip = FrictionStates(states).slip if has_friction else 0.0
    told.work = FrictionStates(states).work if has_friction else 0.0
    if is_any:
        told.status = 0.0 + (Status.SLIPS if not has_friction or margin > 0.0 else Status.STICKS).value


@called_by_address(*WATCH_SIGNATURE)
def contact_point_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write `PointOutputs` of each point."""
    at, room = AtState(ContactNumbers(numbers), numbers, ends, states), local_numbers()
    met = look(at, room)
    for i in range(int(at.own.count)):
        tell_point(at, i, look_up(at, i, met), PointsOutputs(out)[i])


@inlined
def tell_point(at: AtState, i: int, place: Place, told: PointOutputs) -> None:
    """Write the outputs of a point."""
    has_friction, A_s, n = at.own.friction > 0.0, Ends(at.ends)[0].A, place.normal
    told.pressed, told.rubbed, told.depth, told.stretch, told.slip, told.status = (
        0.0,
        ZERO,
        place.depth,
        ZERO,
        ZERO,
        0.0,
    )
    if place.depth <= 0.0 or place.share <= 0.0:
        if has_friction and at.own.rests_at == 0.0:
            told.stretch = A_s.T @ across(A_s @ AnchorStates(at.states, first_state_of(at, i)).stretch, n)
        return
    found = felt(at, i, place)
    rubbed = found.rubbed
    sticks = has_friction and rubbed.beyond <= 0.0
    passed = velocity(Ends(at.ends)[0], end_of(at, i), place.point)
    if has_friction:
        passed = found.along - rubbed.stretch_rate
    told.pressed, told.rubbed = found.normal.force, -(A_s.T @ rubbed.force)
    told.stretch = A_s.T @ across(found.stretch, n)
    if not (sticks and at.own.holds > 0.0):  # bristles creep; of what sticks there is round-off alone
        told.slip = A_s.T @ across(passed, n)
    told.status = 0.0 + (Status.STICKS if sticks else Status.SLIPS).value
