"""Simple meshes without a mesh generator: boxes, rectangles, cylinders and tubes, along x, with named ends."""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.places import InCylinder, OnPlane, PlaceLike
from kanefe.fe_model.shapes import row_numbers, shape
from kanefe.frames import numbers
from kanefe_fem.machine.memory import check_size
from kanefe_fem.mesh.mesh import Mesh

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
"""Corners of a hexahedron, in VTK order."""

_CORE = 0.55
"""Half-diagonal of the central square of a round section, relative to its radius: angles stay near 90 degrees."""


@checked("kind")
def box_mesh(
    size: tuple[float, float, float],
    counts: tuple[int, int, int],
    kind: Literal["hexahedron", "tetra"] = "hexahedron",
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Mesh:
    """Return the mesh of a box along the axes.

    Parameters
    ----------
    size : (float, float, float)
        Lengths of the edges in m.
    counts : (int, int, int)
        Numbers of bricks along the edges.
    kind : {"hexahedron", "tetra"}
        Bricks, or each of them cut into six tetrahedra.
    start : (float, float, float)
        Corner with the smallest coordinates, m.

    Returns
    -------
    Mesh
        Of order 1 with the group of cells "body" and the facets "root" and "tip" (smallest and largest x), "right" and
        "left" (y), "bottom" and "top" (z).

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> print(box_mesh((1.0, 0.1, 0.1), (10, 2, 2)))
    mesh a box: 99 nodes, 40 hexahedron
      extent  1 x 0.1 x 0.1 m, from (0, 0, 0)
      cells   body (40, 0.01 m3)
      facets  root (4, 0.01 m2), tip (4, 0.01 m2), right (20, 0.1 m2), left (20, 0.1 m2), bottom (20, 0.1 m2), top \
(20, 0.1 m2)
    """
    _check("box_mesh", {"size": size, "start": start}, {"counts": counts}, signed=("start",), length=3)
    if kind not in ("hexahedron", "tetra"):
        raise ModelError(f"box_mesh: kind={kind!r}. Remedy: 'hexahedron' or 'tetra'")
    index = np.arange(np.prod(np.array(counts) + 1)).reshape(np.array(counts) + 1)
    axes = [np.linspace(0.0, length, count + 1) for length, count in zip(size, counts, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) + np.asarray(start)
    bricks = np.column_stack([_shifted(index, corner).ravel() for corner in _CORNERS])
    cells = bricks if kind == "hexahedron" else _tetrahedra(bricks)
    mesh = Mesh(nodes, 3, {"body": (Cells(kind, cells),)}, source="a box")
    ends = np.asarray(start) + np.asarray(size)
    names = (("root", "tip"), ("right", "left"), ("bottom", "top"))
    places: dict[str, PlaceLike] = {}
    for axis, (first, last) in enumerate(names):
        normal = np.eye(3)[axis].tolist()
        places |= {first: OnPlane(start, normal), last: OnPlane(ends.tolist(), normal)}
    return mesh.with_groups(places)


def rectangle_mesh(length: float, height: float, counts: int | tuple[int, int], start: Any = (0.0, 0.0)) -> Mesh:
    """Return the mesh of a rectangle in the x-y plane, for plane stress or strain.

    Parameters
    ----------
    length, height : float
        Lengths along x and y in m.
    counts : int or (int, int)
        Number of quadrilaterals along x (one row), or along x and y.
    start : (float, float)
        Corner with the smallest coordinates, m.

    Returns
    -------
    Mesh
        Of order 1 with the group of cells "body" and the lines "root" and "tip" (smallest and largest x), "bottom" and
        "top".

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> rectangle_mesh(1.0, 0.1, (10, 2)).cell_count
    20
    """
    both: Any = (counts, 1) if isinstance(counts, (int, np.integer)) and not isinstance(counts, bool) else counts
    _check("rectangle_mesh", {"size": (length, height), "start": start}, {"counts": both}, signed=("start",), length=2)
    x, y = (
        first + np.linspace(0.0, size, count + 1)
        for first, size, count in zip(start, (length, height), both, strict=True)
    )
    nodes = np.column_stack([np.tile(x, len(y)), np.repeat(y, len(x))])
    index = np.arange(len(nodes)).reshape(len(y), len(x)).T
    quads = np.column_stack([_shifted(index, corner[:2]).ravel() for corner in _CORNERS[:4]])
    mesh = Mesh(nodes, 2, {"body": (Cells("quad", quads),)}, source="a rectangle")
    low, high = (x[0], y[0], 0.0), (x[-1], y[-1], 0.0)
    return mesh.with_groups(
        {
            "root": OnPlane(low, (1, 0, 0)),
            "tip": OnPlane(high, (1, 0, 0)),
            "bottom": OnPlane(low, (0, 1, 0)),
            "top": OnPlane(high, (0, 1, 0)),
        }
    )


@checked("inner_radius", "order")
def cylinder_mesh(
    length: float, radius: float, counts: tuple[int, int, int], *, inner_radius: float = 0.0, order: Literal[1, 2] = 2
) -> Mesh:
    """Return the mesh of a round bar or tube about x, from x = 0.

    Parameters
    ----------
    length, radius : float
        In m.
    counts : (int, int, int)
        Numbers of hexahedra along the axis, along the radius and around the axis; the last is a multiple of four. A bar
        has a square in its middle, with a quarter of the last number along each side.
    inner_radius : float
        Inner radius of a tube in m; 0 for a bar.
    order : {1, 2}
        Order of the geometry: 2 follows the circle with mid-side nodes, 1 is a prism.

    Returns
    -------
    Mesh
        With the group of cells "body" and the facets "root" and "tip" (smallest and largest x), "outside", and for a
        tube "inside".

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> shaft = cylinder_mesh(1.0, 0.05, (10, 2, 12))
    >>> sorted(shaft.facets)
    ['outside', 'root', 'tip']
    """
    _check("cylinder_mesh", {"length and radius": (length, radius)}, {"counts": counts}, length=None)
    along, radial, around = counts
    if around % 4 or not 0.0 <= inner_radius < radius or order not in (1, 2):
        raise ModelError(
            f"cylinder_mesh: counts={counts}, inner_radius={inner_radius!r}, order={order!r}. Remedy: a multiple of "
            "four around, an inner radius below the radius, and order 1 or 2"
        )
    side, fine = around // 4, order
    patches = []
    for quarter in range(4):
        angle = (quarter + np.linspace(0.0, 1.0, fine * side + 1)) * np.pi / 2.0
        circle = np.column_stack((np.cos(angle), np.sin(angle)))
        ends = circle[[0, -1]]
        t = np.linspace(0.0, 1.0, fine * side + 1)[:, None]
        inner = inner_radius * circle if inner_radius > 0.0 else _CORE * radius * (ends[0] * (1 - t) + ends[1] * t)
        s = np.linspace(0.0, 1.0, fine * radial + 1)[:, None, None]
        patches.append((1 - s) * inner + s * radius * circle)
    if inner_radius == 0.0:
        t = np.linspace(0.0, 1.0, fine * side + 1)
        u, v = np.meshgrid(t, t, indexing="ij")
        corners = _CORE * radius * np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
        weights = (((1 - u) * (1 - v)), (u * (1 - v)), (u * v), ((1 - u) * v))
        patches.append(sum(w[..., None] * c for w, c in zip(weights, corners, strict=True)))  # type: ignore[arg-type]
    kind = "hexahedron27" if order == 2 else "hexahedron"
    x = np.linspace(0.0, length, fine * along + 1)
    points, cells = _extruded(patches, x, kind)
    mesh = Mesh(points, 3, {"body": (Cells(kind, cells),)}, source="a tube" if inner_radius else "a round bar")
    # the middle of a straight side is closer to the axis than the radius, but the corners decide
    rim = radius * (1.0 - 1e-6)
    places: dict[str, PlaceLike] = {
        "root": OnPlane((0, 0, 0), (1, 0, 0)),
        "tip": OnPlane((length, 0, 0), (1, 0, 0)),
        "outside": InCylinder((0, 0, 0), (length, 0, 0), radius, rim),
    }
    if inner_radius:
        places["inside"] = InCylinder((0, 0, 0), (length, 0, 0), inner_radius)
    return mesh.with_groups(places)


def _extruded(patches: list[Any], x: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and cells of patches (a, b, 2) of y and z, extruded along x; coincident nodes are merged."""
    element = shape(kind)
    offsets = np.round(element.order * element.nodes).astype(int)
    points, tables, start = [], [], 0
    for patch in patches:
        a, b = patch.shape[:2]
        grid = np.empty((len(x), a, b, 3))
        grid[..., 0], grid[..., 1:] = x[:, None, None], patch[None]
        index = start + np.arange(grid[..., 0].size).reshape(grid.shape[:3])
        step = element.order
        columns = [
            index[tuple(slice(o, n - step + o, step) for o, n in zip(offset, index.shape, strict=True))].ravel()
            for offset in offsets
        ]
        points.append(grid.reshape(-1, 3))
        tables.append(np.column_stack(columns))
        start += grid[..., 0].size
    return merged(np.concatenate(points), np.concatenate(tables))


def merged(nodes: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes (n, 3) and cells with one node where several lie within 1e-9 of the size of the mesh."""
    size = np.ptp(nodes, axis=0).max()
    numbers = row_numbers(np.round((nodes - nodes.min(axis=0)) / (1e-9 * size)).astype(np.int64))
    _, first, place = np.unique(numbers, return_index=True, return_inverse=True)
    return nodes[first], place.reshape(-1)[cells]


def _check(
    who: str, lengths: dict[str, Any], counts: dict[str, Any], *, signed: tuple[str, ...] = (), length: int | None
) -> None:
    """Raise a ModelError for lengths that are not positive and finite, and counts that are not integers above 0."""
    for name, given in lengths.items():
        values = numbers(given)
        has_flags = any(isinstance(one, (bool, np.bool_)) for one in np.ravel(np.asarray(given, dtype=object)))
        bad = has_flags or not np.isfinite(values).all() or (name not in signed and (values <= 0.0).any())
        if bad or (length is not None and values.shape != (length,)):
            raise ModelError(f"{who}: {name}={given!r}. Remedy: finite lengths in m, above zero")
    for name, given in counts.items():
        if numbers(given).shape != (length or 3,) or not all(
            isinstance(n, (int, np.integer)) and n >= 1 for n in given
        ):
            raise ModelError(f"{who}: {name}={given!r}. Remedy: whole numbers of at least 1")
        check_size(math.prod(int(n) + 1 for n in given), f"{who}: {name}={given!r}")


def _shifted(index: np.ndarray, corner: tuple[int, ...]) -> np.ndarray:
    """Return the node of one corner of every brick of a grid of nodes."""
    return index[tuple(slice(c, n - 1 + c) for c, n in zip(corner, index.shape, strict=True))]


def _tetrahedra(bricks: np.ndarray) -> np.ndarray:
    """Cut bricks along their diagonal (Kuhn): one tetrahedron for each order in which x, y and z are stepped."""
    tetrahedra = []
    for order in permutations(range(3)):
        path = np.cumsum([np.zeros(3, dtype=int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        corners = bricks[:, [_CORNERS.index(tuple(step)) for step in path.tolist()]]
        is_odd = np.linalg.det(np.eye(3)[list(order)]) < 0
        tetrahedra.append(corners[:, [0, 2, 1, 3]] if is_odd else corners)
    return np.concatenate(tetrahedra)
