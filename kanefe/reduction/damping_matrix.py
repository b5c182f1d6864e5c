"""Damping of the free coordinates of a reduced body."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.damping import Damping, ModalDamping, RayleighDamping
from kanefe.errors import ModelError
from kanefe.finite_element_model import FiniteElementModel


def damping_matrix(
    damping: Damping, model: FiniteElementModel, free_basis: np.ndarray, stiffness: np.ndarray, mass: np.ndarray
) -> np.ndarray:
    """Return C of the free coordinates, shape (k, k)."""
    count = len(stiffness)
    if damping is None:
        damping = model.damping
    if damping is None or count == 0:
        return np.zeros((count, count))
    if isinstance(damping, RayleighDamping):
        return damping.mass * mass + damping.stiffness * stiffness
    if isinstance(damping, ModalDamping):
        squares, shapes = scipy.linalg.eigh(stiffness, mass)
        weighted = mass @ shapes
        rates = 2 * damping.ratios(count) * np.sqrt(np.maximum(squares, 0.0))
        return (weighted * rates) @ weighted.T
    C = checked_damping(damping, model)
    reduced = free_basis.T @ (C @ free_basis)
    if np.linalg.eigvalsh(reduced).min() < -1e-9 * abs(reduced).max():
        raise ModelError("the damping matrix feeds energy in (it has a negative eigenvalue). Remedy: check its signs")
    return reduced


def checked_damping(damping: object, model: FiniteElementModel) -> sp.csr_matrix:
    """Return a given C of all degrees of freedom, (N, N), sparse; a ModelError says what is wrong with it."""
    if isinstance(damping, (int, float, str)):
        raise ModelError(f"damping={damping!r} is no damping. Remedy: ModalDamping({damping!r}) or RayleighDamping")
    C = sp.csr_matrix(damping)
    if C.shape != (model.size, model.size):
        raise ModelError(f"the damping matrix has shape {C.shape}, the model has {model.size} degrees of freedom")
    if not np.all(np.isfinite(C.data)) or abs(C - C.T).max() > 1e-9 * abs(C).max():
        raise ModelError("the damping matrix is not symmetric or not finite. Remedy: pass its symmetric part")
    return C


def damping_name(damping: Damping) -> str:
    """Return how a report names the damping."""
    return "given matrix" if sp.issparse(damping) or isinstance(damping, np.ndarray) else repr(damping)
