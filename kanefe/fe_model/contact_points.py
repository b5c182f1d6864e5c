"""Points of a body's outside that stand for a part of it in contacts, each with its share of the area."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.skin import group_at


def contact_points(
    nodes: np.ndarray, cells: Sequence[Cells], place: PlaceLike, most: int, label: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes of a place on the outside of a body, and their shares of its area, which are 1 together.

    Shares are as the diagonal of ``int N_i N_j``, which is above zero for elements of all orders. Of more nodes than
    `most` those are taken that lie furthest from each other, and each has the shares of all that it is nearest to.

    Raises
    ------
    ModelError
        If there is no node in the place, or `most` is no number of points.
    """
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        raise ModelError(f"most of {label} must be a whole number of points, 1 or more, not {most!r}")
    group = group_at(nodes, cells, place, label)
    members = np.asarray(group.nodes)
    shares = np.ones(len(members)) if group.measure is None else group.measure.diagonal()
    shares = shares / shares.sum()
    if len(members) <= most:
        return members, shares
    places = nodes[members]
    chosen = [int(np.argmax(np.linalg.norm(places - shares @ places, axis=1)))]
    distance = np.linalg.norm(places - places[chosen[0]], axis=1)
    nearest = np.zeros(len(members), dtype=int)
    while len(chosen) < most:
        chosen.append(int(np.argmax(distance)))
        to_new = np.linalg.norm(places - places[chosen[-1]], axis=1)
        nearest[to_new < distance] = len(chosen) - 1
        distance = np.minimum(distance, to_new)
    return members[chosen], np.bincount(nearest, shares, minlength=most)
