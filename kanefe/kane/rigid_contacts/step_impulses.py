"""Impulses of closed contacts in a step over impacts: by Newton's restitution, as far as that makes no energy.

    y = v_E + s e v_A along the normal, v_E across it,    v_E = v_free + G I

obeys Coulomb's law with impulses I, whose work is ``I (v_A + v_E) / 2``. With friction, and between several contacts,
Newton's restitution may make energy (Kane & Levinson, "Dynamics: Theory and Applications", 1985): there the share s of
it is the largest, below 1, with which it does not. Forces that turn a motion round within a step may let impulses do
work without any restitution, by what is of second order in the step: there the mean ``(v_A + v_E) / 2`` obeys the law,
whose work then is that of Coulomb's friction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.contact.rigid.cone import Cones, residual, solved
from kanefe.frames import Matrix, Vector
from kanefe.kane.rigid_contacts.impact_laws import coupled, rows_of
from kanefe.kernels.impacts.tolerances import HALVINGS, ROUND_OFF_OF_FORCES


class Struck(NamedTuple):
    """Impulses of closed contacts.

    Attributes
    ----------
    impulses : ndarray, shape (3 k,)
        N s.
    residual : float
        Of their complementarity, of the largest.
    lowered : int
        Of how many groups of contacts, which move each other, the restitution was lowered.
    """

    impulses: Vector
    residual: float
    lowered: int


def struck(G: Matrix, before: Vector, freely: Vector, mu: Vector, restitution: Vector) -> Struck | None:
    """Return the impulses; None where none were found.

    Parameters
    ----------
    G : ndarray, shape (3 k, 3 k)
        What unit impulses do to the rates.
    before, freely : ndarray, shape (3 k,)
        Rates before the step and after it without impulses, m/s.
    mu, restitution : ndarray, shape (k,)
    """
    impulses, left, lowered = np.zeros(len(before)), 0.0, 0
    for members in coupled(G, apart=0.0):
        rows = rows_of(members)
        part = _Island(G[np.ix_(rows, rows)], before[rows], freely[rows], mu[members], restitution[members])
        found = part.struck()
        if found is None:
            return None
        impulses[rows] = found.impulses
        left, lowered = max(left, found.residual), lowered + found.lowered
    return Struck(impulses, left, lowered)


class _Island(NamedTuple):
    """Contacts that move each other; attributes as in `struck`."""

    G: Matrix
    before: Vector
    freely: Vector
    mu: Vector
    restitution: Vector

    def struck(self) -> Struck | None:
        """Return the impulses."""
        found = self._by(1.0, 0.0)
        if found is None or not self._makes_energy(found.impulses):
            return found
        found = self._by(0.0, 0.0)
        if found is None:
            return None
        if self._makes_energy(found.impulses):
            return self._by(0.0, 1.0)
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            tried = self._by(share, 0.0)
            if tried is None or self._makes_energy(tried.impulses):
                high = share
            else:
                low, found = share, tried
        return found._replace(lowered=1)

    def _by(self, share: float, of_all: float) -> Struck | None:
        """Return the impulses by shares of the restitution, and of the rates before that count in all directions."""
        b = self.freely + of_all * self.before
        b[::3] += share * self.restitution * self.before[::3]
        problem = Cones(self.G, b, self.mu, np.zeros(len(self.mu)), np.full((len(self.mu), 2), np.nan))
        found = solved(problem)
        if found is None:
            return None
        softest, fastest = float(np.diag(self.G).max()), float(np.abs(self.before).max())
        largest = max(float(np.abs(found).max()), fastest / softest, 1e-300)
        return Struck(found, residual(problem, found) / largest, 0)

    def _makes_energy(self, impulses: Vector) -> bool:
        """Return whether impulses do work beyond round-off."""
        mean = 0.5 * (self.before + self.freely + self.G @ impulses)
        fastest = max(float(np.abs(self.before).max()), float(np.abs(self.freely).max()))
        return float(impulses @ mean) > ROUND_OFF_OF_FORCES * fastest * float(np.abs(impulses).sum())
