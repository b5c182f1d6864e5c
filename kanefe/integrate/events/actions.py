"""What events do to the state of a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.equations.forces_at import seen
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.events.event import Event
from kanefe.integrate.events.load_events import EventOfLoad, torn_loose
from kanefe.integrate.events.switching import check_switched
from kanefe.tree.model_data import QUADRATURES


def acted(dynamics: Dynamics, events: Sequence[Event], happened: Sequence[Event], t: float, y: Vector) -> Vector:
    """Return the state after events that happened at a time (s), in their order, and what follows for all.

    Raises
    ------
    SimulationError
        If there is none.
    """
    asked = [event.asked for event in happened if isinstance(event, EventOfLoad) and event.asked]
    for event in (*happened, *asked):
        y = _after(dynamics, event, t, y)
    if any(event.action is not None for event in (*happened, *asked)):
        y = np.concatenate((torn_loose(dynamics.model, events, t, y[:-QUADRATURES]), y[-QUADRATURES:]))
    return y


def _after(dynamics: Dynamics, event: Event, t: float, y: Vector) -> Vector:
    """Return the state after an action, its loops closed, and the energy of the change taken into account."""
    model, size = dynamics.model, len(y) - QUADRATURES
    changed = event.changed(t, seen(model, t, y), y[:size])
    if changed is None:
        return y
    after = np.concatenate((changed, y[size:]))
    check_switched(model, t, y, after)
    after = dynamics.projected(t, after).copy()
    gained = model.energy(t, after[:size]).total - model.energy(t, y[:size]).total
    after[size if gained < 0.0 else size + 1] += abs(gained)
    return after
