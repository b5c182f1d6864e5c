"""Rotations within a flexible body relative to its mesh frame G: the measure of the validity of linear elasticity.

Rotations are those of interfaces, of nodes that have them, and elsewhere of cells, by the rigid motion that fits the
displacements of their nodes best. For a body with known nodes only, displacements relative to its length are used.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, TRANSLATIONS
from kanefe.frames import Matrix, Vector
from kanefe.storage.scipy_later import sp

MOST = 1000
"""Largest number of nodes or cells that are evaluated, picked evenly: more hardly change the largest value."""

AT_ONCE = 4096
"""Number of states evaluated at once."""

_kept: WeakKeyDictionary[FlexibleBody, InnerRotations] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class InnerRotations:
    """Rotations of places inside a body, from its free coordinates.

    Attributes
    ----------
    places : tuple of str
    motion : ndarray or csr_matrix, shape (3 places, k)
        Rotation in rad of each, in components of G; sparse for unreduced bodies.
    chosen : ndarray of int
        Interfaces, and the place with the largest rotation for each coordinate.
    of_displacements : bool
        Whether these are displacements over the length of the body instead of rotations.
    """

    places: tuple[str, ...]
    motion: Matrix | sp.csr_matrix
    chosen: np.ndarray
    of_displacements: bool

    @cached_property
    def of_chosen(self) -> Matrix | sp.csr_matrix:
        """Rotations of the chosen places, (3 chosen, k)."""
        return self.motion[(3 * self.chosen[:, None] + np.arange(3)).ravel()]

    @cached_property
    def watched(self) -> tuple[Vector, Vector, Vector]:
        """Arrays for the check in compiled code, see `kanefe.kernels.evaluation.bending`.

        Workspace for coordinates with a bound of the rotations by each, workspace for components, and the motion by
        coordinate.
        """
        turns = self.of_chosen
        bounds = np.sqrt(np.square(turns).reshape(-1, 3, turns.shape[1]).sum(axis=1).max(axis=0))
        return np.append(np.zeros(len(bounds)), bounds), np.zeros(len(turns)), turns.T.ravel()

    def size(self, eta: Vector) -> float:
        """Return the largest rotation of a chosen place in a state, rad; zero if it is not finite."""
        size = float(np.square((self.of_chosen @ eta).reshape(-1, 3)).sum(axis=1).max(initial=0.0))
        return size**0.5 if np.isfinite(size) else 0.0

    def worst_row(self, etas: Matrix) -> int:
        """Return the number of the state, among many (T, k), with the largest rotation of the chosen places."""
        parts = np.split(etas.T, range(AT_ONCE, len(etas), AT_ONCE), axis=1)  # limits the memory
        squares = (np.square(self.of_chosen @ part).reshape(-1, 3, part.shape[1]) for part in parts)
        largest = np.concatenate([part.sum(axis=1).max(axis=0, initial=0.0) for part in squares])
        return int(np.where(np.isfinite(largest), largest, 0.0).argmax())

    def largest(self, eta: Vector) -> tuple[str, Vector]:
        """Return the place with the largest rotation in a state, and its rotation vector in rad."""
        turned = (self.motion @ eta).reshape(-1, 3)
        worst = int(np.square(turned).sum(axis=1).argmax())
        return self.places[worst], turned[worst]


def inner_rotations(body: FlexibleBody) -> InnerRotations | None:
    """Return the rotations within a body, computed once for each; None if it cannot deform, or may bend far."""
    if body.bends_far or not body.free_count or not len(body.nodes):
        return None
    if body not in _kept:
        _kept[body] = _made(body)
    return _kept[body]


def _made(body: FlexibleBody) -> InnerRotations:
    k, count, frames = body.free_count, len(body.nodes), len(body.interfaces)
    picked = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int))
    turns = [i for i, c in enumerate(body.components) if c in ROTATIONS]
    parts = [np.array([frame.motion[3:, :k] for frame in body.interfaces]).reshape(-1, k)]
    places = [f"interface {frame.name!r}" for frame in body.interfaces]
    of_displacements = False
    if turns:
        parts.append(_of_nodes(body, picked, turns))
        places += [f"node {node}" for node in picked]
    elif any(block.nodes.shape[1] > 1 for block in body.cells):
        for block in body.cells:
            if block.nodes.shape[1] > 1:
                cells = np.unique(np.linspace(0, len(block.nodes) - 1, min(len(block.nodes), MOST)).round().astype(int))
                parts.append(_of_cells(body, block.nodes[cells]))
                places += [f"cell {cell} ({block.kind})" for cell in cells]
    elif not np.abs(parts[0]).any():
        length = float(np.ptp(body.nodes, axis=0).max()) or 1.0
        parts, places, frames = [_of_nodes(body, picked, _moves(body)) / length], [f"node {node}" for node in picked], 0
        of_displacements = True
    if isinstance(body, UnreducedBody):
        motion: Matrix | sp.csr_matrix = sp.vstack([sp.csr_matrix(part) for part in parts], format="csr")
        return InnerRotations(tuple(places), motion, np.arange(len(places)), of_displacements)
    motion = np.concatenate(parts)
    of_modes = np.square(motion).reshape(-1, 3, k).sum(axis=1).argmax(axis=0)
    return InnerRotations(tuple(places), motion, np.union1d(np.arange(frames), of_modes), of_displacements)


def _moves(body: FlexibleBody) -> list[int]:
    return [i for i, c in enumerate(body.components) if c in TRANSLATIONS]


def _of_nodes(body: FlexibleBody, nodes: np.ndarray, columns: list[int]) -> Matrix | sp.csr_matrix:
    """Return the motion (3 nodes, k) of some components of nodes, in the direction or about the axis of each."""
    weights = np.zeros((3, len(columns)))
    weights[[COMPONENTS.index(body.components[i]) % 3 for i in columns], range(len(columns))] = 1.0
    rows = nodes[:, None] * len(body.components) + columns
    return _combined(body, rows, np.broadcast_to(weights, (len(nodes), *weights.shape)))


def _of_cells(body: FlexibleBody, cells: np.ndarray) -> Matrix | sp.csr_matrix:
    """Return the rotations (3 cells, k) of the rigid motions nearest to those of the nodes of cells."""
    moves = _moves(body)
    at = [COMPONENTS.index(body.components[i]) for i in moves]
    x = body.nodes[cells] - body.nodes[cells].mean(axis=1, keepdims=True)
    levers = np.einsum("mna,mnb->mab", x, x)
    inertia = np.trace(levers, axis1=1, axis2=2)[:, None, None] * np.eye(3) - levers
    moments = np.einsum("abc,mnb->manc", _CROSS[:, :, at], x)
    weights = np.linalg.pinv(inertia, rcond=1e-9, hermitian=True) @ moments.reshape(len(cells), 3, -1)
    rows = cells[:, :, None] * len(body.components) + moves
    return _combined(body, rows.reshape(len(cells), -1), weights)


def _combined(body: FlexibleBody, rows: np.ndarray, weights: np.ndarray) -> Matrix | sp.csr_matrix:
    """Return sums of rows (n, r) of the basis with three sets of weights (n, 3, r): a matrix (3 n, k)."""
    k, (n, r) = body.free_count, rows.shape
    if not isinstance(body, UnreducedBody):
        return np.asarray(weights @ body.basis[rows.ravel(), :k].reshape(n, r, k)).reshape(-1, k)
    places = np.repeat(rows, 3, axis=0).ravel()
    combining = sp.csr_matrix((weights.ravel(), places, np.arange(0, 3 * n * r + 1, r)), (3 * n, body.basis.shape[0]))
    return combining @ body.basis[:, :k]


_CROSS = np.zeros((3, 3, 3))
_CROSS[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
_CROSS[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0
