"""Rest on rigid contacts: the loaded ones are found such that Signorini's and Coulomb's conditions hold.

    0 <= gap  _|_  normal force >= 0,    sticking points do not move, with |friction| <= mu normal

An active-set method: loaded points are held by the constraint rows of a run, the balance is found under these, points
in tension are released and penetrated ones are added. If this fails from the start, compliant contacts give a better
starting point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kanefe.contact.contact import Contact
from kanefe.contact.rigid.rigid_contact import OPEN, SLIPS, STICKS, RigidContact, rigid_contacts
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.kane.contact_shares import DEPENDENT, spare_forces
from kanefe.kernels.contact.laws import Coulomb, KelvinVoigt
from kanefe.kernels.impacts.contact_questions import Asks
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.equilibrium.dynamic_relaxation import NoRest, found_or_fallen
from kanefe.linear.imbalance import force_sizes
from kanefe.literal.contact_forces import margins, probe_forces
from kanefe.literal.route import LiteralRoute
from kanefe.loads.base import Load
from kanefe.states.constraints import held_rows, meetings, touching_rows
from kanefe.states.state import State
from kanefe.tree.scales import scene_length, scene_weight

Key = tuple[int, int]
"""Number of a contact among the rigid contacts, and number of its contact point."""

Found = tuple[Model, BalanceSearch, tuple[Vector, Vector]]

HELD, FREED = "held", "freed"
"""States of a loaded contact point: it sticks, if there is friction; or it may slide once, if friction is too small."""

TOUCHING = 1e-9
"""Gap relative to the scene's length up to which a contact point touches at the start, and depth up to which it has not
penetrated."""

PULLED = 1e-9
"""Force relative to the largest normal force beyond which a contact point is in tension or needs more friction than it
has; round-off is smaller."""

THROUGH = 1e-2
"""Depth relative to the scene's length above which a search has passed through the surface."""

NEARLY = 0.0, 1e-4, 1e-2
"""Gaps relative to the scene's length up to which contact points are tried as the loaded ones after the search with
compliant contacts."""

SETTLING = 1e-4
"""Deflection of contacts under the weight in dynamic relaxation, relative to the scene's length."""

MOST_SLIDES = 3
"""Largest number of slides of a body that friction does not hold to positions that need less friction."""


def rest_on_contacts(
    model: Model,
    t: float,
    q: Vector,
    u: Vector,
    search: Callable[[Model, Vector], Found],
    approach: Callable[[Vector, Callable[[float], Model]], Vector],
    may_stay: bool,
) -> Found:
    """Return a balance on rigid contacts.

    Parameters
    ----------
    model : Model
    t : float
        s.
    q, u : ndarray
        Where the search begins.
    search : callable
        Finds the balance of a model, with the constraint rows of its internal states, from coordinates.
    approach : callable
        Finds coordinates near the balance, from others and from models with compliant contacts by deflection (m).
    may_stay : bool
        Whether the contacts at the start are tried first, so that sticking points stay exactly where they are.

    Raises
    ------
    SimulationError
        If no balance is found; the message names the contact that slips.
    """
    if may_stay:
        state = State(model, t, q, u)
        near = TOUCHING * scene_length(model)
        touching = {key: HELD for key, gap in _gaps(state).items() if gap <= near}
        rest = _Rest(model, t, u, search, 0)
        try:
            return rest.found_if_held(q, touching)
        except SimulationError:
            pass  # not in balance near the start
    led = approach(q, lambda depth: yielding(model, t, q, u, depth))
    depth = SETTLING * scene_length(model)
    return found_or_fallen(
        lambda q: _from_near(model, t, q, u, search), led, lambda: yielding(model, t, q, u, depth), t, q, u
    )


def _from_near(model: Model, t: float, q: Vector, u: Vector, search: Callable[[Model, Vector], Found]) -> Found:
    """Return an equilibrium carried by the contact points nearest to touching at q."""
    gaps = _gaps(State(model, t, q, u))
    tried: list[dict[Key, str]] = []
    error: SimulationError | None = None
    for share in NEARLY:
        touching = {key: HELD for key, gap in gaps.items() if gap <= share * scene_length(model)}
        if touching in tried:
            continue
        tried.append(touching)
        try:
            return _Rest(model, t, u, search, MOST_SLIDES).found_if_held(q, touching)
        except SimulationError as failed:
            error = failed if error is None or touching else error
    raise error or SimulationError("no equilibrium of the scene was found")


