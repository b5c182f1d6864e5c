"""Seams: where a shell meets a solid, along its edges or with its surface.

Along an edge the motion of the shell is that of the solid over the thickness: displacement and tilt ``b = theta x n``
are the line through the solid's displacements, fitted along the normal, and averaged along the edge with functions
that are dual to those of the shell. Nothing is clamped, since the solid's thickness and warping stay free, and the
forces on the solid do the same work as those of the shell (distributing coupling; the dual functions of mortar methods
are Wohlmuth's, SIAM J. Numer. Anal. 38 (2000) 989). A surface that lies on the solid follows its displacement, and the
thickness beside it turns by itself. Rigid motions fit exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from kanefe.errors import MeshError
from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import FACES, corner_kind, shape
from kanefe.fe_model.skin import facet_of
from kanefe.frames import skews
from kanefe_fem.mesh.closest import closest_points
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.problem import ShellCells

TOUCHES = 1e-6
"""Distance of a node from the solid, relative to the size of the body, up to which they touch."""

BESIDE = 0.02
"""Distance of a point in the thickness from the solid, relative to the thickness, up to which it is on it."""

LEAST = 0.45
"""Least part of an edge that lies on the solid, relative to its thickness."""

MOST = 6
"""Largest number of parts of an edge, and of its thickness, for quadrature."""


class Seams(NamedTuple):
    """Nodes of a shell that follow a solid.

    Attributes
    ----------
    nodes : ndarray of int, shape (k,)
    held : ndarray, shape (k, 6, 6)
        Projector on the components of the nodes that follow.
    follows : csr_matrix, shape (6 k, 3 n)
        These components from the displacements of the solid's nodes.
    arms : ndarray, shape (k, 3)
        From the solid to nodes of a surface on it, m; zero on edges: there ``theta x arm`` is added.
    edges, faces : int
        Numbers of edges and of cells.
    on_solid : float
        Least part of the thickness of an edge that lies on the solid.
    """

    nodes: np.ndarray
    held: np.ndarray
    follows: sp.csr_matrix
    arms: np.ndarray
    edges: int
    faces: int
    on_solid: float


class _Edges(NamedTuple):
    """Edges with the directors, the thickness and the ends of the section at their nodes."""

    nodes: np.ndarray
    normals: np.ndarray
    thickness: np.ndarray
    ends: np.ndarray


def seams_of(
    nodes: np.ndarray, found: Directors, cells: Sequence[ShellCells], solid: np.ndarray, skin: Sequence[Cells]
) -> Seams:
    """Return where a shell meets a solid.

    Parameters
    ----------
    nodes : ndarray, shape (m, 3)
        Of the shell, m.
    found : Directors
    cells : sequence of ShellCells
    solid : ndarray, shape (n, 3)
        Nodes of the solid, m.
    skin : sequence of Cells
        Facets of the solid's skin.

    Raises
    ------
    MeshError
        If they do not meet, or an edge is not across the solid's surface.
    """
    size = np.ptp(np.concatenate((nodes, solid)), axis=0).max()
    at = closest_points(solid, skin, nodes)
    touching = at.distance <= TOUCHES * size
    on_face = [touching[one.cells.nodes[:, : shape(one.cells.kind).corners]].all(axis=1) for one in cells]
    laid = np.unique(
        np.concatenate([one.cells.nodes[which].ravel() for one, which in zip(cells, on_face, strict=True)])
    )
    is_laid = np.zeros(len(nodes), dtype=bool)
    is_laid[laid] = True
    edges = _edges(found, cells, touching, is_laid)
    if not len(laid) and not len(edges.nodes):
        raise MeshError(
            "the shell meets the solids nowhere: no edge of it and no cell has all its corners on their skin. Remedy: "
            "fragment the geometry (BooleanFragments in a .geo), so that edges lie on faces; bodies apart are joined "
            "by joints of a scene"
        )
    return _both(nodes, laid, at.shares, solid, _along(nodes, edges, solid, skin), sum(int(w.sum()) for w in on_face))


def _edges(found: Directors, cells: Sequence[ShellCells], touching: np.ndarray, is_laid: np.ndarray) -> _Edges:
    """Return the edges of the shell whose ends touch the solid, other than those of cells that lie on it, each once."""
    nodes, normals, thickness, ends = [np.zeros((0, 3), dtype=np.int64)], [np.zeros((0, 3, 3))], [np.zeros((0, 3))], []
    for one in cells:
        reach = np.array([[own.layers[0].bottom, own.layers[-1].top] for own in one.sections])[one.of_cell]
        for side in FACES[corner_kind(one.cells.kind)]:
            columns = list(facet_of(one.cells.kind, side)[1])
            table = one.cells.nodes[:, columns]
            which = touching[table[:, :2]].all(axis=1) & ~is_laid[table].all(axis=1)
            nodes.append(table[which])
            normals.append(found.normal[one.sides[which][:, columns]])
            thickness.append(one.thickness[which][:, columns])
            ends.append(reach[which])
    table = np.concatenate(nodes)
    once = np.unique(np.sort(table, axis=1), axis=0, return_index=True)[1]
    return _Edges(
        table[once], np.concatenate(normals)[once], np.concatenate(thickness)[once], np.concatenate(ends)[once]
    )


class _Fitted(NamedTuple):
    """Sums over the edges at each node: displacement and tilt from the solid, and the weights."""

    nodes: np.ndarray
    displacement: sp.csr_matrix
    turn: sp.csr_matrix
    spread: np.ndarray
    edges: int
    on_solid: float


def _along(nodes: np.ndarray, edges: _Edges, solid: np.ndarray, skin: Sequence[Cells]) -> _Fitted:
    """Return the fit of the solid's displacements along edges."""
    used, where = np.unique(edges.nodes, return_inverse=True)
    where = where.reshape(edges.nodes.shape)
    count = len(solid)
    weight, spread, least = np.zeros(len(used)), np.zeros((len(used), 3, 3)), 1.0
    if not len(used):
        none = sp.csr_matrix((0, 3 * count))
        return _Fitted(used, none, none, spread, 0, least)
    facet = _facet_sizes(solid, skin, nodes[edges.nodes].mean(axis=1))
    points = [_points(nodes[table], *own) for table, *own in zip(*edges, facet, strict=True)]
    at = closest_points(solid, skin, np.concatenate([one.places for one in points]))
    start, means, tilts = 0, [], []
    for one, normal, thickness, place in zip(points, edges.normals, edges.thickness.mean(axis=1), where, strict=True):
        own = slice(start, start := start + len(one.places))
        inside = (at.distance[own] <= BESIDE * thickness).reshape(one.heights.shape)
        covered = float((inside @ one.shares).min())
        least = min(least, covered)
        if covered < LEAST:
            _refuse_edge(one.places.mean(axis=0), thickness, covered)
        level, slope = _line(one.heights, inside * one.shares)
        lengths = one.along @ one.N
        mass = np.einsum("p,pi,pj->ij", one.along, one.N, one.N)
        dual = lengths[:, None] * np.linalg.solve(mass, (one.along[:, None] * one.N).T)
        of_mean, of_tilt = ((dual[:, :, None] * fit).reshape(3, -1) @ at.shares[own] for fit in (level, slope))
        means.append(sp.csr_matrix(of_mean))
        tilts.append(sp.csr_matrix(of_tilt))
        np.add.at(weight, place, lengths)
        np.add.at(spread, place, lengths[:, None, None] * (np.eye(3) - normal[:, :, None] * normal[:, None, :]))
    mean = _spread(sp.vstack(means), where.ravel(), len(used))
    # theta = n x b at the nodes, of all edges there by least squares
    turn = _turns(sp.vstack(tilts), edges.normals.reshape(-1, 3), where.ravel(), len(used))
    displacement = sp.kron(sp.diags(1.0 / weight) @ mean, sp.identity(3), format="csr")
    return _Fitted(used, displacement, turn, spread, len(edges.nodes), least)


