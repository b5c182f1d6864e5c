"""Load continuation towards a rest: from the rest without the loads, along the path on which they are raised together.

Newton's method fails where a scene moves far under its loads, such as a beam that coils up. The path leads there, also
past limit points, by arc length: see `kanefe.linear.paths.arc_length`.
"""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.paths.arc_length import PathLost, Stop
from kanefe.linear.paths.loaded_scene import LoadedScene
from kanefe.linear.paths.traced import first_stop
from kanefe.linear.paths.walk import Walk
from kanefe.linear.paths.zeros import crossing_of_factor
from kanefe.linear.stability.raised_loads import chosen_loads

LONGEST = 1.0
"""Largest change of a coordinate in one step, rad or scene lengths: the bend of the path determines the steps."""

MOST_STOPS = 1000
"""Largest number of steps."""


def raised_to(model: Model, t: float, q: Vector) -> Vector | None:
    """Return the coordinates of the first rest under all loads on the path that begins at the rest without them.

    None if nothing is raised, if something is not held without the loads, or if the path ends before.

    Parameters
    ----------
    model : Model
        At rest, without contacts and friction.
    t : float
        s.
    q : ndarray, shape (coordinates,)
        Where the search for the rest without the loads begins.
    """
    try:
        raised, _ = chosen_loads(model, t, None, "equilibrium")
        scene = LoadedScene(model, t, raised, 1.0)
        search = BalanceSearch(scene.model_at(0.0), t, q, np.zeros(model.free_count), np.zeros(0, dtype=int), ())
        begun = search.run()[0]
        if not search.is_stiff(begun):
            return None
        here, walk = first_stop(scene, begun, 0.0, 1.0), Walk(scene, LONGEST)
        for _ in range(MOST_STOPS):
            there: Stop = walk.next(here)
            if there.factor >= 1.0:
                return crossing_of_factor(scene, here, there, 1.0).q
            if there.factor <= 0.0:
                return None
            here.balance.forget()
            here = there
    except (KanefeError, PathLost, np.linalg.LinAlgError):
        return None
    return None
