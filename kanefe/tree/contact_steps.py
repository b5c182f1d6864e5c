"""Steps over the impacts of rigid contacts: what they lead to, and the impulses in them, which kernels find."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.impacts.cones import problem_of, solve_one
from kanefe.kernels.impacts.step_impulses import Tried, closed_points, solve_step, step_of
from kanefe.kernels.values.tensors import Vector as Three
from kanefe.tree.model_data import ModelData
from kanefe.tree.rigid_points import rigid_points


class Stepped(NamedTuple):
    """What a step over impacts leads to.

    Attributes
    ----------
    y : ndarray
        State (q, u, z, energy dissipated, work) at its end.
    impulses : ndarray, shape (3 k,)
        Of the contacts that were closed, N s.
    closed : list of (int, int)
        Of the contacts that were closed: the number among the rigid ones, and of the probe.
    deepest : float
        Depth of the deepest of them at the midpoint, m.
    residual : float
        Of their complementarity, of the largest impulse.
    approach, bend : float
        By how much a step may enter a surface that it has not met before, and one along which it goes, m.
    lowered : int
        Of how many groups of contacts the restitution was lowered.
    """

    y: Vector
    impulses: Vector
    closed: list[tuple[int, int]]
    deepest: float
    residual: float
    approach: float
    bend: float
    lowered: int


def struck(
    model: ModelData, closed: list[int], G: Matrix, before: Vector, freely: Vector
) -> tuple[Vector, float, float] | None:
    """Return the impulses of closed points (3 k,), their residual, and of how many groups restitution was lowered.

    None where none were found.

    Parameters
    ----------
    model : ModelData
    closed : list of int
        Numbers of the points.
    G : ndarray, shape (3 k, 3 k)
        What unit impulses do to the rates.
    before, freely : ndarray, shape (3 k,)
        Rates before the step and after it without impulses, m/s.
    """
    table = rigid_points(model)
    table, k = table._replace(places=table.places[closed], numbers=table.numbers[closed]), len(closed)
    problem = problem_of(k)
    step = step_of(table, problem, solve_one.bound(problem).prepared().for_kernels(), np.ascontiguousarray(G))
    found = Tried(step.tried, step.told)
    found.closed = k
    for a, one in enumerate(closed_points(step)):
        one.point, one.before, one.freely = a, Three(*before[3 * a : 3 * a + 3]), Three(*freely[3 * a : 3 * a + 3])
    if not solve_step(step):
        return None
    return np.array([one.impulse.numbers for one in closed_points(step)]).ravel(), found.residual, found.lowered
