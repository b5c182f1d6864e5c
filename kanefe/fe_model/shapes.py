"""Shapes of the cells of a mesh: node order (VTK's), shape functions, quadrature, faces.

Everything that depends on the order of an element's nodes follows from one table, `MIDS`: each node past the corners is
the mean of some corners. The orders of other programs (gmsh, basix) are found by matching reference coordinates, never
written down.

Shapes without nodes inside their faces are the serendipity elements (Zienkiewicz & Taylor, "The Finite Element Method",
volume 1, chapter 8); a pyramid has rational shape functions (Bedrosian, "Shape functions and integration formulas for
three-dimensional finite element analysis", Int. J. Numer. Methods Eng. 35 (1992) 95-108).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

_EDGES_TRIANGLE = ((0, 1), (1, 2), (2, 0))
_EDGES_QUAD = ((0, 1), (1, 2), (2, 3), (3, 0))
_EDGES_TETRA = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_EDGES_HEXAHEDRON = (
    *((0, 1), (1, 2), (2, 3), (3, 0)),
    *((4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
_EDGES_WEDGE = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
_EDGES_PYRAMID = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4))
_FACES_HEXAHEDRON = ((0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7))

MIDS: dict[str, tuple[tuple[int, ...], ...]] = {
    "line": (),
    "triangle": (),
    "quad": (),
    "tetra": (),
    "hexahedron": (),
    "wedge": (),
    "pyramid": (),
    "line3": ((0, 1),),
    "triangle6": _EDGES_TRIANGLE,
    "quad8": _EDGES_QUAD,
    "quad9": (*_EDGES_QUAD, (0, 1, 2, 3)),
    "tetra10": _EDGES_TETRA,
    "hexahedron20": _EDGES_HEXAHEDRON,
    "wedge15": _EDGES_WEDGE,
    "wedge18": (*_EDGES_WEDGE, (0, 1, 3, 4), (1, 2, 4, 5), (2, 0, 5, 3)),
    "pyramid13": _EDGES_PYRAMID,
    "hexahedron27": (*_EDGES_HEXAHEDRON, *_FACES_HEXAHEDRON, tuple(range(8))),
}
"""Corners whose mean is each node after the corners on the reference element, by shape."""

_CORNERS = {
    "line": ((0,), (1,)),
    "triangle": ((0, 0), (1, 0), (0, 1)),
    "quad": ((0, 0), (1, 0), (1, 1), (0, 1)),
    "tetra": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "hexahedron": ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    "wedge": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    "pyramid": ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1)),
}
FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": _EDGES_TRIANGLE,
    "quad": _EDGES_QUAD,
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
"""Corners of the faces (edges in the plane) of each first-order shape, anticlockwise about the outward normal."""

_QUADRATIC = {
    "line": "line3",
    "triangle": "triangle6",
    "quad": "quad9",
    "tetra": "tetra10",
    "hexahedron": "hexahedron27",
    "wedge": "wedge15",
    "pyramid": "pyramid13",
}
_LINEAR = {quadratic: linear for linear, quadratic in _QUADRATIC.items()}
_LINEAR |= {"quad8": "quad", "hexahedron20": "hexahedron", "wedge18": "wedge"}
SERENDIPITY = {"quad9": "quad8", "hexahedron27": "hexahedron20"}
"""Shape without nodes inside faces and cells for each shape with them: these fit the other shapes in a mixed mesh."""
_SIMPLICES = ("line", "triangle", "tetra")


@dataclass(frozen=True, eq=False)
class Shape:
    """An element of order 1 or 2, ``x(s) = sum_i N_i(s) x_i``.

    Attributes
    ----------
    kind : str
        meshio's name, e.g. "tetra10".
    corner_kind : str
        The shape of order 1 with the same corners, e.g. "tetra".
    order : int
        1 or 2.
    nodes : ndarray, shape (nodes per cell, dimension)
        Reference coordinates in the unit simplex or cube, the product of both (wedge), or over the square [-1, 1]^2
        with its apex at (0, 0, 1) (pyramid); VTK order.
    exponents : ndarray of int, shape (nodes per cell, dimension), or one column more
        Exponents of the monomials that span the space; of a pyramid also of 1 / (1 - z).
    coefficients : ndarray, shape (nodes per cell, nodes per cell)
        Column i holds the coefficients of N_i.
    """

    kind: str
    corner_kind: str
    order: int
    nodes: np.ndarray
    exponents: np.ndarray
    coefficients: np.ndarray

    @property
    def dimension(self) -> int:
        """Number of reference coordinates."""
        return int(self.nodes.shape[1])

    @property
    def corners(self) -> int:
        """Number of corners."""
        return len(_CORNERS[self.corner_kind])

    @property
    def is_simplex(self) -> bool:
        """True for lines, triangles and tetrahedra."""
        return self.corner_kind in _SIMPLICES

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return N_i at reference points (p, dimension), shape (p, nodes per cell)."""
        return _monomials(self.exponents, points) @ self.coefficients

    def gradients(self, points: np.ndarray) -> np.ndarray:
        """Return dN_i/ds_a at reference points (p, dimension), shape (p, nodes per cell, dimension)."""
        columns = []
        for axis in range(self.dimension):
            lowered = self.exponents.copy()
            lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
            columns.append((_monomials(lowered, points) * self.exponents[:, axis]) @ self.coefficients)
        if self.exponents.shape[1] > self.dimension:
            raised = self.exponents + np.eye(1, 4, 3, dtype=int)
            columns[2] = columns[2] + (_monomials(raised, points) * self.exponents[:, 3]) @ self.coefficients
        return np.stack(columns, axis=-1)

    def match(self, reference: np.ndarray) -> np.ndarray:
        """Return, for each row of `reference`, the number of our node with these reference coordinates.

        Parameters
        ----------
        reference : ndarray, shape (nodes per cell, dimension)
            Reference coordinates of another program in its own node order, on the same unit element.
        """
        distance = np.abs(np.asarray(reference, dtype=float)[:, None, :] - self.nodes[None, :, :]).max(axis=2)
        nearest = distance.argmin(axis=1)
        if distance.min(axis=1).max() > 1e-6 or len(np.unique(nearest)) != len(self.nodes):
            raise ValueError(f"the reference coordinates are not those of a {self.kind}")
        return nearest

    def reversal(self) -> np.ndarray:
        """Return the node permutation that mirrors the element: it turns a negative Jacobian positive."""
        mirrored = self.nodes.copy()
        if self.dimension == 1:
            mirrored[:, 0] = 1.0 - mirrored[:, 0]
        else:
            mirrored[:, [0, 1]] = mirrored[:, [1, 0]]
        return self.match(mirrored)


