"""Normal modes of a body with all its interfaces held."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.factorise import Factorisation
from kanefe.statics import StaticProblem


def normal_modes(
    problem: StaticProblem, count: int | None, up_to_frequency: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest normal modes with all interfaces held; of a body without interfaces its rigid ones too.

    Parameters
    ----------
    problem : StaticProblem
    count : int or None
        How many elastic modes; None: all those up to a frequency.
    up_to_frequency : float, optional
        Hz.

    Returns
    -------
    squares : ndarray, shape (m,)
        Squared angular frequencies, (rad/s)2.
    modes : ndarray, shape (tied, m)
        M-orthonormal shapes; zero on the interfaces.

    Raises
    ------
    ModelError
        If more modes are asked for than there are degrees of freedom.
    """
    # with interfaces the constraint modes span the rigid motions
    rigid = 0 if len(problem.boundary) else problem.rigid_count
    size = len(problem.interior)
    wanted = (12 if count is None else count) + rigid
    squares, shapes = np.zeros(0), np.zeros((size, 0))
    while wanted > 0:
        squares, shapes = _lowest(
            problem.interior_stiffness, problem.interior_mass, wanted, problem.shift, problem.factors
        )
        if up_to_frequency is None:
            break
        limit = (2 * np.pi * up_to_frequency) ** 2
        if squares[-1] > limit or len(squares) >= size:
            squares, shapes = squares[squares <= limit], shapes[:, squares <= limit]
            break
        wanted = min(2 * wanted, size)
    modes = np.zeros((problem.size, shapes.shape[1]))
    modes[problem.interior] = shapes
    return squares, modes


def _lowest(
    K: sp.csc_matrix, M: sp.csc_matrix, count: int, shift: float, factors: Factorisation
) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and shapes of the lowest modes of (K, M), using the factors of K + shift M."""
    size = K.shape[0]
    if count > size:
        raise ModelError(
            f"{count} modes were asked of a body whose interior has {size} degrees of freedom. Remedy: "
            "fewer modes, or reduction=None"
        )
    if count > size - 2 or size <= 400:  # ARPACK needs room; LAPACK is as fast for small matrices
        squares, shapes = scipy.linalg.eigh(K.toarray(), M.toarray(), subset_by_index=(0, count - 1))
        return squares, shapes
    inverse = spla.LinearOperator(K.shape, matvec=factors.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(size)  # the same modes in every run
    squares, shapes = spla.eigsh(K, k=count, M=M, sigma=-shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], shapes[:, order]
