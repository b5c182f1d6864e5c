"""Flexible bodies of a few point masses and bars, built with numpy only; soft, so that they deform much."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.robustness.units import SI, Units
from kanefe.errors import UnitWarning
from kanefe.fe_model.damping import ModalDamping
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.reduction import CraigBampton, flexible_body

ROOT = np.array([[0.0, 0.2, -0.1], [0.0, -0.2, -0.1], [0.05, 0.0, 0.2]])
TIP = ROOT * [-1.0, 1.0, 1.0] + [1.0, 0.05, 0.0]
"""End nodes of a lattice, m."""


def truss(
    nodes: np.ndarray,
    bars: Mapping[tuple[int, int], float],
    mass: np.ndarray,
    groups: Mapping[str, Sequence[int]],
) -> FiniteElementModel:
    """Return nodes joined by bars that carry axial forces only.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    bars : dict of (node, node) to float
        Stiffness of each, N/m.
    mass : ndarray, shape (n, n)
        Mass matrix of the nodes, the same for each direction, kg.
    groups : dict of str to node numbers
    """
    size = len(nodes)
    K = np.zeros((3 * size, 3 * size))
    for (i, j), stiffness in bars.items():
        direction = (nodes[j] - nodes[i]) / np.linalg.norm(nodes[j] - nodes[i])
        row = np.zeros(3 * size)
        row[3 * i : 3 * i + 3], row[3 * j : 3 * j + 3] = -direction, direction
        K += stiffness * np.outer(row, row)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)  # extreme bodies and other units are intended
        return model_from_matrices(np.kron(mass, np.eye(3)), K, nodes, groups=groups, source="a truss")


def lattice(
    seed: int,
    interfaces: Mapping[str, str] | None = None,
    *,
    modes: int = 4,
    units: Units = SI,
    turn: np.ndarray | None = None,
    damping: float = 0.0,
    spring: float = 100.0,
) -> FlexibleBody:
    """Return a body of seven masses, each pair joined by a bar: about 1 m long along x, frequencies of a few hertz.

    Parameters
    ----------
    seed : int
        Seed of the random masses and bars.
    interfaces : dict, optional
        Kinds of "root" and "tip", three nodes each; default: root clamped, tip rigid, so that it can carry bodies.
    modes : int
        Number of normal modes.
    units : Units
        Units of the body.
    turn : ndarray, shape (3, 3), optional
        Rotation of the body in its mesh frame.
    damping : float
        Damping ratio of every mode.
    spring : float
        Mean stiffness of a bar, N/m.
    """
    rng = np.random.default_rng((seed, 11))
    middle = np.array([[0.5, 0.0, 0.0]]) + 0.25 * rng.uniform(-1, 1, (1, 3))
    nodes = np.vstack((ROOT, middle, TIP)) * units.length
    if turn is not None:
        nodes = nodes @ turn.T
    count = len(nodes)
    bars = {pair: float(spring * rng.uniform(0.5, 1.5) * units.stiffness) for pair in combinations(range(count), 2)}
    random = rng.uniform(0.1, 1.0, (count, count))
    mass = np.diag(rng.uniform(0.5, 1.5, count)) + 0.02 * random @ random.T
    mass *= 2.0 * units.mass / mass.sum()
    groups = {"root": (0, 1, 2), "tip": (count - 3, count - 2, count - 1)}
    return flexible_body(
        truss(nodes, bars, mass, groups),
        {"root": "clamped", "tip": "rigid"} if interfaces is None else dict(interfaces),
        reduction=CraigBampton(modes=modes),
        damping=ModalDamping(damping) if damping else None,
    )
