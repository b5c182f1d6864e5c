"""What happens to rigid contacts at an event, decided by kernels that ask a route about the scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import Call
from kanefe.kernels.compiler.python_calls import PythonCall
from kanefe.kernels.impacts.cones import Cones, solve_one
from kanefe.kernels.impacts.contact_changes import change_contacts
from kanefe.kernels.impacts.contact_questions import (
    REPORTED,
    Asks,
    Reported,
    Reports,
    WhyNot,
    inquiry_of,
    question_of,
)
from kanefe.kernels.impacts.decision import Asked, Asking, Decision, Look, Status, decision_of, points_of
from kanefe.kernels.tables import RigidPoints
from kanefe.tree.model_data import ModelData
from kanefe.tree.rigid_points import points_of_contacts, rigid_points
from kanefe.tree.scales import moving_length
from kanefe.tree.told_impacts import ToldImpacts

Looking = Call | PythonCall


class Changed(NamedTuple):
    """What an event leads to.

    Attributes
    ----------
    y : ndarray
        State (q, u, z) after it.
    reports : list of (float, int)
        Times (s) and codes of what is told: see `kanefe.kernels.impacts.contact_changes.change_contacts`.
    titles : list of str
        Of the contacts that the event concerns.
    told : ToldImpacts
        What is to be told of its impact.
    """

    y: Vector
    reports: list[tuple[float, int]]
    titles: list[str]
    told: ToldImpacts


class Responses(NamedTuple):
    """What unit forces at k points of rigid contacts do, and how these move.

    Attributes
    ----------
    G, b : ndarray, shapes (3 k, 3 k), (3 k,)
        Accelerations of the points along the normal and both directions of the surface by the forces, and without any.
    speeds : ndarray, shape (3 k, free)
        Accelerations of the free speeds by the forces.
    sizes, accelerated : ndarray, shape (k,)
        Sums of the speeds (m/s) and accelerations (m/s2) that a point has by each of the speeds of the scene.
    """

    G: Matrix
    b: Vector
    speeds: Matrix
    sizes: Vector
    accelerated: Vector


class ContactInstant(Protocol):
    """What events of rigid contacts ask of a state."""

    def statuses(self) -> Sequence[int]: ...  # noqa: D102
    def margins(self) -> Matrix: ...  # noqa: D102
    def meetings(self) -> Matrix: ...  # noqa: D102
    def accelerations(self) -> Vector: ...  # noqa: D102
    def responses(self, points: Sequence[int]) -> Responses: ...  # noqa: D102


def decider_by(model: ModelData, at: Callable[[ModelData, float, Vector], ContactInstant]) -> ContactDecider:
    """Return what decides events by answers of Python about states."""
    return ContactDecider(model, rigid_points(model), lambda *place: PythonCall(partial(_look, model, at, *place)))


def _look(
    model: ModelData, at: Callable[[ModelData, float, Vector], ContactInstant], decision: Decision, y: Vector
) -> None:
    """Write to a decision what it asks of a state, or of one a little later."""
    asked, n = Asked(decision.asked, decision.when), model.coordinate_count
    if asked.look == Look.POINTS_LATER:
        decision.state[:n] = model.advance(y[:n], decision.motion[1])
        y = decision.state
    instant = at(model, asked.t, y)
    if asked.look == Look.MARGINS:
        decision.now.met[:, :-3] = instant.meetings()
        for point, status, row in zip(points_of(decision), instant.statuses(), instant.margins(), strict=True):
            point.before = Status(status)
            point.gap, point.normal, point.slip_margin, point.left_of_slip = row
    elif asked.look == Look.FREE_ACCELERATIONS:
        decision.motion[0] = instant.accelerations()
    else:
        moment = decision.now if asked.look == Look.POINTS else decision.later
        points = decision.taking[: asked.taking]
        found, rows = instant.responses(points.tolist()), (3 * points[:, None] + np.arange(3)).ravel()
        moment.met[:, :-3] = instant.meetings()
        moment.G[np.ix_(rows, rows)], moment.b[rows], moment.responses[rows] = found.G, found.b, found.speeds
        moment.sizes[points], moment.accelerated[points] = found.sizes, found.accelerated
    asked.is_known = True


def touched(route: AsksContacts, t: float, y: Vector, span: float, stop: float, rtol: float) -> Vector:
    """Return a state with what touches in it known, after impacts, as a run begins."""
    found = route.asked_contacts(Asks.START, t, y, span, stop, rtol).changed()
    found.told.warn()
    route.warns_at_start = route.warns_at_start or bool(found.told.warnings)
    return found.y


class AsksContacts(Protocol):
    """A route that has events of rigid contacts decided; `warns_at_start`: impacts at a start were warned of."""

    warns_at_start: bool

    def asked_contacts(  # noqa: D102
        self, what: int, t: float, y: Vector, span: float = ..., stop: float = ..., rtol: float = ...
    ) -> ContactDecider: ...


def asking_of(points: RigidPoints, look: Looking, decision: Decision, first_state: int) -> Asking:
    """Return whom a decision asks.

    Parameters
    ----------
    points : RigidPoints
    look : Call or PythonCall
        That writes to the decision what is asked of the scene.
    decision : Decision
    first_state : int
        Where in a state the internal states begin.
    """
    solving = [solve_one.bound(problem).prepared().for_kernels() for problem in (decision.problem, decision.ahead)]
    return Asking(points, look.for_kernels(), solving[0], solving[1], first_state)


class ContactDecider:
    """Events of rigid contacts of a scene: of one thread at a time.

    Parameters
    ----------
    model : ModelData
    points : RigidPoints
    look : function (Decision, y) -> Call or PythonCall
        Gives the call that writes to a decision what is asked of the scene at a state (q, u, z).
    size : int, optional
        Of the states a little later that it is asked about; default: that of (q, u, z).

    Attributes
    ----------
    y : ndarray
        The state, which is changed.
    """

    def __init__(
        self, model: ModelData, points: RigidPoints, look: Callable[[Decision, Vector], Looking], size: int = 0
    ) -> None:
        self._model, first = model, model.coordinate_count + model.free_count
        self.y = np.zeros(first + model.state_count)
        self._decision = decision_of(len(points.places), model.free_count, size or len(self.y))
        self._inquiry = inquiry_of(len(points.places))
        self._asked = question_of(self._inquiry)
        self._look = look(self._decision, self.y)
        asking = asking_of(points, self._look, self._decision, first)
        self._changing = change_contacts.bound(asking, self._decision, self._inquiry, self.y).prepared()

    def ask(self, what: int, t: float, y: Vector, span: float = 0.0, stop: float = np.inf, rtol: float = 0.0) -> bool:
        """Ask what follows an event at a state (q, u, z), or for margins; return whether the scene says that.

        Parameters
        ----------
        what : int
            Of `kanefe.kernels.impacts.contact_questions.Asks`; START: what touches is not known yet.
        t : float
            s.
        y : ndarray
            Begins with q, u and z.
        span : float
            Of the run, s; zero: only the time itself is looked at.
        stop : float
            End of the run, s, beyond which motions may not be known.
        rtol : float
            Of the run: the share of speeds, or of the scene's length in a second, that it does not resolve.
        """
        self.y[:] = y[: len(self.y)]
        asked, self._t = self._asked, t
        asked.what, asked.reports, asked.tells_gains = what, 0, True
        asked.when, asked.span, asked.stop, asked.rtol, asked.length = t, span, stop, rtol, moving_length(self._model)
        self._changing()
        if isinstance(self._look, PythonCall):
            self._look.raise_again()
        return asked.why_not != WhyNot.UNKNOWN

    @property
    def margins(self) -> Matrix:
        """Distances of points from what may happen, (points, 4): gap, normal force, friction left, and slip; or inf."""
        points = points_of(self._decision)
        return np.array([(one.gap, one.normal, one.slip_margin, one.left_of_slip) for one in points]).reshape(-1, 4)

    @property
    def blurs(self) -> tuple[float, ...]:
        """How far they may be below zero by round-off."""
        blurs = self._asked.blurs
        return tuple(float(getattr(blurs, name)) for name in blurs.fields)

    def changed(self) -> Changed:
        """Return what follows.

        Raises
        ------
        SimulationError
            If contacts have no impulses, or no forces that fit (Painleve's paradox).
        """
        if self._asked.why_not != WhyNot.FOUND:
            raise self._refusal(self._asked.why_not)
        model, told = self._model, ToldImpacts()
        told_first = list(Reports(self._inquiry.reports))[: self._asked.reports]
        reports = [(float(one.t), int(one.code)) for one in told_first]
        for _, code in reports:
            contact, what = divmod(code, REPORTED)
            if contact < len(model.rigid_contacts) and what in (Reported.BY_POISSON, Reported.BY_ORDER):
                note = told.was_by_poisson if what == Reported.BY_POISSON else told.was_by_order
                note([model.rigid_contact(contact).name], self._t)
        points = list(zip(points_of_contacts(model), points_of(self._decision), strict=True))
        if self._asked.gained > 0.0:
            names = sorted({model.rigid_contact(c).name for (c, _), one in points if one.takes_part and one.gains})
            told.adding.append((self._t, tuple(names), float(self._asked.gained)))
        titles = sorted({model.rigid_contact(c).title for (c, _), one in points if one.takes_part and one.is_concerned})
        return Changed(self.y.copy(), reports, titles, told)

    def _refusal(self, why: int) -> SimulationError:
        model, remedy = self._model, "Remedy: less friction, or compliant contacts, kanefe.HuntCrossley(...)"
        points = zip(points_of_contacts(model), points_of(self._decision), strict=True)
        taking = [(model.rigid_contact(c).title, one) for (c, _), one in points if one.takes_part]
        if why == WhyNot.PARADOX:
            c, i = points_of_contacts(model)[int(self._decision.alone[0])]
            return paradox(model.rigid_contact(c).title, i, self._t)
        if why == WhyNot.NO_IMPULSES:
            names = ", ".join(sorted({title for title, _ in taking}))
            return SimulationError(
                f"at t = {self._t:.6g} s the impact on {names} has no impulses that were found. {remedy}"
            )
        active = [title for title, one in taking if one.is_closed]
        cones = Cones(self._decision.problem.each)
        slips = sorted({title for a, title in enumerate(active) if not np.isnan(cones[a].along)})
        reason = (
            f" with which {', '.join(slips)} goes on to slip: there are none, or several, where friction presses what "
            "slips into its surfaces more than the forces of all together can hold it out (Painleve's paradox)"
        )
        names = ", ".join(sorted(set(active)))
        return SimulationError(
            f"at t = {self._t:.6g} s no forces of {names} were found{reason if slips else ''}. {remedy}"
        )


def paradox(title: str, i: int, t: float) -> SimulationError:
    """Return the error that Painleve's paradox deserves, of a point of a contact."""
    return SimulationError(
        f"at t = {t:.6g} s the force on probe {i + 1} of {title}, which slips, has no value, or several: "
        "friction presses it into the surface more than the force can hold it out (Painleve's paradox). Remedy: less "
        "friction, or a compliant contact, kanefe.HuntCrossley(...)"
    )
