"""What happens to rigid contacts at an event: impacts, and which of them are open, stick and slip afterwards.

Impacts are Newton's or Poisson's with Coulomb's friction of the impulses, all contacts that are closed taking part at
once. What follows is decided by the forces: the same complementarity, of accelerations.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kanefe.contact.cone import Cones, solved
from kanefe.contact.rigid import POISSON
from kanefe.contact.rigid_contact import AT_REST, EACH, OPEN, SLIPS, STICKS, TOLD, RigidContact
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import accelerations
from kanefe.kane.constraints import meetings
from kanefe.kane.impulses import answers
from kanefe.kane.rigid_contacts import ROUND_OFF_OF_FORCES, STOPPED, margins, paradox, probe_jacobian, rest_speed
from kanefe.kane.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length

TOUCH, LIFT, SLIP, STICK, START = "touch", "lift", "slip", "stick", "start"

NEAR = 1e-9
"""Of the scene's length: gaps up to which a probe takes part in an impact; and of the largest of what an event looks
at, up to which others are past it too."""

STILL = 1e-10
"""Of the speeds with which a probe is moved: what is slower along the normal does not move."""

MOMENT = 1e-11
"""Of the span: what is slower than something that falls for so long does not move either."""

HOLDS = 1.0 - ROUND_OFF_OF_FORCES
"""Of what friction holds: from there on the accelerations a moment later tell whether it goes on to hold."""

AHEAD = 1e-9, 1e-8, 1e-7, 1e-6, 1e-5
"""Of the span: moments after an event at which the accelerations are looked at where those at the event are in balance
with the limit of friction. The first that is past round-off decides."""

CROWDED, SHORT_FLIGHT = 1e-6, 5e-8
"""Of the span: time within which impacts that follow each other come to their end, and time of one flight, below which
they are taken together: what bounces is at rest."""

BEGINNING = 2.0 / 3.0
"""Power of rtol: so fast, of the speeds that a scene has, a slip that begins is followed in the direction of the friction
that would hold it. Friction would draw it there the faster the slower it is, and no step is short enough. That
direction is known to first order in time, and so the speed to the power 3/2: to rtol."""

Key = tuple[int, int]
"""Number of a contact among the rigid ones, and of a probe in it."""


@dataclass
class Changed:
    """What an event leads to.

    Attributes
    ----------
    u : ndarray, shape (free,)
        Speeds after it.
    z : ndarray, shape (states,)
        Internal states after it.
    happened : list of (str, float)
        Names of what is told, "<contact> touch" and so on, and their times, s.
    """

    u: Vector
    z: Vector
    happened: list[tuple[str, float]] = field(default_factory=list)


def resolved(
    model: ModelData, t: float, y: Vector, kind: str, span: float, stop: float = np.inf, rtol: float = 0.0
) -> Changed:
    """Return what follows an event of rigid contacts.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    y : ndarray
        State (q, u, z) at it.
    kind : str
        `TOUCH`, `LIFT`, `SLIP` or `STICK`: what the run found; `START`: what touches is not known yet.
    span : float
        Of the run, s; zero: only the time itself is looked at.
    stop : float
        End of the run, s, beyond which motions may not be known.
    rtol : float
        Of the run: the share of speeds, or of the scene's length in a second, that it does not resolve.

    Raises
    ------
    SimulationError
        If contacts have no forces that fit (Painleve's paradox).
    """
    return _Event(model, t, y, kind, span, stop, rtol).changed()


class _Event:
    def __init__(
        self, model: ModelData, t: float, y: Vector, kind: str, span: float, stop: float, rtol: float
    ) -> None:
        self.model, self.t, self.kind, self.span, self.stop, self.rtol = model, t, kind, span, stop, rtol
        self.q, self.u, self.z = (part.copy() for part in model.parts(y))
        state = State(model, t, self.q, self.u, self.z)
        self.met = {(c, i): one for c, probes in enumerate(meetings(state)) for i, one in enumerate(probes)}
        self.before = {key: self._contact(key).status(self._own(key))[key[1]] for key in self.met}
        self.concerned = self._past(state)
        near = NEAR * scene_length(model)
        self.keys = [
            key
            for key, one in self.met.items()
            if self.before[key] != OPEN or one.gap <= near or (kind == TOUCH and key in self.concerned)
        ]
        self._surfaces = {c: state.marker(self._contact((c, 0)).ends[0]).A_NF for c in {key[0] for key in self.keys}}
        self.happened: list[tuple[str, float]] = []

    def _contact(self, key: Key) -> RigidContact:
        return self.model.rigid_contact(key[0])

    def _own(self, key: Key) -> Vector:
        return self.z[self.model.load_states[self.model.rigid_contacts[key[0]]]]

    def _past(self, state: State) -> set[Key]:
        """Return the probes that the event is of."""
        if self.kind == START:
            return set()
        found = margins(state)
        values = {
            TOUCH: found.gaps,
            LIFT: found.normals,
            SLIP: found.reserves,
            STICK: found.slips,
        }[self.kind]
        least = min(values.values(), default=0.0)
        scale = {TOUCH: scene_length(self.model), STICK: float(np.abs(self.u).max(initial=0.0))}.get(
            self.kind, max((abs(x) for x in found.normals.values()), default=0.0)
        )
        return {key for key, value in values.items() if value <= max(least, 0.0) + NEAR * scale}

    def changed(self) -> Changed:
        """Return what follows."""
        if not self.keys:
            return Changed(self.u, self.z)
        free = self._without(self.u)
        J, G, b = self._problem(free)
        fallen = float(np.abs(b).max()) * MOMENT * self.span
        sizes = np.array([rest_speed(free, *key) / STOPPED for key in self.keys])
        still, self.rest = np.maximum(STILL * sizes, fallen), np.maximum(STOPPED * sizes, fallen)
        speeds = np.maximum(sizes, scene_length(self.model))
        self.slow = self.rtol**BEGINNING * speeds
        if self.kind == STICK:  # a slip that ends, or turns, within the noise of the run, begins anew or is over
            ended = [key in self.concerned for key in self.keys]
            self.rest = np.where(ended, np.maximum(self.rest, self.rtol * speeds), self.rest)
        rates = np.concatenate([self.met[key].rates for key in self.keys])
        self.struck = np.zeros(len(self.keys), dtype=bool)
        if np.any(rates[::3] < -still):
            impulses = self._impulses(G, rates)
            self.struck = impulses[::3] > 0.0
            self.u = self.u + answers(free, (J.T @ impulses)[:, None])[:, 0]
            rates = rates + G @ impulses
            still = np.maximum(still, 1e-11 * (np.abs(G) @ np.abs(impulses))[::3])
        closed = rates[::3] <= still
        if self.kind == LIFT:
            closed &= [key not in self.concerned for key in self.keys]
        self._decide(J, G, rates, closed)
        self._tell()
        return Changed(self.u, self.z, self.happened)

    def _problem(self, state: State) -> tuple[Matrix, Matrix, Vector]:
        """Return the partial rates of all probes that take part, what unit forces do, and what happens without any."""
        rows, n = np.vstack([probe_jacobian(state, *key) for key in self.keys]), self.model.free_count
        met = meetings(state)
        left = np.concatenate([met[c][i].remainder for c, i in self.keys]) + rows[:, n:] @ state.driven_rates
        J = rows[:, :n]
        return J, J @ answers(state, J.T), J @ accelerations(state) + left

    def _without(self, u: Vector) -> State:
        """Return the state at some speeds with all rigid contacts open."""
        z = self.z.copy()
        for load in self.model.rigid_contacts:
            where = self.model.load_states[load]
            z[where.start + TOLD : where.stop : EACH] = OPEN
        return State(self.model, self.t, self.q, u, z)

    def _impulses(self, G: Matrix, rates: Vector) -> Vector:
        """Return the impulses of an impact, (3 k,)."""
        laws = [self._contact(key).law for key in self.keys]
        e = np.array([law.restitution for law in laws])
        is_poisson = np.array([law.impact == POISSON for law in laws])
        mu = np.array([self._contact(key).static for key in self.keys])
        none = np.full((len(self.keys), 2), np.nan)
        b = rates.copy()
        b[::3] += np.where(is_poisson, 0.0, e) * np.minimum(rates[::3], 0.0)
        pressed = self._solved(Cones(G, b, mu, np.zeros(len(mu)), none))
        least = np.where(is_poisson, e * pressed[::3], 0.0)
        if not least.any():
            return pressed
        # the second part of Poisson's impact; contacts by Newton's law keep what they have come to
        after = rates + G @ pressed
        after[::3] += np.where(is_poisson, 0.0, e * np.minimum(rates[::3], 0.0))
        return pressed + self._solved(Cones(G, after, mu, least, none))

    def _solved(self, problem: Cones) -> Vector:
        found = solved(problem)
        if found is None:
            key = self.keys[0]
            raise SimulationError(
                f"at t = {self.t:.6g} s the impact on {self._contact(key).title} has no impulses that were found. "
                "Remedy: less friction, or contacts that yield, kanefe.HuntCrossley(...)"
            )
        return found

    def _decide(self, J: Matrix, G: Matrix, rates: Vector, closed: np.ndarray) -> None:
        """Write what each probe does from now on, by the accelerations; what bounces too fast to follow is at rest.

        Each round closes a probe more, so that they end.
        """
        while True:
            rates = self._stopped(J, G, rates, closed)
            y, statuses, kept, turning = self._forces(J, rates, closed)
            resting = [
                k
                for k, key in enumerate(self.keys)
                if not closed[k] and rates[3 * k] > 0.0 and self._is_crowded(key, rates[3 * k], y[3 * k])
            ]
            if not resting:
                break
            for k in resting:
                closed[k], e = True, self._contact(self.keys[k]).law.restitution
                left = 2.0 * rates[3 * k] / (-y[3 * k] * (1.0 - e))
                self.happened.append((f"{self._contact(self.keys[k]).name} rest", self.t + left))
        for k, key in enumerate(self.keys):
            contact, met = self._contact(key), self.met[key]
            along = rate = np.zeros(3)
            if statuses[k] == SLIPS:
                speed = max(AT_REST, self.slow[k] if self._is_at_rest(k, rates) else 0.0)
                along, rate = speed * kept[k] @ met.axes[1:] @ self._surfaces[key[0]], speed * turning[k]
            if statuses[k] == STICKS:
                was = self.before[key] == STICKS
                along = contact.kept(self._own(key), key[1]) if was else met.place
            contact.with_status(self._own(key), key[1], statuses[k], along, rate)

    def _is_at_rest(self, k: int, rates: Vector) -> bool:
        """Tell whether a probe does not slip but for round-off: what it does next its acceleration decides."""
        return float(np.hypot(*rates[3 * k + 1 : 3 * k + 3])) <= self.rest[k]

    def _stopped(self, J: Matrix, G: Matrix, rates: Vector, closed: np.ndarray) -> Vector:
        """Take the round-off from the speeds of what is closed, and from those of what does not slip."""
        held = [3 * int(k) for k in np.flatnonzero(closed)]
        held += [
            3 * int(k) + j
            for k in np.flatnonzero(closed)
            for j in (1, 2)
            if self._contact(self.keys[k]).friction is not None and self._is_at_rest(k, rates)
        ]
        if not np.any(rates[held]):
            return rates
        stopped = -np.linalg.lstsq(G[np.ix_(held, held)], rates[held], rcond=None)[0]
        self.u = self.u + answers(self._without(self.u), (J[held].T @ stopped)[:, None])[:, 0]
        rates = rates + G[:, held] @ stopped
        rates[held] = 0.0
        return rates

    def _is_crowded(self, key: Key, rate: float, acceleration: float) -> bool:
        """Tell whether a probe that has just parted comes back so soon that its impacts cannot be told apart."""
        e = self._contact(key).law.restitution
        if acceleration >= 0.0 or e == 1.0:
            return False
        flight = 2.0 * rate / -acceleration
        return flight <= SHORT_FLIGHT * self.span or flight <= (1.0 - e) * CROWDED * self.span

    def _forces(self, J: Matrix, rates: Vector, closed: np.ndarray) -> tuple[Vector, list[int], Matrix, Matrix]:
        """Return accelerations, and what each probe does with the direction of its slip and the rate of that.

        What is at rest sticks, unless the accelerations say that it slips; where these are at the limit of friction,
        those a moment later. Each round lets a probe more slip, and none stick again, so that they end.
        """
        k, free = len(self.keys), self._without(self.u)
        _, G, b = self._problem(free)
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
        while True:
            x = self._followed(problem, begins, active)
            new = _slipping(problem, x) or self._slipping_soon(problem, x, J, rows, active)
            if not new:
                break
            for at, along in new.items():
                problem.slips[at] = along
                problem.mu[at] = self._contact(self.keys[active[at]]).friction_at(0.0)
            begins |= set(new)
        forces = np.zeros(3 * k)
        forces[rows] = x
        statuses, kept, turning = [OPEN] * k, np.zeros((k, 2)), self._turning(problem, x, J, rows, begins, active)
        biggest = float(np.abs(x).max(initial=0.0))
        for at, i in enumerate(active):
            if x[3 * at] <= ROUND_OFF_OF_FORCES * biggest:
                continue
            is_slip = not np.isnan(problem.slips[at, 0])
            statuses[i] = SLIPS if is_slip else STICKS
            if is_slip:
                kept[i] = problem.slips[at]
        return b + G @ forces, statuses, kept, turning

    def _slipping_soon(
        self, problem: Cones, x: Vector, J: Matrix, rows: list[int], active: list[int]
    ) -> dict[int, Vector]:
        """Return the directions in which begins to slip what is held by all that friction can hold."""
        full = _at_limit(problem, x)
        if not full:
            return {}
        for share in AHEAD if self.span > 0.0 else ():
            _, later = self._ahead(share, problem, x, J, rows)
            found = solved(later, x)
            if found is None:
                continue
            new = {at: along for at, along in _slipping(later, found).items() if at in full}
            if new or not full & _at_limit(later, found):
                return new
        return {}

    def _ahead(self, share: float, problem: Cones, x: Vector, J: Matrix, rows: list[int]) -> tuple[State, Cones]:
        """Return the state a share of the span later, and what is asked of the forces there."""
        free, h = self._without(self.u), min(share * self.span, self.stop - self.t)
        du = accelerations(free) + answers(free, (J[rows].T @ x)[:, None])[:, 0]
        q = self.model.advance(self.q, h * (self.u + 0.5 * h * du))
        later = State(self.model, self.t + h, q, self.u + h * du, free.z)
        _, G, b = self._problem(later)
        return later, problem._replace(G=G[np.ix_(rows, rows)], b=b[rows])

    def _turning(
        self, problem: Cones, x: Vector, J: Matrix, rows: list[int], begins: set[int], active: list[int]
    ) -> Matrix:
        """Return the rates of the directions of slips that begin, in the axes of the surfaces, 1/s."""
        turning = np.zeros((len(self.keys), 3))
        if not begins or min(self.span, self.stop - self.t) <= 0.0:
            return turning
        state, later = self._ahead(AHEAD[-1], problem, x, J, rows)
        slips = problem.slips.copy()
        slips[list(begins)] = np.nan
        found = solved(later._replace(slips=slips), x)
        for at in begins if found is not None else ():
            (c, i), friction = self.keys[active[at]], found[3 * at + 1 : 3 * at + 3]
            if size := float(np.linalg.norm(friction)):
                before = problem.slips[at] @ self.met[c, i].axes[1:] @ self._surfaces[c]
                A = state.marker(self._contact((c, i)).ends[0]).A_NF
                after = -friction / size @ meetings(state)[c][i].axes[1:] @ A
                turning[active[at]] = (after - before) / (state.t - self.t)
        return turning

    def _followed(self, problem: Cones, begins: set[int], active: list[int]) -> Vector:
        """Return the forces, with slips that begin against the friction of what is free to choose its direction.

        That is known also where it is all but balanced, and accelerations are the difference of large numbers.
        """
        if begins:
            slips = problem.slips.copy()
            slips[list(begins)] = np.nan
            free = solved(problem._replace(slips=slips))
            for at in begins if free is not None else ():
                friction = free[3 * at + 1 : 3 * at + 3]
                size = float(np.linalg.norm(friction))
                if size > 0.0:
                    problem.slips[at] = -friction / size
        self._check_paradox(problem, active)
        x = solved(problem)
        if x is None:
            raise paradox(*self._named(active[0]), self.t)
        return x

    def _check_paradox(self, problem: Cones, active: list[int]) -> None:
        for at, slip in enumerate(problem.slips):
            if not np.isnan(slip[0]):
                row = problem.G[3 * at]
                own = float(row[3 * at] - problem.mu[at] * (row[3 * at + 1 : 3 * at + 3] @ slip))
                if own <= 1e-9 * row[3 * at]:
                    raise paradox(*self._named(active[at]), self.t)

    def _named(self, number: int) -> tuple[RigidContact, int]:
        key = self.keys[number]
        return self._contact(key), key[1]

    def _tell(self) -> None:
        """Note what the event is told as, contact by contact."""
        for c in sorted({key[0] for key in self.keys}):
            keys = [key for key in self.keys if key[0] == c]
            contact = self._contact(keys[0])
            was = [self.before[key] for key in keys]
            now = [contact.status(self._own(key))[key[1]] for key in keys]
            struck = {key for key, is_struck in zip(self.keys, self.struck, strict=True) if is_struck}
            if any(
                key in struck or (key in self.concerned and self.kind == TOUCH and now[at] != OPEN)
                for at, key in enumerate(keys)
                if was[at] == OPEN
            ):
                self.happened.append((f"{contact.name} touch", self.t))
            if max(was) != OPEN and max(now) == OPEN:
                self.happened.append((f"{contact.name} lift", self.t))
            if contact.friction is None:
                continue
            slipped, slips = SLIPS in was, SLIPS in now
            if slips and not slipped and STICKS in was:
                self.happened.append((f"{contact.name} slip", self.t))
            if STICKS in now and not slips and (slipped or max(was) == OPEN):
                self.happened.append((f"{contact.name} stick", self.t))


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
    y = problem.G @ x + problem.b
    least = ROUND_OFF_OF_FORCES * float(np.abs(problem.b).max(initial=0.0))
    found = {at: y[3 * at + 1 : 3 * at + 3] for at in sorted(_at_limit(problem, x))}
    return {at: along / np.linalg.norm(along) for at, along in found.items() if np.linalg.norm(along) > least}
