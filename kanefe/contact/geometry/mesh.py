"""Closed meshes of triangles that things touch."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from kanefe.arguments import checked, positive
from kanefe.contact.geometry.mesh_parts import check_parts
from kanefe.contact.geometry.points import on_triangles, standing_for
from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.contact.geometry.stl import read_stl
from kanefe.contact.geometry.stl_repair import are_flat
from kanefe.contact.geometry.triangles import EDGES, open_and_doubled_edges, vertices_and_triangles
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.loads.reach import Bounds

LEAF = 4
"""Largest number of triangles in a leaf of the tree."""


@dataclass(frozen=True, eq=False)
class Mesh(SurfaceShape):
    """A closed mesh of triangles, which points and balls touch.

    The distance is that of the nearest point of the mesh, its sign that of the normal there; of edges and vertices
    normals are weighed by angles (Baerentzen and Aanaes, IEEE Trans. Vis. Comput. Graph. 11, 2005).

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        m.
    triangles : array_like of int, shape (m, 3)
        Vertices of each, counter-clockwise seen from outside.

    Raises
    ------
    ModelError
        If the mesh is not closed, is inside out, goes through itself, or has triangles without area; or if one of its
        parts is within another one and no hollow of it.

    Examples
    --------
    >>> import kanefe as kf
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> wedge = kf.shapes.Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    >>> distance, normal = wedge.distance((0.2, 0.2, -0.5))
    >>> float(distance)
    0.5
    """

    vertices: Any
    triangles: Any
    kind = 8
    _table: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        vertices, triangles = vertices_and_triangles(self.vertices, self.triangles, "a mesh")
        _check_closed(vertices, triangles)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)
        object.__setattr__(self, "_table", _table_of(vertices, triangles))

    @classmethod
    @checked
    def from_stl(cls, path: str | Path, scale: float = 1.0) -> Self:
        """Return the mesh of an STL file, binary or text.

        Vertices that differ by round-off of single precision at the largest coordinate are one, and triangles without
        area are left out, so that what is closed in the program that wrote it is closed here.

        Parameters
        ----------
        path : str or Path
        scale : float
            Metres in a unit of the file: 1e-3 of one in millimetres.

        Raises
        ------
        FileError
            If it is no such file.
        ModelError
            If its mesh is not closed.
        """
        vertices, triangles = read_stl(Path(path))
        return cls(positive(scale, "scale of a file of a surface") * vertices, triangles)

    def sampled(self, spacing: float) -> SurfaceShape:
        """Return points of its triangles: see `SurfaceShape.sampled`."""
        places = on_triangles(self.vertices, self.triangles, positive(spacing, "spacing"))
        return standing_for(self.title, *places)

    @property
    def bounds(self) -> Bounds:
        """The box about it."""
        return Bounds(self.vertices.min(axis=0), self.vertices.max(axis=0))

    @property
    def numbers(self) -> Vector:
        """How many nodes its tree has, these, and its triangles: see `kanefe.kernels.contact.contact_mesh`."""
        nodes, order = _tree(self.vertices[self.triangles])
        return np.concatenate(((len(nodes),), nodes.ravel(), self._table[order].ravel()))


def _check_closed(vertices: Matrix, triangles: np.ndarray) -> None:
    flat = int(np.sum(are_flat(vertices[triangles])))
    if flat:
        raise ModelError(f"{flat} of {len(triangles)} triangles of a mesh have no area. Remedy: leave them out")
    open_edges, twice = open_and_doubled_edges(triangles)
    if open_edges or twice:
        raise ModelError(
            f"a mesh of {len(triangles)} triangles is not closed: {open_edges} edges have no triangle on their other "
            f"side, {twice} have two on one. Remedy: close its holes and turn its triangles one way round, counter-"
            "clockwise from outside; ground is a HeightField"
        )
    check_parts(vertices, triangles)


def _table_of(vertices: Matrix, triangles: np.ndarray) -> np.ndarray:
    """Return of each triangle a vertex, two sides, and normals of itself, its edges and its vertices, (m, 30)."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    edges = [np.sort(triangles[:, pair], axis=1) for pair in EDGES]
    keys = [edge[:, 0] * len(vertices) + edge[:, 1] for edge in edges]
    found, where = np.unique(np.concatenate(keys), return_inverse=True)
    sums = np.zeros((len(found), 3))
    np.add.at(sums, where, np.tile(normals, (3, 1)))
    of_edges = sums[where].reshape(3, len(triangles), 3)
    of_vertices = np.zeros_like(vertices)
    for at, (p, q, r) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
        first, second = q - p, r - p
        cosine = np.einsum("ij,ij->i", first, second)
        cosine /= np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
        np.add.at(of_vertices, triangles[:, at], np.arccos(np.clip(cosine, -1.0, 1.0))[:, None] * normals)
    ab, bc, ca = of_edges
    of_a, of_b, of_c = (of_vertices[triangles[:, i]] for i in range(3))
    return np.hstack((a, b - a, c - a, normals, of_a, of_b, ab, of_c, ca, bc))  # see `kernels.contact.contact_mesh`


def _tree(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return boxes about triangles (m, 3, 3), each with those in it behind it, and the order of the triangles.

    A node is its lower and upper corner, the node to go to where nothing in it is near, the first of its triangles and
    how many they are; 0: it is no leaf.
    """
    lower, upper, middle = corners.min(axis=1), corners.max(axis=1), corners.mean(axis=1)
    nodes: list[list[float]] = []
    order: list[int] = []

    def add(members: np.ndarray) -> None:
        at, low, high = len(nodes), lower[members].min(axis=0), upper[members].max(axis=0)
        nodes.append([*low, *high, 0.0, 0.0, 0.0])
        if len(members) <= LEAF:
            nodes[at][7:] = len(order), len(members)
            order.extend(members.tolist())
        else:
            axis = int(np.argmax(np.ptp(middle[members], axis=0)))
            ranked = members[np.argsort(middle[members, axis], kind="stable")]
            add(ranked[: len(ranked) // 2])
            add(ranked[len(ranked) // 2 :])
        nodes[at][6] = len(nodes)

    add(np.arange(len(corners)))
    return np.array(nodes), np.array(order)
