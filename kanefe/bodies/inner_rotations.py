"""How far the inside of a flexible body turns against its mesh frame G, and where: what linear elasticity is judged by.

Rotations are those of interfaces, of nodes that have them, and of cells elsewhere: of the rigid motion that fits the
displacements of their nodes best. A body of which only nodes are known tells displacements as shares of its length.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, TRANSLATIONS
from kanefe.frames import Matrix, Vector

MOST = 1000
"""Nodes or cells that are looked at, picked evenly: more of them change a largest value little."""

_kept: WeakKeyDictionary[FlexibleBody, InnerRotations] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class InnerRotations:
    """Rotations of places inside a body, from its free coordinates.

    Attributes
    ----------
    places : tuple of str
    motion : ndarray, shape (places, 3, k)
        Rotation in rad of each, in components of G.
    chosen : ndarray of int
        Interfaces, and the places that some coordinate turns the most.
    of_displacements : bool
        Whether they are displacements over the length of the body in their place.
    """

    places: tuple[str, ...]
    motion: np.ndarray
    chosen: np.ndarray
    of_displacements: bool

    def worst_row(self, etas: Matrix) -> int:
        """Return which of many states (T, k) turns the chosen places the most."""
        turned = etas @ self.motion[self.chosen].reshape(-1, etas.shape[1]).T
        sizes = np.square(turned).reshape(len(etas), -1, 3).sum(axis=2).max(axis=1, initial=0.0)
        return int(np.where(np.isfinite(sizes), sizes, 0.0).argmax())

    def largest(self, eta: Vector) -> tuple[str, Vector]:
        """Return the place that is turned most in a state, and its rotation vector in rad."""
        turned = self.motion @ eta
        worst = int(np.square(turned).sum(axis=1).argmax())
        return self.places[worst], turned[worst]


def inner_rotations(body: FlexibleBody) -> InnerRotations | None:
    """Return the rotations inside a body, made once of each; None: nothing of it can move."""
    if not body.free_count or not len(body.nodes):
        return None
    if body not in _kept:
        _kept[body] = _made(body)
    return _kept[body]


def _made(body: FlexibleBody) -> InnerRotations:
    k, count = body.free_count, len(body.nodes)
    frames = len(body.interfaces)
    picked = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int))
    turns = [i for i, c in enumerate(body.components) if c in ROTATIONS]
    parts = [np.array([frame.motion[3:, :k] for frame in body.interfaces]).reshape(-1, 3, k)]
    places = [f"interface {frame.name!r}" for frame in body.interfaces]
    of_displacements = False
    if turns:
        at = [COMPONENTS.index(body.components[i]) - 3 for i in turns]
        parts.append(_rows(body, picked, turns, at))
        places += [f"node {node}" for node in picked]
    elif any(block.nodes.shape[1] > 1 for block in body.cells):
        for block in body.cells:
            if block.nodes.shape[1] > 1:
                cells = np.unique(np.linspace(0, len(block.nodes) - 1, min(len(block.nodes), MOST)).round().astype(int))
                parts.append(_of_cells(body, block.nodes[cells]))
                places += [f"cell {cell} ({block.kind})" for cell in cells]
    elif not np.abs(parts[0]).any():
        length = float(np.ptp(body.nodes, axis=0).max()) or 1.0
        moves = [i for i, c in enumerate(body.components) if c in TRANSLATIONS]
        at = [COMPONENTS.index(body.components[i]) for i in moves]
        parts, places, frames = [_rows(body, picked, moves, at) / length], [f"node {node}" for node in picked], 0
        of_displacements = True
    motion = np.concatenate(parts)
    chosen = np.arange(frames)
    if not isinstance(body, UnreducedBody):
        chosen = np.union1d(chosen, np.square(motion).sum(axis=1).argmax(axis=0))
    else:
        chosen = np.arange(len(motion))
    return InnerRotations(tuple(places), motion, chosen, of_displacements)


def _rows(body: FlexibleBody, nodes: np.ndarray, columns: list[int], at: list[int]) -> np.ndarray:
    """Return the motion (n, 3, k) of some components of nodes, which are put at these of three."""
    width = len(body.components)
    found = np.zeros((len(nodes), 3, body.free_count))
    rows = body.basis[(nodes[:, None] * width + columns).ravel()][:, : body.free_count]
    dense = rows if isinstance(rows, np.ndarray) else rows.toarray()
    found[:, at] = dense.reshape(len(nodes), len(columns), -1)
    return found


def _of_cells(body: FlexibleBody, cells: np.ndarray) -> np.ndarray:
    """Return the rotations (m, 3, k) of the rigid motions nearest to those of the nodes of cells."""
    moves = [i for i, c in enumerate(body.components) if c in TRANSLATIONS]
    at = [COMPONENTS.index(body.components[i]) for i in moves]
    m, n = cells.shape
    u = _rows(body, cells.ravel(), moves, at).reshape(m, n, 3, -1)
    x = body.nodes[cells] - body.nodes[cells].mean(axis=1, keepdims=True)
    levers = np.einsum("mna,mnb->mab", x, x)
    inertia = np.trace(levers, axis1=1, axis2=2)[:, None, None] * np.eye(3) - levers
    moments = np.einsum("abc,mnb,mnck->mak", _CROSS, x, u)
    return np.asarray(np.linalg.pinv(inertia, rcond=1e-9, hermitian=True) @ moments)


_CROSS = np.zeros((3, 3, 3))
_CROSS[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
_CROSS[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0