class _Points(NamedTuple):
    """Points of quadrature on the end face of a shell at one edge: p along it, h over the thickness.

    `N` (p, 3) and `along` (p,), weights in m, belong to the edge; `heights` (p, h) in m and `shares` (h,) to the
    thickness; `places` is (p h, 3).
    """

    N: np.ndarray
    along: np.ndarray
    heights: np.ndarray
    shares: np.ndarray
    places: np.ndarray


def _points(x: np.ndarray, normal: np.ndarray, thickness: np.ndarray, ends: np.ndarray, facet: float) -> _Points:
    """Return the points of an edge with nodes x (3, 3) beside facets of a size in m."""
    element = shape("line3")
    xi, w = _gauss(float(np.linalg.norm(x[1] - x[0])), facet)
    N = element.values(xi[:, None])
    along = np.linalg.norm(np.einsum("pna,ni->pi", element.gradients(xi[:, None]), x), axis=1) * w
    z, shares = _gauss((ends[1] - ends[0]) * thickness.mean(), facet)
    heights = (N @ thickness)[:, None] * (ends[0] + (ends[1] - ends[0]) * z)
    places = (N @ x)[:, None] + heights[:, :, None] * (N @ normal)[:, None]
    return _Points(N, along, heights, shares, places.reshape(-1, 3))


