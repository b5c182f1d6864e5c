"""Convex bodies by their corners."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

import numpy as np

from kanefe.arguments import checked, positive
from kanefe.contact.geometry.mesh import Mesh
from kanefe.contact.geometry.shape import Probe, axes_about
from kanefe.contact.geometry.stl import read_stl
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers

SAME_FACE = 1e-9
"""Largest difference between the unit normals of triangles of one face, dimensionless, due to round-off."""


class Convex(Mesh):
    """The convex hull of points, which touches planes and rooms with its corners, and other convex shapes.

    Points and balls touch it as they touch a mesh.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        m, at least four that are not in one plane.

    Attributes
    ----------
    faces : tuple of (ndarray, ndarray of int)
        Normal of each face, and its corners among `vertices`, counter-clockwise seen from outside.

    Raises
    ------
    ModelError
        If they have no volume.

    Examples
    --------
    >>> import kanefe as kf
    >>> wedge = kf.shapes.Convex([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.1, 0.1, 0.1)])
    >>> wedge.vertices.shape, round(float(wedge.distance((0.2, 0.2, -0.5))[0]), 6)
    ((4, 3), 0.5)
    """

    def __init__(self, points: Any) -> None:
        from scipy.spatial import ConvexHull, QhullError

        places = numbers(points)
        if places.ndim != 2 or places.shape[1:] != (3,) or not np.all(np.isfinite(places)):
            raise ModelError(f"points of a convex hull must be finite, shape (n, 3), m, not shape {places.shape}")
        try:
            hull = ConvexHull(places)
        except (QhullError, ValueError) as error:
            raise ModelError("points of a convex hull must be four or more, not in one plane") from error
        corners = hull.simplices
        a, b, c = (places[corners[:, i]] for i in range(3))
        inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
        corners[inwards] = corners[inwards][:, ::-1]
        kept, triangles = np.unique(corners, return_inverse=True)
        super().__init__(places[kept], triangles.reshape(-1, 3))
        planes = np.unique(np.round(hull.equations / SAME_FACE) * SAME_FACE, axis=0, return_inverse=True)[1].ravel()
        numbered = np.searchsorted(kept, corners)
        faces = tuple(
            _face(places[kept], hull.equations[planes == k][0, :3], np.unique(numbered[planes == k]))
            for k in range(planes.max() + 1)
        )
        object.__setattr__(self, "faces", faces)

    @classmethod
    @checked
    def from_stl(cls, path: str | Path, scale: float = 1.0) -> Self:
        """Return the hull of the corners of an STL file, text or binary, whose mesh need not be closed.

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
            If its corners lie in one plane.
        """
        return cls(positive(scale, "scale of a file of a surface") * read_stl(Path(path))[0])

    def probes(self) -> tuple[Probe, ...]:
        """Return its corners; those of the face that has most of them have the whole stiffness together."""
        most = max(len(loop) for _, loop in self.faces)
        return tuple(Probe(corner, 0.0, 1.0 / most) for corner in self.vertices)

    faces: tuple[tuple[Vector, Vector], ...]


def _face(vertices: Matrix, normal: Vector, corners: Vector) -> tuple[Vector, Vector]:
    """Return the normal of a face and its corners, going round it counter-clockwise seen from outside."""
    offsets = vertices[corners] - vertices[corners].mean(axis=0)
    axes = axes_about(normal)
    return normal, corners[np.argsort(np.arctan2(offsets @ axes[:, 1], offsets @ axes[:, 0]))]
