"""Forces of rigid contacts that rigid bodies share in several ways: shared so that they can be, if they can.

What the legs of a table carry, and what friction each of them holds, is not determined by what is rigid. As long as
there is a way in which none pulls and none is asked for more than its friction, what touches stands and sticks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import held_accelerations
from kanefe.states.constraints import constraint_rates, force_rows, held_rows, touching_rows
from kanefe.states.state import State, once
from kanefe.storage.scipy_later import scipy
from kanefe.tree.row_rates import RANK_TOLERANCE, ROUND_OFF
from kanefe.tree.scales import scene_length

DEPENDENT = 1e-9
"""Singular value of the rows of closed contacts, relative to the largest, below which forces can be shared in several
ways."""

CUTS = 30
"""Largest number of rounds of planes tangent to the friction cones; each round approximates all cones more closely."""

EXACT = 1e-12
"""Accuracy of the best distribution of forces, relative to the largest force."""


class _Touching(NamedTuple):
    """Rows of what touches.

    Attributes
    ----------
    heads : ndarray of int, shape (k,)
        Rows of normal forces.
    sticks : ndarray of int, shape (s,)
        Which of them stick; two rows of friction follow these.
    mu : ndarray, shape (s,)
    """

    heads: np.ndarray
    sticks: np.ndarray
    mu: Vector

    def margins(self, forces: Vector) -> Vector:
        """Return the normal forces, then what friction could hold beyond what it does, N."""
        n = self.heads[self.sticks]
        return np.append(forces[self.heads], self.mu * forces[n] - np.hypot(forces[n + 1], forces[n + 2]))


@once
def shared_forces(state: State) -> Vector:
    """Return the multipliers of all rows that hold; those of least norm, or others where these cannot be.

    Rows that depend on each other have several that lead to the same motion. Where points touch, the norm is that of
    forces in N, and of moments in N times the length of the scene. Where by those of least norm a contact pulls or
    friction holds more than it can, friction is shared by the normal forces; where that does not help either, the least
    of all margins is made as large as it can be.
    """
    forces = held_accelerations(state)[1]
    touching = _touching(state, len(forces))
    if not len(touching.heads) or not np.all(np.isfinite(forces)):  # of a state too far ahead
        return forces
    spare = spare_forces(state)
    if not spare.shape[1]:
        return forces
    forces = _least(state, forces, spare)
    if touching.margins(forces).min() >= 0.0:
        return forces
    by_normals = _by_normals(forces, spare, touching)
    if touching.margins(by_normals).min() >= 0.0:
        return by_normals
    return _best(forces, spare, touching)


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
    return np.asarray((constraint_rates(state).J if forces is None else forces).T @ shared_forces(narrow))


def spare_forces(state: State) -> Matrix:
    """Return multipliers that together do nothing, (rows, ways)."""
    pushed, rates, free = force_rows(state), constraint_rates(state), slice(state.model.free_count)
    P = (rates.J if pushed is None else pushed)[:, free]
    moves = (P**2).sum(axis=1) > RANK_TOLERANCE * ROUND_OFF * rates.reach[:, free].sum(axis=1)  # else it is round-off
    left, values, _ = np.linalg.svd(np.where(moves[:, None], P, 0.0))
    rank = int(np.count_nonzero(values > DEPENDENT * values.max(initial=0.0)))
    return np.asarray(left[:, rank:])


def _touching(state: State, count: int) -> _Touching:
    touching = touching_rows(state)
    sizes = [len(rows) for _, _, rows in touching]
    heads = count - sum(sizes) + np.cumsum([0, *sizes[:-1]], dtype=int)
    sticks = np.flatnonzero(np.array(sizes) == 3)
    return _Touching(heads[: len(sizes)], sticks, np.array([touching[i][0].static for i in sticks]))


def _least(state: State, forces: Vector, spare: Matrix) -> Vector:
    from kanefe.constraints.rows import RADIAN

    units = np.array([scene_length(state.model) if row.unit == RADIAN else 1.0 for _, row in held_rows(state)])
    return np.asarray(forces - spare @ np.linalg.lstsq(spare / units[:, None], forces / units, rcond=None)[0])


def _by_normals(forces: Vector, spare: Matrix, touching: _Touching) -> Vector:
    """Return the forces with friction shared by what the normal forces can hold, which stay as they are."""
    n = touching.heads[touching.sticks]
    room = touching.mu * forces[n]
    if not len(n) or room.min() <= 0.0:
        return forces
    fixed = np.setdiff1d(np.arange(len(forces)), np.append(n + 1, n + 2))
    own = spare @ scipy.linalg.null_space(spare[fixed], rcond=DEPENDENT)
    weights = 1.0 / np.sqrt(np.append(room, room))
    rows = np.append(n + 1, n + 2)
    return forces + own @ np.linalg.lstsq(weights[:, None] * own[rows], -weights * forces[rows], rcond=None)[0]


def _best(forces: Vector, spare: Matrix, touching: _Touching) -> Vector:
    """Return the forces with the largest least margin: by linear programs, with planes for the cones of friction."""
    heads, n = touching.heads, touching.heads[touching.sticks]
    count, scale = spare.shape[1], float(np.abs(forces).max())
    A, b = np.hstack((-spare[heads], np.ones((len(heads), 1)))), forces[heads] / scale
    found = forces
    for _ in range(CUTS):
        sizes = np.maximum(np.hypot(found[n + 1], found[n + 2]), 1e-300)
        along, across = found[n + 1] / sizes, found[n + 2] / sizes

        def plane(x: np.ndarray, c: Vector = along, s: Vector = across) -> np.ndarray:
            return (touching.mu * x[n].T - c * x[n + 1].T - s * x[n + 2].T).T

        A = np.vstack((A, np.hstack((-plane(spare), np.ones((len(n), 1))))))
        b = np.append(b, plane(forces) / scale)
        best = scipy.optimize.linprog(
            np.append(np.zeros(count), -1.0), A_ub=A, b_ub=b, bounds=[(None, None)] * (count + 1)
        )
        if best.x is None:
            break
        found = forces + scale * spare @ best.x[:-1]
        if touching.margins(found).min() >= scale * (best.x[-1] - EXACT):
            break
    return found
