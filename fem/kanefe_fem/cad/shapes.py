"""What is in a CAD file, in numbers: solids with their faces, in metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

LABEL, NAMELESS = "=>[", "Open CASCADE STEP translator"
"""Beginnings of what OpenCASCADE puts in place of names: of shapes within a part, of parts without one."""

NAME_OF_NONE = "part"
"""Name of a part that has none in its file; numbers tell several apart."""


def name_of_colour(colour: Colour) -> str:
    """Return a colour as the name of a group, such as "#cc8000"."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


NOISE = 1e-12
"""Length below which coordinates are zero, relative to the size of what they belong to."""


def without_noise(place: np.ndarray, size: float) -> np.ndarray:
    """Return a place with zeros in place of round-off, m."""
    return np.where(np.abs(place) < NOISE * size, 0.0, place)


@dataclass(frozen=True, eq=False)
class Face:
    """A face of a solid.

    Attributes
    ----------
    tag : int
        Number in gmsh.
    kind : {"plane", "cylinder", "other"}
    area : float
        m^2.
    centre : ndarray, shape (3,)
        Centroid, m.
    edges, inside : ndarray, shape (e, k, 3) and (i, 3)
        Points along each edge, and inside it, m.
    name : str
        In the file; empty if it has none.
    colour : tuple of int, optional
        0 to 255.
    normal : ndarray, shape (3,)
        Of a plane, out of the solid; of a cylinder its axis.
    point : ndarray, shape (3,)
        Of a plane a point on it, of a cylinder the middle of its axis, m.
    radius, length, angle : float
        Of a cylinder: m, m, and the angle that the face spans, rad.
    is_hole : bool
        Whether a cylinder is hollow: its solid lies outside.
    """

    tag: int
    kind: str
    area: float
    centre: np.ndarray
    edges: np.ndarray
    inside: np.ndarray
    name: str = ""
    colour: Colour | None = None
    normal: np.ndarray = field(default_factory=lambda: np.zeros(3))
    point: np.ndarray = field(default_factory=lambda: np.zeros(3))
    radius: float = 0.0
    length: float = 0.0
    angle: float = 0.0
    is_hole: bool = False

    @property
    def points(self) -> np.ndarray:
        """Points on its edges and inside it, m, shape (k, 3)."""
        return np.concatenate([self.edges.reshape(-1, 3), self.inside])


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid: a part of an assembly.

    Attributes
    ----------
    tag : int
        Number in gmsh.
    name : str
        Each once in a file.
    product : str
        Name that equal parts share.
    path : str
        Names of the assemblies that it is in, and its own.
    colour : tuple of int, optional
        0 to 255.
    volume : float
        m^3.
    centre : ndarray, shape (3,)
        Centre of volume, m.
    moments : ndarray, shape (3, 3)
        Inertia about the centre at density one, m^5.
    low, high : ndarray, shape (3,)
        A box around it, m; where it is curved the box may be larger.
    faces : tuple of Face
    """

    tag: int
    name: str
    product: str
    path: str
    colour: Colour | None
    volume: float
    centre: np.ndarray
    moments: np.ndarray
    low: np.ndarray
    high: np.ndarray
    faces: tuple[Face, ...]

    @property
    def area(self) -> float:
        """Area of all faces, m^2."""
        return sum(face.area for face in self.faces)


@dataclass(frozen=True, eq=False)
class Shapes:
    """The solids of a file.

    Attributes
    ----------
    solids : tuple of Solid
    unit : str
        Unit in which the file was read.
    scale : float
        Of the millimetres of OpenCASCADE, m.
    healed : float
        Largest gap that was closed to make solids of faces, m; zero if none was.
    left_out : int
        Number of surfaces beside the solids that are part of none.
    unread : tuple of str
        Names of faces in the file that were not read, because the library for it is missing.
    """

    solids: tuple[Solid, ...]
    unit: str
    scale: float
    healed: float
    left_out: int
    unread: tuple[str, ...]

    @property
    def extent(self) -> np.ndarray:
        """Sides of the box around points on all faces, m, shape (3,): boxes of OpenCASCADE are too large."""
        return np.asarray(np.ptp(np.concatenate([face.points for s in self.solids for face in s.faces]), axis=0))

    @property
    def size(self) -> float:
        """Diagonal of the box around all solids, m."""
        return float(np.linalg.norm(self.extent))


def names_of(paths: list[str]) -> list[tuple[str, str]]:
    """Return name and product of each solid by the paths that OpenCASCADE gives; each name once.

    A path lists instances and products in turn. Equal parts share their product; they are told apart by their
    instances, or else by numbers.
    """
    words = [_words(path) or [NAME_OF_NONE] for path in paths]
    products = [each[-1] for each in words]
    instances = [each[-2] if len(each) > 1 else each[-1] for each in words]
    by_product = {p: [i for i, other in zip(instances, products, strict=True) if other == p] for p in products}
    taken: set[str] = set()
    found = []
    for product, instance in zip(products, instances, strict=True):
        name = product
        of_equals = by_product[product]
        if len(of_equals) > 1 and len(set(of_equals)) == len(of_equals):
            name = instance
        elif len(of_equals) > 1:
            name = _numbered(product, taken | set(products), start=1)
        if name in taken:
            name = _numbered(name, taken | set(products), start=2)
        taken.add(name)
        found.append((name, product))
    return found


def _words(path: str) -> list[str]:
    """Return the names of a path without what exporters add: materials, kinds of shape, labels without name."""
    parts = [part.strip() for part in path.split(" & ")[0].split("/")]
    parts = parts[1:] if parts[:1] == ["Shapes"] else parts
    parts = [part for part in parts if part and not part.startswith(LABEL) and part not in {"SOLID", "COMPOUND"}]
    named = [part for part in parts[:-1] if not part.isdigit() and not part.startswith(NAMELESS)]  # no bare numbers
    if parts and parts[-1].startswith(NAMELESS):  # the instance may have a name
        return named if named and named[-1] == parts[-2] else []
    return [*named, *parts[-1:]]


def _numbered(name: str, taken: set[str], start: int) -> str:
    number = start
    while f"{name} {number}" in taken:
        number += 1
    return f"{name} {number}"


def by_name(solids: Mapping[str, Solid], name: str) -> list[Solid]:
    """Return the solids that a name stands for: one by its own name, equal parts by their product or colour."""
    if name in solids:
        return [solids[name]]
    return [s for s in solids.values() if s.product == name or (s.colour and name_of_colour(s.colour) == name)]
