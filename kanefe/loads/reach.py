"""Region where a load can act: balls about its ends and bounds of their opposite sides, tested before it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

EVERYWHERE = np.full(3, np.inf)


class Bounds(NamedTuple):
    """A box, rounded by a ball, out of which there is nothing to meet; of a room: in which there is nothing.

    Attributes
    ----------
    lower, upper : ndarray, shape (3,)
        Corners in its axes, m; infinite where it has no end.
    axes : ndarray, shape (3, 3)
        Its axes to those of its frame.
    rounding : float
        m.
    stretch : float
        By how much more than its radius a ball has to be away.
    is_room : bool
    """

    lower: Vector = -EVERYWHERE
    upper: Vector = EVERYWHERE
    axes: Matrix = np.eye(3)
    rounding: float = 0.0
    stretch: float = 1.0
    is_room: bool = False

    @property
    def is_bounded(self) -> bool:
        """Whether it ends in all directions."""
        return not self.is_room and bool(np.all(np.isfinite(self.lower)) and np.all(np.isfinite(self.upper)))

    @property
    def size(self) -> float:
        """Radius of the ball about it, m; 0 where it has no end."""
        return 0.5 * float(np.linalg.norm(self.upper - self.lower)) + self.rounding if self.is_bounded else 0.0


class LoadReach(NamedTuple):
    """Where a load acts at all, and what it does elsewhere.

    Attributes
    ----------
    probes : tuple of (int, ndarray (3,), float)
        Balls that hold all that it acts by: end, centre from the end in its axes and radius, m.
    bounds : Bounds
        Of what they meet, in the axes of the first end. Where none of them does, nothing acts.
    decays : ndarray, shape (states, 2)
        l and e of each internal state where nothing acts: ``dz/dt = -l z``, and an energy ``e z^2``, J.
    watched : tuple of float
        What its events see there, for each of them: so much of how far it is from acting.
    """

    probes: tuple[tuple[int, Vector, float], ...]
    bounds: Bounds
    decays: Matrix
    watched: tuple[float, ...]
