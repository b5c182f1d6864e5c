"""Events of rigid contacts: they touch, lift, slip and stick, and the run goes on from what follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.events import Event
from kanefe.kane.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length
from kanefe.tree.scene_state import SceneState

TOLD = "touch", "lift", "slip", "stick", "rest"
"""What a result tells of a rigid contact, after its name."""

ROUND_OFF = 1e-14
"""Of the scene's length: gaps that have no sign. The lowest bounces that are followed are a hundred times as high."""

FAR = 1.0
"""Value of a function that looks at nothing."""


@dataclass(frozen=True, eq=False)
class ContactChange(Event):
    """A moment at which a rigid contact of a scene touches, lifts, slips or sticks; not told itself.

    Attributes
    ----------
    model : ModelData
    kind : str
    span : float
        Of the run, s.
    happened : list of (str, float)
        What it has led to, for the run loop to take: names and times of events that are told.
    """

    model: ModelData = field(kw_only=True)
    kind: str = field(kw_only=True)
    span: float = field(kw_only=True)
    happened: list[tuple[str, float]] = field(kw_only=True, default_factory=list)

    @property
    def acts(self) -> bool:
        """It changes states of contacts, and speeds."""
        return True

    @property
    def blur(self) -> float:
        """What has just lifted has neither speed nor acceleration along the normal: its gap is round-off at first."""
        from kanefe.kane.impacts import TOUCH

        return ROUND_OFF * scene_length(self.model) if self.kind == TOUCH else 0.0

    def changed(self, t: float, state: SceneState, y: Vector) -> Vector | None:
        """Return the state after what happens."""
        from kanefe.kane.impacts import resolved

        found = resolved(self.model, t, y, self.kind, self.span)
        self.happened.extend(found.happened)
        return np.concatenate((y[: self.model.coordinate_count], found.u, found.z))


@dataclass(frozen=True, eq=False)
class ToldOfContact(Event):
    """What is told of a rigid contact; a `ContactChange` finds it."""

    @property
    def acts(self) -> bool:
        """It does nothing itself."""
        return False


STEPS_OVER = "moreau-jean"
"""The method whose steps impacts do not end."""


def changes_of_contacts(model: ModelData, method: str, span: float) -> tuple[Event, ...]:
    """Return the events that find what happens to rigid contacts; of scenes without them none."""
    if not model.rigid_contacts or method == STEPS_OVER:
        return ()
    from kanefe.kane.impacts import LIFT, SLIP, STICK, TOUCH

    return tuple(
        ContactChange(f"a rigid contact: {kind}", partial(_nearest, kind), -1, model=model, kind=kind, span=span)
        for kind in (TOUCH, LIFT, SLIP, STICK)
    )


def told_of_contacts(model: ModelData, method: str) -> tuple[Event, ...]:
    """Return the events that are told of rigid contacts."""
    if method == STEPS_OVER:
        return ()
    names = (model.loads[load].name for load in model.rigid_contacts)
    return tuple(ToldOfContact(f"{name} {what}", _never) for name in names for what in TOLD)


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
    from kanefe.kane.impacts import LIFT, SLIP, STICK, TOUCH
    from kanefe.kane.rigid_contacts import margins

    if not isinstance(state, State):
        raise TypeError("scenes with rigid contacts are evaluated by the literal route")
    found = margins(state)
    values = {TOUCH: found.gaps, LIFT: found.normals, SLIP: found.reserves, STICK: found.slips}[kind]
    return min(values.values(), default=FAR)
