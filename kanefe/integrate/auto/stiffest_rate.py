"""The fastest natural frequency or decay of a scene as it starts."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.integrate.auto.largest_eigenvalue import ROUNDS, largest_eigenvalue
from kanefe.integrate.dynamics import Dynamics
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.storage.scipy_later import scipy
from kanefe.tree.route import Form
from kanefe.tree.tangents import joint_tangents


def stiffest_rate(model: Model, start: float) -> float:
    """Return the highest natural frequency or decay rate of the scene as it starts, in rad/s; zero without elasticity.

    Of K and C of flexible bodies and springs with the mass of the whole scene: a body on a hinge, or a light
    one on a stiff spring, vibrates faster than its own modes say. Of many bodies to about `CLOSE`.
    """
    state = model.literal.at(start, model.initial_coordinates, model.initial_speeds)
    if model.free_count > ROUNDS and _is_of_joints(model):
        of_joints = joint_tangents(state)
        if np.all(np.concatenate(of_joints) >= 0.0):
            return _rate_by_sweeps(model, start, *of_joints)
    return highest_rate(model, start, *model.literal.tangents(state))


def _is_of_joints(model: Model) -> bool:
    """Return whether nothing but springs and dampers in joints of a tree of rigid bodies is elastic."""
    is_rigid = all(body.flexible is None for body in model.bodies)
    return is_rigid and not model.loads and not model.constraints and not model.route.lacks(Form.SWEEPS)


def _rate_by_sweeps(model: Model, start: float, stiffness: Vector, damping: Vector) -> float:
    """Return the highest rate from accelerations by what springs and dampers do along directions: order n each."""
    dynamics = Dynamics(model)
    n, m, y = model.coordinate_count, model.free_count, dynamics.initial_state(start)

    def accelerations_of(place: int, direction: Vector) -> Vector:
        vectors = np.zeros((VECTOR.stiffness_direction + 1, len(y)))
        vectors[VECTOR.at], vectors[place, n : n + m] = y, direction
        dynamics.implicit_rate(start, vectors, 0.0, 0.0)
        return np.array(vectors[VECTOR.slope, n : n + m])

    rest = accelerations_of(VECTOR.stiffness_direction, np.zeros(m))

    def largest(place: int, diagonal: Vector) -> float:
        return largest_eigenvalue(lambda x: accelerations_of(place, x) - rest, partial(np.multiply, diagonal), m)

    return max(math.sqrt(largest(VECTOR.stiffness_direction, stiffness)), largest(VECTOR.damping_direction, damping))


def highest_rate(model: Model, start: float, K: Matrix, C: Matrix) -> float:
    """Return the same for given matrices over the free speeds, with the mass of the scene as it starts."""
    if not (np.any(K) or np.any(C)):
        return 0.0
    M = model.literal.mass_at_start(start)
    if not all(np.isfinite(X).all() for X in (K, C, M)):
        return math.inf  # the run says what overflows
    try:
        squares, rates = (_largest(X, M) for X in (K, C))
    except np.linalg.LinAlgError:
        model.literal.evaluate(start, model.initial_state)  # names what has no inertia
        raise
    return float(max(np.sqrt(max(squares, 0.0)), rates))


def _largest(X: Matrix, M: Matrix) -> float:
    """Return the largest eigenvalue of a matrix with a mass matrix; of zero zero."""
    n = len(M)
    if not np.any(X):
        return 0.0
    if n <= ROUNDS or np.any(np.diag(X) < 0.0):
        L = np.linalg.cholesky(M)  # by numpy: scipy's part for it takes longer to import than many scenes to run
        half = np.linalg.solve(L, np.tril(X) + np.tril(X, -1).T)
        return float(np.linalg.eigvalsh(np.linalg.solve(L, half.T))[-1])
    factor = scipy.linalg.cho_factor(M)
    product: Callable[[Vector], Vector] = X.__matmul__
    return largest_eigenvalue(lambda x: scipy.linalg.cho_solve(factor, product(x)), product, n)
