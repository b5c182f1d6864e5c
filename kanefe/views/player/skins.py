"""The skin of a flexible body as points that move by its coordinates, and triangles between them.

The points of a solid are nodes. A shell is drawn with its thickness. A beam is drawn with the outline of its sections
if it is known, else as boxes with the same axial and bending stiffness, as far as rectangles can have it (see
`kanefe.fe_model.ribs.equivalent_sides`). Nodes without cells are drawn as small octahedra.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from kanefe.fe_model.drawn_shell import drawn_shell, tubes
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.fe_model.ribs import CORNERS, outlines
from kanefe.fe_model.shapes import is_supported
from kanefe.fe_model.shapes import shape as element
from kanefe.fe_model.skin import skin as outside
from kanefe.fe_model.thick_shell import ThickShell, thick_skin
from kanefe.results.body_shape import BodyShape
from kanefe.views.player.creases import SMOOTH, shaded

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine

THIN = 0.01
"""Side of a beam with unknown section, and size of a node without cells, relative to the body's size."""

FEW = 10
"""Number of nodes without cells above which they are drawn smaller."""

MOST_NODES = 2000
"""Largest number of nodes without cells that are drawn."""

PIECES = 4
"""Number of straight pieces by which an exact beam is drawn from one station to the next."""

_HALVES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 2), (0, 2, 3)),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 7), (5, 6, 7)),
    "quad9": ((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
}
"""Triangles of a facet, by its shape."""

_RIMS: dict[str, tuple[int, ...]] = {
    "triangle": (0, 1, 2),
    "quad": (0, 1, 2, 3),
    "triangle6": (0, 3, 1, 4, 2, 5),
    "quad8": (0, 4, 1, 5, 2, 6, 3, 7),
    "quad9": (0, 4, 1, 5, 2, 6, 3, 7),
}
"""Nodes around a facet."""

_TIPS = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
_OCTAHEDRON = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])


@dataclass(frozen=True, eq=False)
class Skin:
    """Points of a body that move with its nodes, and triangles and lines between them.

    Attributes
    ----------
    nodes : ndarray of int, shape (p,)
        The node with which each point moves.
    arms : ndarray, shape (p, 3), or None
        From the node to the point, m, if the rotation of the node moves the point.
    points : ndarray, shape (p, 3)
        Undeformed, in G, m.
    triangles : ndarray of int, shape (m, 3)
        Of points, turning about the outward normal.
    lines : ndarray of int, shape (e, 2)
        Edges of the cells.
    creases : ndarray of int, shape (c, 2), or None
        Sharp edges, if they are known: for beams, whose elements are separate pieces.
    fibres : int
        Number of points of each section of a beam; the points are ordered by element and end. 0 for other bodies.
    pieces : int
        Into which each element of an exact beam is divided; its nodes are then the root and all ends of pieces.
    """

    nodes: np.ndarray
    arms: np.ndarray | None
    points: np.ndarray
    triangles: np.ndarray
    lines: np.ndarray
    creases: np.ndarray | None = None
    fibres: int = 0
    pieces: int = 1

    def motion(self, shape: BodyShape, eta: np.ndarray) -> np.ndarray:
        """Return the displacements of the points in G, (r, p, 3) in m, from coordinates (r, k)."""
        if self.arms is not None and shape.line is not None:
            A, p = (of[:, self.nodes] for of in _fine(shape.line, eta))
            rest = _fine(shape.line, np.zeros((1, shape.line.count)))[0][0, self.nodes]
            own = np.squeeze(np.swapaxes(rest, 1, 2) @ self.arms[..., None], -1)
            return np.asarray(p + np.squeeze(A @ own[..., None], -1) - self.points)
        moved = shape.displacements(eta, self.nodes)
        if self.arms is None:
            return moved
        return moved + np.cross(shape.rotations(eta, self.nodes), self.arms)

    def part(self, rows: slice) -> Skin:
        """Return some of the points, without triangles."""
        arms = None if self.arms is None else self.arms[rows]
        return replace(self, nodes=self.nodes[rows], arms=arms, points=self.points[rows], triangles=self.triangles[:0])


