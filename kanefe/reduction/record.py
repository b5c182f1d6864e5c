"""What a body tells of its reduction: `FlexibleBody.provenance["reduction"]`."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.progress import stage
from kanefe.reduction.basis import Basis, Reduction
from kanefe.reduction.effective_mass import effective_masses
from kanefe.reduction.error_estimate import error_estimate
from kanefe.reduction.load_cases import some_groups
from kanefe.statics import StaticProblem


def reduction_record(reduction: Reduction, problem: StaticProblem, chosen: Basis, modes: np.ndarray) -> dict[str, Any]:
    """Return the json-able record of a reduction.

    Parameters
    ----------
    reduction : Reduction
    problem : StaticProblem
    chosen : Basis
        What the method gave.
    modes : ndarray, shape (tied, k)
        The M-orthonormal modes that became of it.

    Returns
    -------
    dict
        "method": the options; "columns" given and "kept" after dependent and rigid ones were left out; "effective_mass"
        of the modes kept; "modes": normal modes looked at; "load_vectors": names and numbers; "error_estimate" if it
        was asked for (see `kanefe.reduction.error_estimate`).
    """
    record = {
        "method": repr(reduction),
        "columns": chosen.columns.shape[1],
        "kept": modes.shape[1],
        "effective_mass": effective_masses(problem, modes),
        **chosen.record,
    }
    limit = reduction.error_up_to
    if limit is not None:
        groups = some_groups(problem, reduction.loads)
        with stage("error estimate"):
            record["error_estimate"] = error_estimate(problem, modes, groups, limit)
    return record
