"""Signs of modes by a rule, so that a body is the same however its modes were found.

A mode is known up to its sign, and modes of one frequency, as of a round shaft, are known only together. The rule asks
for their products with fixed random columns w: each mode has a positive product with the first, and the n-th of equal
frequency none with the first n - 1. Random columns have no symmetry, so that no mode is orthogonal to them by its own.
"""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector

ALIKE = 1e-8
"""Distance of neighbouring w^2, relative to them, up to which modes are of one frequency: above round-off."""


def with_fixed_signs(modes: np.ndarray, squares: Vector) -> np.ndarray:
    """Return modes (n, k) with their signs by the rule, those of one frequency turned among themselves.

    Parameters
    ----------
    modes : ndarray, shape (n, k)
        In ascending order of `squares`.
    squares : ndarray, shape (k,)
        w^2, (rad/s)2.

    Examples
    --------
    >>> one = with_fixed_signs(np.eye(3)[:, :1], np.ones(1))
    >>> np.array_equal(one, with_fixed_signs(-np.eye(3)[:, :1], np.ones(1)))
    True
    """
    starts = np.flatnonzero(np.diff(squares, prepend=-np.inf) > ALIKE * np.abs(squares))
    groups = np.split(np.arange(len(squares)), starts[1:])
    found = np.empty_like(modes)
    random = np.random.default_rng(0).standard_normal((max(map(len, groups), default=0), len(modes)))
    for group in groups:
        products = random[: len(group)] @ modes[:, group]
        turn, upper = np.linalg.qr(products.T)  # products @ turn is lower triangular
        found[:, group] = modes[:, group] @ (turn * np.where(np.diag(upper) < 0.0, -1.0, 1.0))
    return found
