"""What a run has done with rigid contacts, checked at its output times: no law of theirs may be broken unseen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.integrate.events.contact_changes import STEPS_OVER
from kanefe.integrate.status import UNFIT, RunStatus
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.impacts.march import MARCHING, Told
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length

if TYPE_CHECKING:
    from kanefe.order_n.granular_contacts import GranularSteps
    from kanefe.tree.contact_steps import Stepped

SHARE = 0.05
"""Number of output times that are checked, relative to the number of evaluations of a run. The run itself monitors
these margins in each step."""

REMEDY_OF_STEPS = "a smaller step, or compliant contacts, kanefe.HuntCrossley(...)"

REMEDY = "a smaller rtol, or compliant contacts, kanefe.HuntCrossley(...)"


def of_contacts(
    model: Model, times: Vector, states: Matrix, method: str, evaluations: int, rtol: float | None
) -> RunStatus | None:
    """Return the status of a run in which a rigid contact breaks its law at an output time; None if none does.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (T,)
        s.
    states : ndarray, shape (T, state)
        (q, u, z, ...).
    method : str
        Of the run.
    evaluations : int
        Of the run.
    rtol : float or None
    """
    if not model.rigid_contacts or method == STEPS_OVER or not len(times):
        return None
    entered = max(MARCHING.beyond, UNFIT * (rtol or 0.0))
    rows = np.unique(np.linspace(0, len(times) - 1, min(len(times), 2 + int(SHARE * evaluations))).round().astype(int))
    if model.route.watching is not None and model.route.watching.contact_columns:
        columns = [model.route.watching.contact_columns[kind] for kind in ("touch", "lift", "slip", "largest")]
        gap, normal, slip, largest = model.route.watching.values(times[rows], states[rows])[:, columns].T
        static = min((model.rigid_contact(k).static for k in range(len(model.rigid_contacts))), default=0.0)
        is_broken = (gap < -entered * scene_length(model)) | (normal < -MARCHING.beyond * largest)
        # the others need not be looked at closely
        rows = rows[is_broken | (slip < -MARCHING.beyond * static * largest)]
    for i in rows.tolist():
        broken = _broken(model, float(times[i]), states[i], entered)
        if broken:
            return RunStatus("failed", float(times[i]), broken, REMEDY)
    return None


class StepsChecked:
    """Checks of steps over impacts: impulses within the friction cones, and gaps within the error of the steps.

    A step enters a surface that it has not met before by its way, and leaves one that is curved by half a second
    difference; from then on contacts hold speeds alone.

    Parameters
    ----------
    model : ModelData

    Attributes
    ----------
    told : ndarray, shape (5,)
        Of all steps so far: see `kanefe.kernels.impacts.march.Told`.
    too_deep : float
        Depth that is round-off, m.
    """

    def __init__(self, model: ModelData) -> None:
        self._model, self.told = model, np.zeros(Told.number_count)
        self.too_deep = MARCHING.beyond * scene_length(model)
        self._so_far = Told(self.told)

    @property
    def counted(self) -> dict[str, int | float]:
        """What steps have told, by its names in the statistics of a run."""
        told = self._so_far
        counts: dict[str, int | float] = {
            "penetration": float(told.deepest),
            "contact_residual": float(told.residual),
        }
        return counts | ({"restitution_lowered": int(told.lowered)} if told.lowered else {})

    def check(self, found: Stepped) -> None:
        """Raise a StepFailure if a step breaks a law of a contact."""
        if not found.closed:
            return
        told = self._so_far
        approach, bend = max(float(told.approach), found.approach), float(told.bend) + found.bend
        pushes = found.impulses.reshape(-1, 3)
        largest = float(np.abs(pushes[:, 0]).max())
        for (number, _), push in zip(found.closed, pushes, strict=True):
            contact = self._model.rigid_contact(number)
            asked, held = float(np.hypot(push[1], push[2])), contact.static * float(push[0])
            if push[0] < -MARCHING.beyond * largest:
                raise StepFailure(f"{contact.title} has a tensile impulse of {-push[0]:.4g} N s", REMEDY_OF_STEPS)
            if asked > held + max(MARCHING.beyond * contact.static, ROUND_OFF_OF_FORCES) * largest:
                raise StepFailure(
                    f"the impulse of friction of {contact.title} is {asked:.6g} N s, more than mu N = {held:.6g} N s",
                    REMEDY_OF_STEPS,
                )
        if found.deepest > self.too_deep + MARCHING.doubly * (approach + bend):
            names = ", ".join(sorted({self._model.rigid_contact(number).title for number, _ in found.closed}))
            raise StepFailure(
                f"{names}: penetrated by {found.deepest:.3g} m, more than the error of steps", REMEDY_OF_STEPS
            )
        told.deepest, told.residual = max(told.deepest, found.deepest), max(told.residual, found.residual)
        told.approach, told.bend, told.lowered = approach, bend, told.lowered + found.lowered

    def check_granular(self, granular: GranularSteps) -> None:
        """Raise a StepFailure if impulses among many are none that contacts can have, or one ball is within another."""
        title, mu = f"contacts {self._model.granular.name!r}" if self._model.granular else "", granular.friction
        pushes = granular.impulses
        largest = float(np.abs(pushes).max(initial=0.0))
        beyond = np.hypot(pushes[:, 1], pushes[:, 2]) - mu * pushes[:, 0]
        for worst, what in ((-pushes[:, 0], "are tensile by"), (beyond, "have friction beyond mu N by")):
            if (most := float(worst.max(initial=0.0))) > MARCHING.beyond * largest:
                raise StepFailure(f"impulses of {title} {what} {most:.4g} N s", REMEDY_OF_STEPS)
        if granular.deepest > granular.smallest:
            raise StepFailure(
                f"{title}: penetrated by {granular.deepest:.3g} m, more than the radius of the smallest ball",
                REMEDY_OF_STEPS,
            )
        told = self._so_far
        told.deepest, told.residual, told.lowered = granular.deepest, granular.residual, granular.lowered


def _broken(model: ModelData, t: float, y: Vector, entered: float) -> str:
    """Return which law a contact breaks at a state; empty if none does."""
    from kanefe.contact.rigid.rigid_contact import STICKS
    from kanefe.literal.contact_forces import margins, probe_forces
    from kanefe.states.constraints import meetings
    from kanefe.states.state import State

    size = model.coordinate_count + model.free_count + model.state_count
    state = State(model, t, *model.parts(y[:size]))
    for number, i in margins(state).gaps:
        gap = meetings(state)[number][i].gap  # also of one that left from as deep
        if gap < -entered * scene_length(model):
            return f"{model.rigid_contact(number).title} is penetrated by {-gap:.3g} m"
    forces = probe_forces(state)
    largest = max((abs(force.normal) for force in forces), default=0.0)
    for force in forces:
        contact = model.rigid_contact(force.contact)
        if force.normal < -MARCHING.beyond * largest:
            return f"{contact.title} is in tension by {-force.normal:.4g} N"
        asked, held = float(np.linalg.norm(force.friction)), contact.static * force.normal
        if (
            force.status == STICKS
            and contact.friction is not None
            and asked > held + MARCHING.beyond * contact.static * largest
        ):
            return f"friction of {contact.title} holds {asked:.6g} N, more than mu N = {held:.6g} N"
    return ""
