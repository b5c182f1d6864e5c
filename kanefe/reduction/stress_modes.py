"""Stresses of elements of the user: those of unit coordinates, by a function of the displacements."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, Stresses

ROUND_OFF = 1e-9
"""Deviation from a linear function, relative to its values, that counts as round-off."""


def stress_modes(model: FiniteElementModel, basis: np.ndarray) -> np.ndarray | None:
    """Return the stress at the nodes of unit coordinates, shape (n, 6, K) in Pa, from a basis (N, K).

    None if the model has no function of its stresses.

    Raises
    ------
    ModelError
        If the function returns another shape, numbers that are not finite, is not linear, or gives stress to a rigid
        motion.
    """
    if model.stresses is None:
        return None
    found = _evaluated(model, model.stresses, basis)
    sums = np.cos(np.arange(basis.shape[1]))
    # rigid motions as large as the deformation with whose stress theirs is compared
    rigid = model.rigid_modes(about=model.nodes.mean(axis=0))
    size = float(np.ptp(model.nodes, axis=0).max()) or 1.0
    rigid[:, 3:] /= size
    whole = _evaluated(
        model, model.stresses, np.column_stack((basis @ sums, 2.0 * rigid * abs(basis @ sums).max(initial=0.0)))
    )
    largest = np.abs(found @ sums).max(initial=0.0)
    if np.abs(found @ sums - whole[:, :, 0]).max(initial=0.0) > ROUND_OFF * np.abs(found).max(initial=0.0):
        raise ModelError(
            "the stresses of the elements are not linear in the displacements. Remedy: return C : e of the small "
            "strain, without constant terms"
        )
    resisted = np.abs(whole[:, :, 1:]).max(initial=0.0)
    if resisted > 1e-6 * largest:
        raise ModelError(
            f"the stresses of the elements are not zero in a rigid motion: {resisted:.3g} Pa beside {largest:.3g} Pa "
            "of a deformation of this size. Remedy: check the order of nodes and components"
        )
    return found


def _evaluated(model: FiniteElementModel, stresses: Stresses, columns: np.ndarray) -> np.ndarray:
    found = np.asarray(stresses(columns), dtype=float)
    expected = (len(model.nodes), 6, columns.shape[1])
    if found.shape != expected or not np.all(np.isfinite(found)):
        raise ModelError(
            f"the stresses of the elements have shape {found.shape} for {columns.shape[1]} displacements, or are not "
            f"finite. Remedy: shape {expected}, six components of each node by displacement, in Pa"
        )
    return found
