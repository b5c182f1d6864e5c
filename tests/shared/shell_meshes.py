"""Meshes of surfaces for tests of shells: grids mapped to curved ones, distorted, of quadrangles or triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.surface_grid import surface_mesh

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
    moved = [_refined(x).ravel() for x in (s, r)]
    mesh = surface_mesh(lambda *_: SURFACES[surface](*moved), counts)
    if kind == "quad9":
        return mesh
    cells = mesh.connectivity
    halves = np.concatenate((cells[:, [0, 1, 2, 4, 5, 8]], cells[:, [0, 2, 3, 8, 6, 7]]))
    return replace(mesh, cells={"body": (Cells(kind, halves),)})


def _refined(x):
    """Return values at corners with the means between them."""
    fine = np.zeros((2 * x.shape[0] - 1, 2 * x.shape[1] - 1))
    fine[::2, ::2] = x
    fine[1::2, ::2] = (x[1:] + x[:-1]) / 2.0
    fine[:, 1::2] = (fine[:, 2::2] + fine[:, :-2:2]) / 2.0
    return fine
