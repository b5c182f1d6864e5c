"""Check of bodies with inertia about only one axis, as for planar scenes: they must not rotate about others."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.rigid import NO_MOMENT
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import kept_of_scene

TURNS = 1e-9
"""Fraction of a unit angular velocity across the axis that counts as zero: round-off of the axes of joints is below it.
"""


def check_planar_inertias(model: Model, t: float) -> None:
    """Raise a ModelError if a body with inertia about only one axis can rotate about others, at time t (s)."""
    planar = planar_bodies(model)
    if not planar:
        return
    state = model.route.view(t, model.initial_state)
    for number, axis in planar:
        W = state.motion(number, None).W
        if np.abs(W - np.outer(axis, axis @ W)).max(initial=0.0) > TURNS:
            raise ModelError(
                f"body {model.bodies[number].name!r} has inertia about {np.round(axis, 6).tolist()} alone, as no body "
                "in space has, and can turn about other axes. Remedy: its inertia about all three"
            )


@kept_of_scene
def planar_bodies(model: ModelData) -> list[tuple[int, Vector]]:
    """Return the numbers of the bodies with inertia about one axis alone, and these axes in their frames."""
    rigid = [
        (i, body.rigid.inertia) for i, body in enumerate(model.bodies) if body.rigid and not body.rigid.is_as_given
    ]
    if not rigid:
        return []
    moments, axes = np.linalg.eigh([inertia for _, inertia in rigid])
    is_planar = (moments[:, 2] > 0.0) & (moments[:, 1] <= NO_MOMENT * moments[:, 2])
    return [(rigid[k][0], axes[k, :, 2]) for k in np.flatnonzero(is_planar)]
