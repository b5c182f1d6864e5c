"""Impulses of an impact of rigid contacts, each group of coupled ones by itself, and what is to be told of them.

One contact has Stronge's impulse, or by its law Newton's or Poisson's with Coulomb's friction of the impulses. Several
at once have Poisson's: pressed together until none approaches,

    v_C = v + G p_C,    0 <= p_C,N  _|_  v_C,N >= 0,    p_C,T in Coulomb's cone against v_C,T

and let go by ``p_E,N >= e p_C,N`` (Ch. Glocker & F. Pfeiffer, Nonlinear Dyn. 7 (1995) 471-497). The first part takes
energy, ``p_C . (v + v_C) / 2 = p_C . v_C - p_C G p_C / 2 <= 0``; of the second the largest share is taken with which
the whole gives none. With any share of it impulses are in their cones and nothing approaches: both are convex.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.contact.rigid.cone import Cones, solved
from kanefe.contact.rigid.rigid import DISTRIBUTING, NEWTON, STRONGE
from kanefe.contact.rigid.rigid_contact import RigidContact
from kanefe.frames import Matrix, Vector
from kanefe.kane.rigid_contacts.stronge import Rubs, struck
from kanefe.kernels.impacts.tolerances import ADDED, APART, CLOSELY, IN_TURN, JUMPS, ROUGHLY, STILL_IN_TURN


class Impact(NamedTuple):
    """An impact of some contacts.

    Attributes
    ----------
    impulses : ndarray, shape (3 k,)
        N s.
    energies : ndarray, shape (k,)
        What each contact gives to the motion, below zero where it takes it, J.
    by_poisson : set of int
        Contacts whose law is Newton's, and whose impulses are Poisson's.
    adding : set of int
        Contacts of groups whose impulses give energy.
    by_order : set of int
        Contacts of groups that would part otherwise if they struck one after the other.
    """

    impulses: Vector
    energies: Vector
    by_poisson: set[int]
    adding: set[int]
    by_order: set[int]


class ImpactProblem(NamedTuple):
    """Contacts that may take part in an impact.

    Attributes
    ----------
    G : ndarray, shape (3 k, 3 k)
        What unit impulses do to the rates.
    contacts : list of RigidContact
    still : ndarray, shape (k,)
        Normal speeds below which they do not move, m/s.
    """

    G: Matrix
    contacts: Sequence[RigidContact]
    still: Vector

    def of(self, members: Sequence[int]) -> ImpactProblem:
        """Return that of some of the contacts."""
        rows = rows_of(members)
        return ImpactProblem(self.G[np.ix_(rows, rows)], [self.contacts[i] for i in members], self.still[list(members)])


def rows_of(members: Sequence[int]) -> list[int]:
    """Return the three rows of each of some contacts."""
    return [3 * i + j for i in members for j in range(3)]


def impact(problem: ImpactProblem, rates: Vector) -> Impact | None:
    """Return the impact at some rates (3 k,), m/s; None if no impulses were found."""
    k = len(problem.contacts)
    found = Impact(np.zeros(3 * k), np.zeros(k), set(), set(), set())
    for members in coupled(problem.G):
        own, rows = problem.of(members), rows_of(members)
        before = rates[rows]
        if not np.any(before[::3] < -own.still):
            continue
        together = _together(own, before)
        if together is None:
            return None
        impulses, is_poisson = together
        after = before + own.G @ impulses
        energies = 0.5 * (impulses * (before + after)).reshape(-1, 3).sum(axis=1)
        found.impulses[rows], found.energies[members] = impulses, energies
        if is_poisson:
            found.by_poisson.update(i for i in members if problem.contacts[i].law.impact == NEWTON)
        if energies.sum() > ADDED * 0.5 * float(np.abs(impulses) @ (np.abs(before) + np.abs(after))):
            found.adding.update(members)
        shares = any(contact.law.impact == DISTRIBUTING for contact in own.contacts)
        if len(members) > 1 and not shares and depends_on_order(own, before, after):
            found.by_order.update(members)
    return found


def coupled(G: Matrix, apart: float = APART) -> list[list[int]]:
    """Return the groups of contacts whose impulses move each other by more than a share of what they do, in order."""
    k = len(G) // 3
    sizes = np.abs(G).reshape(k, 3, k, 3).max(axis=(1, 3))
    own = np.sqrt(np.diag(sizes))
    labels = np.arange(k)
    for _ in range(k):
        meets = sizes > apart * np.outer(own, own)
        new = np.where(meets, labels[None], k).min(axis=1, initial=k)
        new = np.minimum(new, labels)
        if np.array_equal(new, labels):
            break
        labels = new
    return [np.flatnonzero(labels == label).tolist() for label in np.unique(labels)]


def _together(problem: ImpactProblem, rates: Vector, rtol: float = CLOSELY) -> tuple[Vector, bool] | None:
    """Return the impulses of a group, and whether they are Poisson's where Newton's do not exist."""
    laws = [contact.law.impact for contact in problem.contacts]
    if len(laws) == 1 and laws[0] in (STRONGE, DISTRIBUTING):
        contact = problem.contacts[0]
        found = struck(problem.G, rates, contact.law.restitution, Rubs(contact.friction_at, contact.static), rtol)
        return None if found is None else (found, False)
    if DISTRIBUTING in laws:
        from kanefe.kane.rigid_contacts.distributing import distributed

        found = distributed(problem.G, rates, problem.contacts)
        return None if found is None else (found, False)
    is_poisson = np.array([law != NEWTON for law in laws])
    for again in (False, True):
        found = pressed(problem, rates, is_poisson | again)
        if found is not None:
            return found, again
    return None


def pressed(
    problem: ImpactProblem, rates: Vector, is_poisson: np.ndarray, first: Vector | None = None
) -> Vector | None:
    """Return the impulses of several contacts at once; `first` is a guess of those that press them together."""
    G = problem.G
    e = np.array([contact.law.restitution for contact in problem.contacts])
    mu = np.array([contact.static for contact in problem.contacts])
    none = np.full((len(e), 2), np.nan)
    b = rates.copy()
    b[::3] += np.where(is_poisson, 0.0, e) * np.minimum(rates[::3], 0.0)
    together = solved(Cones(G, b, mu, np.zeros(len(mu)), none), first)
    if together is None:
        return None
    least = np.where(is_poisson, e * together[::3], 0.0)
    if not least.any():
        return together
    # the second part of Poisson's impact; contacts by Newton's law keep what they have come to
    after = rates + G @ together
    after[::3] += np.where(is_poisson, 0.0, e * np.minimum(rates[::3], 0.0))
    more = solved(Cones(G, after, mu, least, none))
    if more is None:
        return None
    return together + (_share(G, rates, together, more) if is_poisson.all() else 1.0) * more


def _share(G: Matrix, rates: Vector, together: Vector, more: Vector) -> float:
    """Return the largest share of a second part of impulses with which the whole gives no energy."""
    gone = float(together @ (rates + 0.5 * G @ together))
    linear, squared = float(more @ (rates + G @ together)), 0.5 * float(more @ G @ more)
    if gone + linear + squared <= ADDED * float(np.abs(more) @ np.abs(rates)) or squared <= 0.0:
        return 1.0
    gone = min(gone, 0.0)
    return min(1.0, -2.0 * gone / (linear + np.sqrt(linear**2 - 4.0 * squared * gone)))


def depends_on_order(problem: ImpactProblem, before: Vector, after: Vector) -> bool:
    """Return whether contacts that struck one after the other, the first or the last first, would part otherwise.

    So they do if gaps that nobody can measure are between them.
    """
    size = float(np.abs(before).max())
    for order in (1, -1):
        rates = _in_turn(problem, before, order, STILL_IN_TURN * size)
        if rates is not None and np.abs(rates - after).max() > JUMPS * size:
            return True
    return False


def _in_turn(problem: ImpactProblem, rates: Vector, order: int, still: float) -> Vector | None:
    """Return the rates after impacts of one contact after the other, until none approaches; None without an end."""
    numbers = range(len(problem.contacts))[::order]
    for _ in range(IN_TURN):
        first = next((i for i in numbers if rates[3 * i] < -still), None)
        if first is None:
            return rates
        own = rows_of([first])
        one = _together(problem.of([first]), rates[own], ROUGHLY)
        if one is None:
            return None
        rates = rates + problem.G[:, own] @ one[0]
    return None
