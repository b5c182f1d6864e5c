"""The lowest modes of imported matrices, with the diagonal of M: how many are zero, and how much nodes turn in them."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.fe_model.factorise import Factorise
from kanefe.fe_model.model import ROTATIONS, FiniteElementModel


def lowest_modes(model: FiniteElementModel, count: int, factorise: Factorise) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest eigenvalues of K with the diagonal of M, which suffices for the number of zeros, and modes."""
    K, masses = model.stiffness, model.mass.diagonal()
    stiff = K.diagonal()
    massive = masses > 1e-12 * masses.max()
    typical = float(np.median(stiff[massive] / masses[massive]))
    # coordinates without mass, rotations of lumped matrices, are scaled by their own stiffness
    own = stiff / typical if typical > 0 else np.zeros_like(stiff)
    scale = 1.0 / np.sqrt(np.where(massive, masses, np.where(own > 0, own, masses.max())))
    scaled = sp.diags(scale) @ K @ sp.diags(scale)
    if model.size <= 400:
        squares, vectors = np.linalg.eigh(scaled.toarray())
        return _in_order(squares, vectors, scale, count)
    shift = 1e-6 * scaled.diagonal().mean()
    start = np.random.default_rng(0).standard_normal(model.size)
    try:
        factors = factorise((scaled + shift * sp.identity(model.size)).tocsc())
    except RuntimeError as error:
        raise ModelError(
            f"the stiffness matrix is not positive ({error}). Remedy: export it without prestress or buckling loads"
        ) from error
    inverse = spla.LinearOperator(K.shape, matvec=factors.solve, dtype=float)
    squares, vectors = spla.eigsh(scaled, k=count, sigma=-shift, OPinv=inverse, v0=start)
    return _in_order(squares, vectors, scale, count)


def _in_order(squares: np.ndarray, vectors: np.ndarray, scale: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    order = np.argsort(np.abs(squares))[:count]
    return np.abs(squares[order]), scale[:, None] * vectors[:, order]


def slope_of(model: FiniteElementModel, shape: np.ndarray) -> float | None:
    """Return root mean square rotation over displacement of the nodes in a motion (N,), 1/m, weighed by their mass."""
    turning = np.isin(model.components, ROTATIONS)
    if turning.sum() < 3 or model.generalised:
        return None
    by_node, masses = (x.reshape(-1, len(turning)) for x in (shape, model.mass.diagonal()))
    weights = masses[:, ~turning].mean(axis=1)
    moved = weights @ (by_node[:, ~turning] ** 2).sum(axis=1)
    return float(np.sqrt(weights @ (by_node[:, turning] ** 2).sum(axis=1) / moved)) if moved > 0.0 else None
