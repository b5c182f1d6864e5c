"""Beam elements that K and M show, whose shape functions are those of the static beam.

Between two nodes that one element joins, K has ``12 E I / l^3 (1 + Phi)`` across and ``(2 - Phi) E I / l (1 + Phi)`` in
rotation, so that their ratio tells the shear parameter Phi of each plane (Przemieniecki, Theory of Matrix Structural
Analysis, sec. 5.6), 0 for Bernoulli's beam. With the shape functions the block of M between the nodes is linear in mass
and rotary inertia of the section, which follow by least squares. An element is taken if it has that block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import COMPONENTS
from kanefe.imports.rigid_parts import WIDTH, RigidParts, rigid_parts

STATIONS = 4
"""Gauss points along an element, exact to degree 7: the integrands have degree 6."""


class Pairs(NamedTuple):
    """Pairs of nodes, with the element that may join them.

    Attributes
    ----------
    nodes : ndarray of int, shape (m, 2)
    length : ndarray, shape (m,)
        m.
    axes : ndarray, shape (m, 3, 3)
        x along, y and z the principal directions of bending, as columns.
    shear : ndarray, shape (m, 2)
        Phi of bending along y and along z.
    """

    nodes: np.ndarray
    length: np.ndarray
    axes: np.ndarray
    shear: np.ndarray


def slender_elements(
    K: sp.csr_matrix, M: sp.csr_matrix, points: np.ndarray, motions: sp.spmatrix, components: tuple[str, ...]
) -> RigidParts | None:
    """Return the points of the beam elements that matrices of six components (6 n, 6 n) show; None if there are none.

    Arguments as of `kanefe.imports.rigid_parts.rigid_parts`.
    """
    coupled = sp.csr_matrix(M).tobsr(blocksize=(WIDTH, WIDTH))
    rows = np.repeat(np.arange(len(points)), np.diff(coupled.indptr))
    nodes = np.column_stack((rows, coupled.indices))
    pairs = _pairs(nodes[nodes[:, 0] < nodes[:, 1]], points, K)
    if not len(pairs.nodes):
        return None
    at_stations, weights = _stations(pairs)
    has = np.array([name in components for name in COMPONENTS])
    sections, fits = _sections(pairs, at_stations, weights, _blocks_of(M, pairs.nodes), np.outer(has, has))
    if not fits.any():
        return None
    taken = Pairs(*(part[fits] for part in pairs))
    return _parts(taken, at_stations[fits], weights, sections[fits], points, motions, has)


def _blocks_of(A: sp.csr_matrix, nodes: np.ndarray) -> np.ndarray:
    """Return the blocks (m, 6, 6) of a matrix between pairs of nodes."""
    rows = WIDTH * nodes[:, 0, None] + np.arange(WIDTH)
    columns = WIDTH * nodes[:, 1, None] + np.arange(WIDTH)
    rows, columns = (np.broadcast_to(x, (len(nodes), WIDTH, WIDTH)) for x in (rows[:, :, None], columns[:, None]))
    return np.asarray(sp.csr_matrix(A)[rows.ravel(), columns.ravel()]).reshape(-1, WIDTH, WIDTH)


def _pairs(nodes: np.ndarray, points: np.ndarray, K: sp.csr_matrix) -> Pairs:
    """Return the pairs that K joins, with axes and shear."""
    apart = points[nodes[:, 1]] - points[nodes[:, 0]]
    length = np.linalg.norm(apart, axis=1)
    blocks = _blocks_of(K, nodes)
    joined = (length > 0.0) & (np.abs(blocks[:, :3, :3]).max(axis=(1, 2)) > 0.0)
    nodes, length, blocks = nodes[joined], length[joined], blocks[joined]
    along = apart[joined] / length[:, None]
    beside = np.eye(3)[np.abs(along).argmin(axis=1)]
    beside -= np.einsum("ma,ma->m", beside, along)[:, None] * along
    beside /= np.linalg.norm(beside, axis=1)[:, None]
    across = np.stack((beside, np.cross(along, beside)), axis=2)
    stiff = -np.einsum("mai,mab,mbj->mij", across, blocks[:, :3, :3], across)
    across = across @ np.linalg.eigh(0.5 * (stiff + np.swapaxes(stiff, 1, 2)))[1]
    axes = np.stack((along, across[..., 0], np.cross(along, across[..., 0])), axis=2)
    local = [np.einsum("mai,mab,mbi->mi", axes, part, axes)[:, 1:] for part in (blocks[:, :3, :3], blocks[:, 3:, 3:])]
    force, turn = -local[0], local[1][:, ::-1]  # bending along y turns about z
    known = force > 1e-12 * np.abs(blocks[:, :3, :3]).max(axis=(1, 2))[:, None]
    shear = 2.0 - 12.0 * np.where(known, turn, 0.0) / (np.where(known, force, 1.0) * length[:, None] ** 2)
    return Pairs(nodes, length, axes, np.where(known, np.maximum(shear, 0.0), 0.0))


def _stations(pairs: Pairs) -> tuple[np.ndarray, np.ndarray]:
    """Return the motion of sections at Gauss points, shape (m, stations, 6, 12), all in G, and weights of sum 1."""
    x, w = np.polynomial.legendre.leggauss(STATIONS)
    s = 0.5 * (1.0 + x)
    T = np.zeros((len(pairs.nodes), STATIONS, WIDTH, 2 * WIDTH))
    for component in (0, 3):
        T[:, :, component, component], T[:, :, component, WIDTH + component] = 1.0 - s, s
    length = pairs.length[:, None]
    for move, turn, sign in ((1, 5, 1.0), (2, 4, -1.0)):  # a slope along z turns about -y
        phi = pairs.shear[:, move - 1, None]
        whole = 1.0 + phi
        T[:, :, move, move] = (1 - 3 * s**2 + 2 * s**3 + phi * (1 - s)) / whole
        T[:, :, move, turn] = sign * length * (s - 2 * s**2 + s**3 + phi * (s - s**2) / 2) / whole
        T[:, :, move, WIDTH + move] = (3 * s**2 - 2 * s**3 + phi * s) / whole
        T[:, :, move, WIDTH + turn] = sign * length * (s**3 - s**2 - phi * (s - s**2) / 2) / whole
        slope = 6 * (s - s**2) / (length * whole)
        T[:, :, turn, move], T[:, :, turn, WIDTH + move] = -sign * slope, sign * slope
        T[:, :, turn, turn] = (1 - 4 * s + 3 * s**2 + phi * (1 - s)) / whole
        T[:, :, turn, WIDTH + turn] = (3 * s**2 - 2 * s + phi * s) / whole
    turned = np.zeros((len(T), 2 * WIDTH, 2 * WIDTH))
    for start in range(0, 2 * WIDTH, 3):
        turned[:, start : start + 3, start : start + 3] = pairs.axes
    six = turned[:, :WIDTH, :WIDTH]
    return six[:, None] @ T @ np.swapaxes(turned, 1, 2)[:, None], 0.5 * w


def _sections(
    pairs: Pairs, T: np.ndarray, weights: np.ndarray, blocks: np.ndarray, present: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mass and inertia of the sections (m, 6, 6) of whole elements, and which have the blocks (m, 6, 6) of M."""
    parts = np.zeros((len(T), 4, WIDTH, WIDTH))
    parts[:, 0, :3, :3] = np.eye(3)
    for a in range(3):
        parts[:, 1 + a, 3:, 3:] = pairs.axes[:, :, a, None] * pairs.axes[:, None, :, a]
    ends = T[..., :WIDTH], T[..., WIDTH:]
    shares = np.einsum("s,msai,mpab,msbj->mpij", weights, ends[0], parts, ends[1], optimize=True) * present
    length = pairs.length[:, None]
    scale = np.concatenate((np.ones_like(length).repeat(3, 1), 1.0 / length.repeat(3, 1)), axis=1)
    scale = scale[:, :, None] * scale[:, None]
    # inertia of a section relative to mass times length squared, so that all unknowns are alike
    shares[:, 1:] *= length[:, :, None, None] ** 2
    A = np.swapaxes((shares * scale[:, None]).reshape(len(T), 4, -1), 1, 2)
    b = (blocks * scale).reshape(len(T), -1)
    found = np.einsum("mpk,mk->mp", np.linalg.pinv(A, rcond=1e-10), b)
    error = np.abs(np.einsum("mkp,mp->mk", A, found) - b).max(axis=1)
    fits = (error <= ROUND_OFF * np.abs(b).max(axis=1)) & (found[:, 0] > 0.0)
    fits &= (found[:, 1:] >= -ROUND_OFF * found[:, :1]).all(axis=1)  # per length squared
    found[:, 1:] *= length**2
    if not present[3, 3]:  # a plane model: its sections are flat
        found[:, 1] = found[:, 2] + found[:, 3]
    return np.einsum("mp,mpab->mab", found, parts), fits


