"""Matrices of small motions that overflow."""

from __future__ import annotations

import numpy as np

from kanefe.errors import SimulationError
from kanefe.frames import Matrix


def refuse_overflow(what: str, *matrices: Matrix) -> None:
    """Raise a SimulationError if a number is not finite: LAPACK fails on such matrices, or never ends."""
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        raise SimulationError(
            f"{what} overflows: a number is not finite. Remedy: check loads, stiffnesses, masses and lengths for great "
            "numbers, and their units"
        )
