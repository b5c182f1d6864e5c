"""Derivatives of the rates by complex steps, exact to round-off: ``f'(y) d = Im f(y + i e d) / e``, whose e^2 vanishes.

Nothing is subtracted, so that nothing cancels (Squire & Trapp 1998).
"""

import numpy as np

from kanefe.kernels.evaluation.evaluation import DONE_AS, KEEPS
from kanefe.kernels.language import COMPLEX, Prepared, RealRows, ValueRows, call_address, entry
from kanefe.kernels.steppers.step_commands import VECTOR

COMPLEX_STEP = 1e-30


@entry(COMPLEX)
def derivatives(evaluation: Prepared, vectors: ValueRows, directions: RealRows, found: RealRows) -> bool:
    """Write derivatives of dy/dt to the rows of `found`, along the rows of `directions`; return whether all are finite.

    The first row of `vectors`, complex, is the state; `evaluation` is a call of
    `kanefe.kernels.evaluation.evaluation.evaluate` with these vectors.
    """
    at, slope = vectors[VECTOR.at], vectors[VECTOR.slope]
    for row in range(len(directions)):
        direction = directions[row]
        for i in range(len(at)):
            at[i] = complex(at[i].real, COMPLEX_STEP * direction[i])
        evaluation.places[KEEPS] = row > 0  # a direction changes a few bodies
        call_address(evaluation.address, (evaluation.places, evaluation.numbers))
        if evaluation.numbers[DONE_AS] < 0.0:
            return False
        for i in range(len(at)):
            found[row, i] = slope[i].imag / COMPLEX_STEP
            if not abs(found[row, i]) < np.inf:
                return False
    return True
