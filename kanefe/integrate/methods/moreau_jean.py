"""Time stepping of Moreau and Jean: steps that impacts do not end, for scenes of many rigid contacts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.method import Method
from kanefe.integrate.methods.python_stepper import PythonStepper
from kanefe.tree.bending import Bent

if TYPE_CHECKING:
    from kanefe.integrate.stepper import StepControl


AT_NO_OUTPUT = np.array([np.inf])
"""Time of an output that no step passes, s."""


class MoreauJeanStepper(PythonStepper):
    """Steps of Moreau and Jean in the middle of a run: see `kanefe.literal.impact_steps`.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        Its step.
    name : str
        Of the method.
    """

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> None:
        from kanefe.integrate.run_checks.bending_check import bends_in_kernels, watched_bodies
        from kanefe.integrate.run_checks.contact_check import StepsChecked
        from kanefe.order_n.granular_contacts import GranularSteps

        super().__init__(name, dynamics)
        self._step, self._stop = float(control.step or 0.0), stop
        self._in_python = 0
        model = dynamics.model
        few = model.granular is None
        self._granular = None if few else GranularSteps(model)
        self._checked = StepsChecked(model)
        self._bodies, told = watched_bodies(model), (self._checked.told, self._checked.too_deep)
        self._bending = bends_in_kernels(self._bodies, 0)
        self._compiled = model.route.impact_steps(*told, self._bending) if few else None
        self.restart(start, dynamics.initial_state(start))

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state."""
        self._t = self._t_old = t
        self._y = self._y_old = y.copy()
        if self._granular is not None:
            self._granular.forget()

    @property
    def bent(self) -> list[Bent]:
        """Where each flexible body was bent the most."""
        if self._compiled is None:
            return super().bent
        from kanefe.integrate.run_checks.bending_check import bends_of_kernels

        return bends_of_kernels(self._bodies, *self._bending)

    def state(self) -> Vector:
        """Return the state at t."""
        return self._y.copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step: places on the line between its ends.

        Speeds and what else jumps in a step are those of the nearer end.
        """
        if self._t == self._t_old:
            return np.tile(self._y, (len(times), 1))
        share = ((times - self._t_old) / (self._t - self._t_old))[:, None]
        found = np.where(share > 0.5, self._y, self._y_old)
        n = self._dynamics.model.coordinate_count
        found[:, :n] = (1.0 - share) * self._y_old[:n] + share * self._y[:n]
        return found

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return copies of all that is needed to continue."""
        counts = np.array((self._steps, self._dynamics.evaluations, self._in_python))
        kept = {"t": np.array(self._t), "y": self._y.copy(), "counts": counts, "told": self._checked.told.copy()}
        if self._granular is not None:
            kept |= {f"crowd {name}": array for name, array in self._granular.memory().items()}
        return kept | {"bending": self._bending[1].copy()} | self._bends.snapshot()

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self.restart(float(snapshot["t"]), snapshot["y"])
        self._steps, self._dynamics.evaluations, self._in_python = (int(count) for count in snapshot["counts"])
        self._checked.told[:] = snapshot["told"]
        self._bending[1][:] = snapshot["bending"]
        self._bends.resume(snapshot)
        if self._granular is not None:
            kept = {name.removeprefix("crowd "): array for name, array in snapshot.items() if name.startswith("crowd ")}
            self._granular.recall(kept)

    def _counted(self) -> dict[str, int | float]:
        told = self._checked.counted
        if self._in_python:
            told["steps_in_python"] = self._in_python
        if self._granular is not None:
            told |= {"contacts_of_steps": self._granular.contacts, "sweeps": self._granular.sweeps}
        return told

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Continue until all times or so many steps are passed, in compiled code as far as that has them."""
        if self._granular is None and self._compiled is None:
            return super().integrate_through(times, states, most_steps)
        passed = 0
        while passed < len(times) and most_steps > 0:
            before = self._steps
            if self._granular is None:
                passed += self._march(times[passed:], states[passed:], most_steps)
            else:
                from kanefe.kernels.impacts.march import MARCHING

                whole = int((float(times[passed]) - self._t) / self._step * (1.0 - MARCHING.round_off))
                self._pass_whole(min(whole, most_steps - 1))
            most_steps -= self._steps - before
            if passed < len(times) and most_steps > 0:
                passed += super().integrate_through(times[passed : passed + 1], states[passed:], 1)
                most_steps -= 1
        return passed

    def _pass_whole(self, count: int) -> None:
        """Take steps with a crowd, none of which is an output's."""
        if self._granular is None or count <= 0:
            return
        self._y = self._granular.go_on(self._y, self._step, count)
        self._checked.check_granular(self._granular)
        self._t += count * self._step
        self._steps += count
        self._dynamics.evaluations += count

    def _march(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        """Take compiled steps until one that is left to the literal equations; return how many times were passed."""
        compiled = self._compiled
        if compiled is None:
            return 0
        from kanefe.kernels.impacts.march import Ending

        ended, count, passed = compiled.go_on(self._t, self._y, self._step, self._stop, most_steps, times, states)
        if count:
            self._t_old, self._y_old, self._t, self._y = compiled.last
            self._steps += count
            self._dynamics.evaluations += 2 * count
        if ended == Ending.BROKEN:
            self._checked.check(compiled.tried)
        return int(passed)

    def _advance(self, target: float) -> None:
        """Take a step; the last one ends where the run does."""
        before = self._steps
        self._march(AT_NO_OUTPUT, self._y[None], 1)
        if self._steps == before:
            self._advance_in_python()

    def _advance_in_python(self) -> None:
        """Take a step by the literal equations, or one with a crowd."""
        from kanefe.kernels.impacts.march import MARCHING

        t, y = self._t, self._y
        left = self._stop - t
        h = left if left <= self._step * (1.0 + MARCHING.round_off) else self._step
        if self._granular is not None:
            after = self._granular.go_on(y, h, 1)
            self._dynamics.evaluations += 1
            self._checked.check_granular(self._granular)
        else:
            found = self._dynamics.model.literal.step_over_impacts(t, y, h)
            self._dynamics.evaluations += 2
            self._in_python += 1
            self._checked.check(found)
            after = found.y
        self._t_old, self._y_old = t, y
        self._t, self._y = self._stop if h == left else t + h, after
        self._steps += 1


def _serves(model: Model) -> str:
    """Return why it cannot run a model, with a remedy."""
    if model.granular is not None:
        from kanefe.order_n.granular_contacts import lacking

        if lack := lacking(model):
            return f"takes loose bodies with {model.granular.name!r}, and no {lack}. Remedy: add_contact for each pair"
        return ""
    if not model.rigid_contacts:
        return "steps over the impacts of rigid contacts, of which the scene has none. Remedy: 'auto'"
    for number in range(len(model.rigid_contacts)):
        contact = model.rigid_contact(number)
        if (law := contact.law.impact) in ("poisson", "distributing"):
            return f"has Newton's impact law only, and {contact.title} {law!r}. Remedy: leave impact out, or 'auto'"
        if contact.friction is not None and contact.friction.has_memory:
            return f"has one coefficient of friction, and {contact.title} two. Remedy: leave out static, or 'auto'"
    if model.states_move and any(load.has_rates for i, load in enumerate(model.loads) if i not in model.rigid_contacts):
        return "does not integrate internal states of loads. Remedy: 'auto'"
    return ""


METHOD = Method(
    name="moreau-jean",
    about="steps over impacts: for scenes with many rigid contacts",
    stepper=MoreauJeanStepper,
    order=1,
    has_error_control=False,
    has_fixed_steps=True,
    steps_over_impacts=True,
    serves=_serves,
)
