"""The mean motion of a node or a group of nodes as a frame, on which lumped parts and preloads act."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, rigid_motion

Target: TypeAlias = str | int
"""Name of a group, or number of a node."""

LARGEST_PATCH = 300
"""Number of nodes that represent a larger group, weighted by the number of nodes near each: M and K stay sparse."""


def mean_motion(model: FiniteElementModel, at: Target, position: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the mean motion of a node or a group as the motion of a frame.

    Parameters
    ----------
    model : FiniteElementModel
    at : str or int
    position : ndarray, shape (3,)
        Position of the frame in m.

    Returns
    -------
    T : csr_matrix, shape (6, N)
        Translation and rotation of the frame from the degrees of freedom.
    blind : ndarray, shape (6, b)
        Motions of the frame that the body can make but that do not move the nodes.
    """
    nodes, weights = patch(model, at)
    width = len(model.components)
    R = rigid_motion(model.nodes[nodes], position, model.components)
    spread = np.sqrt(np.mean(np.sum((model.nodes[nodes] - model.nodes[nodes].mean(axis=0)) ** 2, axis=1))) or 1.0
    # rotations of nodes are weighted like translations at the mean distance from the middle
    of_component = np.array([1.0 if c in ("x", "y", "z") else spread**2 for c in model.components])
    W = (weights[:, None] * of_component).ravel()
    scale = np.array([1.0, 1.0, 1.0, spread, spread, spread])
    values, vectors = np.linalg.eigh((R.T * W) @ R / np.outer(scale, scale))
    seen = values > 1e-10 * values[-1]
    scaled = vectors[:, seen] / scale[:, None]
    T = (scaled / values[seen]) @ (scaled.T @ (R.T * W))
    dofs = (nodes[:, None] * width + np.arange(width)).ravel()
    rows = np.repeat(np.arange(6), len(dofs))
    matrix = sp.csr_matrix((T.ravel(), (rows, np.tile(dofs, 6))), shape=(6, model.size))
    impossible = np.linalg.norm(model.rigid_modes(model.nodes.mean(axis=0)), axis=0) == 0.0
    blind = vectors[:, ~seen] / scale[:, None]
    blind[impossible] = 0.0
    return matrix, blind


def patch(model: FiniteElementModel, at: Target) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes that define the motion of a node or a group, and their weights."""
    if isinstance(at, str):
        nodes = np.asarray(model.group(at).nodes)
    elif isinstance(at, (int, np.integer)) and not isinstance(at, bool) and 0 <= at < len(model.nodes):
        nodes = np.array([at])
    else:
        raise ModelError(
            f"{at!r} is not a place of this model. Remedy: the name of a group, or a node from 0 to "
            f"{len(model.nodes) - 1}"
        )
    if not len(nodes):
        raise ModelError(f"the group {at!r} has no nodes. Remedy: give its physical group some facets")
    if len(nodes) <= LARGEST_PATCH:
        return nodes, np.ones(len(nodes))
    points = model.nodes[nodes]
    kept, distance = [0], np.linalg.norm(points - points[0], axis=1)
    while len(kept) < LARGEST_PATCH:
        kept.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[kept[-1]], axis=1))
    _, owner = cKDTree(points[kept]).query(points)
    return nodes[kept], np.bincount(owner, minlength=len(kept)).astype(float)


def place(model: FiniteElementModel, at: Target) -> np.ndarray:
    """Return the position of a node or a group, (3,) in m."""
    if isinstance(at, str):
        return np.asarray(model.group(at).position, dtype=float)
    return model.nodes[patch(model, at)[0][0]]
