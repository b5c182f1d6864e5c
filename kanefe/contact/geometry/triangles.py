"""Triangles as users give them: whether they are numbers of vertices, and whether they close a surface."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, numbers

EDGES = ((0, 1), (1, 2), (2, 0))
"""Vertices of the edges of a triangle, in the order of the kernel's numbers."""


def vertices_and_triangles(vertices: Any, triangles: Any, name: str) -> tuple[Matrix, np.ndarray]:
    """Return vertices (n, 3) in m and triangles (m, 3) of `name`, such as "a mesh", as arrays.

    Raises
    ------
    ModelError
        If they are none.
    """
    vertices, triangles = numbers(vertices), numbers(triangles)
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or not np.all(np.isfinite(vertices)):
        raise ModelError(f"vertices of {name} must be finite, shape (n, 3), m")
    if triangles.ndim != 2 or triangles.shape[1:] != (3,) or np.any(triangles % 1.0) or not len(triangles):
        raise ModelError(f"triangles of {name} must be whole numbers, shape (m, 3): the vertices of each")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ModelError(f"triangles of {name} name vertices that are none of its {len(vertices)}")
    return vertices, triangles.astype(np.int64)


def open_and_doubled_edges(triangles: np.ndarray) -> tuple[int, int]:
    """Return how many edges have no triangle on their other side, and how many have two on one; closed: (0, 0)."""
    edges = np.concatenate([triangles[:, pair] for pair in EDGES])
    one_way, counts = np.unique(edges, axis=0, return_counts=True)
    both = np.unique(np.concatenate((one_way, one_way[:, ::-1])), axis=0)
    return len(both) - len(one_way), int(np.sum(counts > 1))
