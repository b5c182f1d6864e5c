"""Coordinates moved along the speeds: rotations by the exponential map."""

import numpy as np

from kanefe.kernels.bodies import AllModalCoordinates
from kanefe.kernels.joints.by_kind import advance_joint
from kanefe.kernels.language import kernel
from kanefe.kernels.tables import FlexibleTables, Tables
from kanefe.kernels.tree import Links


@kernel
def advance(
    tables: Tables, flexible: FlexibleTables, q: np.ndarray, step: np.ndarray, share: float, moved: np.ndarray
) -> None:
    """Write q moved by a share of a step (free,), a vector in the directions of the free speeds times a time."""
    links = Links(tables.rows, tables.geometry)
    for i in range(len(links)):
        advance_joint(links[i], q, step, share, moved)
    bodies = AllModalCoordinates(flexible.bodies)
    for f in range(len(bodies)):
        at, speed = bodies[f].first_eta, bodies[f].first_deta
        for j in range(bodies[f].k):
            moved[at + j] = q[at + j] + share * step[speed + j]
