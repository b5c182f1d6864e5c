"""A contact about a state of rest: what sticks is held by springs to marks on the surface."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.loads.base import End


class Rest(NamedTuple):
    """Where the points of a contact were when it was at rest.

    Attributes
    ----------
    material : ndarray, shape (probes, 3)
        Points of what touches that were in contact, from its frame in its axes, m.
    marks : ndarray, shape (probes, 3)
        Where they were on the surface, from its frame in its axes, m.
    turns : ndarray, shape (probes, 3, 3)
        From the axes of what touches to those of the surface, then.
    softness : float
        Depth over which the normal force begins, m: it acts from afar too, so that a search for rest feels it. 0: it
        begins where the contact does.
    """

    material: Matrix
    marks: Matrix
    turns: np.ndarray
    softness: float

    def gone(self, i: int, surface: End, end: End) -> Vector:
        """Return how far a point has gone along with the surface since, in N, m."""
        return (end.p + end.A @ self.material[i]) - (surface.p + surface.A @ self.marks[i])

    def turned(self, i: int, surface: End, end: End) -> Vector:
        """Return how far what touches has turned past the surface since, to first order, in N, rad."""
        R = surface.A.T @ end.A @ self.turns[i].T
        turned = 0.5 * np.array((R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]))
        return np.asarray(surface.A @ turned)

    def depth(self, depth: float) -> float:
        """Return the depth that the normal law is given: ``s ln(1 + exp(depth / s))``."""
        if self.softness == 0.0:
            return depth
        x = depth / self.softness
        return self.softness * (max(x, 0.0) + math.log1p(math.exp(-abs(x))))
