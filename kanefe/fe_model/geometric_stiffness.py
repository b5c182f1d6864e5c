"""Check of a geometric stiffness that a user gives, as a function of a static displacement."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.damping import real_matrix
from kanefe.fe_model.model import FiniteElementModel

ROUND_OFF = 1e-6
"""Asymmetry, or departure from a linear function, relative to the largest entry, of a matrix in printed digits."""


def check_geometric_stiffness(model: FiniteElementModel) -> None:
    """Raise a ModelError if the geometric stiffness of a model is not symmetric, or not linear in the displacement.

    A model without one passes.
    """
    if model.stress_stiffness is None:
        return
    w = 1e-3 * np.cos(np.arange(model.size)) * np.ptp(model.nodes, axis=0).max()
    once, twice = (real_matrix(model.stress_stiffness(factor * w, None)) for factor in (1.0, 2.0))
    if once.shape != (model.size, model.size) or not np.all(np.isfinite(once.data)):
        raise ModelError(
            f"the geometric stiffness has shape {once.shape}, or is not finite. Remedy: ({model.size}, {model.size})"
        )
    uneven, bent = abs(once - once.T).max(), abs(twice - 2.0 * once).max()
    if max(uneven, bent) > ROUND_OFF * abs(once).max():
        raise ModelError(
            f"the geometric stiffness is not {'symmetric' if uneven >= bent else 'linear in the displacement w'} (by "
            f"{max(uneven, bent) / abs(once).max():.2g} of its largest entry). Remedy: int grad(u) s(w) : grad(v) "
            "with the linear stress s of w, without constant terms"
        )
