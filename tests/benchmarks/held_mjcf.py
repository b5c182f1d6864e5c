"""Accelerations of a model whose equalities hold exactly, by MuJoCo's inertia, forces and Jacobians."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Held(NamedTuple):
    """What equalities hold: ``rows @ qacc = -rest``."""

    rows: np.ndarray
    rest: np.ndarray


def held_by(model: Any, state: Any) -> Held:
    """Return what the equalities of a model hold in a state; coordinates of coupled joints are moved to fit."""
    import mujoco

    equality, off = mujoco.mjtEq, mujoco.mjtDisableBit
    rows, rest = [np.zeros((0, model.nv))], [np.zeros(0)]
    if model.opt.disableflags & (off.mjDSBL_EQUALITY | off.mjDSBL_CONSTRAINT):
        return Held(rows[0], rest[0])
    for number in range(model.neq):
        if model.eq_type[number] == equality.mjEQ_JOINT:
            rows.append(_coupled(model, state, number))
            rest.append(np.zeros(1))
    mujoco.mj_forward(model, state)
    for number in range(model.neq):
        data, bodies = model.eq_data[number], (model.eq_obj1id[number], model.eq_obj2id[number])
        if model.eq_type[number] != equality.mjEQ_JOINT:
            is_weld = model.eq_type[number] == equality.mjEQ_WELD
            place = state.body(bodies[1]).xpos + state.body(bodies[1]).xmat.reshape(3, 3) @ data[:3]
            if not is_weld:
                place = state.body(bodies[0]).xpos + state.body(bodies[0]).xmat.reshape(3, 3) @ data[:3]
            one, two = (_jacobians(model, state, place, body) for body in bodies)
            count = 6 if is_weld and data[10] else 3
            rows.append((one[0] - two[0])[:count])
            rest.append((one[1] - two[1])[:count] @ state.qvel)
    return Held(np.concatenate(rows), np.concatenate(rest))


def accelerations(model: Any, state: Any, held: Held) -> np.ndarray:
    """Return the accelerations under what is held; without it those of `mj_forward`."""
    import mujoco

    mujoco.mj_forward(model, state)
    if not len(held.rows):
        return np.array(state.qacc)
    _check_rows(model, state, held)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, state, inertia)
    free = np.linalg.solve(inertia, state.qfrc_smooth)
    # by the root of the inertia the pull of redundant rows is that of least squares
    root = np.linalg.cholesky(inertia)
    scaled = np.linalg.solve(root, held.rows.T).T
    missing = np.linalg.pinv(scaled, rcond=1e-10) @ (-held.rest - held.rows @ free)
    return free + np.linalg.solve(root.T, missing)


def _coupled(model: Any, state: Any, number: int) -> np.ndarray:
    """Move the first of two coupled joints to where the second puts it, and return the row of the coupling."""
    one, two = model.eq_obj1id[number], model.eq_obj2id[number]
    (constant, factor), place, row = model.eq_data[number, :2], model.jnt_qposadr, np.zeros((1, model.nv))
    state.qpos[place[one]] = model.qpos0[place[one]] + constant
    row[0, model.jnt_dofadr[one]] = 1.0
    if two >= 0:
        state.qpos[place[one]] += factor * (state.qpos[place[two]] - model.qpos0[place[two]])
        row[0, model.jnt_dofadr[two]] = -factor
    return row


def _jacobians(model: Any, state: Any, place: np.ndarray, body: int) -> tuple[np.ndarray, np.ndarray]:
    """Return those of velocity and angular velocity of a body at a place, (6, nv), and their rates."""
    import mujoco

    found = []
    for jacobian in (mujoco.mj_jac, mujoco.mj_jacDot):
        made = np.zeros((6, model.nv))
        jacobian(model, state, made[:3], made[3:], place, body)
        found.append(made)
    return found[0], found[1]


def _check_rows(model: Any, state: Any, held: Held) -> None:
    """Raise an AssertionError if MuJoCo's own rows allow or forbid other speeds, or are not satisfied in the state."""
    import mujoco

    own = np.zeros((state.nefc, model.nv))
    if mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(own, state.efc_J, state.efc_J_rownnz, state.efc_J_rowadr, state.efc_J_colind)
    else:
        own[:] = state.efc_J.reshape(-1, model.nv)
    ranks = [np.linalg.matrix_rank(rows, tol=1e-9) for rows in (own, held.rows, np.concatenate((own, held.rows)))]
    assert len(set(ranks)) == 1, ranks
    assert abs(state.efc_pos).max() < 1e-12, state.efc_pos
