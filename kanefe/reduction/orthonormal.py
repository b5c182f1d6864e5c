"""M-orthonormal modes of the space that a reduction spans."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError


def orthonormal_modes(free: np.ndarray, K: sp.csr_matrix, M: sp.csr_matrix, rigid_count: int) -> np.ndarray:
    """Return the same space in M-orthonormal modes of (K, M), without the rigid ones of a floating body."""
    if free.shape[1] == 0:
        return free
    stiffness, mass = free.T @ (K @ free), free.T @ (M @ free)
    massless = ModelError(
        "the mass matrix of the reduced coordinates is not positive definite: some motion of the body has no mass. "
        "Remedy: give every degree of freedom mass (rotary_inertia of beams), or ask for fewer modes"
    )
    if np.diag(mass).min() <= 0:
        raise massless
    scale = 1.0 / np.sqrt(np.diag(mass))
    try:
        squares, vectors = scipy.linalg.eigh(stiffness * np.outer(scale, scale), mass * np.outer(scale, scale))
    except np.linalg.LinAlgError as error:
        raise massless from error
    if rigid_count:
        if rigid_count >= len(squares):
            raise ModelError(
                f"the body floats and has {len(squares)} coordinates, {rigid_count} of them rigid: none is "
                "left. Remedy: more modes"
            )
        # Of the eigenvalues of two sparse matrices, those below the round-off of their entries are zeros.
        noise = 1e-14 * float(np.max(K.diagonal() / np.maximum(M.diagonal(), 1e-300)))
        if abs(squares[:rigid_count]).max() > 1e-6 * squares[rigid_count] or squares[rigid_count] < noise:
            raise ModelError(
                f"K does not leave the {rigid_count} rigid motions free (w^2 = {squares[rigid_count - 1]:.3g} against "
                f"{squares[rigid_count]:.3g} of the first elastic mode), or leaves more free. Remedy: check the "
                "order of the nodes and the mesh for loose parts, or clamp an interface"
            )
    modes = free @ (scale[:, None] * vectors[:, rigid_count:])
    # round-off of a large mesh leaves M some 1e-12 off the identity: one step of Newton's method for its root
    return np.asarray(modes @ (1.5 * np.eye(modes.shape[1]) - 0.5 * modes.T @ (M @ modes)))
