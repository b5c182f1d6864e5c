"""Whether the parts of a closed mesh bound one room: apart or hollows of each other, and nowhere through each other."""

from __future__ import annotations

import math
import warnings

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Matrix

INSIDE = 0.5
"""Winding number above which a point is inside a part: 1 if the part faces outwards, -1 in a cavity, 0 outside."""

TOUCHING = 1e-6
"""Distance by which an edge must extend beyond a triangle on either side, relative to the size of the mesh, and within
it, relative to the size of the triangle: parts that touch are accepted, and STL files have seven digits."""

LOOKS, BENEATH = 64, 1e-6
"""Number of evenly chosen triangles of a part beneath which other parts are searched; and the depth of the search,
relative to their size."""

AT_ONCE = 1_000_000
"""Largest number of pairs of near triangles that are tested at once."""


def check_parts(vertices: Matrix, triangles: np.ndarray) -> None:
    """Raise a ModelError if a part of a closed mesh is inside out, is within another one, or goes through one.

    A part that goes through itself is told by an AccuracyWarning: folds of scanned surfaces are wrong there alone.

    Parameters
    ----------
    vertices : ndarray, shape (n, 3)
        m.
    triangles : ndarray of int, shape (m, 3)
        Each edge has one triangle on either side.
    """
    parts = _parts(triangles, len(vertices))
    corners = vertices[triangles]
    shifted = corners - vertices.mean(axis=0)
    of_triangles = np.einsum("ij,ij->i", shifted[:, 0], np.cross(shifted[:, 1], shifted[:, 2])) / 6.0
    volumes = np.bincount(parts, weights=of_triangles)
    if len(volumes) == 1 and volumes[0] <= 0.0:
        raise ModelError(
            f"a mesh is inside out: its volume is {volumes[0]:.3g} m3. Remedy: turn its triangles round, "
            "triangles[:, ::-1]"
        )
    crossing = _crossing(corners, triangles)
    if crossing is not None:
        first, second = (parts[i] for i in crossing)
        x, y, z = corners[crossing[0]].mean(axis=0)
        where = f"near ({x:.4g}, {y:.4g}, {z:.4g}) m: the inside is undefined there"
        if first != second:
            raise ModelError(
                f"parts {first} and {second} of a mesh overlap, {where}. Remedy: unite the parts to one surface, or "
                "one mesh and surface each"
            )
        warnings.warn(
            f"a mesh goes through itself, {where}. Remedy: correct the mesh, such as by a union with itself",
            AccuracyWarning,
            stacklevel=outside(),
        )
    if len(volumes) > 1:
        _check_nested(corners, parts, volumes)


def _check_nested(corners: np.ndarray, parts: np.ndarray, volumes: np.ndarray) -> None:
    """Raise a ModelError if parts face the wrong way, hollows inwards and all others outwards, or share some room."""
    of_part = [corners[parts == i] for i in range(len(volumes))]
    lows, highs = (np.array([end(part, axis=(0, 1)) for part in of_part]) for end in (np.min, np.max))
    for i, (part, volume) in enumerate(zip(of_part, volumes, strict=True)):
        for k in np.unique(np.linspace(0, len(part) - 1, LOOKS).astype(int)).tolist():
            normal = np.cross(part[k, 1] - part[k, 0], part[k, 2] - part[k, 0])
            beneath = part[k].mean(axis=0) - BENEATH * normal / math.sqrt(np.linalg.norm(normal))
            around = np.flatnonzero(np.all((lows <= beneath) & (beneath <= highs), axis=1))
            holding = [j for j in around.tolist() if j != i and abs(_winding(beneath, of_part[j])) > INSIDE]
            if (volume > 0.0) == (len(holding) % 2 == 0):
                continue
            size = f"part {i} of a mesh ({len(part)} triangles, {volume:.3g} m3)"
            if holding:
                raise ModelError(
                    f"{size} is within part {holding[0]}, or shares room with it, and faces outwards like it. Remedy: "
                    "leave it out or unite the two; for a hollow turn its triangles round"
                )
            raise ModelError(f"{size} is inside out. Remedy: turn its triangles round")


