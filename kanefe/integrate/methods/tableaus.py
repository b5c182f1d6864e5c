"""Coefficients of explicit Runge-Kutta methods, as `kanefe.kernels.steppers.explicit_steps` reads them.

Those of Dormand & Prince (1980, order 5) and of Hairer, Norsett & Wanner (1993, DOP853, order 8) are the ones that
scipy carries.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853, RK45

from kanefe.frames import Matrix


class Tableau(NamedTuple):
    """A method.

    Attributes
    ----------
    table : ndarray
        See `kanefe.kernels.steppers.explicit_steps`.
    stages, extra, estimates, dense, order : int
        Stages of a step, further ones for the dense output, rows of error estimates and of dense output, and the order
        of the error that is estimated.
    """

    table: Matrix
    stages: int
    extra: int
    estimates: int
    dense: int
    order: int


def dormand_prince_5() -> Tableau:
    """Return the method of order 5 with 7 stages, the last of which is the first of the next step."""
    # the quartic part of the dense output is all that the cubic through both ends lacks
    rows = [*_stages(RK45.A, RK45.C, RK45.B), _weights(RK45.E), _weights(RK45.P[:, 3])]
    return Tableau(_padded(rows), len(RK45.B), 0, 1, 1, 5)


def dormand_prince_8() -> Tableau:
    """Return the method of order 8 with 12 stages and dense output of order 7, which takes 3 more."""
    rows = [
        *_stages(DOP853.A, DOP853.C, DOP853.B),
        *([c, *a] for c, a in zip(DOP853.C_EXTRA, DOP853.A_EXTRA, strict=True)),
        _weights(DOP853.E5),
        _weights(DOP853.E3),
        *(_weights(d) for d in DOP853.D),
    ]
    return Tableau(_padded(rows), len(DOP853.B), len(DOP853.C_EXTRA), 2, len(DOP853.D), 8)


def classical() -> Tableau:
    """Return the classical method of order 4: no error estimate, and a cubic between the steps."""
    A = [[], [0.5], [0.0, 0.5], [0.0, 0.0, 1.0]]
    rows = _stages(A, [0.0, 0.5, 0.5, 1.0], [1 / 6, 1 / 3, 1 / 3, 1 / 6])
    return Tableau(_padded(rows), 4, 0, 0, 0, 4)


def radau_iia() -> Matrix:
    """Return the nodes and the transformation of Radau IIA of order 5, as `kanefe.kernels.steppers.radau` reads them.

    The inverse of its matrix has one real eigenvalue and a pair of complex ones (Hairer & Wanner, Solving Ordinary
    Differential Equations II, 1996, table 5.6 and IV.8).
    """
    r = np.sqrt(6.0)
    nodes = np.array([(4.0 - r) / 10.0, (4.0 + r) / 10.0, 1.0])
    powers = np.vander(nodes, 3, increasing=True)
    # collocation: exact integrals of 1, c and c^2 from zero to each node
    A = (nodes[:, None] ** np.arange(1, 4) / np.arange(1, 4)) @ np.linalg.inv(powers)
    values, shapes = np.linalg.eig(np.linalg.inv(A))
    real, upper = int(np.argmin(abs(values.imag))), int(np.argmax(values.imag))
    shape, pair = shapes[:, real].real, shapes[:, upper] / shapes[2, upper]
    T = np.column_stack((shape / shape[2], pair.real, -pair.imag))
    gamma = values[real].real
    # the error estimate: a formula of order 3 with the rates at the start, whose share is 1 / gamma
    error = np.linalg.solve(powers.T, 1.0 / np.arange(1, 4) - np.array([1.0 / gamma, 0.0, 0.0]))
    weights = gamma * (np.linalg.inv(A).T @ (error - A[2]))
    return np.vstack((nodes, T, np.linalg.inv(T), weights, [gamma, values[upper].real, values[upper].imag]))


def _stages(A: object, c: object, b: object) -> list[list[float]]:
    rows = [[c_i, *a] for c_i, a in zip(c, A, strict=True)]  # type: ignore[call-overload]
    return [*rows, [1.0, *b]]  # type: ignore[misc]


def _weights(row: object) -> list[float]:
    return [0.0, *row]  # type: ignore[misc]


def _padded(rows: list[list[float]]) -> Matrix:
    table = np.zeros((len(rows), max(len(row) for row in rows)))
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    return table
