"""Forces of one state, as those of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector

if TYPE_CHECKING:
    from kanefe.tree.route import Route
    from kanefe.tree.run_sweeps import RunForces


def forces_of(route: Route, t: float, y: Vector) -> RunForces:
    """Return the forces of a state (q, u, z), as those of a run of one time."""
    times, states = np.array((t,)), np.array(y, dtype=float)[None]
    sweeps = route.sweeps(times, states)
    if sweeps is not None:
        return sweeps.forces
    from kanefe.literal.run_forces import LiteralForces

    return LiteralForces.of_states(route, times, states)
