"""Events of rigid contacts: they touch, lift, slip and stick, and the run goes on from what follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.events import Event, MarginEvent
from kanefe.kane.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.kane.rigid_contacts import Margins

FAR = 1.0
"""Value of a function that looks at nothing."""


@dataclass(frozen=True, eq=False)
class ContactChange(MarginEvent):
    """A moment at which a rigid contact of a scene touches, lifts, slips or sticks; not told itself.

    Attributes
    ----------
    model : ModelData
    kind : str
    span, stop : float
        Length and end of the run, s.
    rtol : float
        Of the run.
    happened : list of (str, float)
        What it has led to, for the run loop to take: names and times of events that are told.
    """

    model: ModelData = field(kw_only=True)
    kind: str = field(kw_only=True)
    span: float = field(kw_only=True)
    stop: float = field(kw_only=True)
    rtol: float = field(kw_only=True)
    happened: list[tuple[str, float]] = field(kw_only=True, default_factory=list)

    @property
    def acts(self) -> bool:
        """It changes states of contacts, and speeds."""
        return True

    def blur(self, t: float, state: SceneState) -> float:
        """Return the largest of the margins that are zero but for round-off: their signs what follows decides."""
        from kanefe.kane.rigid_contacts import blurs

        return max(_of_kind(self.kind, blurs(_literal(state))).values(), default=0.0)

    def changed(self, t: float, state: SceneState, y: Vector) -> Vector | None:
        """Return the state after what happens."""
        from kanefe.kane.impacts import resolved

        found = resolved(self.model, t, y, self.kind, self.span, self.stop, self.rtol)
        self.happened.extend(found.happened)
        return np.concatenate((y[: self.model.coordinate_count], found.u, found.z))


@dataclass(frozen=True, eq=False)
class ToldOfContact(Event):
    """What is told of a rigid contact; a `ContactChange` finds it."""

    @property
    def acts(self) -> bool:
        """It does nothing itself; where it ends the run, the run looks at what a `ContactChange` has led to."""
        return False


STEPS_OVER = "moreau-jean"
"""The method whose steps impacts do not end."""


def changes_of_contacts(model: ModelData, method: str, start: float, stop: float, rtol: float) -> tuple[Event, ...]:
    """Return the events that find what happens to rigid contacts; of scenes without them none."""
    if not model.rigid_contacts or method == STEPS_OVER:
        return ()
    from kanefe.kane.impacts import LIFT, SLIP, STICK, TOUCH

    return tuple(
        ContactChange(
            f"a rigid contact: {kind}",
            partial(_nearest, kind),
            -1,
            model=model,
            kind=kind,
            span=stop - start,
            stop=stop,
            rtol=rtol,
        )
        for kind in (TOUCH, LIFT, SLIP, STICK)
    )


def begun(events: Sequence[Event], t: float, y: Vector) -> Vector | None:
    """Return the state (q, u, z) of which a run begins, with the directions of slips that begin; None without."""
    from kanefe.kane.impacts import START, resolved

    for one in events:
        if isinstance(one, ContactChange):
            found = resolved(one.model, t, y, START, one.span, one.stop, one.rtol)
            return np.concatenate((y[: one.model.coordinate_count], found.u, found.z))
    return None


def told_of_contacts(model: ModelData, method: str) -> tuple[Event, ...]:
    """Return the events that are told of rigid contacts."""
    if method == STEPS_OVER:
        return ()
    contacts = (model.loads[load] for load in model.rigid_contacts)
    return tuple(ToldOfContact(f"{one.name} {what}", _never) for one in contacts for what in one.told)


def taken(events: Sequence[Event]) -> list[tuple[str, float]]:
    """Return what events of rigid contacts have led to, and forget it."""
    found: list[tuple[str, float]] = []
    for event in events:
        if isinstance(event, ContactChange):
            found += event.happened
            event.happened.clear()
    return found


def _never(t: float, state: SceneState) -> float:
    return FAR


def _nearest(kind: str, t: float, state: SceneState) -> float:
    from kanefe.kane.rigid_contacts import margins

    return min(_of_kind(kind, margins(_literal(state))).values(), default=FAR)


def _of_kind(kind: str, found: Margins) -> dict[tuple[int, int], float]:
    from kanefe.kane.impacts import LIFT, SLIP, STICK, TOUCH

    return {TOUCH: found.gaps, LIFT: found.normals, SLIP: found.reserves, STICK: found.slips}[kind]


def _literal(state: SceneState) -> State:
    if not isinstance(state, State):
        raise TypeError("scenes with rigid contacts are evaluated by the literal route")
    return state
