"""Derivatives of the rates by complex steps, exact to round-off: ``f'(y) d = Im f(y + i e d) / e``, whose e^2 vanishes.

Nothing is subtracted, so that nothing cancels (Squire & Trapp 1998).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import entry_without_arrays
from kanefe.kernels.constraints import Loops
from kanefe.kernels.evaluation import evaluate
from kanefe.kernels.layout import FlexibleTables, Tables
from kanefe.kernels.loads_between import LoadsBetween
from kanefe.kernels.stepping import AT, SLOPE

COMPLEX_STEP = 1e-30


@entry_without_arrays
def derivatives(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: LoadsBetween | None,
    loops: Loops | None,
    drives: np.ndarray,
    t: float,
    inputs: np.ndarray,
    vectors: np.ndarray,
    directions: np.ndarray,
    found: np.ndarray,
    memory: np.ndarray,
) -> bool:
    """Write derivatives of dy/dt to the rows of `found`, along the rows of `directions`; tell whether all are finite.

    The first row of `vectors`, complex, is the state; all else is as in `kanefe.kernels.evaluation.evaluate`.
    """
    at, slope = vectors[AT], vectors[SLOPE]
    for row in range(len(directions)):
        direction = directions[row]
        for i in range(len(at)):
            at[i] = complex(at[i].real, COMPLEX_STEP * direction[i])
        done, _ = evaluate(tables, flexible, between, loops, drives, t, inputs, vectors, 0.0, 0.0, memory)
        if done < 0:
            return False
        for i in range(len(at)):
            found[row, i] = slope[i].imag / COMPLEX_STEP
    return True
