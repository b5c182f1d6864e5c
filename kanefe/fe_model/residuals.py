"""How far solutions are from their equations: the check of every static shape and mode, whatever solver found it."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from kanefe.errors import AccuracyWarning, outside
from kanefe.frames import Vector

LARGEST = 1e-6
"""Residual relative to the load from which it is told: displacements and frequencies are off by more than that."""


def largest_residual(
    what: str,
    reached: np.ndarray,
    asked: np.ndarray,
    numbers: Vector | None = None,
    moved: tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]] | None = None,
) -> float:
    """Return the largest norm of ``reached - asked`` over that of `asked`, of each column.

    Forces in stiff directions hardly move a body: round-off along a thin sheet is large beside the forces that bend
    it. Where solutions and the inverse of K are given, a residual that would be told is the root of the energy of its
    own displacement over that of the solution, if this is less.

    Parameters
    ----------
    what : str
        Name of the solutions, for the warning.
    reached : ndarray, shape (n, m)
        Forces that the solutions take: ``K x``.
    asked : ndarray, shape (n, m)
        Forces that they should take: the load, or ``w^2 M x`` of a mode.
    numbers : ndarray, shape (m,), optional
        By which the warning names the columns. Default: from 1.
    moved : (ndarray, callable), optional
        The solutions (n, m), and the function that returns displacements (n, c) of forces (n, c).

    Warns
    -----
    AccuracyWarning
        If one is above `LARGEST`, or not a number.
    """
    if not asked.shape[1]:
        return 0.0
    sizes, errors = (np.sqrt(np.einsum("ij,ij->j", part, part)) for part in (asked, reached - asked))
    relative = errors / np.where(sizes > 0.0, sizes, 1.0)
    doubtful = np.flatnonzero(relative > LARGEST)
    if moved is not None and len(doubtful):
        shapes, solve = moved
        left = (reached - asked)[:, doubtful]
        energies = np.abs([np.einsum("ij,ij->j", left, solve(left)), (shapes * asked)[:, doubtful].sum(axis=0)])
        relative[doubtful] = np.minimum(relative[doubtful], np.sqrt(energies[0] / energies[1]))
    worst = int(np.argmax(np.where(np.isnan(relative), np.inf, relative)))
    if not relative[worst] <= LARGEST:
        name = worst + 1 if numbers is None else numbers[worst]
        warnings.warn(
            f"{what} {name} leaves {relative[worst]:.1e} of its forces unbalanced (at most {LARGEST:g} is usual): what "
            "is computed from it is off by more. Remedy: check the mesh for slivers and for materials or masses whose "
            "sizes differ by many orders, which round-off spoils",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return float(relative[worst])
