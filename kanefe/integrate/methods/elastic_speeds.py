"""Which coordinates of a scene are settled in outputs, and of which bodies vibrations fade.

See `kanefe.kernels.steppers.settled_outputs` and `kanefe.kernels.steppers.force_scales`.
"""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.equations.model import Model
from kanefe.tree.route import Form

LEAST_DAMPING = 0.005
"""Damping ratio of a mode from which a vibration is followed: it has faded to a ten-thousandth in 9 / 0.005 radians."""


def elastic_speeds(model: Model) -> np.ndarray:
    """Return the speeds of modes; none where there are no sweeps that know of their stiffness.

    Joints on springs are not among them: friction and stops act on them, whose stiffness no sweep knows.
    """
    if model.bearings or model.route.lacks(Form.SWEEPS):
        return np.zeros(0, dtype=np.int64)
    found = [np.zeros(0, dtype=np.int64)]
    for body in model.bodies:
        if body.flexible:
            found.append(np.arange(model.free_count)[body.flexible.speeds])
    of_all = np.concatenate(found)
    return of_all[of_all < model.free_count]


def is_damped(body: FlexibleBody) -> bool:
    """Return whether the vibrations of all modes of a body fade within some thousand radians."""
    k = body.free_count
    K, C, M = (np.diag(X)[:k] for X in (body.stiffness, body.damping, body.moments.elastic_mass))
    return bool(np.all(C >= 2.0 * LEAST_DAMPING * np.sqrt(np.maximum(K, 0.0) * M)))
