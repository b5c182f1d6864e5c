"""Anderson acceleration of an iteration x -> g(x): the next x is mixed from the last values g.

Weights are those with which the residuals g - x of the last iterations nearly cancel, by least squares (Walker & Ni,
Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 2011). So the few directions in which an
iteration converges slowly, or not at all, are found and left out, for no more evaluations and some products of vectors.
"""

import numpy as np

from kanefe.kernels.language import copy, kernel, vector_kernel
from kanefe.kernels.sweeps.elastic import total

DEPTH = 5
"""Number of earlier iterations that are mixed: there are about as many slow directions."""

ROWS_OF_MIXING = 2 + 2 * DEPTH
"""Rows of the last residual and the last step, and of pairs of changes of both; those of residuals are orthonormal."""

DEPENDENT = 1e-6
"""Part of a change of the residual that is independent of the others, relative to it, below which it is ignored."""


@kernel
def mix(memory: np.ndarray, call: int, residual: np.ndarray, answer: np.ndarray, mixed: np.ndarray) -> None:
    """Write the next x.

    Parameters
    ----------
    memory : ndarray, shape (ROWS_OF_MIXING, n)
        Of the earlier calls; the first one needs none.
    call : int
        How many calls there were before for this solution.
    residual, answer : ndarray, shape (n,)
        Weighted g - x, weights the same in all calls, and g.
    mixed : ndarray, shape (n,)
        On return the next x.
    """
    if call > 0:
        slot = 2 + 2 * ((call - 1) % DEPTH)
        change, effect = memory[slot], memory[slot + 1]
        for i in range(len(change)):
            change[i] = residual[i] - memory[0, i]
            effect[i] = answer[i] - memory[1, i]
        whole = np.sqrt(total(change, change))
        for k in range(2, 2 + 2 * min(call - 1, DEPTH), 2):
            if k != slot:
                share = total(memory[k], change)
                _add(-share, memory[k], change)
                _add(-share, memory[k + 1], effect)
        rest = np.sqrt(total(change, change))
        scale = 1.0 / rest if rest > DEPENDENT * whole else 0.0
        for i in range(len(change)):
            change[i] *= scale
            effect[i] *= scale
    copy(residual, memory[0])
    copy(answer, memory[1])
    copy(answer, mixed)
    for k in range(2, 2 + 2 * min(call, DEPTH), 2):
        _add(-total(memory[k], residual), memory[k + 1], mixed)


@vector_kernel
def _add(share: float, x: np.ndarray, y: np.ndarray) -> None:
    for i in range(len(x)):
        y[i] += share * x[i]
