r"""What a basis leaves out of the static response to the loads that any scene puts on a body.

With the M-orthonormal modes V, ``V^T K V = diag(w^2)``, unit loads F deform the body by ``K^-1 F``, of which V holds
``V (F^T V / w^2)^T``. What is left over has

    twice the energy  f^T R f,   R = F^T K^-1 F - F^T V diag(1 / w^2) V^T F      (residual flexibility)
    and the displacement  U = K^-1 F - V diag(1 / w^2) V^T F,  root of f^T D f over the mass,  D = U^T M U / m

for loads f of any size (MacNeal, "A hybrid method of component mode synthesis", Computers & Structures 1 (1971) 581).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.load_cases import spread_groups

HELD = 1e-6
"""Fraction of the energy of a load's static response that may be missing: a thousandth of its stresses."""


def left_out(problem: StaticProblem, modes: np.ndarray) -> dict[str, Any]:
    """Return what modes leave out of the statics of inertia and of load patterns, json-able.

    Parameters
    ----------
    problem : StaticProblem
    modes : ndarray, shape (tied, k)
        M-orthonormal, K diagonal in them.

    Returns
    -------
    dict
        "loads": [name, component] of each load that is not held; "energy": R, J per squares of the units of the loads;
        "displacement": D, m2 per the same.
    """
    groups = spread_groups(problem)
    names = [[group.name, component] for group in groups for component in group.kept]
    if not names:
        return {"loads": [], "energy": [], "displacement": []}
    F = problem.relieved(np.hstack([group.forces for group in groups]))
    U = problem.solve(F)
    whole = F.T @ U
    translation = problem.ties.coordinates(problem.model.rigid_modes())[:, 0]
    mass = float(translation @ (problem.mass @ translation))
    held = F.T @ modes / np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    U -= modes @ held.T
    R, D = F.T @ U, U.T @ (problem.mass @ U) / mass
    kept = np.flatnonzero(np.diag(R) > HELD * np.diag(whole))
    R, D = (0.5 * (X + X.T)[np.ix_(kept, kept)] for X in (R, D))
    return {"loads": [names[i] for i in kept], "energy": R.tolist(), "displacement": D.tolist()}
