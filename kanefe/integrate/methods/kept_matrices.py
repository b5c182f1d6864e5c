"""Matrices of a Newton iteration that are kept for later iterations and steps, with the loops held."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import constrained_solver
from kanefe.kane.constraints import Rates
from kanefe.storage.scipy_later import scipy
from kanefe.tree.model_data import ModelData


class KeptMatrices(NamedTuple):
    """Step, mass matrix, iteration matrix and rows of the loops over the free speeds, of an earlier iteration.

    Attributes
    ----------
    h : float
        s.
    mass, matrix : ndarray, shape (n, n)
    rates : Rates or None
        None: nothing is constrained.
    solve : callable (force (n,), opening (m,)) -> ndarray, shape (n,)
        Return x of ``matrix x = force + J^T y, J x = opening``.
    """

    h: float
    mass: Matrix
    matrix: Matrix
    rates: Rates | None
    solve: Callable[[Vector, Vector], Vector]

    @classmethod
    def factored(cls, model: ModelData, h: float, mass: Matrix, matrix: Matrix, rates: Rates | None) -> KeptMatrices:
        """Return them with the matrix factored."""
        if rates is None:
            factors = scipy.linalg.lu_factor(matrix, check_finite=False)
            return cls(h, mass, matrix, None, partial(_solve_free, factors))
        solver = constrained_solver(model, matrix, rates)
        return cls(h, mass, matrix, rates, lambda force, opening: solver.solve(force, -opening)[0])

    @classmethod
    def from_arrays(cls, model: ModelData, h: float, arrays: Mapping[str, np.ndarray]) -> KeptMatrices:
        """Return those of `arrays`."""
        rates = None
        if "rows" in arrays:
            rates = Rates(*(np.array(arrays[name]) for name in ("rows", "remainder", "reach", "given")))
        return cls.factored(model, h, np.array(arrays["mass"]), np.array(arrays["matrix"]), rates)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what is factored, for a checkpoint."""
        found = {"mass": self.mass.copy(), "matrix": self.matrix.copy()}
        if self.rates is not None:
            found |= dict(zip(("rows", "remainder", "reach", "given"), self.rates, strict=True))
        return found

    def correction(self, difference: Vector) -> Vector:
        """Return the Newton step that takes accelerations nearer to those they should be, from the difference."""
        opening = np.zeros(0) if self.rates is None else self.rates.J @ difference
        return self.solve(self.mass @ difference, opening)

    def filtered(self, move: Vector) -> Vector:
        """Return a move without what the step does not resolve, and without what opens loops."""
        return self.solve(self.mass @ move, np.zeros(0 if self.rates is None else len(self.rates.J)))


def _solve_free(factors: tuple[Matrix, np.ndarray], force: Vector, _opening: Vector) -> Vector:
    return np.asarray(scipy.linalg.lu_solve(factors, force, check_finite=False))
