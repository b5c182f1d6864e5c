"""An impact that several contacts share by their compliance, of which only ratios count: nothing moves meanwhile.

    dv/dt = G F,    F_N = k x^n,    dx/dt = -v_N of what approaches, -v_N / e^2 of what parts, x >= 0

with the friction of Coulomb's cones. Its time and depths shrink with the compliance and its speeds do not: those after
it are the limit of ever stiffer contacts. Of the energy ``k x^(n+1) / (n+1)`` a share of e^2 is given back, and
friction takes some (the distributing law of C. Liu, Z. Zhao & B. Brogliato, Proc. R. Soc. Lond. A 464 (2008) 3193-3211,
over time in place of the impulse of one contact).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.contact.rigid.rigid_contact import RigidContact
from kanefe.frames import Matrix, Vector
from kanefe.kernels.impacts.tolerances import (
    HELD,
    LEAST_RESTITUTION,
    MOST_SHARING_STEPS,
    MOST_SWEEPS,
    NEARLY_HELD,
    OVER,
    SHARING_STEP,
)


def distributed(G: Matrix, rates: Vector, contacts: Sequence[RigidContact]) -> Vector | None:
    """Return the impulses (3 k,) of an impact of coupled contacts, N s; None if it does not end.

    Parameters
    ----------
    G : ndarray, shape (3 k, 3 k)
        What unit impulses do to the rates.
    rates : ndarray, shape (3 k,)
        m/s.
    contacts : sequence of RigidContact
        Of each, whose restitution, friction, stiffness and exponent count.
    """
    size, unit = float(np.abs(rates).max()), float(np.diag(G).max())
    e = np.maximum([contact.law.restitution for contact in contacts], LEAST_RESTITUTION)
    k = np.array([contact.law.stiffness for contact in contacts])
    n = np.array([contact.law.exponent for contact in contacts])
    mu = np.array([contact.static for contact in contacts])
    found = _followed(G / unit, rates / size, e, k / k.max(), n, mu)
    return None if found is None else _without_gain(G, rates, size / unit * found)


def _followed(G: Matrix, rates: Vector, e: Vector, k: Vector, n: Vector, mu: Vector) -> Vector | None:
    x, force, p, v = np.zeros(len(e)), np.zeros(len(rates)), np.zeros(len(rates)), rates.copy()
    slower, friction = 1.0 / e**2, _Friction(G, mu)
    for _ in range(MOST_SHARING_STEPS):
        parts = v[::3] > 0.0
        if not x.any() and v[::3].min() >= -OVER:
            return p
        h = SHARING_STEP * float(e[parts & (x > 0.0)].min(initial=1.0))
        x = _moved(x, v[::3], slower, 0.5 * h)
        force[::3] = k * x**n
        if not friction.put(v, h, force):
            return None
        p += h * force
        v = rates + G @ p
        x = _moved(x, v[::3], slower, 0.5 * h)
    return None


def _moved(x: Vector, rate: Vector, slower: Vector, h: float) -> Vector:
    """Return depths a little later."""
    return np.maximum(x - h * rate * np.where(rate > 0.0, slower, 1.0), 0.0)


class _Friction:
    """Friction of contacts whose normal forces are given: the least of a convex function over discs is one."""

    def __init__(self, G: Matrix, mu: Vector) -> None:
        self._G, self._mu, rows = G, mu, [slice(3 * i + 1, 3 * i + 3) for i in range(len(mu))]
        self._rows = [
            (i, own, float(np.linalg.eigvalsh(G[own, own])[-1]))
            for i, own in enumerate(rows)
            if mu[i] > 0.0 and G[own, own].any()
        ]

    def put(self, v: Vector, h: float, force: Vector) -> bool:
        """Write the friction against the slips at the end of a step; return whether it was found."""
        if not self._rows:
            return True
        largest, moved = float(force[::3].max()), v + h * self._G @ force
        worst = np.inf
        for _ in range(MOST_SWEEPS):
            worst = 0.0
            for i, own, stiffest in self._rows:
                new = force[own] - moved[own] / (h * stiffest)
                length, most = float(np.hypot(*new)), float(self._mu[i] * force[3 * i])
                change = (new * (most / length) if length > most else new) - force[own]
                force[own] += change
                moved += h * self._G[:, own] @ change
                worst = max(worst, abs(float(change[0])), abs(float(change[1])))
            if worst <= HELD * largest:
                return True
        return worst <= NEARLY_HELD * largest


def _without_gain(G: Matrix, rates: Vector, p: Vector) -> Vector:
    """Return the impulses without the energy that the errors of steps have given them."""
    taken, given = -float(p @ rates), 0.5 * float(p @ G @ p)
    return p * min(1.0, taken / given) if given > 0.0 else p
