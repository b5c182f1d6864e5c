"""Runs of planar scenes."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import entry_without_arrays
from kanefe.kernels.drives import Drives, put_drives
from kanefe.kernels.evaluation import parts_of
from kanefe.kernels.planar.evaluation import planar_workspace_in, put_planar_rates
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.stepping import (
    AT,
    IMPLICIT,
    LARGEST_OF_DRIVES,
    NO_INERTIA,
    RATES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    TIME_AT,
    Run,
    go_on,
)


@entry_without_arrays
def integrate_planar(
    tables: PlanarTables,
    drives: np.ndarray,
    motions: Drives,
    fill: Any,
    inputs: np.ndarray,
    run: Run,
    vectors: np.ndarray,
    memory: np.ndarray,
) -> tuple[int, float]:
    """Go on with a run, as `kanefe.kernels.integration.integrate` does in space."""
    workspace, parts, reals = planar_workspace_in(memory, tables), parts_of(tables, vectors), run.reals
    while True:
        command = go_on(run, vectors)
        if command != RATES and command != IMPLICIT:
            return command, 1.0
        t = reals[TIME_AT]
        reals[LARGEST_OF_DRIVES] = put_drives(motions, t, drives)
        fill(t, vectors[AT], inputs)
        shares = reals[SHARE_DAMPING], reals[SHARE_STIFFNESS]
        if not put_planar_rates(tables, drives, inputs, vectors, parts, command == IMPLICIT, shares, workspace):
            return NO_INERTIA, 1.0
