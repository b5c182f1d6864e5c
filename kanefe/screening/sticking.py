"""A scene on its carrier, and the same scene with everything sticking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.integrate.events.load_events import EventOfLoad, events_of_loads
from kanefe.loads.base import Load
from kanefe.loads.screened import screening_of
from kanefe.screening.carrier import Carrier
from kanefe.screening.riders import Riders

STICKY = 1e6
"""Factor on friction with which everything sticks under any force."""


class Sticking:
    """A scene on its carrier, and the same scene with everything sticking.

    Parameters
    ----------
    model : Model
        The model at its start.

    Raises
    ------
    ModelError
        If the scene has parts that cannot be screened.
    """

    def __init__(self, model: Model) -> None:
        _check(model)
        self.model = model
        self.carrier = Carrier(model)
        self.riders = Riders(model, self.carrier)
        self.held = replace(model, loads=tuple(_stuck(load) for load in model.loads))
        self.held_at_rest = self.carrier.stilled(self.held)
        self.at_rest = self.carrier.stilled(model)
        screened = [screening_of(load) for load in model.loads]
        self.ropes = [number for number, said in enumerate(screened) if said.pull]
        self.strongest = [screened[i].strongest for i in self.ropes]
        self._pulls = [model.loads[i].columns.index(screened[i].pull) for i in self.ropes]
        watching = model.route.watching
        columns = {} if watching is None else watching.columns
        self.events = []
        for event in events_of_loads(model, keeps_steps=False):
            if isinstance(event, EventOfLoad) and event.number in columns:
                self.events.append(event)
            elif not isinstance(event, EventOfLoad) or event.number not in self.ropes:
                raise ModelError(
                    f"event {event.name!r} is evaluated in Python, which a screened run does not support. "
                    "Remedy: a kernel with watch= (kanefe.LoadKernel), or kf.System.simulate"
                )
        self._columns = [columns[event.number].start + event.index for event in self.events]
        self.names = (*(event.name for event in self.events), *(f"{model.loads[i].name} pull" for i in self.ropes))

    def rates(self, times: Vector, states: Matrix) -> Matrix:
        """Return the rates of states (T, n) with everything sticking."""
        route, size = self.held.route, states.shape[1]
        if (sweeps := route.sweeps(times, states)) is not None:
            return np.asarray(sweeps.rates[:, :size])
        return np.array([route.evaluate(t, y).rates[:size] for t, y in zip(times.tolist(), states, strict=True)])

    def watched(self, model: Model, times: Vector, states: Matrix) -> np.ndarray:
        """Return the event functions at states (T, n) of a model with the same events, (T, events)."""
        watching = model.route.watching
        if watching is None:
            return np.zeros((len(times), 0))
        return np.asarray(watching.values(times, states)[:, self._columns])

    def tensions(self, model: Model, times: Vector, states: Matrix) -> np.ndarray:
        """Return the tensions of ropes, N, (T, ropes)."""
        if not self.ropes:
            return np.zeros((len(times), 0))
        found = []
        for t, y in zip(times.tolist(), states, strict=True):
            scene = model.route.state(t, y)
            pulls = []
            for i, pull in zip(self.ropes, self._pulls, strict=True):
                load = self.model.loads[i]
                outputs = load.tell(t, scene.load_ends(i), scene.load_states(i))
                pulls.append(float(outputs[pull]))
            found.append(pulls)
        return np.array(found)


def _stuck(load: Load) -> Load:
    """Return a load with everything sticking."""
    stuck = screening_of(load).stuck
    return load if stuck is None else stuck(STICKY)  # type: ignore[no-any-return]


def _check(model: Model) -> None:
    """Raise a ModelError if the scene has parts that screened runs do not support."""
    found = ""
    if model.constraints:
        found = "loops and couplers"
    elif model.rigid_contacts:
        found = "rigid contacts"
    elif model.controllers:
        found = "controllers"
    elif model.has_unreduced:
        found = "unreduced bodies"
    for load in model.loads:
        if what := screening_of(load).refused:
            found = f"{what}, as of {load.kind} {load.name!r}"
    if found:
        raise ModelError(f"screened runs are not supported for scenes with {found}. Remedy: kf.System.simulate")
