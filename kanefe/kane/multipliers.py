"""Forces of constraints and rigid contacts: the one share of each that reactions and contacts tell."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.assemble import held_accelerations
from kanefe.kane.constraints import constraint_rates, force_rows, touching_rows
from kanefe.kane.state import State, once
from kanefe.storage.scipy_later import scipy

DEPENDENT = 1e-9
"""Singular value of the rows of what touches, of the largest, below which forces can be shared in several ways."""


@once
def multipliers(state: State) -> Vector:
    """Return the multipliers of all rows that hold, N and N m.

    Of rigid contacts whose rows depend on each other, where some would pull, those of which the least is largest.

    What the legs of a table carry is not determined by what is rigid: as long as there is a way in which none pulls, it
    stands.
    """
    forces = held_accelerations(state)[1]
    touching = touching_rows(state)
    if len(touching) < 2:
        return forces
    first = len(forces) - sum(len(rows) for _, _, rows in touching)
    heads = first + np.cumsum([0, *(len(rows) for _, _, rows in touching[:-1])])
    if forces[heads].min() >= 0.0:
        return forces
    pushed = force_rows(state)
    P = constraint_rates(state).J if pushed is None else pushed
    n = state.model.free_count
    left, values, _ = np.linalg.svd(P[:, :n])
    rank = int(np.count_nonzero(values > DEPENDENT * values[0]))
    spare = left[:, rank:]
    if not spare.shape[1]:
        return forces
    # the largest s with forces + spare c >= s at all heads
    count = spare.shape[1]
    scale = float(np.abs(forces).max())
    best = scipy.optimize.linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.hstack((-spare[heads], np.ones((len(heads), 1)))),
        b_ub=forces[heads] / scale,
        bounds=[(None, None)] * (count + 1),
    )
    return forces if best.x is None else forces + scale * spare @ best.x[:-1]


def constraint_forces(state: State, narrow: State) -> Vector:
    """Return ``J^T lambda``, the generalised forces of the constraints, over the speeds that a state spans.

    Parameters
    ----------
    state : State
        Over whose speeds.
    narrow : State
        The same one over free and driven speeds, from which the multipliers come.
    """
    if not state.model.is_constrained:
        return np.zeros(state.columns)
    forces = force_rows(state)
    return np.asarray((constraint_rates(state).J if forces is None else forces).T @ multipliers(narrow))
