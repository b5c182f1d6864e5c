"""Weighted moments of a patch: what an average over its nodes keeps equal to the frame's motion."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.finite_element_model import TRANSLATIONS, FiniteElementModel
from kanefe.patches import Patch


def patch_moments(model: FiniteElementModel, patch: Patch) -> np.ndarray:
    """Return P = R^T W of what follows the frame, along the axes of the interface, shape (components, following).

    W is the L2 product over the facets (``weights="area"``), the rows and columns of the mass matrix, or one number for
    each node. Rotations of the nodes count only by mass, or where the translations leave the frame undetermined.

    Raises
    ------
    ModelError
        If there is no area, the numbers do not fit the nodes, or the weights leave a component undetermined.
    """
    follows = np.tile(patch.follows, len(patch.nodes))
    motion = patch.motion[follows]
    moments = np.asarray((_weights(model, patch)[follows][:, follows] @ motion).T)
    if not _determines(moments @ motion, motion):
        raise ModelError(
            f"the weights of interface {patch.name!r} leave a component of its frame undetermined. Remedy: weights "
            "above zero on at least three nodes that are not in line, or weights='uniform'"
        )
    return moments


def _determines(gram: np.ndarray, motion: np.ndarray) -> bool:
    """Tell whether R^T W R is far from singular, however its components are scaled."""
    size = np.linalg.norm(motion, axis=0)
    scaled = gram / np.outer(size, size)
    squares = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return bool(squares[0] > 1e-12 * squares[-1])


def _weights(model: FiniteElementModel, patch: Patch) -> sp.csr_matrix:
    """Return W over all components of the nodes of a patch, along its axes."""
    rule, count, width = patch.spec.weights, len(patch.nodes), len(model.components)
    if rule == "mass":
        dofs = (patch.nodes[:, None] * width + np.arange(width)).ravel()
        turn = sp.kron(sp.identity(count), patch.turn, format="csr")
        return (turn.T @ model.mass[dofs][:, dofs] @ turn).tocsr()
    if rule == "area" and patch.measure is None:
        raise ModelError(
            f"interface {patch.name!r} has no facets or lines to be weighted by area. Remedy: weights='uniform', "
            "'mass', or one number for each node"
        )
    if isinstance(rule, tuple):
        if len(rule) != count:
            raise ModelError(
                f"interface {patch.name!r} has {count} nodes and {len(rule)} weights. Remedy: one for each node, in "
                "the order of their numbers"
            )
        scalar = sp.diags(np.array(rule), format="csr")
    else:
        scalar = sp.identity(count, format="csr") if rule == "uniform" or patch.measure is None else patch.measure
    moved = np.array([c in TRANSLATIONS for c in model.components])
    weights = sp.kron(scalar, np.diag(moved.astype(float)), format="csr")
    if moved.all() or _determines(patch.motion.T @ (weights @ patch.motion), patch.motion):
        return weights
    # squares of slopes need a length to stand beside squares of displacements
    points = model.nodes[patch.nodes]
    length = np.linalg.norm(points - points.mean(axis=0), axis=1).max() or 1.0
    return weights + sp.kron(scalar, np.diag(length**2 * ~moved), format="csr")
