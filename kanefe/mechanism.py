"""What moves in a body whose stiffness is singular: the nodes of a mechanism or of a loose part, for a message."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.factorise import Factorise
from kanefe.finite_element_model import FiniteElementModel

SHIFT = 1e-9
"""Share of its diagonal that is added to a singular K, so that it can be factored."""

SOFT = 1e-7
"""Stiffness along a motion, relative to the diagonal of K, below which it counts as none."""

NAMED = 4
"""How many nodes a message names."""


def moving_nodes(model: FiniteElementModel, motion: sp.csr_matrix, K: sp.csc_matrix, factorise: Factorise) -> str:
    """Return a sentence on the nodes that move without force, or nothing if none is found.

    Parameters
    ----------
    model : FiniteElementModel
    motion : csr_matrix, shape (N, n)
        Motion of the model's degrees of freedom from the coordinates of K.
    K : csc_matrix, shape (n, n)
        Singular stiffness.
    factorise : Factorise
    """
    weights = np.abs(K.diagonal())
    weights[weights <= SHIFT * weights.max(initial=0.0)] = weights.mean() or 1.0
    try:
        factors = factorise((K + sp.diags(SHIFT * weights)).tocsc())
    except (ModelError, RuntimeError):
        return ""
    x = np.random.default_rng(0).standard_normal(K.shape[0])
    for _ in range(5):  # of inverse iteration: what resists grows by 1/SHIFT less in each
        x = factors.solve(weights * x)
        x /= np.sqrt(x @ (weights * x))
    if not x @ (K @ x) < SOFT:
        return ""
    moved = np.linalg.norm((motion @ x).reshape(len(model.nodes), -1), axis=1)
    order = np.argsort(-moved, kind="stable")
    count = int(np.count_nonzero(moved > 0.5 * moved.max()))
    places = (
        f"{node} at ({', '.join(f'{c:.4g}' for c in model.nodes[node])}) m" for node in order[: min(count, NAMED)]
    )
    which = "it is" if count == 1 else f"{count} nodes, among them" if count > NAMED else "they are"
    return f". What moves without force: {which} node {', node '.join(places)}"
