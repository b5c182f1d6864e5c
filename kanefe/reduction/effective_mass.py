"""Effective masses: how much of a body's inertia each mode carries, by direction and by interface.

With the M-orthonormal mode V_i the participation in a unit motion R of the support is ``L_i = V_i^T M R``, and its
effective mass is L_i^2 (Wijker 2004, "Mechanical vibrations in spacecraft design"). Over all modes of a body that is
clamped they add up to the mass, less what the nodes of the clamp carry.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.finite_element_model import COMPONENTS
from kanefe.statics import StaticProblem


def effective_masses(problem: StaticProblem, modes: np.ndarray) -> dict[str, Any]:
    """Return effective masses of M-orthonormal modes, shape (tied, k), as json-able lists.

    Returns
    -------
    dict
        "directions": names of the six unit motions of G, rotations about its origin; "modes": L_i^2, (k, 6) in kg and
        kg m2; "total": those of the whole body; "interfaces": for each interface fixed in G its fixed components, and
        L_i^2 of their unit motions, (k, components).
    """
    model, ties = problem.model, problem.ties
    R = model.rigid_modes()
    loads = model.mass @ R
    participation = (ties.transformation.T @ loads).T @ modes
    interfaces = {}
    weighted = problem.mass @ modes
    for tie in ties.ties:
        if tie.fixed:
            shapes = problem.constraint_modes[:, tie.rows[list(tie.fixed)] - ties.interior_count]
            interfaces[tie.name] = {
                "components": [tie.names[i] for i in tie.fixed],
                "modes": ((shapes.T @ weighted) ** 2).T.tolist(),
            }
    return {
        "directions": list(COMPONENTS),
        "modes": (participation**2).T.tolist(),
        "total": np.einsum("ij,ij->j", R, loads).tolist(),
        "interfaces": interfaces,
    }
