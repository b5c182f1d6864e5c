"""Incompatible modes of elements, condensed by statics: ``u_i = G u,  G = -K_ii^-1 K_in`` from the nodes u.

A mode is a displacement within its element that no other shares, so K_ii is block diagonal and K keeps its pattern:
``K = K_nn + K_ni G``. The mass that the modes move goes along, ``M = T^T M T`` with T = [I; G] (Guyan 1965, "Reduction
of stiffness and mass matrices", AIAA J. 3: 380). The field of displacements remains linear in u, so the mass field of
the body is exact: that of the nodes, and of one function without place for each mode.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
import scipy.sparse.csgraph

from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, MassField
from kanefe.imports.units import Units, scales


class CondensedModes(NamedTuple):
    """Matrices of the nodes.

    Attributes
    ----------
    stiffness, mass : csr_matrix, shape (N, N)
    nodal_mass : csr_matrix, shape (N, N)
        Without what the modes move.
    follow : csr_matrix, shape (modes, N)
        G.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    nodal_mass: sp.csr_matrix
    follow: sp.csr_matrix


def condensed(K: sp.csr_matrix, M: sp.csr_matrix, is_inner: np.ndarray) -> CondensedModes:
    """Return matrices without the rows of incompatible modes, `is_inner` (N,)."""
    inner, nodal = np.flatnonzero(is_inner), np.flatnonzero(~is_inner)
    if not len(inner):
        return CondensedModes(K, M, M, sp.csr_matrix((0, len(nodal))))
    coupling = K[inner][:, nodal]
    follow = (-_inverse(K[inner][:, inner]) @ coupling).tocsr()
    shared = M[nodal][:, inner] @ follow
    nodal_mass = M[nodal][:, nodal].tocsr()
    mass = nodal_mass + shared + shared.T + follow.T @ M[inner][:, inner] @ follow
    stiffness = K[nodal][:, nodal] + coupling.T @ follow
    K, M = ((0.5 * (A + A.T)).tocsr() for A in (stiffness, mass))
    return CondensedModes(K, M, nodal_mass, follow)


def _inverse(K: sp.csr_matrix) -> sp.csr_matrix:
    """Return the inverse of a matrix that is block diagonal up to the order of its rows."""
    K = K.copy()
    K.eliminate_zeros()
    count, block = scipy.sparse.csgraph.connected_components(K, directed=False)
    order = np.argsort(block, kind="stable")
    sizes = np.bincount(block, minlength=count)
    blocks = []
    first = 0
    sorted_K = K[order][:, order]
    for size in sizes:
        own = sorted_K[first : first + size, first : first + size].toarray()
        try:
            blocks.append(np.linalg.inv(own))
        except np.linalg.LinAlgError as error:
            raise ModelError(f"incompatible modes of an element have no stiffness ({error})") from error
        first += size
    inverse = sp.block_diag(blocks, format="csr")
    back = np.argsort(order)
    return inverse[back][:, back]


def mass_field_with_modes(
    model: FiniteElementModel, M: sp.csr_matrix, is_inner: np.ndarray, follow: sp.csr_matrix, units: Units
) -> MassField:
    """Return the exact mass field of a condensed model of translations.

    Parameters
    ----------
    model : FiniteElementModel
        Its rows are in the order of those of M that are no modes.
    M : csr_matrix, shape (rows, rows)
        Before it was condensed, in the units of its file: the same for every direction.
    is_inner : ndarray of bool, shape (rows,)
    follow : csr_matrix, shape (modes, N)
        G.
    units : Units
        Of the file.
    """
    order = np.argsort(is_inner, kind="stable")  # those of the nodes first
    scalar = M[order][:, order][::3][:, ::3] * scales(units)[1]
    functions = np.zeros((scalar.shape[0] - len(model.nodes), 3))
    interpolation = sp.vstack((sp.identity(model.size), follow), format="csr")
    return MassField(np.vstack((model.nodes, functions)), scalar.tocsr(), interpolation)
