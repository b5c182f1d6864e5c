"""Contact points of shells: balls of half the thickness in its middle, which touch at either face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shell_stack import ShellStack


class ShellBall(NamedTuple):
    """A ball in the thickness of a shell, which touches what comes to either face.

    Attributes
    ----------
    point : int
        Number of the contact point with which it moves and turns.
    centre : ndarray, shape (3,)
        Of the thickness, from that point, m.
    radius : float
        Half the thickness, m.
    """

    point: int
    centre: np.ndarray
    radius: float


def balls_in_thickness(stack: ShellStack, nodes: np.ndarray) -> tuple[ShellBall, ...]:
    """Return the balls of contact points at nodes (k,); on folds one for each side, if the middle is off the nodes.

    A node that belongs to no shell has a ball of radius zero.
    """
    places, found = stack.places, []
    ends = stack.heights_of(places.section) * places.thickness[:, None]
    middles = ends.mean(axis=1)[:, None] * places.director
    radii = np.diff(ends, axis=1)[:, 0] / 2.0
    for number, node in enumerate(nodes):
        here = np.flatnonzero(places.node == node)
        rows = np.column_stack((middles[here], radii[here]))
        finest = 1e-9 * max(float(np.abs(rows).max(initial=0.0)), 1e-300)
        kept = np.unique(np.round(rows / finest), axis=0, return_index=True)[1] if len(rows) else ()
        found += [ShellBall(number, rows[i, :3], float(rows[i, 3])) for i in kept] or [
            ShellBall(number, np.zeros(3), 0.0)
        ]
    return tuple(found)
