"""Changes of rigid contacts in a run: the calls of the kernels that decide them, and that tell what they take."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.filling import fill_nothing
from kanefe.kernels.compiler.python_calls import PythonCall
from kanefe.kernels.evaluation.momenta import Balance
from kanefe.kernels.events.watched_run import ContactCalls
from kanefe.kernels.impacts.contact_changes import change_contacts
from kanefe.kernels.impacts.contact_questions import inquiry_of
from kanefe.kernels.impacts.decision import Asked, Decision, Look, decision_of
from kanefe.kernels.impacts.moments import ContactScene, look_at_points
from kanefe.kernels.loads.telling import States
from kanefe.kernels.sweeps.drives import Drives, Piece
from kanefe.order_n.contact_watching import ContactLook
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.contact_changes import ContactDecider, asking_of

NO_DRIVES = Drives(np.zeros((0, 2), dtype=np.int64), np.zeros((0, Piece.number_count)), np.zeros((0, 2)), fill_nothing)
"""Motions that are not written in compiled code."""


def contact_calls(route: Evaluated, motions: Drives, held: np.ndarray, y: Vector) -> ContactCalls:
    """Return the calls that change a state in a run.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    motions : Drives
    held : ndarray
        Values of loads, those written that do not change in the run.
    y : ndarray
        The state.
    """
    look, size, driven = ContactLook(route), len(y), len(route.model.drives)
    points = len(route.loops.points.places)
    inquiry, decision = inquiry_of(points), decision_of(points, route.model.free_count, look.vectors.shape[1])
    looking = look_at_points.bound(_scene_of(route, look, motions, route.fill, held), decision, y).prepared()
    asking = asking_of(route.loops.points, looking, decision, look.looked.first_state)
    changing = change_contacts.bound(asking, decision, inquiry, y).prepared()
    states = States(np.zeros(2), np.zeros((2, driven, 3)), np.zeros((2, len(held))), np.zeros((2, size)))
    balances = np.zeros((2, Balance.number_count))
    balancing = route.balances.prepared(states, balances, np.zeros(route.memory_size))
    return ContactCalls(changing.for_kernels(), inquiry, balancing.for_kernels(), states, balances)


def _scene_of(route: Evaluated, look: ContactLook, motions: Drives, fill: Any, held: np.ndarray) -> ContactScene:
    return ContactScene(look.looked, route.loops, route.tables, route.flexible, motions, fill, held)


def decider_of(route: Evaluated) -> ContactDecider:
    """Return what decides events of rigid contacts that are asked for from Python."""
    look, model = ContactLook(route), route.model

    def looking(decision: Decision, y: Vector) -> PythonCall:
        held = route.inputs.constants.copy()
        motions = cast(Drives, route.motion_tables) if route.is_autonomous else NO_DRIVES
        fill = route.fill if route.is_autonomous else fill_nothing
        call = look_at_points.bound(_scene_of(route, look, motions, fill, held), decision, y).prepared()

        def look_at_state() -> None:
            if route.is_autonomous:
                held[:] = route.inputs.begun(route.parts(y)[2])
            else:
                asked, n, at = Asked(decision.asked, decision.when), model.coordinate_count, y
                if asked.look == Look.POINTS_LATER:
                    decision.state[:n], at = model.advance(y[:n], decision.motion[1]), decision.state[: len(y)]
                look.drives[:], held[:] = route.drives(asked.t), route.values(asked.t, at)
            call()

        return PythonCall(look_at_state)

    return ContactDecider(model, route.loops.points, looking, look.vectors.shape[1])
