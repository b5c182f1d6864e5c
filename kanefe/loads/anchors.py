"""Anchors of dry friction, as the start of a run sees them: what each may hold, and how it slips."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

DAMPING_RATIO = 1.0
"""Damping ratio of anchors, relative to critical damping: a sticking point overshoots by exp(-2) of its change of load.
A ratio of 0.1 would give 0.7, and slip without cause. More does no harm, for example where less mass moves than assumed
here; less oscillates, and costs steps: see docs/theory/contact.md."""


def default_damping(stiffness: float, mass: float) -> float:
    """Return the damping of an anchor where none is given, N s/m, from its stiffness (N/m) and what it holds (kg)."""
    return 2.0 * DAMPING_RATIO * sqrt(stiffness * mass)


class Anchor(NamedTuple):
    """An anchor of a load: one to three directions in which friction acts together.

    Attributes
    ----------
    rows : ndarray, shape (r, 6 ends)
        Partial derivatives of the rates of slip by velocity and angular velocity of each end, in N.
    slip : ndarray, shape (r,)
        Rates of slip.
    shares : ndarray, shape (r,)
        Of friction in the directions: x with a length of no more than what it holds is a friction ``shares * x``.
    holds, slides : float
        What friction holds, and with what it rubs at these rates, of x.
    stiffness, damping : float
        Of spring and damper, the same in all directions.
    """

    rows: Matrix
    slip: Vector
    shares: Vector
    holds: float
    slides: float
    stiffness: float
    damping: float

    @property
    def moves(self) -> bool:
        """Whether it slips fast: its damper alone asks for more than friction holds."""
        return self.damping * float(np.linalg.norm(self.slip / self.shares)) > self.holds

    @property
    def steady(self) -> Vector:
        """Friction x of what moves, against its slip."""
        against = self.slip / self.shares
        return self.slides / float(np.linalg.norm(against)) * against

    def stretch(self, x: Vector) -> Vector:
        """Return the stretch of the spring with which it gives a friction x, of what moves in steady sliding."""
        friction_force = self.shares * x
        return (friction_force if self.moves else friction_force - self.damping * self.slip) / self.stiffness
