"""A scene with rigid contacts at one moment in order n: what their events ask, from unit responses by sweeps."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.constraints.rows import MarkerMotion
from kanefe.contact.rigid.meeting import Meeting
from kanefe.contact.rigid.rigid_contact import OPEN, SLIPS, STICKS
from kanefe.frames import Matrix, Vector
from kanefe.kane.rigid_contacts.contact_forces import ContactMargins
from kanefe.kane.rigid_contacts.instant import Key
from kanefe.kernels.constraints.loop_tables import Limits, UnitResponses, head_of, unit_responses_in
from kanefe.kernels.contact.rigid_points import CONTACT, MET, ON_SURFACE, STATUS
from kanefe.kernels.evaluation.evaluation import AT_TIME
from kanefe.kernels.layout import R
from kanefe.kernels.loads.markers import MARKER_AXES
from kanefe.kernels.steppers.step_commands import AT, NO_INERTIA, SLOPE
from kanefe.order_n.contact_watching import SingleLook
from kanefe.order_n.evaluated import Evaluated

STILL = np.zeros(3)


class _Answers(NamedTuple):
    """What unit forces at all contact points do, loops held.

    Attributes
    ----------
    met : ndarray, shape (points, MET_NUMBERS)
    J : ndarray, shape (3 points, free and driven)
        Partial rates.
    G : ndarray, shape (3 points, 3 points)
    b : ndarray, shape (3 points,)
        Accelerations without forces.
    responses : ndarray, shape (3 points, free)
        Accelerations of the free speeds.
    axes : list of ndarray, shape (3, 3)
        Of the surface of each point.
    drives : ndarray, shape (driven, 3)
    """

    met: Matrix
    J: Matrix
    G: Matrix
    b: Vector
    responses: Matrix
    axes: list[Matrix]
    drives: Matrix


class OrderNInstant:
    """See `kanefe.kane.rigid_contacts.instant.ContactInstant`.

    Parameters
    ----------
    route : Evaluated
    look : SingleLook
        Whose memory may be used in each question.
    t : float
        s.
    y : ndarray
        State (q, u, z).
    """

    def __init__(self, route: Evaluated, look: SingleLook, t: float, y: Vector) -> None:
        self.t, self._route, self._look, self._y = t, route, look, y
        points = route.loops.points.places
        self._first: dict[int, int] = {}
        for p, number in enumerate(points[:, CONTACT].tolist()):
            self._first.setdefault(number, p)

    def _evaluate(self, status: int | None) -> int:
        """Evaluate the scene with all contact points in a status; None: as they are. Return how that ended."""
        look, route, y = self._look, self._route, self._y
        at = look.vectors[AT]
        at[:], at[: len(y)] = 0.0, y
        look.drives[:], look.inputs[:] = route.drives(self.t), route.values(self.t, y)
        if status is None:
            look.times[0], look.states[0] = self.t, at
            look.watch()
            return 0
        q, u, _ = route.parts(y)
        at[len(q) + len(u) + route.loops.points.places[:, STATUS]] = status
        look.call.numbers[AT_TIME] = self.t
        return int(look.call()[0])

    def _kept(self) -> UnitResponses:
        look = self._look
        return unit_responses_in(look.workspace.holding, self._route.loops)

    @property
    def is_regular(self) -> bool:
        """Whether everything has inertia by itself; else the literal route has to answer."""
        return self._answers is not None

    @cached_property
    def _answers(self) -> _Answers | None:
        if self._evaluate(STICKS) == NO_INERTIA:
            return None
        route, kept = self._route, self._kept()
        loops, n = route.loops, route.model.free_count
        is_contact, moves = np.arange(len(loops.rows)) >= head_of(loops, 0), kept.scale != 0.0
        A = np.where(np.outer(moves, moves), np.tril(kept.A) + np.tril(kept.A, -1).T, 0.0)
        X, rest, c = np.where(moves[:, None], kept.unit_responses[:, :n], 0.0), kept.rest, is_contact
        G, b, responses = A[np.ix_(c, c)], -rest[c], X[c]
        if held := np.flatnonzero(~is_contact & moves).tolist():
            scale, across = kept.scale[held], A[np.ix_(held, c)]
            tolerance = Limits(loops.limits).rank_tolerance
            inverse = np.linalg.pinv(A[np.ix_(held, held)] * np.outer(scale, scale), tolerance, True)
            inverse *= np.outer(scale, scale)
            G = G - across.T @ inverse @ across
            b = b + across.T @ (inverse @ rest[held])
            responses = responses - (inverse @ across).T @ X[held]
        work, points, axes = self._look.workspace.frames.numbers, loops.points, []
        for p, row in enumerate(points.places[:, ON_SURFACE].tolist()):
            own = points.markers[2 * p, MARKER_AXES : MARKER_AXES + 9].reshape(3, 3)
            axes.append(own if row < 0 else work[row, R : R + 9].reshape(3, 3) @ own)
        met, J = kept.met.copy(), kept.J[c].copy()
        return _Answers(met, J, G, b, responses.copy(), axes, self._look.drives.copy())

    @property
    def _found(self) -> _Answers:
        if self._answers is None:
            raise TypeError("what is not regular has no answers")
        return self._answers

    def _rows(self, keys: Sequence[Key]) -> np.ndarray:
        """Return the numbers of the three rows of each of some points."""
        points = np.array([self._first[c] + i for c, i in keys], dtype=np.int64)
        return (3 * points[:, None] + np.arange(3)).ravel()

    def meeting(self, key: Key) -> Meeting:
        """Return where a contact point meets its surface."""
        row, at = self._found.met[self._first[key[0]] + key[1]], MET
        normal = int(at.normal)
        return Meeting(
            float(row[at.gap]),
            row[at.place : at.place + 3],
            row[at.point : at.point + 3],
            row[normal : normal + 9].reshape(3, 3),
            row[at.rates : at.rates + 3],
            row[at.remainder : at.remainder + 3],
        )

    def surface(self, number: int) -> Matrix:
        """Return the axes of the surface of a contact."""
        return self._found.axes[self._first[number]]

    def problem(self, keys: Sequence[Key]) -> tuple[Matrix, Vector]:
        """Return what unit forces at contact points do to their rates, and the accelerations without."""
        rows = self._rows(keys)
        return self._found.G[np.ix_(rows, rows)], self._found.b[rows]

    def respond(self, keys: Sequence[Key], forces: Vector) -> Vector:
        """Return the accelerations that forces at contact points add."""
        return np.asarray(forces @ self._found.responses[self._rows(keys)])

    def accelerations(self) -> Vector:
        """Return du."""
        return self._free

    @cached_property
    def _free(self) -> Vector:
        self._evaluate(OPEN)
        q, u, _ = self._route.parts(self._y)
        return self._look.vectors[SLOPE][len(q) : len(q) + len(u)].copy()

    def speed(self, key: Key) -> float:
        """Return the sum of the speeds with which a contact point moves."""
        full = np.concatenate((self._route.parts(self._y)[1], self._found.drives[:, 1]))
        return self._moved(key, full)

    def acceleration(self, key: Key) -> float:
        """Return the sum of the accelerations of a contact point."""
        return self._moved(key, np.concatenate((self.accelerations(), self._found.drives[:, 2])))

    def _moved(self, key: Key, full: Vector) -> float:
        return float(np.abs(self._found.J[self._rows([key])]).max(axis=0) @ np.abs(full))

    def margins(self) -> ContactMargins:
        """Return how far what touches is from its next event."""
        return self._margins

    @cached_property
    def _margins(self) -> ContactMargins:
        self._evaluate(None)
        forces = self._look.workspace.multipliers.copy()
        forces = forces[head_of(self._route.loops, 0) :].reshape(-1, 3)
        model, found = self._route.model, ContactMargins({}, {}, {}, {})
        z = self._route.parts(self._y)[2]
        for number, first in self._first.items():
            contact, own = model.rigid_contact(number), z[model.load_states[model.rigid_contacts[number]]]
            for i, status in enumerate(contact.status(own)):
                key, (normal, *friction) = (number, i), forces[first + i].tolist()
                if status == OPEN:
                    found.gaps[key] = contact.left_of_gap(self.meeting(key), own, i)
                    continue
                found.normals[key] = normal
                if status == STICKS:
                    found.slip_margins[key] = contact.static * normal - float(np.hypot(*friction))
                elif status == SLIPS and contact.friction is not None:
                    surface = MarkerMotion(STILL, self.surface(number), STILL, STILL, STILL, STILL)
                    found.slips[key] = contact.left_of_slip(self.meeting(key), contact.kept(own, i), surface)
        return found