class _Rest:
    """The active set about a state; `marks` are the points of the surfaces to which contact points stick."""

    def __init__(
        self, model: Model, t: float, u: Vector, search: Callable[[Model, Vector], Found], most_slides: int
    ) -> None:
        self.model, self.t, self.u, self.search, self.most_slides = model, t, u, search, most_slides
        self.length = scene_length(model)
        self.marks: dict[Key, Vector] = {}
        self.friction: dict[Key, tuple[Vector, float]] = {}  # required friction force, and mu N, of slipping points

    def found(self, q: Vector, carries: dict[Key, str]) -> Found:
        """Return the equilibrium found from q, carried by some contact points."""
        slides, most = 0, 4 * sum(len(model_contact.probes) for model_contact in self._contacts()) + 10
        for _ in range(most):
            try:
                model, search, (q, u) = self.search(self.held(q, carries), q)
            except SimulationError as error:
                if FREED not in carries.values():
                    raise
                raise self._slips([key for key, kind in carries.items() if kind == FREED]) from error
            state = State(model, self.t, q, u)
            carries, changed = self._changed(state, carries)
            if changed:
                continue
            slipping, loose = self._beyond_friction(state, carries)
            if not slipping and not loose and FREED not in carries.values():
                return model, search, (q, u)
            slides += bool(slipping)
            if slides > self.most_slides:
                raise self._slips(sorted(slipping))
            # points that have slid stick at their new positions
            self.marks = {key: mark for key, mark in self.marks.items() if carries.get(key) == HELD}
            carries = {key: FREED if key in slipping else HELD for key in carries if key not in loose}
        raise SimulationError(
            f"no equilibrium of the scene was found on its rigid contacts: after {most} changes of what "
            "carries, contacts are still in tension or penetrated. Remedy: start=..., a state nearer to equilibrium "
            "(such as the end of a damped run), or compliant contacts, kanefe.HuntCrossley(...)"
        )

    def found_if_held(self, q: Vector, carries: dict[Key, str]) -> Found:
        """Return the equilibrium found from q, carried by some contact points, if these hold all bodies."""
        begun = BalanceSearch(self.held(q, carries), self.t, q, self.u, np.zeros(0, dtype=int), ())
        if not begun.is_held:
            raise begun.refusal()
        return self.found(q, carries)

    def _contacts(self) -> list[RigidContact]:
        return [self.model.rigid_contact(c) for c in range(len(self.model.rigid_contacts))]

    def held(self, q: Vector, carries: dict[Key, str]) -> Model:
        """Return the model with constraint rows for the loaded points."""
        z = self.model.initial_states.copy()
        met = meetings(State(self.model, self.t, q, self.u))
        for c, contact in enumerate(self._contacts()):
            own = z[self.model.load_states[self.model.rigid_contacts[c]]]
            for i in range(len(contact.probes)):
                kind = carries.get((c, i))
                if kind is None:
                    contact.with_status(own, i, OPEN, np.zeros(3))
                    self.marks.pop((c, i), None)
                elif contact.friction is None or kind == FREED:
                    contact.with_status(own, i, SLIPS, np.zeros(3))  # without direction, thus without friction
                else:
                    mark = self.marks.setdefault((c, i), met[c][i].place)
                    contact.with_status(own, i, STICKS, mark)
        return replace(self.model, initial_states=z)

    def _changed(self, state: State, carries: dict[Key, str]) -> tuple[dict[Key, str], bool]:
        """Return the loaded points after the worst one in tension is released, or penetrated ones are added."""
        entered = {key: -gap for key, gap in margins(state).gaps.items() if gap < -TOUCHING * self.length}
        if entered and max(entered.values()) > THROUGH * self.length:
            worst = max(entered, key=lambda key: entered[key])
            raise SimulationError(
                f"the search for an equilibrium passes through {self._name(worst)}. Remedy: start=..., a state nearer "
                "to it"
            )
        forces = {(force.contact, force.probe): force.normal for force in probe_forces(state)}
        pulled = min(forces, key=lambda key: forces[key], default=None)
        if pulled is not None and forces[pulled] < -PULLED * max(abs(force) for force in forces.values()):
            return {key: kind for key, kind in carries.items() if key != pulled}, True
        return carries | dict.fromkeys(entered, HELD), bool(entered)

    def _beyond_friction(self, state: State, carries: dict[Key, str]) -> tuple[set[Key], set[Key]]:
        """Return the sticking points that must slip, and those that stick without a normal force.

        A point must slip if no distribution of forces is in balance within the friction cones: rigid contacts may share
        forces in more than one way, so that the distribution of least norm alone does not decide.
        """
        found = margins(state)
        largest = max(found.normals.values(), default=0.0)
        if min(found.slip_margins.values(), default=0.0) >= -PULLED * largest:
            return set(), set()
        y = np.concatenate((state.q, state.u, state.z))
        z = state.model.parts(LiteralRoute(state.model).asked_contacts(Asks.START, self.t, y).changed().y)[2]
        forces = {(force.contact, force.probe): force.friction for force in probe_forces(state)}
        slipping: set[Key] = set()
        loose: set[Key] = set()
        for key in found.slip_margins:
            where = self.model.load_states[self.model.rigid_contacts[key[0]]]
            status = self.model.rigid_contact(key[0]).status(z[where])[key[1]]
            if status == SLIPS and carries.get(key) == HELD:
                slipping.add(key)
                self.friction[key] = forces[key], float(np.linalg.norm(forces[key])) + found.slip_margins[key]
            elif status == OPEN and found.slip_margins[key] < -PULLED * largest:
                loose.add(key)
        return slipping, loose

    def _slips(self, keys: list[Key]) -> NoRest:
        reasons = []
        for name in dict.fromkeys(map(self._name, keys)):
            own = [self.friction[key] for key in keys if self._name(key) == name]
            most = sum(most for _, most in own)
            together = float(np.linalg.norm(np.sum([force for force, _ in own], axis=0)))
            each = sum(float(np.linalg.norm(force)) for force, _ in own)
            if together > most:
                reasons.append(f"{name} would slip: it needs a friction of {together:.4g} N and holds {most:.4g} N")
            elif each > most:
                reasons.append(
                    f"{name} would turn: its points need a friction of {each:.4g} N in sum and hold {most:.4g} N"
                )
        if not reasons:  # each has enough friction, but no distribution is within all friction cones
            names = ", ".join(dict.fromkeys(map(self._name, keys)))
            reasons.append(
                f"{names} would slip: no distribution of the forces is within the friction of each contact point"
            )
        return NoRest(
            f"the scene has no equilibrium: {'; '.join(reasons)}. "
            "Remedy: more friction, kanefe.Coulomb(mu), a support, or a run"
        )

    def _name(self, key: Key) -> str:
        return self.model.rigid_contact(key[0]).title


