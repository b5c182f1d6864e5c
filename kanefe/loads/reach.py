"""Region in which a load can act: spheres at its ends and bounds of the opposite side, tested before the load."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

EVERYWHERE = np.full(3, np.inf)


class Bounds(NamedTuple):
    """A box, rounded by a sphere, that contains the surface; for a room the surface is outside of the box.

    Attributes
    ----------
    lower, upper : ndarray, shape (3,)
        Corners in its axes, m; infinite if it is unbounded.
    axes : ndarray, shape (3, 3)
        Rotation matrix from its axes to those of its frame.
    rounding : float
        m.
    stretch : float
        Factor of a sphere's radius for its distance.
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
        """Whether it is bounded in all directions."""
        return not self.is_room and bool(np.all(np.isfinite(self.lower)) and np.all(np.isfinite(self.upper)))

    @property
    def size(self) -> float:
        """Radius of the enclosing sphere, m; 0 if it is unbounded."""
        return 0.5 * float(np.linalg.norm(self.upper - self.lower)) + self.rounding if self.is_bounded else 0.0


class LoadReach(NamedTuple):
    """The region in which a load can act, and its states and events elsewhere.

    Attributes
    ----------
    probes : tuple of (int, ndarray (3,), float)
        Spheres that contain its contact points: end, centre from the end in its axes and radius, m.
    bounds : Bounds
        Bounds of the touched side, in the axes of the first end. The load acts only if a sphere meets them.
    decays : ndarray, shape (states, 2)
        l and e of each internal state while it does not act: ``dz/dt = -l z``, and an energy ``e z^2``, J.
    watched : tuple of float
        Factor for each event: its function is then this factor times the distance from acting.
    """

    probes: tuple[tuple[int, Vector, float], ...]
    bounds: Bounds
    decays: Matrix
    watched: tuple[float, ...]
