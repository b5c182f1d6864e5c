"""The largest eigenvalue of a symmetric matrix with a mass matrix, from a few products: by Lanczos' method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.frames import Vector

ROUNDS = 40
"""Largest number of products. As many speeds or fewer have no more eigenvalues than that, and are solved at once."""

CLOSE = 0.01
"""Change of the eigenvalue over two rounds, relative to it, below which it is known: to a few times that."""


def largest_eigenvalue(answer: Callable[[Vector], Vector], product: Callable[[Vector], Vector], size: int) -> float:
    """Return the largest eigenvalue of ``X x = l M x``, from below, with X without negative eigenvalues.

    Directions ``M^-1 X x`` are orthogonal by X, in whose product the operator is symmetric (Parlett, "The Symmetric
    Eigenvalue Problem", section 15.11): neither M nor its factors are needed.

    Parameters
    ----------
    answer, product : function (x) -> ndarray
        ``M^-1 X x`` and ``X x``.
    size : int
    """
    x = answer(np.random.default_rng(0).standard_normal(size))
    directions, products = np.zeros((ROUNDS, size)), np.zeros((ROUNDS, size))
    T, known = np.zeros((ROUNDS, ROUNDS)), [0.0]
    for k in range(ROUNDS):
        length = float(np.sqrt(max(x @ product(x), 0.0)))
        if not length > np.finfo(float).eps * known[-1]:
            break
        directions[k] = x / length
        products[k] = product(directions[k])
        x = answer(directions[k])
        T[: k + 1, k] = T[k, : k + 1] = products[: k + 1] @ x
        for _ in range(2):  # a second time against round-off
            x = x - (products[: k + 1] @ x) @ directions[: k + 1]
        known.append(float(np.linalg.eigvalsh(T[: k + 1, : k + 1])[-1]))
        if k > 1 and known[-1] - known[-3] <= CLOSE * known[-1]:
            break
    return known[-1]
