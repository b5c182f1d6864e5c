"""Forces of rigid contacts at an event, and what they decide: which of what is at rest sticks, and how slips begin.

The complementarity of accelerations; where it is in balance with the limit of friction, that of a moment later.
"""

from __future__ import annotations

import numpy as np

from kanefe.contact.rigid.cone import Cones, solved
from kanefe.contact.rigid.rigid_contact import OPEN, SLIPS, STICKS, RigidContact
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.rigid_contacts.contact_forces import paradox
from kanefe.kane.rigid_contacts.instant import ContactInstant, InstantAt, Key, noise_of_forces
from kanefe.kernels.impacts.tolerances import AHEAD, HOLDS, NOT_DETERMINED, ROUND_OFF_OF_FORCES
from kanefe.tree.model_data import ModelData


class NoForces(SimulationError):
    """No forces of several contacts let their slips go on."""


class StickOrSlip:
    """Rigid contacts at a state, and the forces that they have there.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    y : ndarray
        State (q, u, z) at it.
    span, stop : float
        Of the run, and its end, s.
    at : InstantAt

    Attributes
    ----------
    met : dict of (int, int) to Meeting
        Of all probes.
    keys : list of (int, int)
        The probes that take part.
    rest : ndarray, shape (keys,)
        Speeds below which they do not slip, m/s.
    """

    def __init__(self, model: ModelData, t: float, y: Vector, span: float, stop: float, at: InstantAt) -> None:
        # of a run that goes on beyond the end that it assumed nothing is known
        self.model, self.t, self.span, self.stop, self._at = model, t, span, stop if stop >= t else np.inf, at
        self.q, self.u, self.z = (part.copy() for part in model.parts(y))
        self.instant = at(t, y)
        contacts = range(len(model.rigid_contacts))
        keys = [(c, i) for c in contacts for i in range(len(model.rigid_contact(c).probes))]
        self.met = {key: self.instant.meeting(key) for key in keys}
        self.keys, self.rest = keys, np.zeros(len(keys))
        self._surfaces = {c: self.instant.surface(c) for c in contacts}

    def _contact(self, key: Key) -> RigidContact:
        return self.model.rigid_contact(key[0])

    def _own(self, key: Key) -> Vector:
        return self.z[self.model.load_states[self.model.rigid_contacts[key[0]]]]

    def _now(self) -> ContactInstant:
        """Return the instant at the speeds that there are now."""
        return self._at(self.t, np.concatenate((self.q, self.u, self.z)))

    def _is_at_rest(self, k: int, rates: Vector) -> bool:
        """Return whether a contact point slips by round-off only: then its acceleration decides."""
        return float(np.hypot(*rates[3 * k + 1 : 3 * k + 3])) <= self.rest[k]

    def _forces(self, rates: Vector, closed: np.ndarray) -> tuple[Vector, list[int], Matrix, Matrix]:
        """Return accelerations, and the status of each contact point with its slip direction and the rate of that.

        What is at rest sticks, unless the accelerations say that it slips; where these are at the limit of friction,
        those a moment later. Each round lets a probe more slip, and none stick again, so that they end.
        """
        k, now = len(self.keys), self._now()
        G, b = now.problem(self.keys)
        active = [int(i) for i in np.flatnonzero(closed)]
        rows = [3 * i + j for i in active for j in range(3)]
        slips = np.full((len(active), 2), np.nan)
        mu = np.array([self._contact(self.keys[i]).static for i in active])
        begins: set[int] = set()
        for at, i in enumerate(active):
            contact, along = self._contact(self.keys[i]), rates[3 * i + 1 : 3 * i + 3]
            if contact.friction is None:
                slips[at] = 0.0
            elif not self._is_at_rest(i, rates):
                speed = float(np.linalg.norm(along))
                slips[at], mu[at] = along / speed, contact.friction_at(speed)
        problem = Cones(G[np.ix_(rows, rows)], b[rows], mu, np.zeros(len(active)), slips)
        noise = noise_of_forces(now, [self.keys[i] for i in active])
        while True:
            x = self._followed(problem, begins, active)
            x = x if np.abs(x).max(initial=0.0) > noise else np.zeros(len(x))
            new = _slipping(problem, x) or self._slipping_soon(problem, x, now, active)
            if not new:
                break
            for at, along in new.items():
                problem.slips[at] = along
                problem.mu[at] = self._contact(self.keys[active[at]]).friction_at(0.0)
            begins |= set(new)
        forces = np.zeros(3 * k)
        forces[rows] = x
        statuses, kept, turning = [OPEN] * k, np.zeros((k, 2)), self._turning(problem, x, now, begins, active)
        biggest, moved = float(np.abs(x).max(initial=0.0)), G @ forces
        # by what forces do, not by b: holding what would move by more takes a pull that counts among them
        y, least = b + moved, ROUND_OFF_OF_FORCES * float(np.abs(moved).max()) if biggest > 0.0 else -1.0
        for at, i in enumerate(active):
            is_slip = not np.isnan(problem.slips[at, 0])
            # what others carry for it stays closed where it would not move either
            parts = y[3 * i : 3 * i + (1 if is_slip else 3)]
            if x[3 * at] <= ROUND_OFF_OF_FORCES * biggest and np.abs(parts).max() > least:
                continue
            statuses[i] = SLIPS if is_slip else STICKS
            if is_slip:
                kept[i] = problem.slips[at]
        return y, statuses, kept, turning

    def _slipping_soon(self, problem: Cones, x: Vector, now: ContactInstant, active: list[int]) -> dict[int, Vector]:
        """Return the directions in which begins to slip what is held by all that friction can hold."""
        full = _at_limit(problem, x)
        if not full:
            return {}
        for share in AHEAD if self.span > 0.0 else ():
            _, later = self._ahead(share, problem, x, now, active)
            found = solved(later, x)
            if found is None:
                continue
            new = {at: along for at, along in _slipping(later, found).items() if at in full}
            if new or not full & _at_limit(later, found):
                return new
        return {}

    def _ahead(
        self, share: float, problem: Cones, x: Vector, now: ContactInstant, active: list[int]
    ) -> tuple[ContactInstant, Cones]:
        """Return the instant a fraction of the span later, and the force problem there."""
        keys, h = [self.keys[i] for i in active], min(share * self.span, self.stop - self.t)
        du = now.accelerations() + now.respond(keys, x)
        q = self.model.advance(self.q, h * (self.u + 0.5 * h * du))
        later = self._at(self.t + h, np.concatenate((q, self.u + h * du, self.z)))
        G, b = later.problem(keys)
        return later, problem._replace(G=G, b=b)

    def _turning(self, problem: Cones, x: Vector, now: ContactInstant, begins: set[int], active: list[int]) -> Matrix:
        """Return the rates of the directions of slips that begin, in the axes of the surfaces, 1/s."""
        turning = np.zeros((len(self.keys), 3))
        if not begins or min(self.span, self.stop - self.t) <= 0.0:
            return turning
        instant, later = self._ahead(AHEAD[-1], problem, x, now, active)
        slips = problem.slips.copy()
        slips[list(begins)] = np.nan
        if (found := solved(later._replace(slips=slips), x)) is None:
            return turning
        for at in begins:
            (c, i), friction = self.keys[active[at]], found[3 * at + 1 : 3 * at + 3]
            if size := float(np.linalg.norm(friction)):
                before = problem.slips[at] @ self.met[c, i].axes[1:] @ self._surfaces[c]
                after = -friction / size @ instant.meeting((c, i)).axes[1:] @ instant.surface(c)
                turning[active[at]] = (after - before) / (instant.t - self.t)
        return turning

    def _followed(self, problem: Cones, begins: set[int], active: list[int]) -> Vector:
        """Return the forces, with slips that begin against the friction of what is free to choose its direction.

        That is known also where it is all but balanced, and accelerations are the difference of large numbers.
        """
        if begins:
            slips = problem.slips.copy()
            slips[list(begins)] = np.nan
            free = solved(problem._replace(slips=slips))
            for at in begins:
                friction = np.zeros(2) if free is None else free[3 * at + 1 : 3 * at + 3]
                size = float(np.linalg.norm(friction))
                if size > 0.0:
                    problem.slips[at] = -friction / size
        x, drawn = solved(problem), _drawn_in(problem)
        if x is None and (not drawn or len(active) > 1):
            raise self._no_forces(problem, active)
        if x is None or drawn:
            raise paradox(*self._named(active[drawn[0]]), self.t)
        return x

    def _no_forces(self, problem: Cones, active: list[int]) -> NoForces:
        """Return the error of several points at once."""
        names = sorted({self._named(i)[0].title for i in active})
        slips = sorted({self._named(i)[0].title for at, i in enumerate(active) if not np.isnan(problem.slips[at, 0])})
        why = (
            f" with which {', '.join(slips)} goes on to slip: there are none, or several, where friction presses what "
            "slips into its surfaces more than the forces of all together can hold it out (Painleve's paradox)"
        )
        return NoForces(
            f"at t = {self.t:.6g} s no forces of {', '.join(names)} were found{why if slips else ''}. "
            "Remedy: less friction, or compliant contacts, kanefe.HuntCrossley(...)"
        )

    def _named(self, number: int) -> tuple[RigidContact, int]:
        key = self.keys[number]
        return self._contact(key), key[1]


