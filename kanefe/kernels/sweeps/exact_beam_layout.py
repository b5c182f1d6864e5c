"""Where the constants of a beam that bends far, and its work, are in the tables of flexible bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.layout import COUNT, EXACT, EXACT_CELLS, EXACT_POINTS, EXACT_WORK, SECTION
from kanefe.kernels.tables import FlexibleTables

# Numbers of a section in its work: axes, place, velocity, angular velocity, remainder accelerations
AXES_AT, PLACE_AT, V_AT, W_AT, Z_AT, Y_AT = 0, 9, 12, 15, 18, 21

# Numbers in the head of a beam: axes of the root in G, and where the coordinates of the six strains begin, and end
ROOT, BEGINS, HEAD = 0, 9, 16


class Beam(NamedTuple):
    """Constants of a beam of C cells with P Gauss points each: see `kanefe.bodies.exact.beam_line.BeamLine`.

    Attributes
    ----------
    head : ndarray, shape (HEAD,)
        Axes of the root in G, and where the coordinates of each strain begin.
    lengths : ndarray, shape (C,)
    integration : ndarray, shape (P + 1, P)
    turn_rest : ndarray, shape (C (P + 1), 9)
    turn_values : ndarray, shape (3 C (P + 1), k)
    values : ndarray, shape (C P, k)
    sections : ndarray, shape (C P, 10)
        Mass, centre of mass and inertia of the Gauss points, kg, m and kg m2.
    stiffness : ndarray, shape (k, k)
    """

    head: np.ndarray
    lengths: np.ndarray
    integration: np.ndarray
    turn_rest: np.ndarray
    turn_values: np.ndarray
    values: np.ndarray
    sections: np.ndarray
    stiffness: np.ndarray


class BeamWork(NamedTuple):
    """What changes with the state of a beam of n sections.

    Attributes
    ----------
    sections : ndarray, shape (n, SECTION)
        Their motion: see the numbers above.
    motions : ndarray, shape (6 n, k)
        Its derivatives by the rates of the coordinates: velocity, angular velocity.
    slopes : ndarray, shape (9, P)
        Of the places of the Gauss points of a cell, along the beam, and their two rates.
    slope_motions : ndarray, shape (3 P, k)
        Derivatives of the first of them.
    rows : ndarray, shape (6, k)
        Workspace.
    mass : ndarray, shape (k, k)
        M in its lower half, or L.
    kept : ndarray, shape (1,)
        Whether motions and mass are those of the last evaluation: not zero.
    """

    sections: np.ndarray
    motions: np.ndarray
    slopes: np.ndarray
    slope_motions: np.ndarray
    rows: np.ndarray
    mass: np.ndarray
    kept: np.ndarray


@inlined
def beam_in(flexible: FlexibleTables, body: np.ndarray) -> Beam:
    """Return the constants of a beam, in the pool."""
    k, C, P, pool = body[COUNT], body[EXACT_CELLS], body[EXACT_POINTS], flexible.pool
    lengths = body[EXACT] + HEAD
    integration = lengths + C
    rest = integration + (P + 1) * P
    turns = rest + 9 * C * (P + 1)
    values = turns + 3 * C * (P + 1) * k
    sections = values + C * P * k
    stiffness = sections + 10 * C * P
    return Beam(
        pool[body[EXACT] : lengths],
        pool[lengths:integration],
        pool[integration:rest].reshape(P + 1, P),
        pool[rest:turns].reshape(C * (P + 1), 9),
        pool[turns:values].reshape(3 * C * (P + 1), k),
        pool[values:sections].reshape(C * P, k),
        pool[sections:stiffness].reshape(C * P, 10),
        pool[stiffness : stiffness + k * k].reshape(k, k),
    )


def beam_work_size(k: int, cells: int, points: int) -> int:
    """Return how many numbers the work of a beam takes."""
    n = 1 + cells * (points + 1)
    return n * (SECTION + 6 * k) + points * (9 + 3 * k) + 6 * k + k * k + 1


@inlined
def beam_work_in(body: np.ndarray, modal: np.ndarray) -> BeamWork:
    """Return the work of a beam, in the modal work."""
    k, C, P = body[COUNT], body[EXACT_CELLS], body[EXACT_POINTS]
    n = 1 + C * (P + 1)
    motions = body[EXACT_WORK] + n * SECTION
    slopes = motions + 6 * n * k
    slope_motions = slopes + 9 * P
    rows = slope_motions + 3 * P * k
    mass = rows + 6 * k
    kept = mass + k * k
    return BeamWork(
        modal[body[EXACT_WORK] : motions].reshape(n, SECTION),
        modal[motions:slopes].reshape(6 * n, k),
        modal[slopes:slope_motions].reshape(9, P),
        modal[slope_motions:rows].reshape(3 * P, k),
        modal[rows:mass].reshape(6, k),
        modal[mass:kept].reshape(k, k),
        modal[kept : kept + 1],
    )


def motion_of_section(body: np.ndarray, station: int) -> int:
    """Return where the motion of a section by the coordinates, (6, k), is in the modal work."""
    k, n = int(body[COUNT]), 1 + int(body[EXACT_CELLS]) * (int(body[EXACT_POINTS]) + 1)
    return int(body[EXACT_WORK]) + n * SECTION + 6 * k * station
