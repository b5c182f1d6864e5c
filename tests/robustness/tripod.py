"""A mass on three bars, whose frequencies are known."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.robustness.bodies import truss
from kanefe.fe_model.damping import ModalDamping
from kanefe.reduction import flexible_body


def tripod(
    frequencies: Sequence[float] | np.ndarray, axes: np.ndarray, mass: float = 1.0, damping: float = 0.0
) -> FlexibleBody:
    """Return a mass on three bars at right angles, whose feet are clamped: its frequencies in Hz are those given.

    Parameters
    ----------
    frequencies : sequence of 3 floats
        Of the mass along each bar, Hz.
    axes : ndarray, shape (3, 3)
        Directions of the bars in its columns. Along x, y and z K is exact; else it has the round-off of its largest
        number.
    mass : float
        kg.
    damping : float
        Ratio of every mode.
    """
    nodes = np.vstack((np.zeros(3), axes.T))
    stiffnesses = mass * (2.0 * np.pi * np.asarray(frequencies)) ** 2
    bars = {(0, i + 1): float(k) for i, k in enumerate(stiffnesses)}
    bars |= {(i, j): float(stiffnesses.max()) for i, j in combinations((1, 2, 3), 2)}
    masses = np.diag((mass, 0.1 * mass, 0.1 * mass, 0.1 * mass))
    model = truss(nodes, bars, masses, {"feet": (1, 2, 3), "top": (0,)})
    return flexible_body(model, {"feet": "clamped"}, damping=ModalDamping(damping) if damping else None)
