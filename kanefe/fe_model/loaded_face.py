"""Faces of a body that carry distributed loads: sums of a field over their facets.

A load on a face may vary by place, ``p(X) = p w(X)`` with a shape w of the undeformed places. Its forces on the points
of a facet are integrals with w in them,

    int w N_i dA,    s int w N_i x_xi x x_eta dxi deta    (sign s, positions x = sum N_i x_i)

and so are their changes as the points move (`kanefe.fe_model.pressure_change`), since w stays with the material.
Facets on which a quadrature and one on their quarters disagree are divided on, so that patches and jumps are resolved.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
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

DIVISIONS = 10
"""Largest number of divisions in four: 1024 parts along a side of a facet."""

COARSE, ROUGHLY = 2, 3
"""Divisions up to which parts have the full degree, and the degree on smaller parts: only jumps are divided on."""

STEEP = 0.8
"""Spread of a field in a part, relative to that in four of them, above which it jumps: 0.5 if it is linear, 0.75 of a
parabola."""

MOST_PARTS = 2**18
"""Largest number of parts of all facets into which they are divided at once: a gigabyte with their shape functions."""

AT_ONCE = 4096
"""Number of parts of facets that are integrated at once."""

ROUGH = 1e-2
"""Jumps that are left, relative to all forces, from which it is told; the error is less than a tenth of them."""


class Parts(NamedTuple):
    """Parts of facets: their facets (s,), corners (s, d) and size on the reference cell, and whether they are turned.

    A part of a square or line has the points ``corner + size * p``, one of a triangle too, or ``corner + size * (1 -
    p)`` if it is turned.
    """

    facets: np.ndarray
    corners: np.ndarray
    size: float
    is_turned: np.ndarray

    def chosen(self, which: np.ndarray) -> Parts:
        """Return some of them."""
        return Parts(self.facets[which], self.corners[which], self.size, self.is_turned[which])


class Piece(NamedTuple):
    """Parts of facets with a quadrature: points (s, p, d), weights (p,) and values of a field (s, p)."""

    parts: Parts
    points: np.ndarray
    weights: np.ndarray
    values: np.ndarray


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


def at_points(
    block: FacetBlock, points: np.ndarray, facets: np.ndarray | slice = slice(None)
) -> tuple[np.ndarray, ...]:
    """Return shape functions (s, p, n), slopes (s, p, n, d), places (s, p, 3) and tangents (s, p, 3, d) of facets.

    At points (s, p, d), or (p, d) of all of them.
    """
    element, x, flat = shape(block.kind), block.places[facets], points.reshape(-1, points.shape[-1])
    values = element.values(flat).reshape(*points.shape[:-1], x.shape[1])
    slopes = element.gradients(flat).reshape(*values.shape, element.dimension)
    tangents = np.stack([slopes[..., a] @ x for a in range(slopes.shape[-1])], axis=-1)
    return values, slopes, values @ x, tangents


def measure_of(tangents: np.ndarray) -> np.ndarray:
    """Return length or area of unit reference cells, from tangents (..., 3, d)."""
    along = tangents[..., 0] if tangents.shape[-1] == 1 else normals(tangents)
    return np.asarray(np.linalg.norm(along, axis=-1))


def _whole(block: FacetBlock) -> list[Piece]:
    points, weights = quadrature(block.kind, DEGREE)
    parts = _first(block)
    return [Piece(parts, points, weights, np.ones((len(parts.facets), len(points))))]


def _first(block: FacetBlock) -> Parts:
    """Return the facets themselves as parts."""
    count = len(block.nodes)
    return Parts(np.arange(count), np.zeros((count, shape(block.kind).dimension)), 1.0, np.zeros(count, dtype=bool))


def _divided(kind: str, parts: Parts) -> Parts:
    """Return the quarters of parts (halves of lines), those of the first part first."""
    element, size = shape(kind), 0.5 * parts.size
    offsets = np.array(list(product((0.0, 1.0), repeat=element.dimension)))
    count = len(offsets)
    corners = parts.corners[:, None] + size * offsets
    is_turned = np.repeat(parts.is_turned[:, None], count, axis=1)
    if element.dimension > 1 and element.is_simplex:  # the last quarter, in the middle, is turned
        at = np.where(parts.is_turned[:, None, None], offsets[[3, 1, 2, 3]], offsets[[0, 1, 2, 0]])
        corners = parts.corners[:, None] + size * at
        is_turned[:, 3] = ~is_turned[:, 3]
    return Parts(np.repeat(parts.facets, count), corners.reshape(-1, element.dimension), size, is_turned.ravel())


class _Looked(NamedTuple):
    """Parts with their quadrature, the shares of the points in the integral (s, n), measures and spreads (s,)."""

    piece: Piece
    shares: np.ndarray
    measure: np.ndarray
    spread: np.ndarray

    def chosen(self, which: np.ndarray) -> _Looked:
        return _Looked(_some(self.piece, which), self.shares[which], self.measure[which], self.spread[which])


def _looked(block: FacetBlock, parts: Parts, degree: int, over: PlaceField) -> _Looked:
    """Return parts with a quadrature; the spread is that of the field between its points and the corners."""
    points, weights = quadrature(block.kind, degree)
    element = shape(block.kind)
    ends = np.array(list(product((0.0, 1.0), repeat=element.dimension)))
    own = np.concatenate((points, ends[:3] if element.dimension > 1 and element.is_simplex else ends))
    at = parts.corners[:, None] + parts.size * np.where(parts.is_turned[:, None, None], 1.0 - own, own)
    values, _, places, _ = at_points(block, at, parts.facets)
    found, count = over.at(places, block.nodes[parts.facets], values), len(points)
    piece = Piece(parts, at[:, :count], weights * parts.size**element.dimension, found[:, :count])
    values, measures = _measures(block, piece)
    shares = (measures * piece.values)[:, None] @ values
    return _Looked(piece, shares[:, 0], measures.sum(axis=1), np.ptp(found, axis=1))


def _resolved(blocks: Sequence[FacetBlock], over: PlaceField) -> list[list[Piece]]:
    """Return quadratures of a field on which division changes nothing; tell where it still does.

    Of a smooth field parts vary by half as much as the whole; where a field jumps, they vary as much.
    """
    looked = [_looked(block, _first(block), DEGREE, over) for block in blocks]
    whole = sum(float(np.abs(one.shares).sum()) for one in looked)
    limit = RESOLVED * whole / sum(len(block.nodes) for block in blocks)
    found: list[list[Piece]] = [[] for _ in blocks]
    for level in range(1, DIVISIONS + 1):
        count = sum(len(one.spread) for one in looked)
        if not count:
            break
        is_last = level == DIVISIONS or 16 * count > MOST_PARTS
        left = 0.0
        for number, (block, last) in enumerate(zip(blocks, looked, strict=True)):
            if not len(last.spread):
                continue
            parts = _divided(block.kind, last.piece.parts)
            one = _looked(block, parts, DEGREE if level <= COARSE else ROUGHLY, over)
            quarters = len(parts.facets) // len(last.spread)
            changes = np.abs(one.shares.reshape(len(last.spread), quarters, -1).sum(axis=1) - last.shares).sum(axis=1)
            jumps = (one.spread > STEEP * np.repeat(last.spread, quarters)) & (one.spread * one.measure > limit)
            goes_on = (np.repeat(changes > limit, quarters) | jumps) & (not is_last)
            left += float((one.spread * one.measure)[jumps].sum()) if is_last else 0.0
            found[number].append(_some(one.piece, ~goes_on))
            looked[number] = one.chosen(goes_on)
        if is_last:
            break
    _tell_of_rough(over, left, any(piece.values.any() for own in found for piece in own), whole)
    return found


def _tell_of_rough(over: PlaceField, left: float, is_there: bool, whole: float) -> None:
    """Refuse a field that is nowhere on the face, and tell of one that division has not resolved."""
    if not is_there and over.component is None:
        raise ModelError(
            f"{over.label}: over= is zero at all places of the facets that are looked at, a tenth of a cell apart. "
            "Remedy: places in m in the frame of the mesh; smaller cells for a patch that is smaller than that"
        )
    if left > ROUGH * whole:
        warnings.warn(
            f"{over.label} is rough within the facets of the mesh: in the smallest parts of them it still jumps by "
            f"{100.0 * left / whole:.2g} % of the forces. Remedy: a smoother field, or sides of cells at its jumps",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _some(piece: Piece, which: np.ndarray) -> Piece:
    return Piece(piece.parts.chosen(which), piece.points[which], piece.weights, piece.values[which])


def _measures(block: FacetBlock, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    """Return shape functions (s, p, n), and the area or length of each point (s, p)."""
    values, _, _, tangents = at_points(block, piece.points, piece.parts.facets)
    return values, abs(block.signs[piece.parts.facets, None]) * measure_of(tangents) * piece.weights


def _sums(block: FacetBlock, pieces: Sequence[Piece]) -> tuple[np.ndarray, np.ndarray, sp.csr_matrix]:
    """Return shares (m, n), forces (m, n, 3) and their change with the displacements of the points (3 m n, 3 m n)."""
    m, n = block.nodes.shape
    shares, forces, v = np.zeros((m, n)), np.zeros((m, n, 3)), np.zeros((m, n, n, 3))
    for piece in pieces:
        for part in np.array_split(np.arange(len(piece.values)), len(piece.values) // AT_ONCE + 1):
            own = _some(piece, part) if piece.points.ndim == 3 else piece
            facets = own.parts.facets
            values, measures = _measures(block, own)
            np.add.at(shares, facets, ((measures * own.values)[:, None] @ values)[:, 0])
            own_forces, own_v = _forces(block, own)
            np.add.at(forces, facets, own_forces)
            np.add.at(v, facets, own_v)
    at = np.repeat(n * np.arange(m)[:, None] + np.arange(n), n, axis=0)
    across = sp.bsr_matrix((-skews(v).reshape(-1, 3, 3), at.ravel(), n * np.arange(m * n + 1))).tocsr()
    across.eliminate_zeros()
    return shares, forces, across


def _forces(block: FacetBlock, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces (s, n, 3) of a unit pressure on parts, and what they change by, v (s, n, n, 3)."""
    values, slopes, _, tangents = at_points(block, piece.points, piece.parts.facets)
    if tangents.shape[3] == 1:
        tangents = np.concatenate((tangents, np.broadcast_to(np.eye(3)[2][:, None], tangents.shape)), axis=3)
        slopes = np.concatenate((slopes, np.zeros_like(slopes)), axis=-1)
    weight = block.signs[piece.parts.facets, None] * piece.weights * piece.values
    weighted = np.swapaxes(weight[..., None] * values, 1, 2)
    first, second = tangents[..., 0], tangents[..., 1]
    v = [weighted @ (slopes[..., 0] * second[..., [c]] - slopes[..., 1] * first[..., [c]]) for c in range(3)]
    return weighted @ np.cross(first, second), np.stack(v, axis=-1)
