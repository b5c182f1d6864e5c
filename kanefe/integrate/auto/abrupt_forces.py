"""Whether the explicit method serves where forces act at once: stops, friction in joints, contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix
from kanefe.integrate.auto.cost import LEAST_BESIDE_KINKS, explicit_work, radau_work, steps_of_radau
from kanefe.integrate.auto.stiffest_rate import highest_rate
from kanefe.integrate.auto.vibrations import vibrations
from kanefe.integrate.dynamics import Dynamics
from kanefe.loads.base import Load
from kanefe.states.state import State
from kanefe.tree.scales import displacement_scales
from kanefe.tree.tangents import constant_tangents

if TYPE_CHECKING:
    from kanefe.contact.contact import Contact

MUCH = 40.0
"""Largest work of the explicit method where stops or contacts act all the time, in multiples of that of Radau's method:
they seldom do, and where they go on to, the run finds it out."""

LITTLE = 0.1
"""Largest work of the explicit method, in multiples of that of Radau's method, where friction in joints sticks, whose
oscillation it limits by its tolerance only."""

STEPS_A_RADIAN, MOST_MOVED = 30.0, 500.0
"""Steps of Radau's method for each joint with friction and each radian of the motion of a scene, for chains of 1 to 20
links; and the motion after which friction has stopped what it can, rad."""

AT_REST = 0.01
"""Motion in a run below which a scene on contacts starts at rest, so that Radau's method steps over it, rad."""


def explicit_serves_stops(model: Model, start: float, span: float) -> bool:
    """Return whether the explicit method has little work while stops do not act, and bearable if they do."""
    free = highest_rate(model, start, *constant_tangents(model))
    implicit = radau_work(model, LEAST_BESIDE_KINKS)
    return (
        explicit_work(model, span * free) < implicit
        and explicit_work(model, span * rate_at_stops(model, start)) < MUCH * implicit
    )


def explicit_serves_friction(model: Model, abrupt: Sequence[Load], start: float, span: float) -> bool:
    """Return whether only friction in joints may become stiff, and the explicit method has much less work with it.

    With what does as all of it sticks, and as anchors give way that slip.
    """
    frictions = [load.held_coordinates for load in abrupt]
    if model.has_stops:
        return False
    (K, C), rate = constant_tangents(model), 0.0
    for load, held in zip(abrupt, frictions, strict=True):
        if held is None:
            return False
        for end, k, c in zip(load.ends, held.stiffness, held.damping, strict=True):
            at = int(model.bodies[end.body].speeds[end.coordinate])
            if at < model.free_count:
                K[at, at] += k
                C[at, at] += c
        rate = max(rate, held.rate)
    rate = max(rate, highest_rate(model, start, K, C))
    moved = min(span * _rate_of_motion(model, start), MOST_MOVED)
    steps = max(LEAST_BESIDE_KINKS, STEPS_A_RADIAN * len(frictions) * moved)
    return explicit_work(model, span * rate) < LITTLE * radau_work(model, steps)


def _rate_of_motion(model: Model, start: float) -> float:
    """Return the rate at which a scene moves by its own size, now or without friction at its start, rad/s."""
    dynamics, n = Dynamics(model), model.free_count
    du = dynamics.rate(start, dynamics.initial_state(start))[model.coordinate_count :][:n]
    scales = displacement_scales(model)
    speeds, falls = np.abs(model.initial_speeds[:n]) / scales, np.sqrt(np.abs(du) / scales)
    return float(max(speeds.max(initial=0.0), falls.max(initial=0.0)))


def explicit_serves_contacts(
    model: Model, abrupt: Sequence[Load], start: float, span: float, rtol: float | None, atol: float, is_loaded: bool
) -> bool:
    """Return whether the explicit method has less work while contacts do not act, and bearable work if they do.

    With what all of them are at most: pressed at all probes that may be at once, and stuck; anchors that slip give way.
    Where some are loaded as the scene starts, they act all the time.
    """
    from kanefe.contact.contact import compliant_contacts

    contacts = [contact for _, contact in compliant_contacts(abrupt)]
    allowed = MUCH * radau_work(model, LEAST_BESIDE_KINKS)
    if len(contacts) < len(abrupt) or model.has_stops or explicit_work(model, 0.0) >= allowed:
        return False
    if span * _rate_of_motion(model, start) < AT_REST:
        return False
    (K, C), slipping = constant_tangents(model), 0.0
    if free := highest_rate(model, start, K, C):
        followed = steps_of_radau(span, rtol, atol, vibrations(Dynamics(model), start, span))
        if explicit_work(model, span * free) > radau_work(model, max(followed, LEAST_BESIDE_KINKS)):
            return False
    state = State(model, start, model.initial_coordinates, model.initial_speeds)
    for contact in contacts:
        if contact.at_most is None:
            return False
        stiffness, damping = contact.at_most
        if contact.friction is not None:
            slipping = max(slipping, contact.friction.relaxation)
        G = _velocities_squared(state, contact)
        K, C = K + stiffness * G, C + damping * G
    rate = highest_rate(model, start, K, C)
    return explicit_work(model, span * max(rate, slipping)) < (allowed / MUCH if is_loaded else allowed)


def _velocities_squared(state: State, contact: Contact) -> Matrix:
    """Return the sum of J^T J of the points where a contact may act, weighted by their shares, (speeds, speeds).

    J are partial velocities past the surface. Balls and tyres may press all around, boxes on boxes at any corner.
    """
    n = state.model.free_count
    from kanefe.integrate.auto.loaded_contacts import velocity_at

    found, shares = np.zeros((n, n)), 0.0
    for end, probe in contact.probes:
        places = probe.point + probe.lever * np.eye(3) if probe.lever > 0.0 else [probe.point]
        marker = state.marker(contact.ends[end])
        for place in [probe.axis] if probe.ring < 0.0 else places:
            point = marker.p_NoFo_N + marker.A_NF @ place
            J = velocity_at(state, contact.ends[0], contact.ends[end], point)[:, :n]
            found += probe.share * (J.T @ J)
        shares += probe.share
    return found / max(shares, 1.0)


def rate_at_stops(model: Model, start: float) -> float:
    """Return the highest rate in rad/s with all stops touched."""
    K, C = constant_tangents(model)
    for body in model.bodies:
        for where, force in zip(body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < model.free_count:
                K[where, where] += force.limit_stiffness
                C[where, where] += force.limit_damping
    return highest_rate(model, start, K, C)
