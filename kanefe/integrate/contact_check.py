"""What a run has done with rigid contacts, checked at its output times: no law of theirs may be broken unseen."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.integrate.contact_changes import STEPS_OVER
from kanefe.integrate.status import UNFIT, RunStatus
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length

BEYOND = 1e-6
"""Share of what friction holds, of the largest normal force and of the scene's length: what is broken by more is an
error of the run."""

SHARE = 0.05
"""Of the evaluations of a run: output times that are checked. The run itself watches the same margins in each step."""

REMEDY = "a smaller rtol, or contacts that yield, kanefe.HuntCrossley(...)"


def of_contacts(
    model: ModelData, times: Vector, states: Matrix, method: str, evaluations: int, rtol: float | None
) -> RunStatus | None:
    """Return the status of a run in which a rigid contact breaks its law at an output time; None if none does.

    Parameters
    ----------
    model : ModelData
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
    rows = np.unique(np.linspace(0, len(times) - 1, min(len(times), 2 + int(SHARE * evaluations))).round().astype(int))
    for i in rows.tolist():
        broken = _broken(model, float(times[i]), states[i], max(BEYOND, UNFIT * (rtol or 0.0)))
        if broken:
            return RunStatus("failed", float(times[i]), broken, REMEDY)
    return None


def _broken(model: ModelData, t: float, y: Vector, entered: float) -> str:
    """Return which law a contact breaks at a state; empty if none does."""
    from kanefe.contact.rigid_contact import STICKS
    from kanefe.kane.rigid_contacts import margins, probe_forces
    from kanefe.kane.state import State

    size = model.coordinate_count + model.free_count + model.state_count
    state = State(model, t, *model.parts(y[:size]))
    for (number, _), gap in margins(state).gaps.items():
        if gap < -entered * scene_length(model):
            return f"{model.rigid_contact(number).title} is entered by {-gap:.3g} m"
    forces = probe_forces(state)
    largest = max((abs(force.normal) for force in forces), default=0.0)
    for force in forces:
        contact = model.rigid_contact(force.contact)
        if force.normal < -BEYOND * largest:
            return f"{contact.title} pulls with {-force.normal:.4g} N"
        asked, held = float(np.linalg.norm(force.friction)), contact.static * force.normal
        if force.status == STICKS and contact.friction is not None and asked > held + BEYOND * contact.static * largest:
            return f"friction of {contact.title} holds {asked:.6g} N, more than mu N = {held:.6g} N"
    return ""
