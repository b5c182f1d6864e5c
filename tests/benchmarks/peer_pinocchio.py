"""Runs in an environment of Pinocchio: public robots, and accelerations of any, asked for over pipes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

# before the peer: see there
from peer_answers import Answer, answer_requests  # isort: skip
import pinocchio  # isort: skip


def versions() -> Answer:
    """Name the peer."""
    return {"pinocchio": pinocchio.__version__}


def robots() -> Answer:
    """List the URDF files of the package example-robot-data."""
    for folder in [Path(path) for path in sys.path] + [Path(sys.prefix)]:
        found = sorted(folder.glob("cmeel.prefix/share/example-robot-data/robots/**/*.urdf"))
        if found:
            return {"files": [str(path) for path in found]}
    return {"files": []}


def accelerations(
    path: str,
    gravity: list[float],
    positions: dict[str, float],
    speeds: dict[str, float],
    couplings: list[dict[str, float]],
    base: Answer | None = None,
) -> Answer:
    """Return the acceleration of each joint without forces in joints, and of a floating base in the house's terms.

    Couplings ``sum c_i q_i = constant`` are exact: accelerations are those of least constraint.
    """
    root = [] if base is None else [pinocchio.JointModelFreeFlyer()]
    model = pinocchio.buildModelFromUrdf(path, *root)
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    q, v = pinocchio.neutral(model), np.zeros(model.nv)
    if base is not None:
        turn = pinocchio.Quaternion(*base["orientation"])
        q[:3], q[3:7] = base["position"], turn.coeffs()
        v[:3], v[3:6] = turn.matrix().T @ np.array(base["velocity"]), base["angular_velocity"]
    for name, value in positions.items():
        joint = model.joints[model.getJointId(name)]
        v[joint.idx_v] = speeds[name]
        q[joint.idx_q : joint.idx_q + joint.nq] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
    found = _least_constraint(model, data, q, v, couplings)
    answer = {name: found[model.joints[model.getJointId(name)].idx_v] for name in positions}
    if base is None:
        return {"joints": answer}
    linear = turn.matrix() @ (found[:3] + np.cross(v[3:6], v[:3]))
    return {"joints": answer, "base": [*linear, *found[3:6]]}


def _least_constraint(model: Any, data: Any, q: np.ndarray, v: np.ndarray, couplings: list[dict[str, float]]) -> Any:
    if not couplings:
        return pinocchio.aba(model, data, q, v, np.zeros(model.nv))
    rows = np.zeros((len(couplings), model.nv))
    for row, coefficients in zip(rows, couplings, strict=True):
        for name, c in coefficients.items():
            row[model.joints[model.getJointId(name)].idx_v] = c
    # the speeds that keep the couplings, an orthonormal basis of them
    free = np.linalg.svd(rows)[2][np.linalg.matrix_rank(rows) :].T
    M = pinocchio.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    bias = pinocchio.nonLinearEffects(model, data, q, v)
    return free @ np.linalg.solve(free.T @ M @ free, -free.T @ bias)


if __name__ == "__main__":
    answer_requests(versions, robots, accelerations)
