"""Which coordinates of a scene are settled in outputs: see `kanefe.kernels.steppers.settled_outputs`."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.tree.route import Form


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
