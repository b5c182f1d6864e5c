"""Whether another rest on contacts is near, which a small tilt or additional load would reach.

The least loaded contacts are removed one by one until the rest of the scene is unstable: its balance is then one from
which the scene tips. The distance to it is the margin of the rest that was found. The tangent gives this distance to
first order, for contacts that lift in the order of their loads.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from kanefe.contact.contact import compliant_contacts
from kanefe.contact.rigid.rigid_contact import OPEN
from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.linear.equilibrium.balance import step_length
from kanefe.linear.small_motions import SmallMotions
from kanefe.literal.contact_forces import probe_forces
from kanefe.states.constraints import meetings, motion_in_N
from kanefe.states.state import State
from kanefe.tree.scales import scene_length

NEAR = 0.1
"""Distance of the tipping equilibrium below which it is reported, rad or scene lengths."""

TOUCHED, LIFTED = 1e-6, 1e-3
"""Gap relative to the scene's length below which a contact is closed at the start, and above which it has lifted."""

UNSTABLE, WEAKEST = -1e-11, 1e-9
"""Stiffness over mass, relative to the largest, below which a motion tips; and fraction of the force with which a
lifted contact still presses."""

TURNED = 0.5
"""Angle to its surface above which a body on three or more contacts has turned over, rad; contacts deflect less."""

PARTING = 1e-6
"""Distance over which contacts are checked for separation, rad or scene lengths."""

Key = tuple[int, int]
"""Number of a load, and number of its contact point."""


class OtherRestWarning(UserWarning):
    """A rest on contacts near which there is another one."""


@dataclass(frozen=True)
class OtherRest:
    """Another rest near the one that was found.

    Attributes
    ----------
    contacts : tuple of str
        The contacts that lift on the way to it, or that touched at the start and have lifted.
    distance : float
        Distance to the tipping balance, in rad or scene lengths; of lifted contacts the largest gap, in scene lengths.
    has_lifted : bool
        Whether a contact that touched at the start has lifted on the way to this rest, permanently or temporarily.
    turned : float
        Angle by which a body has turned over relative to its surface, rad; else 0.
    """

    contacts: tuple[str, ...]
    distance: float
    has_lifted: bool
    turned: float = 0.0

    def __str__(self) -> str:
        names = ", ".join(repr(name) for name in self.contacts[:6]) + (", ..." if len(self.contacts) > 6 else "")
        if self.turned:
            return (
                f"the body that {names} carried at the start has turned over, by {np.degrees(self.turned):.3g} degrees "
                "relative to its support: this is not the equilibrium of the start. Remedy: start=..., a state near "
                "the intended equilibrium, or less load"
            )
        if self.has_lifted:
            return (
                f"{names} touched at the start and lifted, by {self.distance:.2g} of the scene's length: this is not "
                "the equilibrium of the start, and there may be one in which all of them carry load. Remedy: "
                "start=..., a state near the intended equilibrium, or less load"
            )
        return (
            f"another equilibrium is near: tilted by {self.distance:.2g} (rad, or relative to the scene's length) the "
            f"scene balances without {names}, and tips from there by itself. Remedy: a larger margin against tipping; "
            "to find the other equilibrium, start=..., a state near it"
        )


def other_rest(model: Model, t: float, q: Vector, u: Vector, begun: Model) -> OtherRest | None:
    """Return another rest near one on contacts, if there is one.

    Parameters
    ----------
    model : Model
        The model at rest at q, u.
    begun : Model
        The model at the start of the search.
    """
    state = State(model, t, q, u)
    start = State(begun, t, begun.initial_coordinates, begun.initial_speeds)
    length = scene_length(model)
    before, after = {key: met for key, met in _met(start).items() if met.gap <= TOUCHED * length}, _met(state)
    lifted = {key: after[key].gap for key in before if after[key].gap > LIFTED * length}
    if lifted:
        return OtherRest(_names(model, list(lifted)), max(lifted.values()) / length, True)
    turned = _turned_over(before, after, length)
    if turned is not None:
        return OtherRest(_names(model, turned[0]), 0.0, True, turned[1])
    forces = _forces(state)
    least = sorted(forces, key=lambda key: forces[key])
    # bisection for the smallest number of removed contacts with which it tips
    few, many, distance = 0, len(least), None
    while many - few > 1:
        middle = (few + many) // 2
        tipped = _tips(_without(model, least[:middle]), t, q, u, least[:middle])
        if tipped is None:
            few = middle
        else:
            many, distance = middle, tipped
    if distance is None or distance > NEAR:
        return None
    return OtherRest(_names(model, sorted(least[:many])), distance, False)


