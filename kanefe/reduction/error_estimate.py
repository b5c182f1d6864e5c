r"""A-posteriori error of a reduced body: what the modes left out would add to its response, without computing them.

With the basis V the body answers a load f by u_r, and leaves the residual ``r = f - (K + s^2 M) u_r``. It is a
combination of the residuals of the loads and of the modes V_i,

    f - M V V^T f    and    (K - lambda_i M) V_i

so that one static solve for each of them spans the statics of every residual, at all frequencies and for all
combinations of loads. The body projected on V and these is the next better one: the difference of its response to that
of V is the error, but for terms of a higher order in (w / w_d)^2 with the lowest frequency w_d of what was left out (a
hierarchical estimate; Bank & Smith 1993). In statics it is exact: the error has the energy r^T K^-1 r.

What the report of a body says (`FlexibleBody.provenance["reduction"]["error_estimate"]`):

- "value": the largest error of a response, relative to the response, over loads, motions compared and frequencies, with
  a factor of safety of two that covers loads which come at once; "load", "output", "frequency" (Hz) say where;
- "loads": for each load and unit the errors of the displacement (root mean square over the mass), of the translation
  and rotation of each interface that moves, of the "stress" (root of the strain energy), of the "static" response;
  all relative; and the error of the displacement in m per unit of the load;
- "frequencies": by which share natural frequencies within the range are too high at most.

These are errors of the body alone: its fixed interfaces at rest in G, and loads within the frequency range. What they
do to a scene, where bodies drive each other and may be let go suddenly, shows the difference of a run to one with the
`Enriched` body.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg

from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.load_cases import LoadGroup
from kanefe.reduction.orthonormal import normalised, orthonormal_columns
from kanefe.reduction.response_model import ResponseModel


def error_estimate(
    problem: StaticProblem, modes: np.ndarray, groups: Sequence[LoadGroup], up_to_frequency: float
) -> dict[str, Any]:
    """Return the estimated errors of a basis.

    Parameters
    ----------
    problem : StaticProblem
    modes : ndarray, shape (tied, k)
        M-orthonormal modes of the reduced body (K is diagonal in them).
    groups : sequence of LoadGroup
        What the body answers to.
    up_to_frequency : float
        Highest frequency of the loads, Hz.

    Returns
    -------
    dict
        Json-able, as described at the top of this file.
    """
    residual = residual_shapes(problem, modes, groups)
    rich = ResponseModel.of_basis(problem, np.hstack((modes, residual)), groups, up_to_frequency)
    kept = np.eye(rich.stiffness.shape[0])[:, : modes.shape[1]]
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    return {**rich.errors(kept), "frequencies": frequency_error(rich.stiffness, np.sort(squares), up_to_frequency)}


def residual_shapes(problem: StaticProblem, modes: np.ndarray, groups: Sequence[LoadGroup]) -> np.ndarray:
    """Return the statics of the residuals of modes and loads, M-orthonormal and M-orthogonal to the modes, (tied, m).

    Parameters are those of `error_estimate`.
    """
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    forces = np.hstack([group.forces for group in groups])
    solved = problem.solve(np.hstack((problem.mass @ modes, forces)))
    of_modes = modes - squares * solved[:, : modes.shape[1]]
    of_loads = normalised(solved[:, modes.shape[1] :], problem.mass)
    against = np.hstack((problem.rigid_modes, modes))
    return orthonormal_columns(np.hstack((of_modes, of_loads)), problem.mass, against)


def frequency_error(rich_stiffness: np.ndarray, squares: np.ndarray, up_to_frequency: float) -> float:
    """Return by which share natural frequencies within the range are too high, the largest of them."""
    if not len(squares):
        return 0.0
    better = np.maximum(scipy.linalg.eigvalsh(rich_stiffness)[: len(squares)], 0.0)
    within = squares <= (2 * np.pi * up_to_frequency) ** 2
    shares = 1.0 - np.sqrt(better[within] / squares[within])
    return float(np.maximum(shares, 0.0).max(initial=0.0))
