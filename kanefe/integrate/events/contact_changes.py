"""Events of rigid contacts: they touch, lift, slip and stick, and the run continues from the resulting state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.events.event import Event, MarginEvent
from kanefe.kernels.impacts.contact_questions import POINT_CODES, REPORTED, Asks, Reported
from kanefe.tree.scales import moving_length
from kanefe.tree.scene_state import SceneState
from kanefe.tree.told_impacts import ToldImpacts

if TYPE_CHECKING:
    from kanefe.tree.contact_changes import ContactDecider
    from kanefe.tree.point_changes import PointChange

FAR = 1.0
"""Value of an event function that is not evaluated."""

AT_ONCE = 1e-9
"""Time, as a fraction of the run, within which changes of a point count as one."""


class LastLook:
    """The margins of rigid contacts at the last moment that was looked at, and how far they may be below zero.

    Attributes
    ----------
    length : float
        Of what moves in the scene, m.
    """

    def __init__(self, model: Model) -> None:
        self._model, self.length = model, moving_length(model)
        self._last: dict[int, tuple[float, Vector, Any]] = {}

    def margins(self, t: float, state: SceneState) -> Vector:
        """Return the least margins at a time (s): of gaps, normal forces, friction left, and slips; or far."""
        least: Vector = self._at(Asks.MARGINS, t, state, lambda found: found.margins.min(axis=0, initial=np.inf))
        return np.where(least < np.inf, least, FAR)

    def blurs(self, t: float, state: SceneState) -> tuple[float, ...]:
        """Return how far they may be below zero at a time, s."""
        return self._at(Asks.BLURS, t, state, lambda found: found.blurs)  # type: ignore[no-any-return]

    def _at(self, what: int, t: float, state: SceneState, take: Callable[[ContactDecider], Any]) -> Any:
        y, last = state.vector, self._last.get(what)
        if last is None or last[0] != t or not np.array_equal(last[1], y):
            last = self._last[what] = t, y, take(self._model.route.asked_contacts(what, t, y))
        return last[2]


@dataclass(frozen=True, eq=False)
class ContactChange(MarginEvent):
    """A moment at which a rigid contact of a scene touches, lifts, slips or sticks; not reported itself.

    Attributes
    ----------
    model : Model
    kind : str
    span, stop : float
        Length and end of the run, s.
    rtol : float
        Of the run.
    look : LastLook
    reports : list of (float, int)
        What it has led to, for the run loop to take: times and codes of what is told.
    titles : list of str
        Of the contacts that the last one concerned.
    told : ToldImpacts
        What is to be told of impacts.
    """

    model: Model = field(kw_only=True)
    kind: str = field(kw_only=True)
    span: float = field(kw_only=True)
    stop: float = field(kw_only=True)
    rtol: float = field(kw_only=True)
    look: LastLook = field(kw_only=True)
    reports: list[tuple[float, int]] = field(kw_only=True, default_factory=list)
    titles: list[str] = field(kw_only=True, default_factory=list)
    told: ToldImpacts = field(kw_only=True, default_factory=ToldImpacts)

    @property
    def acts(self) -> bool:
        """It changes states of contacts, and speeds."""
        return True

    def blur(self, t: float, state: SceneState) -> float:
        """Return the largest of the margins that are zero but for round-off: their signs what follows decides."""
        return self.look.blurs(t, state)[list(CODES).index(self.kind)]

    def changed(self, t: float, state: SceneState, y: Vector) -> Vector | None:
        """Return the state after what happens."""
        code = CODES[self.kind]
        found = self.model.route.asked_contacts(code, t, y, self.span, self.stop, self.rtol).changed()
        self.reports.extend(found.reports)
        self.titles[:] = found.titles
        self.told.adding.extend(found.told.adding)
        return found.y


@dataclass(frozen=True, eq=False)
class ReportedContactEvent(Event):
    """A reported event of a rigid contact; a `ContactChange` locates it."""

    kind = "never"

    @property
    def acts(self) -> bool:
        """Return False: it does nothing itself; a run that it ends examines the results of a `ContactChange`."""
        return False


CODES = {"touch": Asks.TOUCH, "lift": Asks.LIFT, "slip": Asks.SLIP, "stick": Asks.STICK}
"""Questions to compiled code, by the kinds of events."""

STEPS_OVER = "moreau-jean"
"""Method whose steps do not end at impacts."""


def changes_of_contacts(model: Model, method: str, start: float, stop: float, rtol: float) -> tuple[Event, ...]:
    """Return the events that find what happens to rigid contacts; of scenes without them none."""
    if not model.rigid_contacts or method == STEPS_OVER:
        return ()
    look = LastLook(model)
    return tuple(
        ContactChange(
            f"a rigid contact: {kind}",
            partial(_nearest, kind, look),
            -1,
            model=model,
            kind=kind,
            span=stop - start,
            stop=stop,
            rtol=rtol,
            look=look,
        )
        for kind in CODES
    )


def begun(events: Sequence[Event], t: float, y: Vector) -> Vector | None:
    """Return the state (q, u, z) of which a run begins, with the directions of slips that begin; None without."""
    for one in events:
        if isinstance(one, ContactChange):
            return one.model.route.touched(t, y, one.span, one.stop, one.rtol)
    return None


def reported_contact_events(model: Model, method: str) -> tuple[Event, ...]:
    """Return the reported events of rigid contacts."""
    if method == STEPS_OVER:
        return ()
    contacts = (model.loads[load] for load in model.rigid_contacts)
    return tuple(ReportedContactEvent(f"{one.name} {what}", _never) for one in contacts for what in one.told)


class ChangeReports:
    """Results of the events of rigid contacts, as times of reported events.

    Forces that several points share are decided in steps: one that is let go and held again at one moment stayed.

    Parameters
    ----------
    times : dict of str to list of float
        Of what happened so far.
    span : float
        Of the run, s.

    Attributes
    ----------
    impacts : ToldImpacts
        What is to be told of impacts.
    """

    def __init__(self, times: dict[str, list[float]], span: float) -> None:
        self.impacts = ToldImpacts()
        self._times, self._moment = times, AT_ONCE * span
        self._last: dict[tuple[str, int], PointChange] = {}

    def take(self, events: Sequence[Event]) -> set[str]:
        """Add what events have led to, and forget it there; return its names."""
        names: set[str] = set()
        for event in events:
            if not isinstance(event, ContactChange):
                continue
            for t, code in event.reports:
                names.update(self.take_code(event.model, t, code))
            event.reports.clear()
            self.impacts.take(event.told)
            event.told.clear()
        return names

    def forget(self, events: Sequence[Event]) -> None:
        """Forget what events have led to that was not taken, as in a run that was broken off."""
        for event in events:
            if isinstance(event, ContactChange):
                event.reports.clear()
                event.told.clear()

    def take_code(self, model: Model, t: float, code: int) -> list[str]:
        """Add what is told: see `kanefe.kernels.impacts.contact_changes.change_contacts`; return names of events."""
        from kanefe.contact.rigid.rigid_contact import REPORTED_EVENTS

        contacts = model.rigid_contacts
        if code < REPORTED * len(contacts):
            name, what = model.rigid_contact(code // REPORTED).name, code % REPORTED
            if what == Reported.BY_POISSON:
                self.impacts.was_by_poisson([name], t)
            elif what == Reported.BY_ORDER:
                self.impacts.was_by_order([name], t)
            else:
                self._times[f"{name} {REPORTED_EVENTS[what]}"].append(t)
                return [f"{name} {REPORTED_EVENTS[what]}"]
            return []
        from kanefe.tree.point_changes import PointChange
        from kanefe.tree.rigid_points import points_of_contacts

        number, change = divmod(code - REPORTED * len(contacts), POINT_CODES)
        k, point = points_of_contacts(model)[number]
        before, after, is_struck = change // 6, change // 2 % 3, bool(change % 2)
        rubs = model.rigid_contact(k).friction is not None
        return self._told(PointChange(model.rigid_contact(k).name, point, t, before, after, is_struck, rubs))

    def _told(self, change: PointChange) -> list[str]:
        key = change.contact, change.point
        last = self._last.get(key)
        if last is not None and change.t - last.t <= self._moment:
            for name in last.names:
                self._times[name].pop()
            change = change._replace(before=last.before, is_struck=last.is_struck or change.is_struck)
        self._last[key] = change
        for name in change.names:
            self._times[name].append(change.t)
        return change.names


def _never(t: float, state: SceneState) -> float:
    return FAR


def _nearest(kind: str, look: LastLook, t: float, state: SceneState) -> float:
    return float(look.margins(t, state)[list(CODES).index(kind)])
