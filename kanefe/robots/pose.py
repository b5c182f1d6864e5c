"""The pose of one frame relative to another."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kanefe.frames import Matrix, Vector


@dataclass(frozen=True)
class Pose:
    """Pose of a frame B relative to a frame A.

    Attributes
    ----------
    at : ndarray, shape (3,)
        p_AoBo_A, m.
    axes : ndarray, shape (3, 3)
        A_AB.
    """

    at: Vector = field(default_factory=lambda: np.zeros(3))
    axes: Matrix = field(default_factory=lambda: np.eye(3))

    @property
    def is_none(self) -> bool:
        """Whether B is A."""
        return not self.at.any() and np.array_equal(self.axes, np.eye(3))

    @property
    def inverse(self) -> Pose:
        """Pose of A relative to B."""
        return Pose(-self.axes.T @ self.at, self.axes.T)

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.at + self.axes @ other.at, self.axes @ other.axes)