class _Met(NamedTuple):
    """A contact point: its gap (m), position in N, the normal in the axes of the surface, and the two bodies."""

    gap: float
    point: Vector
    normal: Vector
    bodies: tuple[int, int]


def _met(state: State) -> dict[Key, _Met]:
    found = {}
    for number, contact in compliant_contacts(state.model.loads):
        ends = state.load_ends(number)
        for i, touch in enumerate(contact.touches(ends, state.load_states(number))):
            bodies = contact.ends[0].body, contact.ends[touch.end].body
            found[number, i] = _Met(-touch.depth, touch.point, ends[touch.end].A.T @ touch.normal, bodies)
    for number, met in zip(state.model.rigid_contacts, meetings(state), strict=True):
        rigid = state.model.rigid_contact(state.model.rigid_contacts.index(number))
        for i, one in enumerate(met):
            end = rigid.ends[rigid.probes[i][0]]
            normal = motion_in_N(state, end).A.T @ one.axes[0]
            found[number, i] = _Met(one.gap, one.point, normal, (rigid.ends[0].body, end.body))
    return found


def _turned_over(before: dict[Key, _Met], after: dict[Key, _Met], length: float) -> tuple[list[Key], float] | None:
    """Return the contacts of a body on an area of contacts that has turned over most, and its angle to the surface."""
    groups: dict[tuple[int, int], list[Key]] = {}
    for key, met in before.items():
        groups.setdefault(met.bodies, []).append(key)
    worst: tuple[list[Key], float] | None = None
    for keys in groups.values():
        points = np.array([before[key].point for key in keys])
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        tilt = max(float(np.arccos(np.clip(before[key].normal @ after[key].normal, -1.0, 1.0))) for key in keys)
        if len(keys) > 2 and spread[1] > LIFTED * length and tilt > max(TURNED, worst[1] if worst else 0.0):
            worst = keys, tilt
    return worst


def _forces(state: State) -> dict[Key, float]:
    """Return the normal forces of the loaded contact points, N."""
    model = state.model
    found = {
        (number, i): float(touch.normal_force)
        for number, contact in compliant_contacts(model.loads)
        for i, touch in enumerate(contact.touches(state.load_ends(number), state.load_states(number)))
    }
    found |= {(model.rigid_contacts[force.contact], force.probe): force.normal for force in probe_forces(state)}
    return {key: force for key, force in found.items() if force > 0.0}


def _without(model: Model, lifted: list[Key]) -> Model:
    """Return the model without the forces of some contact points."""
    loads, z = list(model.loads), model.initial_states.copy()
    for number, i in lifted:
        contact = dict(compliant_contacts(loads)).get(number)
        if contact is not None:
            probes = list(contact.probes)
            probes[i] = (probes[i][0], probes[i][1]._replace(share=WEAKEST * probes[i][1].share))
            loads[number] = replace(contact, probes=tuple(probes))
        else:
            model.rigid_contact(model.rigid_contacts.index(number)).with_status(
                z[model.load_states[number]], i, OPEN, np.zeros(3)
            )
    return replace(model, loads=tuple(loads), initial_states=z)


def _tips(model: Model, t: float, q: Vector, u: Vector, lifted: list[Key]) -> float | None:
    """Return the distance to the balance from which a scene tips while `lifted` points part; None if it does not."""
    small = SmallMotions(model, t, q, u)
    lead, P = small.speeds.leading, small.along_positions
    if not small.is_holonomic or not len(lead):
        return None
    L = np.linalg.cholesky(small.speeds.N.T @ small.mass @ small.speeds.N)
    H = -L.T @ P.ddu[lead] @ np.linalg.inv(L).T
    squares, motions = np.linalg.eigh(0.5 * (H + H.T))
    if squares[0] >= UNSTABLE * np.abs(squares).max():
        return None
    tipping = P.z @ np.linalg.solve(L.T, motions[:, 0])
    beside = model.advance(q, PARTING / step_length(model, tipping) * tipping)
    here, there = (_met(State(model, t, place, u)) for place in (q, beside))
    parts = np.array([there[key].gap - here[key].gap for key in lifted])
    if parts.min() < 0.0 < parts.max():
        return None  # contacts on the other side hold it
    pushed = float(motions[:, 0] @ L.T @ small.du[lead])
    return abs(pushed / float(squares[0])) * step_length(model, tipping)


def _names(model: Model, keys: list[Key]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(model.loads[number].name for number, _ in keys))
