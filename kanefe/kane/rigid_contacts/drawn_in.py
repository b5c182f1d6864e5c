"""Impacts without collision: friction draws what slips into its surface, where no force can hold it out.

In Painleve's paradox, ``A = G_NN - mu G_NT s <= 0`` of a closed contact that slips along s, a normal force presses the
contact in. If it is pressed in without force too, ``b_N < 0``, there is no force, and contacts of any stiffness go the
same way: they are pressed in until friction has stopped the slip, the faster the stiffer they are (F. Genot & B.
Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653-677; A. Champneys & P. Varkonyi, IMA J. Appl. Math. 81 (2016) 538-588).
That is an impact by Stronge's law which begins without approach. Where ``b_N >= 0`` the contact may as well open, and
what happens depends on how it came there.

Where several contacts are closed and no forces of all together let the slips go on, they have Poisson's impact, as
several always do: that to which the impulses of ever shorter times come, ``v + h b + G p`` in complementarity with p as
h goes to zero (D. E. Stewart, Arch. Ration. Mech. Anal. 145 (1998) 215-260), and the second part that it leads to.
"""

from __future__ import annotations

import numpy as np

from kanefe.contact.rigid.cone import Cones, solved
from kanefe.frames import Vector
from kanefe.kane.rigid_contacts.impact_laws import ImpactProblem, coupled, pressed, rows_of
from kanefe.kane.rigid_contacts.stronge import Rubs, struck
from kanefe.kernels.impacts.tolerances import NOT_DETERMINED, ROUND_OFF_OF_FORCES, SHORTEST

BEYOND = 100.0
"""Change of rates in that time, relative to what accelerations without contacts make, from which it is an impact."""


def jammed(problem: ImpactProblem, rates: Vector, slips: np.ndarray, closed: np.ndarray) -> list[int]:
    """Return the contacts that slip, each alone in its group, and that a force would press in.

    Parameters
    ----------
    problem : ImpactProblem
    rates : ndarray, shape (3 k,)
        m/s.
    slips, closed : ndarray of bool, shape (k,)
    """
    found = []
    for members in coupled(problem.G):
        touching = [i for i in members if closed[i]]
        if len(touching) != 1 or not slips[touching[0]]:
            continue
        (i,) = touching
        along, own = rates[3 * i + 1 : 3 * i + 3], problem.G[3 * i, 3 * i : 3 * i + 3]
        speed = float(np.linalg.norm(along))
        if own[0] - problem.contacts[i].friction_at(speed) * (own[1:] @ along) / speed <= NOT_DETERMINED * own[0]:
            found.append(i)
    return found


def drawn_in(problem: ImpactProblem, rates: Vector, b: Vector, i: int) -> Vector | None:
    """Return the impulses (3 k,) of the impact of a jammed contact, N s; None where the limit has no single answer.

    Parameters
    ----------
    problem : ImpactProblem
    rates, b : ndarray, shape (3 k,)
        m/s, and accelerations without contact forces, m/s2.
    i : int
        Its number.
    """
    if b[3 * i] >= -ROUND_OFF_OF_FORCES * float(np.abs(b).max()):
        return None
    rows, contact = rows_of([i]), problem.contacts[i]
    before = rates[rows].copy()
    before[0] = 0.0
    own = struck(
        problem.G[np.ix_(rows, rows)], before, contact.law.restitution, Rubs(contact.friction_at, contact.static)
    )
    if own is None or own[0] <= 0.0:
        return None
    impulses = np.zeros(len(rates))
    impulses[rows] = own
    return impulses


def drawn_in_together(problem: ImpactProblem, rates: Vector, b: Vector) -> Vector | None:
    """Return the impulses (3 k,) of several contacts that friction draws in, N s; None where there are none.

    Parameters
    ----------
    problem : ImpactProblem
    rates, b : ndarray, shape (3 k,)
        m/s, and accelerations without contact forces, m/s2.
    """
    k, largest = len(problem.contacts), float(np.abs(b).max())
    if largest == 0.0:
        return None
    least = SHORTEST * float(np.abs(rates).max())
    mu, none = np.array([contact.static for contact in problem.contacts]), np.full((k, 2), np.nan)
    first = solved(Cones(problem.G, rates + least / largest * b, mu, np.zeros(k), none))
    if first is None or np.abs(problem.G @ first).max() <= BEYOND * least:
        return None  # what forces do in that time, which need no impact
    impulses = pressed(problem, rates, np.ones(k, dtype=bool), first)
    return first if impulses is None or np.abs(problem.G @ impulses).max() <= least else impulses
