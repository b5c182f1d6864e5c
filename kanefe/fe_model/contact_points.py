"""Points on the surface of a body that represent a part of it in contacts, each with its share of the area."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.node_shares import NodeShares
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.skin import group_at


def contact_points(
    nodes: np.ndarray,
    cells: Sequence[Cells],
    groups: Sequence[NodeShares],
    place: str | PlaceLike,
    most: int,
    of: str,
    *,
    is_shell: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes of a group, or of a place on the surface of a body, and their shares of its area, of sum 1.

    If there are more nodes than `most`, those furthest from each other are taken, and each gets the shares of all nodes
    that it is nearest to.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Positions of the nodes of the mesh, m.
    cells : sequence of Cells
    groups : sequence of NodeShares
        Groups of the mesh.
    place : str or Place
        Name of a group, or a place.
    most : int
        Largest number of points.
    of : str
        Name of the owner of the points, for messages.
    is_shell : bool
        Whether cells of surfaces are shells, on which places find cells before edges.

    Raises
    ------
    ModelError
        If there is no such group, no node in the place, or `most` is not a whole number above zero.
    """
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        raise ModelError(f"most of a patch of {of} must be a whole number of points, 1 or more, not {most!r}")
    if isinstance(place, str):
        named = {group.name: group for group in groups}
        if place not in named:
            known = ", ".join(named) or "none"
            raise ModelError(
                f"{of} has no group of nodes called {place!r} for a patch. It has: {known}. Remedy: one of them, or a "
                "place such as kanefe.OnPlane"
            )
        group = named[place]
    else:
        group = NodeShares.of("", group_at(nodes, cells, place, f"a patch of {of}", is_shell=is_shell))
    members, shares = group.nodes, group.shares
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