def _parts(triangles: np.ndarray, count: int) -> np.ndarray:
    """Return the number of the part that each triangle is of: parts share no vertex."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components

    rows, columns = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    graph = csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    labels = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return np.unique(labels, return_inverse=True)[1].ravel()


def _winding(point: np.ndarray, corners: np.ndarray) -> float:
    """Return how often triangles (m, 3, 3) go round a point (van Oosterom and Strackee 1983)."""
    a, b, c = (corners[:, i] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    triple = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
    return float(np.sum(np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb)) / (2.0 * math.pi))


def _crossing(corners: np.ndarray, triangles: np.ndarray) -> tuple[int, int] | None:
    """Return two triangles of which an edge of one goes through the other; None: there are none."""
    first, second = _near(corners)
    reach = TOUCHING * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    for start in range(0, len(first), AT_ONCE):
        i, j = first[start : start + AT_ONCE], second[start : start + AT_ONCE]
        apart = np.all(triangles[i][:, :, None] != triangles[j][:, None, :], axis=(1, 2))
        i, j = i[apart], j[apart]
        for p, q in ((i, j), (j, i)):
            a, ab, ac = corners[q, 0], corners[q, 1] - corners[q, 0], corners[q, 2] - corners[q, 0]
            normal = np.cross(ab, ac)
            square = np.einsum("ij,ij->i", normal, normal)
            heights = np.einsum("ikj,ij->ik", corners[p] - a[:, None], normal)
            for k in range(3):
                h0, h1 = heights[:, k], heights[:, (k + 1) % 3]
                least = reach * np.sqrt(square)
                through = np.flatnonzero((h0 * h1 < 0.0) & (np.minimum(abs(h0), abs(h1)) > least))
                s = (h0[through] / (h0[through] - h1[through]))[:, None]
                foot = (1.0 - s) * corners[p[through], k] + s * corners[p[through], (k + 1) % 3] - a[through]
                u = np.einsum("ij,ij->i", np.cross(foot, ac[through]), normal[through]) / square[through]
                v = np.einsum("ij,ij->i", np.cross(ab[through], foot), normal[through]) / square[through]
                found = np.flatnonzero(np.minimum(np.minimum(u, v), 1.0 - u - v) > TOUCHING)
                if len(found):
                    return int(p[through[found[0]]]), int(q[through[found[0]]])
    return None


def _near(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of triangles whose boxes overlap, each once.

    Triangles are sorted by size, in powers of 2. Those of a size meet in the cells of a grid, twice as large as they
    are, with one another and with all smaller ones.
    """
    low, high = corners.min(axis=1), corners.max(axis=1)
    extents = (high - low).max(axis=1)
    levels = np.floor(np.log2(extents / extents.max())).astype(int)
    origin, count = low.min(axis=0), len(corners)
    found = [np.zeros(0, dtype=np.int64)]
    for level in np.unique(levels):
        up_to = np.flatnonzero(levels <= level)
        size = 2.0 ** (level + 1) * extents.max()
        ranks, keys = _in_cells(low[up_to] - origin, high[up_to] - origin, size)
        owners = up_to[ranks]
        ordered = np.argsort(keys, kind="stable")
        owners, keys = owners[ordered], keys[ordered]
        of_level = np.flatnonzero(levels[owners] == level)
        starts, ends = (np.searchsorted(keys, keys[of_level], side=side) for side in ("left", "right"))
        sizes = ends - starts
        i = np.repeat(owners[of_level], sizes)
        j = owners[np.repeat(starts, sizes) + np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)]
        meets = (i != j) & np.all((low[i] <= high[j]) & (low[j] <= high[i]), axis=1)
        found.append(np.minimum(i, j)[meets] * count + np.maximum(i, j)[meets])
    pairs = np.unique(np.concatenate(found))
    return pairs // count, pairs % count


def _in_cells(low: Matrix, high: Matrix, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which boxes are in which cells of a grid: number of the box, and a number of the cell."""
    first, last = (np.floor(x / size).astype(np.int64) for x in (low, high))
    spans = last - first + 1
    counts = spans.prod(axis=1)
    owner = np.repeat(np.arange(len(low)), counts)
    order = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    nx, ny = spans[owner, 0], spans[owner, 1]
    cells = first[owner] + np.column_stack((order % nx, order // nx % ny, order // (nx * ny)))
    across = last.max(axis=0) + 1
    return owner, (cells[:, 0] * across[1] + cells[:, 1]) * across[2] + cells[:, 2]
