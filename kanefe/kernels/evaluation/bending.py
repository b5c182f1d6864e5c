"""The largest rotation so far inside each flexible body of a run, seen at each step.

A bound of a body's rotation takes a product for each of its coordinates. Only where it is above the largest so far are
the rotations made.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel

# Of a body in `integers`: its first coordinate, their count, that of the rotations' components, its place in `reals`
FIRST, COUNT, COMPONENTS, PLACE = range(4)
OF_BODY = 4
# And from that place on in `reals`: the square of its largest rotation, when that was, the coordinates that made it;
# the bound of the rotation by each coordinate of one; components of rotations, and for each coordinate those it makes
LARGEST, WHEN, BENT = range(3)


@kernel
def watch_bends(bodies: np.ndarray, reals: np.ndarray, t: float, y: np.ndarray) -> None:
    """Keep the coordinates of each body that is bent farther than before in a state."""
    for row in range(0, len(bodies), OF_BODY):
        k, count, at = bodies[row + COUNT], bodies[row + COMPONENTS], bodies[row + PLACE]
        eta = y[bodies[row + FIRST] : bodies[row + FIRST] + k]
        bound, bounds = 0.0, at + BENT + k
        for i in range(k):
            bound += reals[bounds + i] * abs(eta[i])
        if not bound * bound > reals[at + LARGEST]:
            continue
        turned, turns = reals[bounds + k : bounds + k + count], reals[bounds + k + count :]
        for j in range(count):
            turned[j] = 0.0
        for i in range(k):
            for j in range(count):
                turned[j] += eta[i] * turns[i * count + j]
        largest = reals[at + LARGEST]
        for i in range(0, count, 3):
            largest = max(largest, turned[i] ** 2 + turned[i + 1] ** 2 + turned[i + 2] ** 2)
        if largest > reals[at + LARGEST]:
            reals[at + LARGEST], reals[at + WHEN] = largest, t
            copy(eta, reals[at + BENT : at + BENT + k])
