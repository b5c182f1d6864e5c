"""Exact inertia of a Craig-Bampton model of Nastran: PHIXG, the motions of all grid points, with their mass MGG."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import COMPONENTS, rigid_motion
from kanefe.imports.labelled import GENERALISED
from kanefe.imports.node_table import NodeTable
from kanefe.imports.rigid_parts import LabelledField, is_round_off, rigid_parts


def shaped_field(
    shapes: sp.csr_matrix,
    mass: sp.csr_matrix,
    reduced: sp.csr_matrix,
    rows: np.ndarray,
    order: np.ndarray,
    table: NodeTable,
) -> LabelledField | None:
    """Return the mass points of a Craig-Bampton model; None if its mass is not that of points that nodes carry.

    Parameters
    ----------
    shapes : csr_matrix, shape (6 n, N)
        Displacements of all grid points, in their own axes.
    mass : csr_matrix, shape (6 n, 6 n)
    reduced : csr_matrix, shape (N, N)
        Mass matrix of the model.
    rows : ndarray of int, shape (N, 2)
        Grid point and component of the columns of `shapes`.
    order : ndarray of int, shape (n,)
        Grid points in the order of their cards: that or ascending labels is the order of rows, by rigid motions.
    table : NodeTable
        The same, ascending.

    Raises
    ------
    ModelError
        If shapes and mass have not the rows of these grid points or do not give the mass of the model, or rigid motions
        of the boundary do not carry all.
    """
    size = 6 * len(order)
    if shapes.shape != (size, len(rows)) or mass.shape != (size, size):
        raise ModelError(
            f"PHIXG has shape {shapes.shape} and MGG {mass.shape}, {len(order)} grid points and {len(rows)} rows "
            f"make ({size}, {len(rows)}) and ({size}, {size}). Remedy: matrices of one run, and its deck"
        )
    if abs(shapes.T @ mass @ shapes - reduced).max() > ROUND_OFF * abs(reduced).max():
        raise ModelError("MXX is not the mass of PHIXG by MGG. Remedy: all three of one run, with one PARAM,WTMASS")
    dense = shapes.toarray()
    for labels in (table.labels, order):
        at = table.places(labels, "PHIXG")
        turns = _axes(at, table)
        turned = np.asarray(turns @ dense)
        if _carries(turned, rows, table, at):
            in_G = (turns @ mass @ turns.T).tocsr()
            found = rigid_parts(in_G, table.points[at], sp.csr_matrix(turned))
            return LabelledField(rows, found.field) if is_round_off(in_G - found.mass, in_G) else None
    raise ModelError(
        "a rigid motion of the boundary by PHIXG does not move all grid points rigidly. Remedy: the deck and matrices "
        "of one run; grid points with mass that hang on nothing have no place in it"
    )


def _axes(at: np.ndarray, table: NodeTable) -> sp.csr_matrix:
    """Return the block diagonal matrix from components in the axes of grid points to those of G."""
    if table.axes is None:
        return sp.identity(6 * len(at), format="csr")
    return sp.block_diag([A for axes in table.axes[at] for A in (axes, axes)], format="csr")


def _carries(shapes: np.ndarray, rows: np.ndarray, table: NodeTable, at: np.ndarray) -> bool:
    """Return whether rigid motions of the boundary translate all grid points rigidly."""
    middle = table.points.mean(axis=0)
    motions = rigid_motion(table.points, middle, COMPONENTS).reshape(-1, 6, 6)
    is_nodal = rows[:, 1] != GENERALISED
    places = table.places(rows[is_nodal, 0], "the boundary")
    own = motions if table.axes is None else np.einsum("npq,npc->nqc", np.kron(np.eye(2), table.axes), motions)
    R = np.zeros((len(rows), 6))
    R[is_nodal] = own[places, rows[is_nodal, 1] - 1]
    error = (shapes @ R).reshape(-1, 6, 6)[:, :3] - motions[at][:, :3]
    return bool(np.abs(error).max() <= ROUND_OFF * max(1.0, np.abs(motions[:, :3]).max()))