def _gaps(state: State) -> dict[Key, float]:
    return {(c, i): one.gap for c, probes in enumerate(meetings(state)) for i, one in enumerate(probes)}


def yielding(model: Model, t: float, q: Vector, u: Vector, depth: float) -> Model:
    """Return a model with compliant instead of rigid contacts, with a given deflection (m) under the scene's weight."""
    force = scene_weight(model) or float(force_sizes(State(model, t, q, u)).max(initial=0.0)) or 1.0
    k, law = force / depth, KelvinVoigt(force / depth, damping=0.0)
    loads: list[Load] = list(model.loads)
    for i, rigid in rigid_contacts(model.loads):
        friction = None if rigid.friction is None else Coulomb(rigid.static, stiffness=k, damping=1e-3 * k)
        loads[i] = Contact(rigid.name, rigid.ends, rigid.shape, rigid.probes, law, friction, np.zeros(3))
    soft = model.with_loads(loads)
    z = soft.initial_states.copy()
    for i, (new, old) in enumerate(zip(soft.load_states, model.load_states, strict=True)):
        if i not in model.rigid_contacts:
            z[new] = model.initial_states[old]
    switches = sum(len(load.initial_states) for load in model.loads)
    z[sum(len(load.initial_states) for load in loads) :] = model.initial_states[switches:]
    return replace(soft, initial_states=z)


def undetermined(state: State) -> tuple[str, ...]:
    """Return the names of rigid contacts whose normal forces are not unique for rigid bodies.

    The reported forces are those of least norm, or others without tension.
    """
    if not touching_rows(state):
        return ()
    spare = spare_forces(state)
    totals: dict[str, Vector] = {}
    for number, (owner, row) in enumerate(held_rows(state)):
        if row.presses:
            totals[owner.name] = totals.get(owner.name, np.zeros(spare.shape[1])) + spare[number]
    return tuple(name for name, total in totals.items() if np.abs(total).max(initial=0.0) > DEPENDENT)
