"""The largest rotation so far inside each flexible body of a run, seen at each step.

A bound of a body's rotation takes a product for each of its coordinates. Only where it is above the largest so far are
the rotations made.
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import Array, One, Record, Start, copy, kernel


class BentBody(Record, is_frozen=True):
    """A body that bends.

    Attributes
    ----------
    first, k : int
        Its first coordinate, and how many there are.
    count : int
        Of components of rotations.
    largest, when : float
        Square of its largest rotation, rad2, and when that was, s.
    bent : ndarray, shape (k,)
        The coordinates that made it.
    bounds : ndarray, shape (k,)
        Bound of the rotation by each coordinate of one.
    turned : ndarray, shape (count,)
        Components of rotations.
    turns : ndarray, shape (k, count)
        Those that each coordinate makes.
    """

    first: int
    k: int
    count: int
    begins: Annotated[int, Start("reals")]
    largest: Annotated[float, One(float)]
    when: Annotated[float, One(float)]
    bent: Annotated[np.ndarray, Array("k")]
    bounds: Annotated[np.ndarray, Array("k")]
    turned: Annotated[np.ndarray, Array("count")]
    turns: Annotated[np.ndarray, Array("k", "count")]


INTEGERS = BentBody.integer_count


@kernel
def watch_bends(bodies: np.ndarray, reals: np.ndarray, t: float, y: np.ndarray) -> None:
    """Keep the coordinates of each body that is bent farther than before in a state."""
    for row in range(0, len(bodies), INTEGERS):
        body = BentBody(bodies[row:], reals)
        eta, bounds, turned, turns, bound = y[body.first :], body.bounds, body.turned, body.turns, 0.0
        for i in range(len(bounds)):
            bound += bounds[i] * abs(eta[i])
        if not bound * bound > body.largest:
            continue
        turned[:] = 0.0
        for i in range(len(bounds)):
            for j in range(len(turned)):
                turned[j] += eta[i] * turns[i, j]
        largest = body.largest
        for j in range(0, len(turned), 3):
            largest = max(largest, turned[j] ** 2 + turned[j + 1] ** 2 + turned[j + 2] ** 2)
        if largest > body.largest:
            body.largest, body.when = largest, t
            copy(eta[: body.k], body.bent)
