"""Damping of the deformation of a flexible body.

C acts on the rate of deformation in G, so that it never damps rigid motion (in the paper's Eq. 27 it acts on the
absolute nodal velocity, which damps rigid motion whenever C has a part proportional to M).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.arguments import checked, plain_numbers
from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.frames import numbers

MOST_MODES = 1_000_000
"""Largest number of modes of one body: a larger number is a mistake."""


@dataclass(frozen=True)
class RayleighDamping:
    """C = mass * M + stiffness * K.

    Parameters
    ----------
    mass : float
        Factor of M in 1/s.
    stiffness : float
        Factor of K in s.

    Raises
    ------
    ModelError
        If a factor is negative or not finite.
    """

    mass: float = 0.0
    stiffness: float = 0.0

    def __post_init__(self) -> None:
        for name in ("mass", "stiffness"):
            value = getattr(self, name)
            number = numbers(value)
            if number.shape != () or not (np.isfinite(number) and number >= 0):
                raise ModelError(f"Rayleigh damping: the {name} factor must be finite and >= 0, not {value!r}")
        plain_numbers(self)

    @classmethod
    @checked("frequencies", "ratios")
    def fit(cls, frequencies: Sequence[float], ratios: Sequence[float]) -> RayleighDamping:
        """Return the factors that give two damping ratios at two frequencies (Hz).

        Raises
        ------
        ModelError
            If the frequencies are equal or not positive, a ratio is above 1, or the fit needs a negative factor.

        Examples
        --------
        >>> fitted = RayleighDamping.fit((10.0, 100.0), (0.02, 0.02))
        >>> round(fitted.ratio(10.0), 12), round(fitted.ratio(100.0), 12)
        (0.02, 0.02)
        """
        given, w = numbers(ratios), 2 * math.pi * numbers(frequencies)
        if not (given.shape == w.shape == (2,) and np.all(np.isfinite((given, w))) and w.min() > 0 and w[0] != w[1]):
            raise ModelError(
                f"Rayleigh damping is fitted to two ratios at two different frequencies above zero, "
                f"not to {ratios!r} at {frequencies!r} Hz"
            )
        _check_vibrates(given, "a damping ratio to be fitted", "; factors that damp so much are given as such")
        mass, stiffness = np.linalg.solve(np.column_stack((0.5 / w, 0.5 * w)), given)
        if min(mass, stiffness) < 0:
            raise ModelError(
                f"ratios {tuple(ratios)} at {tuple(frequencies)} Hz need a negative Rayleigh factor "
                f"(mass {mass:.3g} 1/s, stiffness {stiffness:.3g} s). Remedy: closer ratios, or ModalDamping"
            )
        return cls(float(mass), float(stiffness))

    @checked
    def ratio(self, frequency: float) -> float:
        """Return the damping ratio at a frequency in Hz."""
        if frequency <= 0.0:
            raise ModelError(f"the frequency of a damping ratio must be above zero Hz, not {frequency!r}")
        w = 2 * math.pi * frequency
        return 0.5 * (self.mass / w + self.stiffness * w)


@dataclass(frozen=True)
class ModalDamping:
    """A damping ratio for each elastic mode of the body alone, with its fixed interfaces held.

    In a scene what the body carries lowers frequencies and ratios: an arm with 1 % has 0.41 % with a tool of its own
    weight at its tip, for the damping of its material stays the same. `kanefe.SceneDamping` gives ratios of the modes
    of a scene; their table, ``print(kf.linearise(scene).modes())``, shows both.

    Parameters
    ----------
    ratio : float or sequence of float
        One ratio for all modes, or the ratios of the first modes; the last one applies to all further modes. 0.05 is
        5 % of critical damping.
    overdamped : bool
        Whether ratios above 1 are intended: such modes return to rest without vibration.

    Raises
    ------
    ModelError
        If a ratio is negative or not finite, or above 1 without `overdamped`.
    """

    ratio: float | Sequence[float]
    overdamped: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        values = np.atleast_1d(numbers(self.ratio))
        if values.ndim != 1 or not len(values) or not np.all(np.isfinite(values)) or np.any(values < 0):
            raise ModelError(f"modal damping ratios must be finite and >= 0, not {self.ratio!r}")
        if not self.overdamped:
            _check_vibrates(values, "a modal damping ratio", ", or overdamped=True if it is meant")

    @checked("count")
    def ratios(self, count: int) -> np.ndarray:
        """Return one ratio for each of `count` modes, shape (count,).

        Raises
        ------
        ModelError
            If more ratios were given than there are modes.
        """
        values = np.atleast_1d(numbers(self.ratio))
        if count > MOST_MODES:
            raise ModelError(f"count of modes must be {MOST_MODES} at most, not {count!r}")
        if len(values) > count:
            raise ModelError(
                f"{len(values)} damping ratios were given for {count} elastic modes. Remedy: leave some out"
            )
        return np.concatenate((values, np.full(count - len(values), values[-1])))


def _check_vibrates(ratios: np.ndarray, what: str, meant: str) -> None:
    """Raise a ModelError if a damping ratio is above critical damping: it was probably given in percent."""
    largest = float(ratios.max())
    if largest > 1.0:
        raise ModelError(
            f"{what} of {largest:g} is above 1, that of critical damping: such a mode does not vibrate. Remedy: "
            f"{largest / 100.0:g} for {largest:g} %{meant}"
        )


Damping: TypeAlias = RayleighDamping | ModalDamping | sp.spmatrix | np.ndarray | None
"""Types of the `damping` argument of a body."""


def damping_matrix(
    damping: Damping, model: FiniteElementModel, free_basis: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    """Return C of the free coordinates, shape (k, k)."""
    count = len(stiffness)
    if damping is None:
        damping = model.damping
    if damping is None or count == 0:
        return np.zeros((count, count))
    if isinstance(damping, (RayleighDamping, ModalDamping)):
        return damping_of(damping, stiffness, free_basis.T @ (model.mass @ free_basis))
    C = checked_damping(damping, model)
    reduced = free_basis.T @ (C @ free_basis)
    if np.linalg.eigvalsh(reduced).min() < -1e-9 * abs(reduced).max():
        raise ModelError("the damping matrix feeds energy in (it has a negative eigenvalue). Remedy: check its signs")
    return reduced


def damping_of(damping: RayleighDamping | ModalDamping, stiffness: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return C of coordinates with these matrices, shape (k, k)."""
    if isinstance(damping, RayleighDamping):
        return damping.mass * mass + damping.stiffness * stiffness
    if not (np.isfinite(stiffness).all() and np.isfinite(mass).all()):
        raise ModelError("stiffness or mass is not finite. Remedy: check lengths and materials, in SI")
    squares, shapes = scipy.linalg.eigh(stiffness, mass)
    weighted = mass @ shapes
    rates = 2 * damping.ratios(len(stiffness)) * np.sqrt(np.maximum(squares, 0.0))
    return np.asarray((weighted * rates) @ weighted.T)


