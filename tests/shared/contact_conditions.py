"""What forces, impulses and motions of rigid contacts have to fulfil, and the kernels that find them, on matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

import kanefe as kf
from kanefe.contact.rigid.rigid import IMPACT_LAWS
from kanefe.contact.rigid.rigid_contact import EACH, REPORTED_CHANGES, TAKEN
from kanefe.equations.model import Model
from kanefe.kernels.compiler.python_calls import PythonCall
from kanefe.kernels.contact.rigid_points import GivenPoints, Meetings, RigidPoint
from kanefe.kernels.impacts.cones import Cones, Wanted, problem_of, solve_one
from kanefe.kernels.impacts.contact_changes import change_contacts
from kanefe.kernels.impacts.contact_questions import Asks, WhyNot, inquiry_of, question_of
from kanefe.kernels.impacts.decision import Asked, Look, decision_of, points_of
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.tensors import Vector
from kanefe.literal.contact_forces import probe_forces
from kanefe.states.constraints import meetings
from kanefe.tree.contact_changes import asking_of


class ConeProblem(NamedTuple):
    """``G x + b`` in complementarity with forces in cones: see `kanefe.kernels.impacts.cones`."""

    G: np.ndarray
    b: np.ndarray
    mu: np.ndarray
    least: np.ndarray
    slips: np.ndarray


def solved(problem: ConeProblem) -> np.ndarray | None:
    """Return the forces that the kernel finds, None if it finds none."""
    k = len(problem.mu)
    memory = problem_of(k)
    memory.G[:], memory.b[:] = problem.G, problem.b
    for i, cone in enumerate(Cones(memory.each)):
        cone.mu, cone.least, (cone.along, cone.across) = problem.mu[i], problem.least[i], problem.slips[i]
    wanted = Wanted(memory.wanted)
    wanted.contacts = k
    solve_one(memory)
    return memory.x.copy() if wanted.is_solved else None


def left_of(problem: ConeProblem, x: np.ndarray) -> float:
    """Return how far forces are from a solution: the largest change by a step along the rates and back to the cones."""
    y, worst = problem.G @ x + problem.b, 0.0
    for i, mu in enumerate(problem.mu):
        rows = slice(3 * i, 3 * i + 3)
        step = 1.0 / np.linalg.eigvalsh(problem.G[rows, rows])[-1]
        normal, *friction = x[rows] - step * y[rows]
        normal, size = max(normal, problem.least[i]), np.hypot(*friction)
        along = -problem.slips[i] if np.all(np.isfinite(problem.slips[i])) else np.array(friction) / max(size, 1e-300)
        most = mu * max(normal, 0.0)
        length = most if np.all(np.isfinite(problem.slips[i])) else min(size, most)
        worst = max(worst, np.abs(np.append(normal, length * along) - x[rows]).max())
    return float(worst)


class Impact(NamedTuple):
    """Impulses of contacts (3 k,), the energies that each takes, what all make, and the least of the group of each."""

    impulses: np.ndarray
    taken: np.ndarray
    gained: float
    groups: list[int]


def impact(G: np.ndarray, rates: np.ndarray, laws: Sequence[kf.Rigid], mu: Sequence[float]) -> Impact | None:
    """Return the impact of contacts that meet at some rates, whose responses alone are known; None: none found."""
    k = len(laws)
    places, numbers = np.zeros((k, RigidPoint.integer_count), np.int64), np.zeros((k, RigidPoint.number_count))
    states = REPORTED_CHANGES + EACH
    for i, (own, law, friction) in enumerate(zip(GivenPoints(places, numbers), laws, mu, strict=True)):
        own.first_state, own.status, own.contact = states * i, states * i + REPORTED_CHANGES, i
        own.law, own.rubs = IMPACT_LAWS.index(law.impact), friction > 0.0
        own.restitution, own.stiffness, own.exponent = law.restitution, law.stiffness, law.exponent
        own.friction.mu = own.friction.holding = friction
    points = RigidPoints(places, numbers, np.zeros(0))
    decision, y = decision_of(k, 3 * k, (3 + states) * k), np.zeros((3 + states) * k)

    def look() -> None:
        asked = Asked(decision.asked, decision.when)
        asked.is_known, now = True, decision.now
        if asked.look == Look.MARGINS:
            for i, point in enumerate(points_of(decision)):
                point.gap, point.normal, point.slip_margin, point.left_of_slip = 0.0, np.inf, np.inf, np.inf
                Meetings(now.met)[i].rates = Vector(*rates[3 * i : 3 * i + 3])
        now.G[:], now.responses[:], now.sizes[:] = G, np.eye(3 * k), np.abs(rates).max()

    call = PythonCall(look)
    inquiry = inquiry_of(k)
    asked = question_of(inquiry)
    asked.what, asked.length, asked.tells_gains = Asks.START, 1e-3, True
    change_contacts(asking_of(points, call, decision, 3 * k), decision, inquiry, y)
    call.raise_again()
    if asked.why_not == WhyNot.NO_IMPULSES:
        return None
    taken = y[3 * k :].reshape(k, -1)[:, TAKEN]
    return Impact(y[: 3 * k], taken, float(asked.gained), [int(one.group) for one in points_of(decision)])


def assert_contacts_hold(model: Model, t: float, y: np.ndarray, tolerance: float) -> None:
    """Assert that nothing enters, pulls or holds more than it can after an event, by the literal equations.

    `tolerance`: of forces and speeds, relative to the largest.
    """
    state = model.literal.view(t, y)
    forces, fastest = probe_forces(state), np.abs(state.u).max(initial=0.0)
    largest = max((abs(one.normal) for one in forces), default=0.0)
    for one in forces:
        contact, rates = model.rigid_contact(one.contact), one.met.rates
        assert one.normal >= -tolerance * largest
        assert np.linalg.norm(one.friction) <= contact.static * one.normal + tolerance * largest
        assert abs(rates[0]) <= tolerance * fastest
    closed = {(one.contact, one.probe) for one in forces}
    for c, probes in enumerate(meetings(state)):
        for i, met in enumerate(probes):
            if (c, i) not in closed and met.gap <= 0.0:  # what is open has left, or leaves
                assert met.rates[0] >= -tolerance * fastest
