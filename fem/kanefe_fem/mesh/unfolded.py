"""Straightening of cells of second order that fold over themselves."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from kanefe.errors import outside
from kanefe.fe_model.shapes import MIDS
from kanefe_fem.mesh.checks import MeshWarning, jacobian_range
from kanefe_fem.mesh.mesh import Mesh


def unfolded(mesh: Mesh) -> Mesh:
    """Return the mesh with straight sides of those cells of second order that fold over themselves.

    Cells fold if their mid-side nodes lie on geometry with a radius of curvature below the size of the cells. If a
    neighbour then folds, it is straightened too; the iteration ends because cells with straight sides do not fold.
    """
    if mesh.dimension == 1 or mesh.order == 1:
        return mesh
    nodes = mesh.nodes
    while True:
        now = replace(mesh, nodes=nodes)
        moved = nodes.copy()
        for blocks in mesh.cells.values():
            for block in blocks:
                low, high = jacobian_range(now, block)
                folded = block.nodes[(low <= 0.0) & (high >= 0.0)]
                mids = MIDS[block.kind]
                corners = block.nodes.shape[1] - len(mids)
                for i, ends in enumerate(mids, corners):
                    moved[folded[:, i]] = nodes[folded[:, ends]].mean(axis=1)
        if np.array_equal(moved, nodes):
            break
        nodes = moved
    if nodes is not mesh.nodes:
        warnings.warn(
            f"cells of {mesh.source} would fold over themselves along its curves: their sides are straight. "
            "Remedy: cells fine enough to follow the curves, Mesh.MeshSizeFromCurvature or Mesh.MeshSizeMax",
            MeshWarning,
            stacklevel=outside(),
        )
    return now
