"""The fixed joint: a body fixed on its parent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.joints.base import Joint
from kanefe.joints.held import EVERYWHERE, Held
from kanefe.joints.link import Link


@dataclass(frozen=True)
class Fixed(Joint):
    """No motion between parent and child."""

    def initial_coordinates(self) -> Vector:
        return np.zeros(0)

    def initial_speeds(self) -> Vector:
        return np.zeros(0)

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return np.zeros(3), np.eye(3)

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return np.zeros((3, 0)), np.zeros((3, 0))

    def links(self) -> tuple[Link, ...]:
        return (Link.fixed(),)

    def held(self) -> Held:
        x, _, z = EVERYWHERE
        return Held(along=EVERYWHERE, parallel=z, is_aligned=True, facing=(x, z))
