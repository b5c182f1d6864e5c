"""Anchors of dry friction for the start of a run: their friction limits and slip rates."""

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
    """Return the default damping of an anchor, N s/m, from its stiffness (N/m) and the mass that it holds (kg)."""
    return 2.0 * DAMPING_RATIO * sqrt(stiffness * mass)


class Anchor(NamedTuple):
    """An anchor of a load: one to three directions in which friction acts together.

    Attributes
    ----------
    rows : ndarray, shape (r, 6 ends)
        Partial derivatives of the rates of slip with respect to velocity and angular velocity of each end, in N.
    slip : ndarray, shape (r,)
        Rates of slip.
    shares : ndarray, shape (r,)
        Weights of the directions: the friction is ``shares * x``, with the norm of x limited by `holds`.
    holds, slides : float
        Limits of static friction, and of kinetic friction at these rates, for the norm of x.
    stiffness, damping : float
        Spring and damper, the same in all directions.
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
        """Whether it slips fast: the force of its damper alone exceeds the static friction."""
        return self.damping * float(np.linalg.norm(self.slip / self.shares)) > self.holds

    @property
    def steady(self) -> Vector:
        """Friction x in steady sliding, against the slip."""
        against = self.slip / self.shares
        return self.slides / float(np.linalg.norm(against)) * against

    def stretch(self, x: Vector) -> Vector:
        """Return the stretch of the spring for a friction x; in steady sliding if it moves."""
        return (self.shares * x - (0.0 if self.moves else self.damping * self.slip)) / self.stiffness