class Meshed(Protocol):
    """Nodes and cells of a flexible body or of its `BodyShape`."""

    @property
    def nodes(self) -> np.ndarray:
        """Reference coordinates (n, 3), m."""
        ...

    @property
    def cells(self) -> tuple[Cells, ...]:
        """Blocks of cells, each of one shape."""
        ...

    @property
    def elasticity(self) -> Elasticity | None:
        """Moduli of solids, stiffness of sections of beams."""
        ...


def skin_of(shape: Meshed) -> Skin:
    """Return the skin of a flexible body."""
    blocks: dict[int, list[Cells]] = {1: [], 2: [], 3: []}
    for block in shape.cells:
        if is_supported(block.kind):
            blocks[element(block.kind).dimension].append(block)
    lines, facets = blocks[1], [*blocks[2], *outside(blocks[3])]
    known = shape.elasticity
    if known is not None and known.shell is not None:
        return _of_shell(shape.nodes, shape.cells, known, thick_skin(blocks[2], known.shell))
    if facets:
        return _of_facets(shape.nodes, facets)
    return _of_beams(shape, lines) if lines else _of_nodes(shape.nodes)


def _of_facets(nodes: np.ndarray, facets: Sequence[Cells]) -> Skin:
    used = np.unique(np.concatenate([block.nodes.ravel() for block in facets]))
    triangles, lines = [], []
    for block in facets:
        at = np.searchsorted(used, block.nodes)
        triangles += [at[:, list(three)] for three in _HALVES[block.kind]]
        rim = at[:, list(_RIMS[block.kind])]
        lines.append(np.stack((rim, np.roll(rim, -1, axis=1)), axis=-1).reshape(-1, 2))
    edges = np.unique(np.sort(np.concatenate(lines), axis=1), axis=0)
    return Skin(used, None, nodes[used], np.concatenate(triangles), edges)


def _of_shell(nodes: np.ndarray, cells: Sequence[Cells], known: Elasticity, thick: ThickShell) -> Skin:
    """Return the skin of a shell with its thickness, and after it those of solids and beams in one mesh with it."""
    solids = outside([block for block in cells if element(block.kind).dimension == 3])
    drawn = drawn_shell(nodes, cells, known.ribs, thick, solids)
    points = nodes[drawn.nodes] + drawn.arms
    facets = _of_facets(points, drawn.cells)
    skin = replace(facets, nodes=drawn.nodes, arms=drawn.arms, points=points)
    if not len(drawn.ends):
        return skin
    triangles, lines, seen = _tubes(points[drawn.first :], drawn.ends, drawn.fibres)
    return replace(
        skin,
        triangles=np.concatenate((skin.triangles, drawn.first + triangles)),
        lines=np.concatenate((skin.lines, drawn.first + lines)),
        creases=np.concatenate((shaded(points, skin.triangles).creases, drawn.first + seen)),
    )


def _of_beams(shape: Meshed, blocks: list[Cells]) -> Skin:
    ends, places = np.concatenate([block.nodes[:, :2] for block in blocks]), shape.nodes
    axes, around = _sections(shape, ends)
    line: BeamLine | None = getattr(shape, "line", None)
    if line is not None:
        places = _fine(line, np.zeros((1, line.count)))[1][0]
        ends = np.column_stack((np.arange(len(places) - 1), np.arange(1, len(places))))
        axes, around = (np.repeat(of, PIECES, axis=0) for of in (axes, around))
    count = around.shape[1]
    across = np.einsum("cxa,cka->ckx", axes[:, :, 1:], around)  # (cells, points, 3)
    arms = np.concatenate((across, across), axis=1).reshape(-1, 3)
    nodes = np.repeat(ends, count, axis=1).ravel()
    pieces = 1 if line is None else PIECES
    return Skin(nodes, arms, places[nodes] + arms, *_tubes(places[nodes] + arms, ends, count), count, pieces)


