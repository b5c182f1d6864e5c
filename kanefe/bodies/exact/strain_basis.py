"""Functions along a beam for its strains: Legendre polynomials, or B-splines of a given degree over given knots."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.storage.scipy_later import scipy

MOST_SPANS = 10_000
"""Largest number of spans between knots: a matrix of so many functions takes 0.8 GB."""


class StrainBasis(ABC):
    """Functions of the arc length over the length of the beam, x in [0, 1]."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of functions."""

    @property
    @abstractmethod
    def degree(self) -> int:
        """Largest degree of the polynomials."""

    @property
    @abstractmethod
    def breaks(self) -> np.ndarray:
        """Places within (0, 1) between which the functions are smooth."""

    @property
    def is_hierarchical(self) -> bool:
        """Whether the functions are of rising degree, so that the last ones tell what is left out."""
        return False

    @abstractmethod
    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the values of all functions at some places, (len(x), count)."""


@dataclass(frozen=True)
class Legendre(StrainBasis):
    """Legendre polynomials up to a degree over the whole beam: their error falls exponentially in smooth problems.

    Attributes
    ----------
    count : int
        Number of polynomials, the constant one included.

    Examples
    --------
    >>> Legendre(3).values(np.array([0.0, 0.5, 1.0])).tolist()
    [[1.0, -1.0, 1.0], [1.0, 0.0, -0.5], [1.0, 1.0, 1.0]]
    """

    count: int = 4

    def __post_init__(self) -> None:
        if not isinstance(self.count, (int, np.integer)) or isinstance(self.count, bool) or self.count < 1:
            raise ModelError(f"Legendre: count = {self.count!r} must be a whole number of at least 1")

    @property
    def degree(self) -> int:
        """Largest degree of the polynomials."""
        return self.count - 1

    @property
    def is_hierarchical(self) -> bool:
        """True."""
        return True

    @property
    def breaks(self) -> np.ndarray:
        """No place: the functions are smooth."""
        return np.zeros(0)

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the values of all functions at some places, (len(x), count)."""
        return np.asarray(np.polynomial.legendre.legvander(2.0 * x - 1.0, self.degree))


@dataclass(frozen=True)
class BSpline(StrainBasis):
    """B-splines, which the paper proposes for bodies that bend far (end of its discussion).

    Attributes
    ----------
    degree : int
        Of the polynomials between knots.
    knots : int or sequence of float
        Number of equal spans, or knots within (0, 1), in order. A knot that is repeated m times leaves `degree` - m
        continuous derivatives.

    Examples
    --------
    >>> BSpline(2, 4).count
    6
    """

    degree: int = 3
    knots: int | Sequence[float] = 4

    def __post_init__(self) -> None:
        if not isinstance(self.degree, (int, np.integer)) or isinstance(self.degree, bool) or self.degree < 0:
            raise ModelError(f"BSpline: degree = {self.degree!r} must be a whole number, 0 or more")
        if isinstance(self.knots, (int, np.integer)):
            if isinstance(self.knots, bool) or not 1 <= self.knots <= MOST_SPANS:
                raise ModelError(f"BSpline: knots = {self.knots!r} spans: at least 1 is needed, {MOST_SPANS} at most")
            inner = np.linspace(0.0, 1.0, self.knots + 1)[1:-1]
        else:
            inner = numbers(self.knots)
        if inner.ndim != 1 or not np.all((inner > 0.0) & (inner < 1.0)) or np.any(np.diff(inner) < 0.0):
            raise ModelError(
                f"BSpline: knots must be in order and within (0, 1), the arc length over the length of the beam, not "
                f"{self.knots!r}"
            )
        for knot in np.unique(inner):
            if (times := int(np.count_nonzero(inner == knot))) > self.degree + 1:
                raise ModelError(
                    f"BSpline: the knot {knot:g} is given {times} times, more than degree + 1 = {self.degree + 1}, so "
                    "that a function is zero. Remedy: fewer repetitions, or a higher degree"
                )
        ends = np.zeros(self.degree + 1), np.ones(self.degree + 1)
        object.__setattr__(self, "_all", np.concatenate((ends[0], inner, ends[1])))

    @property
    def count(self) -> int:
        """Number of functions."""
        return len(self._all) - self.degree - 1  # type: ignore[attr-defined]

    @property
    def breaks(self) -> np.ndarray:
        """The knots within (0, 1), each once."""
        return np.unique(self._all[self.degree + 1 : -self.degree - 1])  # type: ignore[attr-defined]

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the values of all functions at some places, (len(x), count)."""
        knots: np.ndarray = self._all  # type: ignore[attr-defined]
        return np.asarray(scipy.interpolate.BSpline.design_matrix(x, knots, self.degree).toarray())
