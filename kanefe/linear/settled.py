"""Elastic coordinates in balance with the motion of the start, such as the stretch of a spinning blade."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.tree.body_terms import is_unreduced

ITERATIONS = 12
"""Largest number of Newton iterations."""

SETTLED = 1e-9
"""Step of the elastic coordinates, relative to them, below which they are at rest; Newton's steps end some digits
below."""


def settled(model: Model, t: float, q: Vector, u: Vector) -> Vector:
    """Return q with the elastic coordinates of bodies that stiffen in balance with the motion of the scene.

    A body is stiffened by its internal loads. A spinning blade that starts without its stretch has none yet, and its
    bending frequency would be that at rest.

    q is returned unchanged if Newton's method does not converge or the scene has loops.
    """
    bodies = [body.flexible for body in model.bodies if body.flexible is not None]
    bodies = [
        terms for terms in bodies if not is_unreduced(terms.body) and terms.body.moments.quadratic_first is not None
    ]
    if not bodies:
        return q
    at = np.concatenate([np.arange(terms.eta.start, terms.eta.stop) for terms in bodies])
    speeds = np.concatenate([np.arange(terms.speeds.start, terms.speeds.stop) for terms in bodies])
    rows, found = model.coordinate_count + speeds, q.copy()
    for _ in range(ITERATIONS):
        y = np.concatenate((found, u, model.initial_states))
        pull = model.rhs(t, y)[rows]
        if not pull.any():
            return found
        if model.is_constrained:
            break
        step = np.linalg.lstsq(model.jacobian(t, y)[np.ix_(rows, at)], -pull, rcond=1e-13)[0]
        found[at] += step
        if not np.all(np.isfinite(found)):
            break
        if np.abs(step).max() <= SETTLED * np.abs(found[at]).max():
            return found
    return q