def _gauss(length: float, facet: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points and weights from 0 to 1, three in each part of the size of a facet."""
    parts = int(np.clip(np.ceil(length / facet - 1e-6), 1, MOST))
    x, w = np.polynomial.legendre.leggauss(3)
    places = (np.arange(parts)[:, None] + 0.5 * (1.0 + x)) / parts
    return places.ravel(), np.tile(0.5 * w / parts, parts)


def _facet_sizes(solid: np.ndarray, skin: Sequence[Cells], places: np.ndarray) -> np.ndarray:
    """Return the shortest side of the facet whose middle is nearest to each place, m."""
    corners = [solid[block.nodes[:, : shape(block.kind).corners]] for block in skin]
    sizes = [np.linalg.norm(own - np.roll(own, 1, axis=1), axis=2).min(axis=1) for own in corners]
    middles = np.concatenate([own.mean(axis=1) for own in corners])
    return np.asarray(np.concatenate(sizes)[cKDTree(middles).query(places)[1]])


def _line(heights: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of values at heights (p, h) in level and slope of the line through them, each (p, h)."""
    total = weights.sum(axis=1, keepdims=True)
    centre = (weights * heights).sum(axis=1, keepdims=True) / total
    slope = weights * (heights - centre)
    slope = slope / (slope * heights).sum(axis=1, keepdims=True)
    return weights / total - centre * slope, slope


def _spread(rows: sp.csr_matrix, place: np.ndarray, count: int) -> sp.csr_matrix:
    """Return rows at their places among `count`."""
    at = sp.csr_matrix((np.ones(len(place)), (place, np.arange(len(place)))), (count, len(place)))
    return at @ rows


def _turns(tilt: sp.csr_matrix, normal: np.ndarray, place: np.ndarray, count: int) -> sp.csr_matrix:
    """Return ``n x b`` of tilts b (3 nodes, solid's nodes) at their places, over displacements."""
    rows = block_diagonal(skews(normal)) @ sp.kron(tilt, sp.identity(3), format="csr")
    return _spread(rows, (3 * place[:, None] + np.arange(3)).ravel(), 3 * count)


def _both(
    nodes: np.ndarray, laid: np.ndarray, shares: sp.csr_matrix, solid: np.ndarray, fitted: _Fitted, faces: int
) -> Seams:
    """Return edges and surfaces together; nodes of surfaces come first."""
    kept = np.flatnonzero(~np.isin(fitted.nodes, laid))
    count, first = len(laid) + len(kept), len(laid)
    # tilt about the axes that the directors at a node define; the rotation about a single one stays its own
    squares, axes = np.linalg.eigh(fitted.spread[kept])
    known = squares > 1e-3 * squares[:, -1:]
    inverse = (axes * np.where(known, 1.0 / np.where(known, squares, 1.0), 0.0)[:, None]) @ axes.swapaxes(1, 2)
    held = np.zeros((count, 6, 6))
    held[:, range(3), range(3)] = 1.0
    held[first:, 3:, 3:] = (axes * known[:, None]) @ axes.swapaxes(1, 2)
    own = (3 * kept[:, None] + np.arange(3)).ravel()
    moved = sp.vstack((sp.kron(shares[laid], sp.identity(3)), fitted.displacement[own]), format="csr")
    turned = block_diagonal(inverse) @ fitted.turn[own]
    numbers = np.arange(count)
    follows = _spread(moved, (6 * numbers[:, None] + np.arange(3)).ravel(), 6 * count)
    follows = follows + _spread(turned, (6 * numbers[first:, None] + np.arange(3, 6)).ravel(), 6 * count)
    arms = np.zeros((count, 3))
    arms[:first] = nodes[laid] - shares[laid] @ solid
    return Seams(np.append(laid, fitted.nodes[kept]), held, follows, arms, fitted.edges, faces, fitted.on_solid)


def _refuse_edge(place: np.ndarray, thickness: float, covered: float) -> None:
    raise MeshError(
        f"the edge of the shell at {place.round(6).tolist()} m is {thickness:.3g} m thick, and {100 * covered:.0f} % "
        "of that lies on the solid. Remedy: an edge across a face that is as high as the shell is thick; where the "
        "shell lies on a face, surfaces of the face as its cells"
    )
