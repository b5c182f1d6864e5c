"""Meshes for the tests: structured boxes made by numpy, so that asserted values do not hang on a mesh generator."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import permutations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kanefe.fe_model.model import Cells
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh

STEEL = Material(E=210e9, nu=0.3, rho=7850.0, name="steel")

# A cube cut into six tetrahedra along its diagonal: one for each way to walk from corner 000 to corner 111.
_KUHN = [np.cumsum([(0, 0, 0), *(np.eye(3, dtype=int)[list(walk)])], axis=0) for walk in permutations(range(3))]


KINDS = ["tetra", "hexahedron", "triangle", "quad"]


def box(kind: str, divisions: Sequence[int], size: Sequence[float], group: str = "bar") -> Mesh:
    """Return a box (or a rectangle) of cells of order 1 with the facet groups "root" (x = 0) and "tip" (x = L).

    Of triangles and quadrilaterals the divisions and sizes in x and y count.
    """
    d = 3 if kind in ("tetra", "hexahedron") else 2
    divisions, size = divisions[:d], size[:d]
    counts = np.array(divisions) + 1
    axes = [np.linspace(0.0, length, n) for length, n in zip(size, counts, strict=True)]
    nodes = np.zeros((int(np.prod(counts)), 3))
    nodes[:, :d] = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, d)
    origins = np.array(list(product(*(range(n) for n in divisions))))

    def number(offsets: Any) -> np.ndarray:
        cells = origins[:, None, :] + np.asarray(offsets)[None]
        return np.ravel_multi_index(tuple(np.moveaxis(cells, -1, 0)), tuple(counts))

    quad = [(0, 0), (1, 0), (1, 1), (0, 1)]
    if kind == "hexahedron":
        cells = number([(*c, z) for z in (0, 1) for c in quad])
        faces = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        facet = "quad"
    elif kind == "tetra":
        cells = np.concatenate([number(walk) for walk in _KUHN])
        faces, facet = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)], "triangle"
    elif kind == "quad":
        cells, faces, facet = number(quad), [(0, 1), (1, 2), (2, 3), (3, 0)], "line"
    else:
        cells = np.concatenate([number([quad[0], quad[1], quad[2]]), number([quad[0], quad[2], quad[3]])])
        faces, facet = [(0, 1), (1, 2), (2, 0)], "line"
    sides = np.concatenate([cells[:, list(face)] for face in faces])
    facets = {
        name: (Cells(facet, sides[(np.abs(nodes[sides][:, :, 0] - x) < 1e-12).all(axis=1)]),)
        for name, x in (("root", 0.0), ("tip", size[0]))
    }
    return Mesh(nodes, d, {group: (Cells(kind, cells),)}, facets, source=f"{kind} box")


def deformed(mesh: Mesh, move: Callable[[np.ndarray], np.ndarray]) -> Mesh:
    """Return the mesh with its nodes moved by a function of their coordinates."""
    return Mesh(move(np.array(mesh.nodes)), mesh.dimension, mesh.cells, mesh.facets, source=f"deformed {mesh.source}")


def write_msh2(path: Path, nodes: Any, elements: Sequence[tuple[int, int, Sequence[int]]], names: Any = ()) -> Path:
    """Write an ascii .msh 2.2 by hand: elements are (gmsh type, physical tag, node numbers from 1)."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if names:
        lines += ["$PhysicalNames", str(len(names)), *(f'{d} {tag} "{name}"' for d, tag, name in names)]
        lines += ["$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes))]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(np.asarray(nodes, float).tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [
        f"{i} {kind} 2 {tag} {tag} " + " ".join(str(n) for n in ids) for i, (kind, tag, ids) in enumerate(elements, 1)
    ]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def shown(error: pytest.ExceptionInfo[Exception], *words: str) -> None:
    """Assert that the message holds each of the words and a remedy."""
    text = str(error.value)
    for word in (*words, "Remedy"):
        assert re.search(re.escape(word), text), f"{word!r} is not in: {text}"
