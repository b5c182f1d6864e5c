"""Normal modes of a body, with all its interfaces held or with only those fixed in G held."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError, outside
from kanefe.fe_model.progress import stage
from kanefe.fe_model.residuals import largest_residual
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.block_lanczos import lowest_modes

MANY = 200
"""Number of normal modes above which a warning about the frequency limit is issued."""


Find = Callable[[sp.spmatrix, int], tuple[np.ndarray, np.ndarray]]
"""Function of M and a number of modes that returns w^2 and M-orthonormal shapes of so many of the lowest modes."""


class ModesWarning(UserWarning):
    """A basis that the user probably did not intend."""


def normal_modes(
    problem: StaticProblem, count: int | None, up_to_frequency: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest elastic normal modes with all interfaces held.

    Parameters
    ----------
    problem : StaticProblem
    count : int or None
        Number of modes; None: all up to a frequency.
    up_to_frequency : float, optional
        Hz.

    Warns
    -----
    ModesWarning
        If there are more than `MANY` up to the frequency.

    Returns
    -------
    squares : ndarray, shape (m,)
        Squared angular frequencies, (rad/s)2.
    modes : ndarray, shape (tied, m)
        M-orthonormal shapes; zero on the interfaces.

    Raises
    ------
    ModelError
        If more modes are requested than there are degrees of freedom in the interior, and it has some.
    """
    if not len(problem.boundary):
        return free_normal_modes(problem, count, up_to_frequency)
    M, factors = problem.interior_mass, problem.factors
    if not len(problem.interior):  # all nodes belong to interfaces: their static shapes are complete
        return np.zeros(0), np.zeros((problem.size, 0))
    with stage("normal modes"):
        # factors on several processes find modes by themselves
        find = getattr(factors, "lowest_modes", None) or _found_by(factors.solve)
        found = _modes(lambda: problem.interior_stiffness, M, find, 0, count, up_to_frequency)
    return _embedded(problem, problem.interior, factors.solve, *found)


def free_normal_modes(
    problem: StaticProblem, count: int | None, up_to_frequency: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest elastic normal modes with only the components fixed in G held.

    Parameters, returns and errors are those of `normal_modes`; rigid modes of a floating body are left out.
    """
    moving = np.setdiff1d(np.arange(problem.size), np.append(problem.fixed, problem.gauge))

    def solve(b: np.ndarray) -> np.ndarray:
        forces = np.zeros((problem.size, b.shape[1]))
        forces[moving] = b
        return np.asarray(problem.solve(forces)[moving])

    def stiffness() -> sp.csr_matrix:
        return problem.stiffness[moving][:, moving]

    M = problem.mass[moving][:, moving]
    found = _modes(stiffness, M, _found_by(solve), problem.rigid_modes.shape[1], count, up_to_frequency)
    return _embedded(problem, moving, solve, *found)


def _found_by(solve: Callable[[np.ndarray], np.ndarray]) -> Find:
    """Return the function that finds modes by statics, which have no rigid motions."""
    return lambda M, count: lowest_modes(M, count, solve)


def _embedded(
    problem: StaticProblem,
    rows: np.ndarray,
    solve: Callable[[np.ndarray], np.ndarray],
    squares: np.ndarray,
    shapes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the modes in all tied coordinates, checked."""
    modes = np.zeros((problem.size, shapes.shape[1]))
    modes[rows] = shapes
    reached, asked = (problem.stiffness @ modes)[rows], (problem.mass @ modes)[rows] * squares
    residual = largest_residual("normal mode", reached, asked, moved=(shapes, solve))
    problem.note_residual("normal modes", residual)
    return squares, modes


def _modes(
    K: Callable[[], sp.spmatrix],
    M: sp.spmatrix,
    find: Find,
    rigid: int,
    count: int | None,
    up_to_frequency: float | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return `count` elastic modes of (K, M), or those up to a frequency."""
    size = M.shape[0] - rigid
    wanted = min(12, size) if count is None else count
    squares, shapes = np.zeros(0), np.zeros((M.shape[0], 0))
    while wanted > 0:
        squares, shapes = _lowest(K, M, wanted, rigid, find)
        if up_to_frequency is None:
            break
        with np.errstate(over="ignore"):  # of a frequency without end: all modes
            limit = np.square(2 * np.pi * up_to_frequency)
        if squares[-1] > limit or len(squares) >= size:
            squares, shapes = squares[squares <= limit], shapes[:, squares <= limit]
            _warn_of_many(len(squares), size, up_to_frequency)
            break
        wanted = min(2 * wanted, size)
    return squares, shapes


def _warn_of_many(count: int, size: int, up_to_frequency: float) -> None:
    if count > MANY:
        warnings.warn(
            f"up_to_frequency={up_to_frequency:g} Hz keeps {count} normal modes"
            f"{', all that the body has' if count == size else ''}: steps of a run cost with their number. Remedy: a "
            'lower frequency in Hz, modes=<number>, or modes="auto" with the highest frequency of the loads',
            ModesWarning,
            stacklevel=outside(),
        )


def _lowest(
    K: Callable[[], sp.spmatrix], M: sp.spmatrix, count: int, rigid: int, find: Find
) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and shapes of the lowest elastic modes of (K, M); `find` leaves out the rigid ones."""
    size = M.shape[0]
    if count + rigid > size:
        raise ModelError(
            f"{count} modes were asked of a body whose interior has {size} degrees of freedom. Remedy: "
            "fewer modes, or reduction=None"
        )
    if 2 * (count + rigid) > size or size <= 400:  # a Krylov space needs room; LAPACK is as fast for small matrices
        return _dense_modes(K().toarray(), M.toarray(), rigid, count)
    return find(M, count)


def _dense_modes(K: np.ndarray, M: np.ndarray, rigid: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and M-normalised shapes of the lowest elastic modes; M may be singular (lumped matrices)."""
    try:
        squares, shapes = scipy.linalg.eigh(K, M, subset_by_index=(rigid, rigid + count - 1))
        return squares, shapes
    except np.linalg.LinAlgError:
        shift = 1e-6 * np.trace(K) / np.trace(M) if rigid else 0.0
    last = len(M) - rigid - 1
    inverse, shapes = scipy.linalg.eigh(M, K + shift * M, subset_by_index=(last - count + 1, last))
    inverse, shapes = inverse[::-1], shapes[:, ::-1]
    if inverse[-1] <= 1e-13 * inverse[0]:
        raise ModelError(
            f"{count} modes were asked of a body of whose interior only {np.sum(inverse > 1e-13 * inverse[0])} degrees "
            "of freedom have mass. Remedy: fewer modes"
        )
    return 1.0 / inverse - shift, shapes / np.sqrt(inverse)
