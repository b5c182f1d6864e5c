"""Triangles that are drawn and that nothing touches: what parts look like, from files of STL and OBJ."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, Self

import numpy as np

from kanefe.arguments import checked, positive
from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.contact.geometry.stl import read_stl
from kanefe.contact.geometry.triangles import open_and_doubled_edges, vertices_and_triangles
from kanefe.errors import FileError, ModelError
from kanefe.frames import Matrix, Vector
from kanefe.storage.files import regular_file


class Weighed(NamedTuple):
    """What a closed look encloses at a density: arguments of `System.add_rigid_body`.

    Attributes
    ----------
    mass : float
        kg.
    inertia : ndarray, shape (3, 3)
        About the centre of mass, kg m2.
    com : ndarray, shape (3,)
        Centre of mass, m.
    """

    mass: float
    inertia: Matrix
    com: Vector


@dataclass(frozen=True, eq=False)
class Look(SurfaceShape):
    """The look of a body in pages and pictures: triangles, closed or not, that nothing touches.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        m.
    triangles : array_like of int, shape (m, 3)
        Vertices of each, counter-clockwise seen from outside.

    Raises
    ------
    ModelError
        If the numbers are no triangles.

    Examples
    --------
    >>> import kanefe as kf
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> look = kf.shapes.Look(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    >>> round(look.weighed(density=600.0).mass, 9)
    100.0
    """

    vertices: Any
    triangles: Any
    kind = -1

    def __post_init__(self) -> None:
        vertices, triangles = vertices_and_triangles(self.vertices, self.triangles, "a look")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)

    @classmethod
    @checked
    def from_file(cls, path: str | Path, scale: float = 1.0) -> Self:
        """Return the look of an STL file, binary or text, or of a Wavefront OBJ file.

        Parameters
        ----------
        path : str or Path
        scale : float
            Metres in a unit of the file: 1e-3 of one in millimetres.

        Raises
        ------
        FileError
            If it is no such file.
        """
        path = Path(path)
        readers = {".stl": read_stl, ".obj": read_obj}
        if path.suffix.lower() not in readers:
            raise FileError(
                f"{path.name} is no file of a look that is read. Remedy: STL or OBJ; of STEP files, parts of "
                "kanefe_fem.read_step have vertices and triangles"
            )
        vertices, triangles = readers[path.suffix.lower()](path)
        return cls(positive(scale, "scale of a file of a look") * vertices, triangles)

    @checked
    def weighed(self, density: float) -> Weighed:
        """Return mass, inertia and centre of mass of what it encloses at a density in kg/m3.

        Raises
        ------
        ModelError
            If it is not closed, or inside out.
        """
        corners = self.vertices[self.triangles]
        middle = corners.mean(axis=(0, 1))
        local = corners - middle
        shares = np.einsum("mx,mx->m", local[:, 0], np.cross(local[:, 1], local[:, 2])) / 6.0
        volume = float(shares.sum())
        # faces of OBJ files may have vertices of their own: those at one place are one
        places = np.unique(self.vertices, axis=0, return_inverse=True)[1].ravel()
        closed = not any(open_and_doubled_edges(places[self.triangles]))
        if not closed or volume <= 0.0:
            what = "inside out" if closed else "not closed"
            raise ModelError(f"a look that is {what} has no mass. Remedy: a closed surface, or mass and inertia")
        first = np.einsum("m,mx->x", shares, local.sum(axis=1)) / 4.0
        sums = local.sum(axis=1)
        second = np.einsum("m,mi,mj->ij", shares, sums, sums) + np.einsum("m,mki,mkj->ij", shares, local, local)
        second /= 20.0
        offset = first / volume
        second -= volume * np.outer(offset, offset)
        inertia = density * (np.eye(3) * np.trace(second) - second)
        return Weighed(density * volume, inertia, middle + offset)

    @property
    def numbers(self) -> NoReturn:
        """None: kernels do not know it."""
        raise ModelError("a look is drawn, and nothing touches it. Remedy: shapes.Mesh or another shape for contacts")


def read_obj(path: Path) -> tuple[Matrix, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) of an OBJ file; faces of more corners are fans of triangles.

    Raises
    ------
    FileError
        If there is no such file, or it is damaged; the message names the line.
    """
    path = regular_file(path, "of a look")
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                x, y, z = map(float, words[1:4])
                vertices.append([x, y, z])
            elif words[:1] == ["f"]:
                given = [int(word.partition("/")[0]) for word in words[1:]]
                corners = [one - 1 if one > 0 else len(vertices) + one for one in given]
                if len(corners) < 3 or not all(0 <= one < len(vertices) for one in corners):
                    raise ValueError("a face needs three vertices that are there")
                triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
        except ValueError as error:
            raise FileError(f"{path} is not an OBJ file: line {number} is {line[:60]!r} ({error})") from error
    if not triangles:
        raise FileError(f"{path} has no faces. Remedy: check that it is a Wavefront OBJ file of a surface")
    return np.array(vertices), np.array(triangles)
