"""Changes of rigid contacts in a run: the calls of the kernels that decide them, and that tell what they take."""

from __future__ import annotations

from typing import cast

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.entries import Call
from kanefe.kernels.evaluation.momenta import BALANCE_NUMBERS
from kanefe.kernels.events.watched_run import ContactCalls
from kanefe.kernels.impacts.cones import solve_one
from kanefe.kernels.impacts.contact_changes import change_contacts
from kanefe.kernels.impacts.contact_questions import (
    ASKED,
    BY_ORDER,
    BY_POISSON,
    IS_DECIDED,
    REPORT_COUNT,
    REPORTED,
    report_count,
)
from kanefe.kernels.impacts.decision import Asking, decision_of
from kanefe.kernels.impacts.moments import look_at_points
from kanefe.kernels.sweeps.drives import Drives
from kanefe.order_n.contact_watching import ContactLook
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.told_impacts import ToldImpacts


def contact_calls(route: Evaluated, motions: Drives, held: np.ndarray, y: Vector) -> tuple[ContactCalls, Call]:
    """Return the calls that change a state, and the first of them alone.

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
    asked, reports = np.zeros(ASKED), np.zeros((report_count(points), 2))
    scene = look.looked, route.loops, route.tables, route.flexible, motions, route.fill, held
    decision = decision_of(points, route.model.free_count, look.vectors.shape[1])
    looking = look_at_points.bound(*scene, decision, y).prepared()
    wanted = np.zeros(5)
    solving = solve_one.bound(decision.problem, decision.ahead, decision.vectors, wanted).prepared()
    calls = looking.for_kernels(), solving.for_kernels()
    asking = Asking(route.loops.points, *calls, wanted, look.looked.first_state)
    changing = change_contacts.bound(asking, decision, asked, y, reports).prepared()
    times, drives, inputs = np.zeros(2), np.zeros((2, driven, 3)), np.zeros((2, len(held)))
    arrays = times, drives, inputs, np.zeros((2, size)), np.zeros((2, BALANCE_NUMBERS))
    balancing = route.balances.prepared(*arrays, np.zeros(route.memory_size))
    return ContactCalls(changing.for_kernels(), asked, reports, balancing.for_kernels(), *arrays), changing


class ContactChanger:
    """Events of rigid contacts asked from Python: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.

    Attributes
    ----------
    y : ndarray
        The state, which is changed.
    asked, reports : ndarray
        See `kanefe.kernels.impacts.contact_changes.change_contacts`.
    """

    def __init__(self, route: Evaluated) -> None:
        self._route, model = route, route.model
        self.y = np.zeros(model.coordinate_count + model.free_count + model.state_count)
        self._held = route.inputs.constants.copy()
        motions = cast(Drives, route.motion_tables)
        calls, self._changing = contact_calls(route, motions, self._held, self.y)
        self.asked, self.reports = calls.asked, calls.reports

    def ask(self, what: int, t: float, y: Vector, span: float, stop: float, rtol: float, length: float) -> bool:
        """Ask for what follows an event at a state (q, u, z), or for blurs; return whether that is decided."""
        self.y[:], self._held[:] = y, self._route.inputs.begun(self._route.parts(y)[2])
        self.asked[:] = 0.0
        self.asked[:REPORT_COUNT] = what, t, span, stop, rtol, length
        self._changing()
        return bool(self.asked[IS_DECIDED])

    def told(self, t: float) -> ToldImpacts:
        """Return what is to be told of the impacts of the last change, at its time, s."""
        model, found = self._route.model, ToldImpacts()
        for code in self.reports[: int(self.asked[REPORT_COUNT]), 1].astype(int).tolist():
            contact, what = divmod(code, REPORTED)
            if contact < len(model.rigid_contacts) and what in (BY_POISSON, BY_ORDER):
                note = found.was_by_poisson if what == BY_POISSON else found.was_by_order
                note([model.rigid_contact(contact).name], t)
        return found
