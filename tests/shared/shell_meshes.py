"""Meshes of surfaces for tests of shells: grids mapped to curved ones, distorted, of quadrangles or triangles."""

from __future__ import annotations

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.mesh import Mesh

SURFACES = {
    "plate": lambda s, r: (s, r, 0.0 * s),
    "half cylinder": lambda s, r: (0.5 * np.cos(np.pi * s), 0.5 * np.sin(np.pi * s), r),
    "saddle": lambda s, r: (s - 0.5, r - 0.5, (s - 0.5) ** 2 - (r - 0.5) ** 2),
    "twisted": lambda s, r: (3.0 * s, (r - 0.5) * np.cos(1.5 * s), (r - 0.5) * np.sin(1.5 * s)),
}
"""Maps of the unit square to surfaces, in m."""


def grid(surface, count, other=None, distort=0.0, kind="quad9", seed=1):
    """Return a mesh of count x other cells on a surface; inner corners are moved by up to `distort` of a cell."""
    counts = (count, other or count)
    r, s = np.meshgrid(*(np.linspace(0.0, 1.0, n + 1) for n in counts[::-1]), indexing="ij")
    rng = np.random.default_rng(seed)
    for x, n in ((s, counts[0]), (r, counts[1])):
        x[1:-1, 1:-1] += rng.uniform(-distort, distort, np.array(x.shape) - 2) / n
    fine = [_refined(x) for x in (s, r)]
    number = np.arange(fine[0].size).reshape(fine[0].shape)

    def at(i, j):
        return number[i : number.shape[0] - 2 + i : 2, j : number.shape[1] - 2 + j : 2].ravel()

    order = ((0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1))
    cells = np.stack([at(*place) for place in order], axis=1)
    nodes = np.stack(SURFACES[surface](*(x.ravel() for x in fine)), axis=1)
    if kind == "triangle6":
        cells = np.concatenate((cells[:, [0, 1, 2, 4, 5, 8]], cells[:, [0, 2, 3, 8, 6, 7]]))
    ends = {name: number[:, column] for name, column in (("root", 0), ("tip", -1))}
    lines = {name: (Cells("line3", np.stack((e[:-2:2], e[2::2], e[1:-1:2]), axis=1)),) for name, e in ends.items()}
    return Mesh(nodes, 2, {"body": (Cells(kind, cells),)}, facets=lines, source=f"a {surface}")


def _refined(x):
    """Return values at corners with the means between them."""
    fine = np.zeros((2 * x.shape[0] - 1, 2 * x.shape[1] - 1))
    fine[::2, ::2] = x
    fine[1::2, ::2] = (x[1:] + x[:-1]) / 2.0
    fine[:, 1::2] = (fine[:, 2::2] + fine[:, :-2:2]) / 2.0
    return fine
