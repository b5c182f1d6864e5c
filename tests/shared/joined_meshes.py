"""Meshes of shells with stiffeners and solids, for tests: surfaces and boxes that do not share nodes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.mesh import Mesh


def with_line(mesh: Mesh, name: str, where: np.ndarray) -> Mesh:
    """Return a mesh of nine-node quadrangles with a group of the sides whose nodes are all in a mask."""
    table = np.concatenate([mesh.connectivity[:, [i, (i + 1) % 4, 4 + i]] for i in range(4)])
    table = table[where[table].all(axis=1)]
    table = table[np.unique(np.sort(table, axis=1), axis=0, return_index=True)[1]]
    return Mesh(mesh.nodes, 2, mesh.cells, facets={**mesh.facets, name: (Cells("line3", table),)})


def beside(box: Mesh, surfaces: Mapping[str, Mesh]) -> Mesh:
    """Return a box and surfaces, groups of facets by their names, as one mesh; lines are "surface.line"."""
    nodes, facets, lines = [box.nodes], dict(box.facets), {}
    for name, mesh in surfaces.items():
        start = sum(len(own) for own in nodes)
        nodes.append(mesh.nodes)
        facets[name] = (Cells("quad9", mesh.connectivity + start),)
        lines |= {f"{name}.{k}": (Cells("line3", own[0].nodes + start),) for k, own in mesh.facets.items()}
    return Mesh(np.concatenate(nodes), 3, {"block": box.cells["body"]}, facets=facets, lines=lines, source="parts")