@cache
def shape(kind: str) -> Shape:
    """Return the shape with meshio's name `kind`; KeyError if it is not one of `MIDS`."""
    mids = MIDS[kind]
    linear = corner_kind(kind)
    corners = np.array(_CORNERS[linear], dtype=float)
    nodes = np.vstack([corners, *(corners[list(mid)].mean(axis=0) for mid in mids)])
    order = 2 if mids else 1
    powers = _exponents(kind, linear, order, corners.shape[1])
    coefficients = np.linalg.inv(_monomials(powers, nodes))
    return Shape(kind, linear, order, nodes, powers, coefficients)


def _exponents(kind: str, linear: str, order: int, dimension: int) -> np.ndarray:
    """Return the exponents of the monomials that span a shape's space."""
    if linear == "pyramid":
        total = [(a, b, c, 0) for a, b, c in product(range(order + 1), repeat=3) if a + b + c <= order]
        # at the apex these vanish with the cross-section of the pyramid
        rational = [(1, 1, 0, 1)] if order == 1 else [(1, 1, 0, 1), (2, 1, 0, 1), (1, 2, 0, 1)]
        return np.array(total + rational)
    powers = np.array(list(product(range(order + 1), repeat=dimension)))
    if linear in _SIMPLICES:
        return powers[powers.sum(axis=1) <= order]
    if linear == "wedge":
        in_triangle = powers[:, 0] + powers[:, 1]
        highest = order if kind != "wedge15" else np.where(powers[:, 2] == 2, 1, 2)
        return powers[in_triangle <= highest]
    if kind in ("quad8", "hexahedron20"):
        return powers[(powers == 2).sum(axis=1) <= 1]
    return powers


def kind_of_order(kind: str, order: int) -> str:
    """Return the shape with the corners of `kind` and the given order (1 or 2): `kind` itself if it has this order."""
    linear = corner_kind(kind)
    if order == 1:
        return linear
    return kind if kind != linear else _QUADRATIC[linear]


def corner_kind(kind: str) -> str:
    """Return the shape of order 1 with the corners of `kind`."""
    return _LINEAR.get(kind, kind)


def node_count(kind: str) -> int:
    """Return the number of nodes of a shape."""
    return shape(kind).corners + len(MIDS[kind])


