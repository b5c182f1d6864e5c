r"""The response that a basis neglects, for the loads that act on a body in any scene, and for its own vibration.

With the M-orthonormal modes V, ``V^T K V = diag(w^2)``, unit loads F deform the body by ``K^-1 F``, of which V contains
``V (F^T V / w^2)^T``. The rest is the displacement ``U = K^-1 F - V diag(1 / w^2) V^T F``. For loads f of any size it
has twice the energy f^T R f, and the root mean square over the mass m of its displacement is that of f^T D f:

    R = F^T K^-1 F - F^T V diag(1 / w^2) V^T F      (residual flexibility)
    D = U^T M U / m

The inertia of the modes themselves, ``-M V a`` with their accelerations a, is one more load. Of normal modes V holds
all of the response to it; of static shapes it does not, and a fast motion shows in them. What ``F f - M V a`` leaves
out is the static response to the residual of the equations of motion, whatever acts on interfaces whose static shapes
are kept: it is that of the modes left out, as long as they are faster than the motion.

(MacNeal, "A hybrid method of component mode synthesis", Computers & Structures 1 (1971) 581).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.fe_model.model import INERTIA_OF_MODES
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.load_cases import spread_groups
from kanefe.reduction.orthonormal import Orthonormal

HELD = 1e-6
"""Fraction of the energy of a load's static response that may be missing: a thousandth in its stresses."""


def left_out(problem: StaticProblem, found: Orthonormal) -> dict[str, Any]:
    """Return the static response to inertia and load patterns that modes neglect, json-able.

    Parameters
    ----------
    problem : StaticProblem
    found : Orthonormal

    Returns
    -------
    dict
        "loads": [name, component] of each load whose response is not complete; "energy": R, J per product of the units
        of two loads; "displacement": D, m2 per product of units.
    """
    groups = spread_groups(problem)
    shaped, inertia = _not_normal(problem, found.modes)
    names = [[group.name, component] for group in groups for component in group.kept]
    names += [[INERTIA_OF_MODES, int(mode)] for mode in shaped]
    if not names:
        return {"loads": [], "energy": [], "displacement": []}
    F = problem.relieved(np.hstack([*(group.forces for group in groups), inertia]))
    F[problem.fixed] = 0.0
    U = problem.solve(F)
    whole = F.T @ U
    translation = problem.ties.coordinates(problem.model.rigid_modes())[:, 0]
    mass = float(translation @ (problem.mass @ translation))
    U -= found.modes @ (F.T @ found.modes / found.squares).T
    R, D = F.T @ U, U.T @ (problem.mass @ U) / mass
    kept = np.flatnonzero(np.diag(R) > HELD * np.diag(whole))
    R, D = (0.5 * (X + X.T)[np.ix_(kept, kept)] for X in (R, D))
    return {"loads": [names[i] for i in kept], "energy": R.tolist(), "displacement": D.tolist()}


def _not_normal(problem: StaticProblem, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of modes that are static shapes and not normal modes of the whole body, and M times these."""
    moving = np.delete(np.arange(problem.size), problem.fixed)
    pulled, inertia = (problem.stiffness @ modes)[moving], problem.mass @ modes
    squares = np.einsum("ij,ij->j", modes[moving], pulled)
    residual = np.linalg.norm(pulled - inertia[moving] * squares, axis=0)
    shaped = np.flatnonzero(residual > np.sqrt(HELD) * np.linalg.norm(pulled, axis=0))
    return shaped, inertia[:, shaped]
