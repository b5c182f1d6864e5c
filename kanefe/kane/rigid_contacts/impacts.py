"""What happens to rigid contacts at an event: impacts, and which of them are open, stick and slip afterwards.

Impacts follow `kanefe.kane.rigid_contacts.impact_laws`, all contacts that are closed taking part at once. What follows
is decided by the forces: the complementarity of accelerations.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np

from kanefe.contact.contact_events import of_point
from kanefe.contact.rigid.rigid_contact import AT_REST, OPEN, SLIPS, STICKS, TAKEN, RigidContact
from kanefe.errors import SimulationError, SimulationWarning, outside
from kanefe.frames import Matrix, Vector
from kanefe.kane.rigid_contacts.contact_forces import ContactMargins
from kanefe.kane.rigid_contacts.drawn_in import drawn_in, drawn_in_together, jammed
from kanefe.kane.rigid_contacts.impact_laws import ImpactProblem, impact
from kanefe.kane.rigid_contacts.instant import InstantAt, Key, LiteralInstant, blur_of_place
from kanefe.kane.rigid_contacts.stick_or_slip import NoForces, StickOrSlip
from kanefe.kernels.impacts.tolerances import (
    BEGINNING,
    CLOSE,
    CROWDED,
    MOMENT,
    NEAR,
    SHORT_FLIGHT,
    STILL,
    STOPPED,
    STRUCK,
)
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import moving_length
from kanefe.tree.told_impacts import ToldImpacts

TOUCH, LIFT, SLIP, STICK, START = "touch", "lift", "slip", "stick", "start"


class PointChange(NamedTuple):
    """What an event changes at a point of a contact.

    Attributes
    ----------
    contact : str
    point : int
    t : float
        s.
    before, after : int
        OPEN, STICKS or SLIPS.
    is_struck : bool
        Whether it took part in an impact, after which it may be open again.
    has_friction : bool
    """

    contact: str
    point: int
    t: float
    before: int
    after: int
    is_struck: bool
    has_friction: bool

    @property
    def names(self) -> list[str]:
        """Names of its reported events: a point that touches and slips at once has both."""
        has_touched = self.before == OPEN and (self.after != OPEN or self.is_struck)
        found = {
            TOUCH: has_touched,
            LIFT: self.before != OPEN and self.after == OPEN,
            SLIP: self.has_friction and self.after == SLIPS != self.before,
            STICK: self.has_friction and self.after == STICKS != self.before,
        }
        return [f"{self.contact} {of_point(what, self.point)}" for what, is_reported in found.items() if is_reported]


@dataclass
class Changed:
    """What an event leads to.

    Attributes
    ----------
    u : ndarray, shape (free,)
        Speeds after it.
    z : ndarray, shape (states,)
        Internal states after it.
    happened : list of (str, float)
        Names of what is told, "<contact> touch" and so on, and their times, s.
    points : list of PointChange
        What is told of single points, where that is asked for.
    titles : list of str
        Of the contacts that the event concerns.
    told : ToldImpacts
        What is to be told of its impact.
    """

    u: Vector
    z: Vector
    happened: list[tuple[str, float]] = field(default_factory=list)
    points: list[PointChange] = field(default_factory=list)
    titles: list[str] = field(default_factory=list)
    told: ToldImpacts = field(default_factory=ToldImpacts)


def resolved(
    model: ModelData,
    t: float,
    y: Vector,
    kind: str,
    span: float,
    stop: float = np.inf,
    rtol: float = 0.0,
    at: InstantAt | None = None,
) -> Changed:
    """Return what follows an event of rigid contacts.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    y : ndarray
        State (q, u, z) at it.
    kind : str
        `TOUCH`, `LIFT`, `SLIP` or `STICK`: what the run found; `START`: what touches is not known yet.
    span : float
        Of the run, s; zero: only the time itself is looked at.
    stop : float
        End of the run, s, beyond which motions may not be known.
    rtol : float
        Of the run: the share of speeds, or of the scene's length in a second, that it does not resolve.
    at : InstantAt, optional
        Of the route of the scene; default: the literal one.

    Raises
    ------
    SimulationError
        If contacts have no forces that fit (Painleve's paradox).
    """
    return _Event(model, t, y, kind, span, at or partial(LiteralInstant, model), stop, rtol).changed()


def warn_of_impacts(told: ToldImpacts) -> None:
    """Warn of what is to be told of impacts as a run begins."""
    for text in told.warnings:
        warnings.warn(text, SimulationWarning, stacklevel=outside())


class _Event(StickOrSlip):
    def __init__(
        self,
        model: ModelData,
        t: float,
        y: Vector,
        kind: str,
        span: float,
        at: InstantAt,
        stop: float,
        rtol: float,
    ) -> None:
        super().__init__(model, t, y, span, stop, at)
        self.kind, self.rtol = kind, rtol
        self.before = {key: self._contact(key).status(self._own(key))[key[1]] for key in self.met}
        self.concerned, self.lifted = self._past()
        self.keys = [
            key
            for key, one in self.met.items()
            if self.before[key] != OPEN or one.gap <= self._near(key) or (kind == TOUCH and key in self.concerned)
        ]
        self.happened: list[tuple[str, float]] = []
        self.points: list[PointChange] = []
        self.told = ToldImpacts()

    def _past(self) -> tuple[set[Key], set[Key]]:
        """Return the contact points that the event concerns, and those of them that it lets go.

        A point whose friction is used up since nothing presses it lifts, at the tip of its cone.
        """
        if self.kind == START:
            return set(), set()
        found = self.instant.margins()
        values = {
            TOUCH: found.gaps,
            LIFT: found.normals,
            SLIP: found.slip_margins,
            STICK: found.slips,
        }[self.kind]
        least = max(min(values.values(), default=0.0), 0.0)
        if self.kind == TOUCH:
            return {key for key, value in values.items() if value <= least + self._near(key)}, set()
        forces = max((abs(x) for x in found.normals.values()), default=0.0)
        scale = float(np.abs(self.u).max(initial=0.0)) if self.kind == STICK else forces
        concerned = {key for key, value in values.items() if value <= least + NEAR * scale}
        if self.kind == LIFT:
            return concerned, concerned
        if self.kind == STICK:
            return concerned, set()
        return concerned, {key for key in concerned if self._is_at_tip(key, found, NEAR * forces)}

    def _is_at_tip(self, key: Key, found: ContactMargins, noise: float) -> bool:
        """Return whether nothing presses a point that sticks, and nothing rubs there."""
        normal = found.normals[key]
        # friction that is beyond its limit by the noise, and by how far a root is
        rubs = self._contact(key).static * normal - found.slip_margins[key]
        return normal <= noise and rubs <= 2.0 * noise

    def _near(self, key: Key) -> float:
        """Return the gap up to which a point takes part, m."""
        return NEAR * moving_length(self.model) + blur_of_place(self.met[key])

    def changed(self) -> Changed:
        """Return what follows."""
        if not self.keys:
            return Changed(self.u, self.z)
        G, b = self.instant.problem(self.keys)
        fallen = float(np.abs(b).max()) * MOMENT * self.span
        sizes = np.array([self.instant.speed(key) for key in self.keys])
        still, self.rest = np.maximum(STILL * sizes, fallen), np.maximum(STOPPED * sizes, fallen)
        speeds = np.maximum(sizes, moving_length(self.model))
        self.slow = self.rtol**BEGINNING * speeds
        if self.kind == STICK:  # a slip that ends, or turns, within the noise of the run, begins anew or is over
            ended = [key in self.concerned for key in self.keys]
            self.rest = np.where(ended, np.maximum(self.rest, self.rtol * speeds), self.rest)
        rates = np.concatenate([self.met[key].rates for key in self.keys])
        self.struck = np.zeros(len(self.keys), dtype=bool)
        if np.any(rates[::3] < -still):
            impulses = self._impulses(G, rates, still)
            self.struck = impulses[::3] > CLOSE * np.abs(impulses).max()
            self.u = self.u + self.instant.respond(self.keys, impulses)
            rates = rates + G @ impulses
            still = np.maximum(still, STRUCK * (np.abs(G) @ np.abs(impulses))[::3])
        rates = self._drawn_in(G, rates, still)
        self._decide(G, rates, still)
        self._tell()
        titles = sorted({self._contact(key).title for key in self.concerned})
        return Changed(self.u, self.z, self.happened, self.points, titles, self.told)

    def _closed(self, rates: Vector, still: Vector) -> np.ndarray:
        closed = rates[::3] <= still
        closed &= [key not in self.lifted for key in self.keys]
        return np.asarray(closed)

    def _drawn_in(self, G: Matrix, rates: Vector, still: Vector) -> Vector:
        """Return the rates after impacts of what friction draws into its surface: see `drawn_in`."""
        closed = self._closed(rates, still)
        problem = ImpactProblem(G, [self._contact(key) for key in self.keys], still)
        slips = np.array(
            [c.friction is not None and not self._is_at_rest(k, rates) for k, c in enumerate(problem.contacts)]
        )
        if not np.any(slips & closed):
            return rates
        for i in jammed(problem, rates, slips, closed):
            impulses = drawn_in(problem, rates, self._now().problem(self.keys)[1], i)
            if impulses is not None:
                rates = self._moved(G, rates, impulses)
        return rates

    def _moved(self, G: Matrix, rates: Vector, impulses: Vector) -> Vector:
        """Take in the impulses of an impact without collision; return the rates after it."""
        after = rates + G @ impulses
        for key, energy in zip(self.keys, 0.5 * (impulses * (rates + after)).reshape(-1, 3).sum(axis=1), strict=True):
            self._own(key)[TAKEN] -= energy
        self.u = self.u + self.instant.respond(self.keys, impulses)
        return after

    def _impulses(self, G: Matrix, rates: Vector, still: Vector) -> Vector:
        """Return the impulses of an impact, (3 k,), with their energies in the states of the contacts."""
        contacts = [self._contact(key) for key in self.keys]
        found = impact(ImpactProblem(G, contacts, still), rates)
        if found is None:
            names = ", ".join(sorted({contact.title for contact in contacts}))
            raise SimulationError(
                f"at t = {self.t:.6g} s the impact on {names} has no impulses that were found. "
                "Remedy: less friction, or compliant contacts, kanefe.HuntCrossley(...)"
            )
        for key, energy in zip(self.keys, found.energies, strict=True):
            self._own(key)[TAKEN] -= energy
        self.told.was_by_poisson(sorted({contacts[i].name for i in found.by_poisson}), self.t)
        self.told.was_by_order(sorted({contacts[i].name for i in found.by_order}), self.t)
        if found.adding:
            adding = sorted({contacts[i].name for i in found.adding})
            self.told.adding.append((self.t, tuple(adding), float(found.energies[list(found.adding)].sum())))
        return found.impulses

    def _decide(self, G: Matrix, rates: Vector, still: Vector) -> None:
        """Write the new status of each contact point by the accelerations; bounces too fast to resolve are at rest.

        Each round closes a probe more, so that they end; or it is an impact of what friction draws in, of which there
        are not more.
        """
        closed, impacts = self._closed(rates, still), 0
        while True:
            rates = self._stopped(G, rates, closed)
            try:
                y, statuses, kept, turning = self._forces(rates, closed)
            except NoForces:
                problem = ImpactProblem(G, [self._contact(key) for key in self.keys], still)
                together = drawn_in_together(problem, rates, self._now().problem(self.keys)[1])
                impacts += 1
                if together is None or impacts > len(self.keys):
                    raise
                rates = self._moved(G, rates, together)
                still = np.maximum(still, STRUCK * (np.abs(G) @ np.abs(together))[::3])
                closed = self._closed(rates, still)
                continue
            resting = [
                k
                for k, key in enumerate(self.keys)
                if not closed[k] and rates[3 * k] > 0.0 and self._is_crowded(key, rates[3 * k], y[3 * k])
            ]
            if not resting:
                break
            for k in resting:
                closed[k], e = True, self._contact(self.keys[k]).law.restitution
                left = 2.0 * rates[3 * k] / (-y[3 * k] * (1.0 - e))
                self.happened.append((f"{self._contact(self.keys[k]).name} rest", self.t + left))
        for k, key in enumerate(self.keys):
            contact, met = self._contact(key), self.met[key]
            along = rate = np.zeros(3)
            if statuses[k] == SLIPS:
                speed = max(AT_REST, self.slow[k] if self._is_at_rest(k, rates) else 0.0)
                along, rate = speed * kept[k] @ met.axes[1:] @ self._surfaces[key[0]], speed * turning[k]
            if statuses[k] == OPEN:
                along = np.array((max(-met.gap, 0.0), 0.0, 0.0))
            if statuses[k] == STICKS:
                was = self.before[key] == STICKS
                along = contact.kept(self._own(key), key[1]) if was else met.place
            contact.with_status(self._own(key), key[1], statuses[k], along, rate)
        for key in self.met.keys() - set(self.keys):
            kept = self._contact(key).kept(self._own(key), key[1])
            kept[0] = min(kept[0], max(-self.met[key].gap, 0.0))

    def _stopped(self, G: Matrix, rates: Vector, closed: np.ndarray) -> Vector:
        """Take the round-off from the speeds of what is closed, and from those of what does not slip."""
        held = [3 * int(k) for k in np.flatnonzero(closed)]
        held += [
            3 * int(k) + j
            for k in np.flatnonzero(closed)
            for j in (1, 2)
            if self._contact(self.keys[k]).friction is not None and self._is_at_rest(k, rates)
        ]
        if not np.any(rates[held]):
            return rates
        stopped = -np.linalg.lstsq(G[np.ix_(held, held)], rates[held], rcond=None)[0]
        forces = np.zeros(len(rates))
        forces[held] = stopped
        self.u = self.u + self.instant.respond(self.keys, forces)
        rates = rates + G[:, held] @ stopped
        rates[held] = 0.0
        return rates

    def _is_crowded(self, key: Key, rate: float, acceleration: float) -> bool:
        """Return whether a point that has just separated returns so soon that its impacts cannot be resolved.

        Or before it has left the surface, in which it was found a little late.
        """
        e = self._contact(key).law.restitution
        if acceleration >= 0.0 or e == 1.0:
            return False
        flight, stays_in = 2.0 * rate / -acceleration, rate * rate <= 2.0 * acceleration * self.met[key].gap
        return stays_in or flight <= SHORT_FLIGHT * self.span or flight <= (1.0 - e) * CROWDED * self.span

    def _tell(self) -> None:
        """Record the reported events of each contact."""
        for c in sorted({key[0] for key in self.keys}):
            keys = [key for key in self.keys if key[0] == c]
            contact = self._contact(keys[0])
            was = [self.before[key] for key in keys]
            now = [contact.status(self._own(key))[key[1]] for key in keys]
            struck = {key for key, is_struck in zip(self.keys, self.struck, strict=True) if is_struck}
            if contact.reports_points:
                self._report_points(contact, keys, was, now)
            if any(
                key in struck or (key in self.concerned and self.kind == TOUCH and now[at] != OPEN)
                for at, key in enumerate(keys)
                if was[at] == OPEN
            ):
                self.happened.append((f"{contact.name} touch", self.t))
            if max(was) != OPEN and max(now) == OPEN:
                self.happened.append((f"{contact.name} lift", self.t))
            if contact.friction is None:
                continue
            slipped, slips = SLIPS in was, SLIPS in now
            if slips and not slipped and STICKS in was:
                self.happened.append((f"{contact.name} slip", self.t))
            if STICKS in now and not slips and (slipped or max(was) == OPEN):
                self.happened.append((f"{contact.name} stick", self.t))

    def _report_points(self, contact: RigidContact, keys: list[Key], was: list[int], now: list[int]) -> None:
        """Record the reported events of each point."""
        struck = dict(zip(self.keys, self.struck.tolist(), strict=True))
        self.points += [
            PointChange(contact.name, key[1], self.t, before, after, struck[key], contact.friction is not None)
            for key, before, after in zip(keys, was, now, strict=True)
            if before != after or (struck[key] and before == OPEN)
        ]
