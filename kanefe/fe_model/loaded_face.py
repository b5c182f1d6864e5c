"""Faces of a body that carry distributed loads: sums of a field over their facets.

A load on a face may vary by place, ``p(X) = p w(X)`` with a shape w of the undeformed places. Its forces on the points
of a facet are integrals with w in them,

    int w N_i dA,    s int w N_i x_xi x x_eta dxi deta    (sign s, positions x = sum N_i x_i)

and so are their changes as the points move (`kanefe.fe_model.pressure_change`), since w stays with the material.
Facets on which a quadrature and one on their quarters disagree are divided on, so that patches and jumps are resolved.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product

import numpy as np

from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.place_field import PlaceField
from kanefe.fe_model.pressure_change import PressureChange, turning
from kanefe.fe_model.shapes import quadrature, shape
from kanefe.frames import skews
from kanefe.storage.scipy_later import sp

DEGREE = 8
"""Degree of quadrature: exact for pressures on curved facets of second order, also if they vary linearly."""

RESOLVED = 1e-6
"""Change of the forces on a facet by division, relative to the mean of all facets, below which it is not divided on."""

DIVISIONS = 5
"""Largest number of divisions of a facet in four: 32 parts along a side."""

ROUGH = 1e-3
"""Relative change of all forces by the last division from which it is told."""

Piece = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Rows of facets, points and weights of a quadrature on them, and values of a field there (m, p)."""


@dataclass(frozen=True, eq=False)
class FacetBlock:
    """Facets of one shape, and how their points move with the nodes of a model.

    Attributes
    ----------
    kind : str
        Shape of the facets, by meshio's name; a line for edges, and for plane bodies.
    nodes : ndarray of int, shape (m, n)
    places : ndarray, shape (m, n, 3)
        Undeformed points of the face, m.
    signs : ndarray, shape (m,)
        1 where a pressure pushes along ``x_xi x x_eta`` (of a line: ``x_xi x e_z``), -1 where against it; of a plane
        body times its thickness (m).
    arms : ndarray, shape (m, n, 3), or None
        Points less nodes, m, where the nodes rotate. None: the points are the nodes.
    """

    kind: str
    nodes: np.ndarray
    places: np.ndarray
    signs: np.ndarray
    arms: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class LoadedFace:
    """A face or a line of a model that carries distributed loads.

    Attributes
    ----------
    blocks : tuple of FacetBlock
        With P points together.
    count, width : int
        How many nodes there are, and components of each: x, y; x, y, z; or three rotations too.
    through : csr_matrix, shape (count * width, N), or None
        Their motion from the components of a model; None: they are the components.
    """

    blocks: tuple[FacetBlock, ...]
    count: int
    width: int
    through: sp.csr_matrix | None = None

    def moved_by(self, motion: sp.csr_matrix) -> LoadedFace:
        """Return the face over other coordinates, by which the components of this one move, (N, others)."""
        return replace(self, through=motion if self.through is None else (self.through @ motion).tocsr())

    @cached_property
    def points(self) -> np.ndarray:
        """Undeformed places, shape (P, 3), m."""
        return np.concatenate([block.places.reshape(-1, 3) for block in self.blocks])

    @cached_property
    def arms(self) -> np.ndarray:
        """Points less nodes, shape (P, 3), m."""
        arms = [np.zeros_like(block.places) if block.arms is None else block.arms for block in self.blocks]
        return np.concatenate(arms).reshape(-1, 3)

    @cached_property
    def motion(self) -> sp.csr_matrix:
        """Displacements of the points from the components of the model, (3 P, N)."""
        found = sp.kron(self._to_nodes, sp.eye(3, self.width), format="csr")
        if self.width > 3:
            found = found - block_diagonal(skews(self.arms)) @ self._turns
        return self._wide(found)

    def pressure_change(self, forces: np.ndarray, across: sp.csr_matrix) -> PressureChange:
        """Return the change of forces (P, 3) with the displacements of the points, given that over these."""
        second = None
        if self.width > 3:
            turns = self._wide(self._turns)
            second = (turns.T @ block_diagonal(turning(forces, self.arms)) @ turns).tocsr()
        return PressureChange(self.points, forces, across, self.motion, second)

    def sums(self, over: PlaceField | None = None) -> tuple[np.ndarray, np.ndarray, sp.csr_matrix]:
        """Return the shares (P,) in the area, the forces (P, 3) of a unit pressure and their change (3 P, 3 P).

        Parameters
        ----------
        over : PlaceField, optional
            The shape by which the load varies. Default: it is uniform.
        """
        pieces = [_whole(block) if over is None else [] for block in self.blocks]
        if over is not None:
            pieces = _resolved(self.blocks, over)
        found = [_sums(block, own) for block, own in zip(self.blocks, pieces, strict=True)]
        shares, forces, across = zip(*found, strict=True)
        return (
            np.concatenate([one.ravel() for one in shares]),
            np.concatenate([one.reshape(-1, 3) for one in forces]),
            sp.block_diag(across, format="csr"),
        )

    @property
    def _to_nodes(self) -> sp.csr_matrix:
        node = np.concatenate([block.nodes.ravel() for block in self.blocks])
        return sp.csr_matrix((np.ones(len(node)), node, np.arange(len(node) + 1)), (len(node), self.count))

    @property
    def _turns(self) -> sp.csr_matrix:
        """Rotations of the nodes of the points, (3 P, count * width)."""
        return sp.kron(self._to_nodes, sp.eye(3, self.width, k=3), format="csr")

    def _wide(self, rows: sp.csr_matrix) -> sp.csr_matrix:
        return rows if self.through is None else (rows @ self.through).tocsr()