def _drawn_in(problem: Cones) -> list[int]:
    """Return the slipping contacts that a force presses in by itself: Painleve's paradox."""
    found = []
    for at, slip in enumerate(problem.slips):
        row = problem.G[3 * at]
        own = row[3 * at] - problem.mu[at] * (row[3 * at + 1 : 3 * at + 3] @ slip)
        if own <= NOT_DETERMINED * row[3 * at]:  # not so of what may stick: NaN
            found.append(at)
    return found


def _at_limit(problem: Cones, x: Vector) -> set[int]:
    """Return the contacts that stick by all that their friction can hold."""
    biggest = float(np.abs(x).max(initial=0.0))
    return {
        at
        for at in range(len(problem.mu))
        if np.isnan(problem.slips[at, 0])
        and x[3 * at] > ROUND_OFF_OF_FORCES * biggest
        and np.hypot(*x[3 * at + 1 : 3 * at + 3]) >= HOLDS * problem.mu[at] * x[3 * at]
    }


def _slipping(problem: Cones, x: Vector) -> dict[int, Vector]:
    """Return the directions of the accelerations of what should stick and does not, by its number."""
    moved = problem.G @ x
    y, least = moved + problem.b, ROUND_OFF_OF_FORCES * float(np.abs(moved).max(initial=0.0))
    found = {at: y[3 * at + 1 : 3 * at + 3] for at in sorted(_at_limit(problem, x))}
    return {at: along / np.linalg.norm(along) for at, along in found.items() if np.linalg.norm(along) > least}