def _parts(
    pairs: Pairs,
    T: np.ndarray,
    weights: np.ndarray,
    sections: np.ndarray,
    points: np.ndarray,
    motions: sp.spmatrix,
    has: np.ndarray,
) -> RigidParts:
    """Return the points of elements, and the mass matrix that they explain."""
    count, stations = len(pairs.nodes), T.shape[1]
    columns = (WIDTH * pairs.nodes[:, :, None] + np.arange(WIDTH)).reshape(count, -1)
    shape = (WIDTH * stations * count, WIDTH * len(points))
    spread = np.broadcast_to(columns[:, None, None], T.shape).ravel()
    of_stations = sp.csr_matrix((T.ravel(), spread, np.arange(0, T.size + 1, T.shape[3])), shape=shape)
    blocks = (weights[:, None, None] * sections[:, None]).reshape(-1, WIDTH, WIDTH)
    starts = np.arange(len(blocks) + 1)
    mass = sp.bsr_matrix((blocks, starts[:-1], starts))
    present = sp.diags(np.tile(has.astype(float), len(points)))
    s = 0.5 * (1.0 + np.polynomial.legendre.leggauss(stations)[0])
    start, end = points[pairs.nodes[:, 0]], points[pairs.nodes[:, 1]]
    places = start[:, None] + s[:, None] * (end - start)[:, None]
    field = rigid_parts(mass, places.reshape(-1, 3), of_stations @ motions).field
    return RigidParts(field, (present @ of_stations.T @ mass @ of_stations @ present).tobsr(blocksize=(WIDTH, WIDTH)))