def is_supported(kind: str) -> bool:
    """Return whether `kind` is one of the shapes in `MIDS`."""
    return kind in MIDS


def quadrature(kind: str, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (p, dimension) and weights (p,) on the reference element, exact to `degree`.

    Gauss-Legendre products; simplices and pyramids by the collapse of the cube (one point more for each collapsed
    direction). `degree` is total on simplices and per direction on cubes; on pyramids that of the collapsed cube.
    """
    element = shape(kind)
    if element.corner_kind == "wedge":
        flat, areas = quadrature("triangle", degree)
        along, lengths = quadrature("line", degree)
        pairs = list(product(range(len(flat)), range(len(along))))
        points = np.array([(*flat[i], along[j, 0]) for i, j in pairs])
        return points, np.array([areas[i] * lengths[j] for i, j in pairs])
    dimension, is_pyramid = element.dimension, element.corner_kind == "pyramid"
    x, w = np.polynomial.legendre.leggauss(degree // 2 + 1 + (is_pyramid or (dimension > 1 and element.is_simplex)))
    if not is_pyramid:
        x, w = (x + 1.0) / 2.0, w / 2.0
    points = np.array(list(product(x, repeat=dimension)))
    weights = np.prod(np.array(list(product(w, repeat=dimension))), axis=1)
    if is_pyramid:
        height = (1.0 + points[:, 2]) / 2.0
        return np.column_stack((points[:, :2] * (1.0 - height)[:, None], height)), weights * (1.0 - height) ** 2 / 2.0
    if element.is_simplex and dimension == 2:
        a, b = points.T
        return np.column_stack([a, (1.0 - a) * b]), weights * (1.0 - a)
    if element.is_simplex and dimension == 3:
        a, b, c = points.T
        rest = (1.0 - a) * (1.0 - b)
        return np.column_stack([a, (1.0 - a) * b, rest * c]), weights * (1.0 - a) * rest
    return points, weights


def measures(kind: str, coordinates: np.ndarray, degree: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Return the length, area or volume (m,) and the first moments (m, 3) of cells in space.

    Parameters
    ----------
    kind : str
        Shape of the cells.
    coordinates : ndarray, shape (m, nodes per cell, 3)
        Their nodes in m.
    degree : int
        Degree of the quadrature, which limits the accuracy for curved facets: their area is not a polynomial.
    """
    size = np.zeros(len(coordinates))
    moment = np.zeros((len(coordinates), 3))
    for weight, value, stretch in stretches(kind, coordinates, degree):
        share = weight * stretch
        size += share
        moment += share[:, None] * np.einsum("mnx,n->mx", coordinates, value)
    return size, moment


def stretches(kind: str, coordinates: np.ndarray, degree: int) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Yield at each point of a quadrature its weight, the shape functions, and the stretch of each cell, shape (m,).

    Arguments as of `measures`; the stretch is the local size of a cell relative to that of the reference shape.
    """
    element = shape(kind)
    points, weights = quadrature(kind, degree)
    for value, gradient, weight in zip(element.values(points), element.gradients(points), weights, strict=True):
        jacobian = np.einsum("mnx,na->mxa", coordinates, gradient)
        gram = np.einsum("mxa,mxb->mab", jacobian, jacobian)
        yield weight, value, np.sqrt(np.maximum(np.linalg.det(gram), 0.0))


def row_numbers(rows: np.ndarray) -> np.ndarray:
    """Return a number for each row of non-negative integers (m, k): equal rows have equal numbers, in [0, m)."""
    numbers = np.unique(rows[:, 0], return_inverse=True)[1].reshape(-1)
    for column in rows.T[1:]:
        # the product stays below m * max(node), far inside 64 bits
        key = numbers.astype(np.int64) * (int(column.max(initial=0)) + 1) + column
        numbers = np.unique(key, return_inverse=True)[1].reshape(-1)
    return numbers


def _monomials(exponents: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the monomials at the points, shape (p, number of monomials)."""
    points = np.asarray(points, dtype=float)
    if exponents.shape[1] > points.shape[1]:
        below = np.maximum(1.0 - points[:, 2], 1e-300)  # at the apex x and y are zero, and so are the monomials
        points = np.column_stack((points, 1.0 / below))
        powers = np.where(exponents[None, :, :] == 0, 1.0, points[:, None, :] ** exponents[None, :, :])
        powers[..., 3] = np.where((powers[..., :2] == 0.0).any(axis=2), 0.0, powers[..., 3])
        return np.prod(powers, axis=2)
    return np.prod(points[:, None, :] ** exponents[None, :, :], axis=2)