def real_matrix(given: object) -> sp.csr_matrix:
    """Return a matrix, dense or sparse, as a sparse one of floats; if it is not a matrix, a single NaN."""
    if sp.issparse(given):
        return sp.csr_matrix(given, dtype=float)
    array = numbers(given)
    return sp.csr_matrix(array if array.ndim == 2 else np.full((1, 1), np.nan))


def checked_damping(damping: object, model: FiniteElementModel) -> sp.csr_matrix:
    """Return a given C of all degrees of freedom as a sparse matrix (N, N); raise a ModelError if it is not valid."""
    if isinstance(damping, (int, float, str)):
        raise ModelError(f"damping={damping!r} is not a damping. Remedy: ModalDamping({damping!r}) or RayleighDamping")
    if hasattr(damping, "put_on"):  # that of a scene, in a layer above
        raise ModelError(
            f"damping={damping!r} is that of a whole scene. Remedy: .put_on(scene) when all bodies are there"
        )
    C = real_matrix(damping)
    if C.shape != (model.size, model.size):
        raise ModelError(
            f"the damping matrix has shape {C.shape}, the model has {model.size} degrees of freedom. Remedy: one row "
            "for each of them"
        )
    if not np.all(np.isfinite(C.data)) or abs(C - C.T).max() > 1e-9 * abs(C).max():
        raise ModelError("the damping matrix is not symmetric or not finite. Remedy: pass its symmetric part")
    return C


def damping_name(damping: Damping) -> str:
    """Return the name of the damping in reports."""
    return "given matrix" if sp.issparse(damping) or isinstance(damping, np.ndarray) else repr(damping)
