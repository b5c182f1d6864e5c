"""The signed distance of a closed mesh, found by a tree of boxes: see `kanefe.contact.geometry.mesh`."""

from collections import namedtuple
from typing import Annotated, Any

import numpy as np

from kanefe.kernels.contact.nearest_places import on_triangle
from kanefe.kernels.language import Behind, Columns, Record, Rows, Vector, dot, inlined, kernel, norm, unit


class Mesh(Record):
    """Numbers of a mesh: its kind, how many nodes its tree has, these, and its triangles."""

    kind: float
    count: float
    nodes: Annotated[Any, Behind()]


class Node(Record):
    """A box of the tree: its corners, the node behind all that is in it, the first of its triangles and how many."""

    lower: Vector
    upper: Vector
    behind: float
    first: float
    count: float


class Triangle(Record):
    """A triangle: a vertex, two sides, its normal, and those of what lies between some of its vertices, by bits.

    1, 2 and 4 are the vertices, 3, 5 and 6 the edges between two of them, and `WITHIN` is the triangle itself.
    """

    a: Vector
    ab: Vector
    ac: Vector
    normal: Vector
    others: Annotated[Any, Columns(18)]


WITHIN = 7
NODE, TRIANGLE = Node.number_count, Triangle.number_count


class Direction(Record):
    """A unit vector."""

    n: Vector


Away = namedtuple("Away", "gap normal")
"""The signed distance of a place from a surface, m, and the normal."""


Nodes = Rows[Node]
Directions = Rows[Direction]


@inlined
def triangle_of(mesh: Mesh, i: int) -> Triangle:
    """Return a triangle of a mesh."""
    return Triangle(mesh.nodes, NODE * int(mesh.count) + TRIANGLE * i)


@kernel
def mesh_distance(mesh: Mesh, x: Vector) -> Away:
    """Return the signed distance of a point from a mesh, and the normal."""
    none = 0.0 * x
    i, ends = nearest_triangle(mesh, Vector(x.x.real, x.y.real, x.z.real))
    triangle = triangle_of(mesh, i)
    a, normal = triangle.a, triangle.normal
    if ends == WITHIN:
        return Away(dot(normal, x - a), normal + none)
    normal = Directions(triangle.others)[ends - 1].n
    b, c = a + triangle.ab, a + triangle.ac
    start = a if ends & 1 else b if ends & 2 else c
    offset = x - start
    if ends == 3 or ends > 4:  # an edge
        side = (b if ends == 3 else c) - start
        offset -= (dot(offset, side) / dot(side, side)) * side
    length = norm(offset)
    if length.real == 0.0:
        return Away(0.0 * length, unit(normal) + none)
    sign = 1.0 if dot(normal, offset).real >= 0.0 else -1.0
    return Away(sign * length, (sign / length) * offset)


@kernel
def nearest_triangle(mesh: Mesh, x: Vector) -> tuple[int, int]:
    """Return the triangle nearest to a point, and the vertices between which the nearest place is: see `Triangle`."""
    nodes, count = Nodes(mesh.nodes), int(mesh.count)
    best, found, ends = np.inf, 0, 0
    i = first_leaf(nodes, x)  # a first bound, from the leaf that the nearest boxes lead to
    is_first = True
    while i < count or is_first:
        node = nodes[i]
        if is_first or square_to_box(node, x) < best:
            for k in range(int(node.first), int(node.first) + int(node.count)):
                triangle = triangle_of(mesh, k)
                a = triangle.a - x
                offset, between = on_triangle(a, a + triangle.ab, a + triangle.ac)
                square = dot(offset, offset)
                if square < best:
                    best, found, ends = square, k, between
            i += 1
        else:
            i = int(node.behind)
        if is_first:
            i, is_first = 0, False
    return found, ends


@inlined
def first_leaf(nodes: Nodes, x: Vector) -> int:
    """Return a leaf of the tree: of two boxes always that which is nearer."""
    i = 0
    while nodes[i].count == 0.0:
        one, other = i + 1, int(nodes[i + 1].behind)
        i = other if square_to_box(nodes[other], x) < square_to_box(nodes[one], x) else one
    return i


@inlined
def square_to_box(node: Node, x: Vector) -> float:
    """Return the square of the distance of a point from the box of a node."""
    below, above = node.lower - x, x - node.upper
    over = Vector(max(below.x, above.x, 0.0), max(below.y, above.y, 0.0), max(below.z, above.z, 0.0))
    return dot(over, over)  # type: ignore[no-any-return]
