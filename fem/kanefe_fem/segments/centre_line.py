"""Centre lines of slender bodies: given, of a chain of beams, or found in a mesh, and stations along them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape
from kanefe.frames import numbers

SLENDER = 5.0
"""Smallest length of a body that is cut, relative to its width across the centre line."""

STRAIGHT = 0.05
"""Distance of sections from a straight axis, relative to their width, up to which a centre line is straight."""

MOST_SAMPLES = 20000
"""Number of points of a centre line that are compared to see whether it crosses itself."""

MOST_PAIRS = 2**20
"""Number of pairs of points and places on a line that are compared at a time."""


def arc_lengths(line: np.ndarray) -> np.ndarray:
    """Return the length of a polyline up to each of its points, m."""
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))))


def given_line(line: object) -> np.ndarray:
    """Return a centre line given as points (p, 3), checked."""
    points = numbers(line)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2 or not np.isfinite(points).all():
        raise ModelError(f"the centre line has shape {points.shape}. Remedy: at least two points, shape (p, 3), in m")
    if not (np.linalg.norm(np.diff(points, axis=0), axis=1) > 0.0).all():
        raise ModelError("the centre line has the same point twice in a row. Remedy: leave one out")
    return points


def check_line(line: np.ndarray, width: float) -> None:
    """Refuse a body that is too stout to be cut, or whose centre line crosses itself.

    Parameters
    ----------
    line : ndarray, shape (p, 3)
        m.
    width : float
        Extent of the body across the line, m.
    """
    s = arc_lengths(line)
    if s[-1] < SLENDER * width:
        raise ModelError(
            f"the body is too stout to be cut: {s[-1]:.3g} m long and {width:.3g} m across, less than {SLENDER:g} "
            "times as long as wide. Remedy: one flexible body (beam_body, solid_body)"
        )
    step = max(0.25 * width, s[-1] / MOST_SAMPLES)
    at = np.linspace(0.0, s[-1], int(np.ceil(s[-1] / step)) + 1)
    samples = np.column_stack([np.interp(at, s, line[:, a]) for a in range(3)])
    pairs = cKDTree(samples).query_pairs(max(0.5 * width, step), output_type="ndarray")
    apart = at[pairs[:, 1]] - at[pairs[:, 0]]
    met = np.flatnonzero(abs(apart) > max(2.0 * width, 4.0 * step))
    if met.size:
        where = ", ".join(f"{x:.4g}" for x in samples[pairs[met[0], 0]])
        raise ModelError(
            f"the centre line crosses or touches itself at ({where}) m. Remedy: cut bodies that are chains, or give "
            "the centre line as line="
        )


def stations(points: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the arc length (m) of the section of a line in which each point (n, 3) lies, and its distance there.

    Sections are planes across the line, whose normals turn steadily from point to point; the ends are prolonged.
    """
    most = max(1, MOST_PAIRS // len(line))
    if len(points) > most:
        parts = [stations(points[i : i + most], line) for i in range(0, len(points), most)]
        return np.concatenate([at for at, _ in parts]), np.concatenate([distance for _, distance in parts])
    s, tangents = arc_lengths(line), _tangents(line)
    ahead = np.einsum("npa,pa->np", points[:, None] - line, tangents)
    share = ahead[:, :-1] / np.where(ahead[:, :-1] == ahead[:, 1:], 1.0, ahead[:, :-1] - ahead[:, 1:])
    is_between = (ahead[:, :-1] >= 0.0) & (ahead[:, 1:] <= 0.0)
    at = np.column_stack([s[:-1] + share * np.diff(s), ahead[:, 0], s[-1] + ahead[:, -1]])
    foot = line[:-1] + share[..., None] * np.diff(line, axis=0)
    ends = np.stack([line[i] + ahead[:, i, None] * tangents[i] for i in (0, -1)], axis=1)
    distance = np.linalg.norm(points[:, None] - np.concatenate([foot, ends], axis=1), axis=2)
    distance[:, :-2][~is_between] = np.inf
    distance[ahead[:, 0] > 0.0, -2] = np.inf
    distance[ahead[:, -1] < 0.0, -1] = np.inf
    nearest = distance.argmin(axis=1)[:, None]
    return np.take_along_axis(at, nearest, 1)[:, 0], np.take_along_axis(distance, nearest, 1)[:, 0]


def _tangents(line: np.ndarray) -> np.ndarray:
    """Return unit tangents at the points of a line, at its ends extrapolated."""
    chords = np.diff(line, axis=0)
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    inner = chords[:-1] + chords[1:]
    if len(inner):
        chords = np.vstack([3.0 * chords[0] - chords[1], inner, 3.0 * chords[-1] - chords[-2]])
    else:
        chords = np.repeat(chords, 2, axis=0)
    return np.asarray(chords / np.linalg.norm(chords, axis=1)[:, None])


def width_across(distances: np.ndarray) -> float:
    """Return the width of a body from the distances of its nodes to the line: the diameter of a full circle, m."""
    return float(2.0 * np.sqrt(2.0 * np.mean(distances**2)))


def found_line(nodes: np.ndarray, cells: Sequence[Cells]) -> np.ndarray:
    """Return the centre line of a mesh: straight, or through the middles of its sections, shape (p, 3).

    A straight one is the principal axis of the nodes. Else sections are sets of nodes at one distance from the ends,
    along the edges of the mesh, and then of one station on the line through the middles of these.
    """
    tables = [block.nodes[:, : shape(block.kind).corners] for block in cells]
    used = np.unique(np.concatenate([table.ravel() for table in tables]))
    nodes = nodes[used]
    middle = nodes.mean(axis=0)
    e = np.linalg.svd(nodes - middle, full_matrices=False)[2][0]
    e = e if e[np.argmax(abs(e))] > 0.0 else -e
    axis = np.array([middle - e, middle + e])
    at, distance = stations(nodes, axis)
    width = width_across(distance)
    middles = _middles(nodes, at, int(np.clip(np.ptp(at) / max(width, 1e-300), 3, 400)))
    off = np.linalg.norm(middles - middle - np.outer((middles - middle) @ e, e), axis=1)
    if off.max() < STRAIGHT * width:
        return middle + np.outer((at.min() - 1.0, at.max() - 1.0), e)
    return _bent(nodes, [np.searchsorted(used, table) for table in tables])


def _bent(nodes: np.ndarray, tables: Sequence[np.ndarray]) -> np.ndarray:
    graph = _edges(nodes, tables)
    first = int(dijkstra(graph, indices=0).argmax())
    ahead = dijkstra(graph, indices=first)
    behind = dijkstra(graph, indices=int(ahead.argmax()))
    at = 0.5 * (ahead - behind)
    width = 2.0 * float(np.sqrt(_spread(nodes, at)))
    bins = int(np.clip(2.0 * np.ptp(at) / max(width, 1e-300), 3, 400))
    line = _middles(nodes, at, bins)
    for _ in range(3):
        at, _ = stations(nodes, line)
        line = _middles(nodes, at, bins)
    at, _ = stations(nodes, line)
    tangents, beyond = _tangents(line), (min(0.0, float(at.min())), max(0.0, float(at.max()) - arc_lengths(line)[-1]))
    ends = [line[i] + tangents[i] * step for i, step in zip((0, -1), beyond, strict=True)]
    return np.vstack([ends[0], line, ends[1]])


def _spread(nodes: np.ndarray, at: np.ndarray) -> float:
    """Return the mean square distance of nodes from the middle of one of twenty sections, twice, m2."""
    number = np.minimum((20 * (at - at.min()) / max(np.ptp(at), 1e-300)).astype(int), 19)
    middles = _middles(nodes, at, 20)
    own = np.unique(number, return_inverse=True)[1]
    return 2.0 * float(np.mean(np.sum((nodes - middles[own]) ** 2, axis=1)))


def _middles(nodes: np.ndarray, at: np.ndarray, bins: int) -> np.ndarray:
    """Return the centres of the nodes in equal intervals of a coordinate, those with nodes."""
    number = np.minimum((bins * (at - at.min()) / max(np.ptp(at), 1e-300)).astype(int), bins - 1)
    counts = np.bincount(number, minlength=bins)
    sums = np.column_stack([np.bincount(number, nodes[:, a], minlength=bins) for a in range(3)])
    return sums[counts > 0] / counts[counts > 0, None]


def _edges(nodes: np.ndarray, tables: Sequence[np.ndarray]) -> sp.csr_matrix:
    """Return the distances between nodes of one cell, shape (n, n)."""
    pairs = []
    for table in tables:
        i, j = np.triu_indices(table.shape[1], 1)
        pairs.append(np.column_stack((table[:, i].ravel(), table[:, j].ravel())))
    a, b = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0).T
    length, n = np.linalg.norm(nodes[a] - nodes[b], axis=1), len(nodes)
    return sp.csr_matrix((np.tile(length, 2), (np.r_[a, b], np.r_[b, a])), (n, n))