def _tubes(points: np.ndarray, ends: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return triangles, lines and those that are seen of straight beams with `count` points around each end."""
    sides, caps = tubes(len(ends), count)
    first = 2 * count * np.arange(len(ends))[:, None, None]
    triangles = np.concatenate((sides[:, [0, 1, 2]], sides[:, [0, 2, 3]], caps))
    around = np.arange(count)
    after = np.roll(around, -1)
    rings = np.concatenate([np.column_stack((around, after)) + start for start in (0, count)])
    corners = around[_turns(points[:count])]
    along = np.column_stack((corners, corners + count))
    lines = (first + np.concatenate((rings, along))).reshape(-1, 2)
    of_points = np.repeat(ends, count, axis=1).ravel()
    is_last = np.bincount(ends.ravel())[of_points] == 1
    seen = (of_points[lines[:, 0]] != of_points[lines[:, 1]]) | is_last[lines[:, 0]]
    return triangles, lines, lines[seen]


def _fine(line: BeamLine, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return axes (T, n, 3, 3) and places (T, n, 3) in G of the root and all ends of pieces of an exact beam."""
    marks = np.concatenate(([0.0], line.points, [1.0]))
    x = (marks[:-1, None] + np.diff(marks)[:, None] * np.arange(1, PIECES + 1) / PIECES).ravel()
    A, p = line.within(eta, x)
    count = len(eta)
    axes = np.concatenate((np.broadcast_to(line.axes, (count, 1, 3, 3)), A.reshape(count, -1, 3, 3)), axis=1)
    return axes, np.concatenate((np.zeros((count, 1, 3)), p.reshape(count, -1, 3)), axis=1)


def _turns(outline: np.ndarray) -> np.ndarray:
    """Return a mask (p,) of the corners among the points (p, 2) or (p, 3) of an outline."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.asarray((before * after).sum(axis=1) < SMOOTH * lengths)


def _sections(shape: Meshed, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return axes (cells, 3, 3) of beams and outlines of their sections, y and z (cells, p, 2)."""
    size = float(np.linalg.norm(np.ptp(shape.nodes, axis=0))) or 1.0
    known = shape.elasticity
    if known is not None and known.axes is not None and len(known.axes) == len(ends):
        stiffness = np.diagonal(known.table, axis1=1, axis2=2)[known.of_cell]
        fibres = None if known.fibres is None else known.fibres[known.of_cell]
        return known.axes, outlines(stiffness, fibres, size, THIN)
    along = shape.nodes[ends[:, 1]] - shape.nodes[ends[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    helper = np.where(np.abs(along[:, 2:]) < 0.9, np.array((0.0, 0.0, 1.0)), np.array((0.0, 1.0, 0.0)))
    y = np.cross(helper, along)
    y /= np.linalg.norm(y, axis=1)[:, None]
    boxes = np.repeat(CORNERS[None] * 0.5 * THIN * size, len(ends), axis=0)
    return np.stack((along, y, np.cross(along, y)), axis=-1), boxes


def _of_nodes(nodes: np.ndarray) -> Skin:
    chosen = np.unique(np.linspace(0, len(nodes) - 1, min(len(nodes), MOST_NODES)).round().astype(int))
    share = THIN * max(1.0, FEW / len(chosen))
    size = 0.5 * share * (float(np.linalg.norm(np.ptp(nodes, axis=0))) or 1.0)
    moving = np.repeat(chosen, len(_TIPS))
    points = (nodes[chosen][:, None] + size * _TIPS).reshape(-1, 3)
    triangles = (len(_TIPS) * np.arange(len(chosen))[:, None, None] + _OCTAHEDRON).reshape(-1, 3)
    return Skin(moving, None, points, triangles, np.zeros((0, 2), dtype=int))
