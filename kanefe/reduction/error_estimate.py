r"""A-posteriori error of a reduced body: the contribution of the truncated modes, without computing them.

With the basis V the response of the body to a load f is u_r, with the residual ``r = f - (K + s^2 M) u_r``. This is a
combination of the residuals of the loads and of the modes V_i,

    f - M V V^T f    and    (K - lambda_i M) V_i

so that one static solve for each of them spans the static response to every residual, at all frequencies and for all
combinations of loads. The body is also projected on V and these shapes: the difference of its response and that of V is
the error, up to terms of a higher order in (w / w_d)^2 with the lowest truncated frequency w_d (a hierarchical
estimate; Bank & Smith 1993). In statics it is exact: the error has the energy r^T K^-1 r.

The report of a body (`FlexibleBody.provenance["reduction"]["error_estimate"]`) has

- "value": the largest error of a response, relative to the response, over loads, outputs and frequencies, with a factor
  of safety of two for suddenly applied loads; "load", "output", "frequency" (Hz): where it occurs;
- "loads": for each load and unit the errors of the displacement (root mean square over the mass), of the translation
  and rotation of each interface that moves, of the "stress" (root of the strain energy), of the "static" response;
  all relative; and the error of the displacement in m per unit of the load;
- "frequencies": the largest relative error of natural frequencies within the range, which are too high.

These are errors of the body alone: its fixed interfaces at rest in G, and loads within the frequency range. Their
effect in a scene, with coupled bodies and sudden releases, is what a run with an accuracy finds by more modes and
static shapes: `kanefe.certified.search`.
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
        Loads of which the response is compared.
    up_to_frequency : float
        Highest frequency of the loads, Hz.

    Returns
    -------
    dict
        Json-able, as described at the top of this module.
    """
    residual = residual_shapes(problem, modes, groups)
    rich = ResponseModel.of_basis(problem, np.hstack((modes, residual)), groups, up_to_frequency)
    kept = np.eye(rich.stiffness.shape[0])[:, : modes.shape[1]]
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    return {**rich.errors(kept), "frequencies": frequency_error(rich.stiffness, np.sort(squares), up_to_frequency)}


def residual_shapes(problem: StaticProblem, modes: np.ndarray, groups: Sequence[LoadGroup]) -> np.ndarray:
    """Return static shapes of the residuals of modes and loads, M-orthonormal and M-orthogonal to the modes, (tied, m).

    Parameters are those of `error_estimate`.
    """
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    forces = np.hstack([group.forces for group in groups])
    solved = problem.solve(np.hstack((problem.mass @ modes, forces)))
    of_modes = modes - squares * solved[:, : modes.shape[1]]
    of_loads = normalised(solved[:, modes.shape[1] :], problem.mass, problem.largest_masses)
    return orthonormal_columns(
        np.hstack((of_modes, of_loads)),
        problem.mass,
        np.hstack((problem.rigid_modes, modes)),
        problem.largest_masses,
    )


def frequency_error(rich_stiffness: np.ndarray, squares: np.ndarray, up_to_frequency: float) -> float:
    """Return the largest relative error of natural frequencies within the range, which are too high."""
    if not len(squares):
        return 0.0
    better = np.maximum(scipy.linalg.eigvalsh(rich_stiffness)[: len(squares)], 0.0)
    within = np.sqrt(np.maximum(squares, 0.0)) <= 2 * np.pi * up_to_frequency
    shares = 1.0 - np.sqrt(better[within] / squares[within])
    return float(np.maximum(shares, 0.0).max(initial=0.0))
