"""Sizes of a scene, against which displacements are small or large."""

from __future__ import annotations

import numpy as np

from kanefe.model import Model


def scene_length(model: Model) -> float:
    """Return a length of the scene in m: its flexible bodies and the offsets in it; 1 m if it has none."""
    lengths = [float(np.ptp(b.flexible.body.nodes, axis=0).max()) for b in model.bodies if b.flexible]
    lengths += [float(np.linalg.norm(b.p_PoFo_P)) for b in model.bodies]
    lengths += [float(np.linalg.norm(b.rigid.com)) for b in model.bodies if b.rigid]
    lengths += [float(np.linalg.norm(m.point)) for c in model.constraints for m in (c.a, c.b) if m is not None]
    return max([x for x in lengths if x > 0], default=1.0)


def joint_scales(model: Model, length: float) -> np.ndarray:
    """Return a large displacement along every free speed: 1 rad, or `length` in m; infinite for elastic coordinates."""
    scales = np.full(model.free_count, np.inf)
    for body in model.bodies:
        for where, name in zip(body.speeds, body.joint.speed_names, strict=True):
            if where < model.free_count:
                scales[where] = 1.0 if "rad" in name else length
    return scales
