"""The signed distance of a closed mesh, found by a tree of boxes: see `kanefe.contact.geometry.mesh`."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, three, times
from kanefe.kernels.compiler._numba import inlined, kernel

# Numbers of a node: lower and upper corner, the node behind all that is in it, its triangles
LOWER, UPPER, BEHIND, FIRST, COUNT = 0, 3, 6, 7, 8
NODE = 9
# Of a triangle: a vertex, two sides, and the normals of itself, its edges and its vertices
NORMALS = 9
TRIANGLE = 30


@kernel
def mesh_distance(numbers: Any, own: int, x: Numbers) -> Any:
    """Return the signed distance of a point from a mesh and the three components of the normal."""
    zero = 0.0 * x[0]
    place = (x[0].real, x[1].real, x[2].real)
    triangle, feature = nearest_triangle(numbers, own, place)
    a, normal = three(numbers, triangle), three(numbers, triangle + NORMALS + 3 * feature)
    if feature == 0:
        return dot(normal, minus(x, a)), normal[0] + zero, normal[1] + zero, normal[2] + zero
    b, c = plus(a, three(numbers, triangle + 3)), plus(a, three(numbers, triangle + 6))
    start = a if feature in (1, 4) else b if feature in (2, 5) else c
    offset = minus(x, start)
    if feature < 4:
        side = minus(b if feature == 1 else c if feature == 2 else a, start)
        offset = minus(offset, times(dot(offset, side) / dot(side, side), side))
    length = np.sqrt(dot(offset, offset))
    if length.real == 0.0:
        size = np.sqrt(dot(normal, normal))
        return zero, normal[0] / size + zero, normal[1] / size + zero, normal[2] / size + zero
    sign = 1.0 if dot(normal, offset).real >= 0.0 else -1.0
    return sign * length, sign * offset[0] / length, sign * offset[1] / length, sign * offset[2] / length


@kernel
def nearest_triangle(numbers: Any, own: int, x: Numbers) -> tuple[int, int]:
    """Return where the triangle nearest to a point begins, and where on it: 0 within, 1 to 3 edges, 4 to 6 vertices."""
    count, nodes = int(numbers[own]), own + 1
    triangles = nodes + NODE * count
    best, found, feature = np.inf, triangles, 0
    node = first_leaf(numbers, nodes, x)  # a first bound, from the leaf that the nearest boxes lead to
    is_first = True
    while node < count or is_first:
        at = nodes + NODE * node
        if is_first or square_to_box(numbers, at, x) < best:
            for i in range(int(numbers[at + COUNT])):
                triangle = triangles + TRIANGLE * (int(numbers[at + FIRST]) + i)
                square, where = on_triangle(numbers, triangle, x)
                if square < best:
                    best, found, feature = square, triangle, where
            node = node + 1
        else:
            node = int(numbers[at + BEHIND])
        if is_first:
            node, is_first = 0, False
    return found, feature


@inlined
def first_leaf(numbers: Any, nodes: int, x: Numbers) -> int:
    """Return a leaf of the tree: of two boxes always that which is nearer."""
    node = 0
    while numbers[nodes + NODE * node + COUNT] == 0.0:
        one = node + 1
        other = int(numbers[nodes + NODE * one + BEHIND])
        is_nearer = square_to_box(numbers, nodes + NODE * other, x) < square_to_box(numbers, nodes + NODE * one, x)
        node = other if is_nearer else one
    return node


@inlined
def square_to_box(numbers: Any, at: int, x: Numbers) -> float:
    """Return the square of the distance of a point from the box of a node."""
    square = 0.0
    for c in range(3):
        over = max(numbers[at + LOWER + c] - x[c], x[c] - numbers[at + UPPER + c], 0.0)
        square += over * over
    return square


@inlined
def on_triangle(numbers: Any, at: int, x: Numbers) -> tuple[float, int]:
    """Return the square of the distance of a point from a triangle, and where on it the nearest place is."""
    ab, ac, normal = three(numbers, at + 3), three(numbers, at + 6), three(numbers, at + NORMALS)
    from_a = minus(x, three(numbers, at))
    from_b, from_c, bc = minus(from_a, ab), minus(from_a, ac), minus(ac, ab)
    if (
        dot(cross(ab, from_a), normal) >= 0.0
        and dot(cross(bc, from_b), normal) >= 0.0
        and dot(cross(from_c, ac), normal) >= 0.0
    ):
        height = dot(from_a, normal)
        return height * height, 0
    first, f1 = on_edge(from_a, ab, 1, 4, 5)
    second, f2 = on_edge(from_b, bc, 2, 5, 6)
    third, f3 = on_edge(from_c, (-ac[0], -ac[1], -ac[2]), 3, 6, 4)
    if first <= second and first <= third:
        return first, f1
    return (second, f2) if second <= third else (third, f3)


@inlined
def on_edge(offset: Numbers, side: Numbers, edge: int, start: int, end: int) -> tuple[float, int]:
    """Return the same of an edge, from whose start the point has an offset."""
    s = dot(offset, side) / dot(side, side)
    if s <= 0.0:
        return dot(offset, offset), start
    if s >= 1.0:
        rest = minus(offset, side)
        return dot(rest, rest), end
    rest = minus(offset, times(s, side))
    return dot(rest, rest), edge
