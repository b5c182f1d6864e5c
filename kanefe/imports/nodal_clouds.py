"""Mass points of a superelement by the shapes of all nodes of the full model: its inertia is that of the full model.

With the nodal mass matrix M of the full model and the motions Psi of its nodes, ``u = Psi q``, the mass matrix of the
superelement is ``Psi^T M Psi``. Where M couples no nodes (lumped) each node carries a rigid part, of mass m, first
moment m c and second moment S about the node, with the displacement ``u + theta x r`` at r. Four points at 0 and at
``a e_i``, whose functions are ``1 - sum r_i / a`` and ``r_i / a``, have these moments and that displacement. Where M is
one scalar matrix for all translations, the nodes themselves are the points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.frames import skews
from kanefe.imports.mass_properties import ROUND_OFF

WIDTH = 6
"""Number of rows of a node in M and Psi."""


class LabelledField(NamedTuple):
    """Mass points that move with labelled degrees of freedom, in the units of their file.

    Attributes
    ----------
    freedoms : ndarray of int, shape (N, 2)
        Label and number of the columns, as of `kanefe.imports.labelled.LabelledMatrix`.
    points : ndarray, shape (P, 3)
    mass : csr_matrix, shape (P, P)
    interpolation : csr_matrix, shape (3 P, N)
    """

    freedoms: np.ndarray
    points: np.ndarray
    mass: sp.csr_matrix
    interpolation: sp.csr_matrix


def field_of_nodes(
    M: sp.csr_matrix, shapes: np.ndarray, points: np.ndarray, freedoms: np.ndarray
) -> LabelledField | None:
    """Return the mass points of a superelement; None if M couples nodes in more than translations.

    Parameters
    ----------
    M : csr_matrix, shape (6 n, 6 n)
        Of the full model, in axes of G.
    shapes : ndarray, shape (6 n, N)
        Psi, in axes of G.
    points : ndarray, shape (n, 3)
        Places of the nodes.
    freedoms : ndarray of int, shape (N, 2)
        Label and number of the columns of Psi.
    """
    entries = M.tocoo()
    is_own = entries.row // WIDTH == entries.col // WIDTH
    if (np.abs(entries.data[~is_own]) > ROUND_OFF * np.abs(entries.data).max(initial=0.0)).any():
        return _of_scalar(M, shapes, points, freedoms)
    blocks = np.zeros((len(points), WIDTH, WIDTH))
    row, column = entries.row[is_own], entries.col[is_own]
    blocks[row // WIDTH, row % WIDTH, column % WIDTH] = entries.data[is_own]
    masses = blocks[:, :3, :3].trace(axis1=1, axis2=2) / 3.0
    if np.abs(blocks[:, :3, :3] - masses[:, None, None] * np.eye(3)).max() > ROUND_OFF * masses.max():
        return None
    reach = float(np.ptp(points, axis=0).max()) or 1.0
    arms = np.vstack((np.zeros(3), reach * np.eye(3)))
    turns = np.einsum("nac,kba->nkbc", shapes.reshape(-1, WIDTH, shapes.shape[1])[:, 3:], -skews(arms))
    moved = shapes.reshape(-1, 1, WIDTH, shapes.shape[1])[:, :, :3] + turns
    functions = np.column_stack(([1.0, 0.0, 0.0, 0.0], np.vstack((-np.ones(3), np.eye(3))) / reach))
    grams = functions @ _moments(blocks, masses) @ functions.T
    rows = np.arange(len(points) + 1)
    return LabelledField(
        freedoms,
        (points[:, None] + arms).reshape(-1, 3),
        sp.bsr_matrix((grams, rows[:-1], rows)).tocsr(),
        sp.csr_matrix(moved.reshape(-1, shapes.shape[1])),
    )


def _moments(blocks: np.ndarray, masses: np.ndarray) -> np.ndarray:
    """Return the inner products (n, 4, 4) of 1 and r over the rigid parts of blocks [[m, -m c~], [m c~, J]]."""
    J = 0.5 * (blocks[:, 3:, 3:] + np.swapaxes(blocks[:, 3:, 3:], 1, 2))
    first = [blocks[:, 5, 1] - blocks[:, 4, 2], blocks[:, 3, 2] - blocks[:, 5, 0], blocks[:, 4, 0] - blocks[:, 3, 1]]
    found = np.zeros((len(blocks), 4, 4))
    found[:, 0, 0] = masses
    found[:, 0, 1:] = found[:, 1:, 0] = 0.5 * np.stack(first, axis=1)
    found[:, 1:, 1:] = 0.5 * np.trace(J, axis1=1, axis2=2)[:, None, None] * np.eye(3) - J
    return found


def _of_scalar(M: sp.csr_matrix, shapes: np.ndarray, points: np.ndarray, freedoms: np.ndarray) -> LabelledField | None:
    """Return the nodes as points where M is one scalar matrix for all translations, and nothing for rotations."""
    scalar = M[::WIDTH][:, ::WIDTH]
    expected = sp.kron(scalar, np.diag((1.0, 1.0, 1.0, 0.0, 0.0, 0.0)), format="csr")
    if abs(M - expected).max() > ROUND_OFF * abs(M).max():
        return None
    moved = shapes.reshape(-1, WIDTH, shapes.shape[1])[:, :3].reshape(-1, shapes.shape[1])
    return LabelledField(freedoms, points, scalar.tocsr(), sp.csr_matrix(moved))
