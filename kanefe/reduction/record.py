"""The record of a body's reduction, `FlexibleBody.provenance["reduction"]`, with the effective masses of its modes.

The participation factor of the M-orthonormal mode V_i in a unit motion R of the support is ``L_i = V_i^T M R``, and its
effective mass is L_i^2 (Wijker 2004, "Mechanical vibrations in spacecraft design"). Over all modes of a clamped body
they add up to its mass without that of the clamped nodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kanefe.fe_model.model import COMPONENTS
from kanefe.fe_model.progress import stage
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.basis import Basis, Reduction
from kanefe.reduction.error_estimate import error_estimate
from kanefe.reduction.left_out import left_out
from kanefe.reduction.load_cases import some_groups
from kanefe.reduction.orthonormal import Orthonormal
from kanefe.reduction.patch_case import contact_compliance

EXACT = 1e-6
"""Relative error of a static response up to which it is told to be exact: above round-off."""


def reduction_record(reduction: Reduction, problem: StaticProblem, chosen: Basis, found: Orthonormal) -> dict[str, Any]:
    """Return the json-able record of a reduction.

    Parameters
    ----------
    reduction : Reduction
    problem : StaticProblem
    chosen : Basis
        Result of the method.
    found : Orthonormal
        Modes of its columns.

    Returns
    -------
    dict
        "method": the options; "residuals": the largest of static shapes and modes (see `kanefe.fe_model.residuals`);
        "columns" given and "kept" after dependent and rigid ones were left out; "effective_mass"
        of the modes kept; "modes": normal modes examined; "load_vectors": names and numbers; "error_estimate" if it
        was requested (see `kanefe.reduction.error_estimate`); "left_out": neglected static response to inertia and load
        patterns (see `kanefe.reduction.left_out`); "contact_compliance" of its surfaces (see
        `kanefe.reduction.patch_case`).
    """
    record = {
        "method": repr(reduction),
        "residuals": dict(problem.residuals),
        "columns": chosen.columns.shape[1],
        "kept": found.modes.shape[1],
        "effective_mass": effective_masses(problem, found.modes),
        **chosen.record,
    }
    with stage("what the modes leave out"):
        record["left_out"] = left_out(problem, found)
        record["contact_compliance"] = contact_compliance(problem, found)
    if reduction.error_up_to is not None:
        groups = some_groups(problem, reduction.loads)
        with stage("error estimate"):
            record["error_estimate"] = error_estimate(problem, found.modes, groups, reduction.error_up_to)
    return record


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
    for tie in ties.ties:
        if tie.fixed:
            shapes = problem.constraint_modes[:, tie.rows[list(tie.fixed)] - ties.interior_count]
            interfaces[tie.name] = {
                "components": [tie.names[i] for i in tie.fixed],
                "modes": (((problem.mass @ shapes).T @ modes) ** 2).T.tolist(),
            }
    return {
        "directions": list(COMPONENTS),
        "modes": (participation**2).T.tolist(),
        "total": np.einsum("ij,ij->j", R, loads).tolist(),
        "interfaces": interfaces,
    }


def told_of_choice(record: Mapping[str, Any]) -> list[str]:
    """Return lines on modes that were chosen for the user: how many, the range, and the error within it."""
    if "choice" not in record:
        return []
    error = record["error_estimate"]
    exact = [name for name, own in error["loads"].items() if own["static"] <= EXACT]
    found = (
        f"reduced to {record['kept']} coordinates by {record['method']}: {record['choice']['kept_modes']} normal modes"
    )
    return [
        f"{found}; statically exact: {', '.join(exact) or 'none of its loads'}",
        f"loads up to {error['up_to_frequency']:.4g} Hz move it with an error of {error['value']:.1e}, most by "
        f"{error['load']}; for faster ones reduction=kf.CraigBampton(up_to_frequency=<Hz>)",
    ]