def normals(tangents: np.ndarray) -> np.ndarray:
    """Return normals with the length of the measure, from tangents (..., 3, d); of a line ``x_xi x e_z``."""
    if tangents.shape[-1] == 1:
        return np.cross(tangents[..., 0], np.eye(3)[2])
    return np.cross(tangents[..., 0], tangents[..., 1])


def at_points(block: FacetBlock, points: np.ndarray, rows: np.ndarray | slice = slice(None)) -> tuple[np.ndarray, ...]:
    """Return shape functions (p, n), their slopes (p, n, d), places (m, p, 3) and tangents (m, p, 3, d) at points."""
    element = shape(block.kind)
    values, slopes, x = element.values(points), element.gradients(points), block.places[rows]
    return values, slopes, np.einsum("pn,mni->mpi", values, x), np.einsum("pna,mni->mpia", slopes, x)


def measure_of(tangents: np.ndarray) -> np.ndarray:
    """Return length or area of unit reference cells, from tangents (..., 3, d)."""
    along = tangents[..., 0] if tangents.shape[-1] == 1 else normals(tangents)
    return np.asarray(np.linalg.norm(along, axis=-1))


@cache
def divided_rule(kind: str, level: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and weights of the quadrature on each of ``2^level`` parts along a side."""
    points, weights = quadrature(kind, DEGREE)
    element, parts = shape(kind), 2**level
    places = np.array(list(product(range(parts), repeat=element.dimension)), dtype=float)[:, None]
    if element.dimension > 1 and element.is_simplex:
        sums = places.sum(axis=2)[:, 0]
        made = np.concatenate((places[sums < parts] + points, places[sums < parts - 1] + 1.0 - points))
    else:
        made = places + points
    return made.reshape(-1, element.dimension) / parts, np.tile(weights, len(made)) / parts**element.dimension


def _whole(block: FacetBlock) -> list[Piece]:
    points, weights = divided_rule(block.kind, 0)
    rows = np.arange(len(block.nodes))
    return [(rows, points, weights, np.ones((len(rows), len(points))))]


def _resolved(blocks: Sequence[FacetBlock], over: PlaceField) -> list[list[Piece]]:
    """Return quadratures of a field on which division changes nothing; tell where it still does."""
    rest = [np.arange(len(block.nodes)) for block in blocks]
    before = [_shares(block, _piece(block, rows, 0, over)) for block, rows in zip(blocks, rest, strict=True)]
    whole = sum(float(np.abs(one).sum()) for one in before)
    found: list[list[Piece]] = [[] for _ in blocks]
    for level in range(1, DIVISIONS + 1):
        left = 0.0
        for number, block in enumerate(blocks):
            piece = _piece(block, rest[number], level, over)
            after = _shares(block, piece)
            changes = np.abs(after - before[number]).sum(axis=1)
            goes_on = changes > RESOLVED * whole / sum(len(one.nodes) for one in blocks)
            is_kept = ~goes_on if level < DIVISIONS else np.ones(len(changes), dtype=bool)
            rows, points, weights, w = piece
            found[number].append((rows[is_kept], points, weights, w[is_kept]))
            left += changes[goes_on].sum()
            rest[number], before[number] = rows[~is_kept], after[~is_kept]
    if left > ROUGH * whole:
        warnings.warn(
            f"{over.label} is rough within the facets of the mesh: dividing them into {2**DIVISIONS} parts a side "
            f"still changes the forces by {100.0 * left / whole:.2g} %. Remedy: a smoother field, or sides of cells "
            "where it jumps",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return found


def _piece(block: FacetBlock, rows: np.ndarray, level: int, over: PlaceField) -> Piece:
    points, weights = divided_rule(block.kind, level)
    return rows, points, weights, over.at(block.places[rows], block.nodes[rows], shape(block.kind).values(points))


def _shares(block: FacetBlock, piece: Piece) -> np.ndarray:
    """Return the shares of the points in the integral of a field, (m, n)."""
    rows, points, weights, w = piece
    values, _, _, tangents = at_points(block, points, rows)
    return np.asarray((abs(block.signs[rows, None]) * measure_of(tangents) * weights * w) @ values)


def _sums(block: FacetBlock, pieces: Sequence[Piece]) -> tuple[np.ndarray, np.ndarray, sp.csr_matrix]:
    """Return shares (m, n), forces (m, n, 3) and their change with the displacements of the points (3 m n, 3 m n)."""
    m, n = block.nodes.shape
    shares, forces, v = np.zeros((m, n)), np.zeros((m, n, 3)), np.zeros((m, n, n, 3))
    for rows, own_shares, own_forces, own_v in _of_pieces(block, pieces):
        shares[rows], forces[rows], v[rows] = own_shares, own_forces, own_v
    at = np.repeat(n * np.arange(m)[:, None] + np.arange(n), n, axis=0)
    across = sp.bsr_matrix((-skews(v).reshape(-1, 3, 3), at.ravel(), n * np.arange(m * n + 1))).tocsr()
    across.eliminate_zeros()
    return shares, forces, across


def _of_pieces(block: FacetBlock, pieces: Sequence[Piece]) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield rows, and shares, forces and their change v (m, n, n, 3) of these."""
    for piece in pieces:
        rows, points, weights, w = piece
        if not len(rows):
            continue
        values, slopes, _, tangents = at_points(block, points, rows)
        if tangents.shape[3] == 1:
            tangents = np.concatenate((tangents, np.broadcast_to(np.eye(3)[2][:, None], tangents.shape)), axis=3)
            slopes = np.concatenate((slopes, np.zeros_like(slopes)), axis=2)
        signs = block.signs[rows]
        first, second = (w[..., None] * tangents[..., a] for a in (0, 1))
        forces = np.einsum("m,mpa,pi->mia", signs, np.cross(first, tangents[..., 1]), weights[:, None] * values)
        weighted = np.einsum("p,pi,pja->apij", weights, values, slopes)
        by_slopes, by_others = (
            np.tensordot(tangent, one, axes=(1, 0)) for tangent, one in ((second, weighted[0]), (first, weighted[1]))
        )
        v = (signs[:, None, None, None] * (by_slopes - by_others)).transpose(0, 2, 3, 1)
        yield rows, _shares(block, piece), forces, v
