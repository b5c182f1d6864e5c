"""Runs in order n: a method of integration gets what it wants evaluated until its outputs or steps are done."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import entry_without_arrays, expanded
from kanefe.kernels.closing import close_state
from kanefe.kernels.constraints import Loops
from kanefe.kernels.drives import Drives, put_drives
from kanefe.kernels.evaluation import Workspace, parts_of, put_rates, workspace_in
from kanefe.kernels.layout import FlexibleTables, Tables
from kanefe.kernels.loads_between import LoadsBetween
from kanefe.kernels.momenta import put_balance
from kanefe.kernels.stepping import (
    AT,
    BALANCE,
    IMPLICIT,
    IS_LEFT_OPEN,
    LARGEST_OF_DRIVES,
    NO_INERTIA,
    PROJECT,
    RATES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    STATE,
    STORED,
    TIME,
    TIME_AT,
    WEAKEST,
    Run,
    go_on,
)
from kanefe.kernels.tolerances import NEAR_SINGULAR
from kanefe.kernels.vectors import copy


@entry_without_arrays
def integrate(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: LoadsBetween | None,
    loops: Loops | None,
    drives: np.ndarray,
    motions: Drives,
    fill: Any,
    inputs: np.ndarray,
    run: Run,
    vectors: np.ndarray,
    memory: np.ndarray,
) -> tuple[int, float]:
    """Go on with a run until its method wants what is not to be had here.

    Parameters
    ----------
    tables, flexible, between, loops
        As in `kanefe.kernels.evaluation.evaluate`.
    drives : ndarray, shape (driven, 3)
        Written by `motions` at each time.
    fill : function (t, y, inputs)
        Writes the values of loads that are compiled functions.
    inputs : ndarray
        Values of loads, the constant ones written.
    vectors : ndarray, shape (vectors of the method, state)
    memory : ndarray, shape (`workspace_size`,)

    Returns
    -------
    command : int
        What the method wants: ACCEPTED where the outputs or the steps have come to their end; RATES, IMPLICIT or
        PROJECT where the loops could not be closed, or only they hold what has no inertia. Or NO_INERTIA.
    weakest : float
        Smallest pivot of a constraint met, of 1.
    """
    workspace = workspace_in(memory, tables, flexible, loops, len(vectors[AT]))
    parts, at, reals = parts_of(tables, vectors), vectors[AT], run.reals
    weakest, closed = 1.0, run.integers[STORED]
    while True:
        command = go_on(run, vectors)
        if loops is not None:
            for stored in range(closed, run.integers[STORED]):
                time, state = run.times[stored], run.states[stored]
                if not _close(tables, flexible, loops, motions, drives, time, reals[SHARE_STIFFNESS], state, workspace):
                    run.integers[IS_LEFT_OPEN] = 1
            closed = run.integers[STORED]
            if command == PROJECT:
                time, state = reals[TIME], vectors[STATE]
                if _close(tables, flexible, loops, motions, drives, time, reals[SHARE_STIFFNESS], state, workspace):
                    continue
        if command != RATES and command != IMPLICIT and command != BALANCE:
            return command, weakest
        t = reals[TIME_AT]
        reals[LARGEST_OF_DRIVES] = put_drives(motions, t, drives)
        if command == BALANCE:
            own = workspace.work, workspace.modal, workspace.acting
            put_balance(tables, flexible, between, t, drives, inputs, *own, run.integers, reals, vectors)
            continue
        is_implicit, shares = command == IMPLICIT, (reals[SHARE_DAMPING], reals[SHARE_STIFFNESS])
        for is_beside in range(2):  # a second time where the loops are nearly singular
            fill(t, at, inputs)
            is_regular, pivot = put_rates(
                tables, flexible, between, loops, drives, t, inputs, vectors, parts, is_implicit, shares, workspace
            )
            weakest = min(weakest, pivot)
            if loops is None:
                break
            if is_beside:
                copy(workspace.asked, at)
                break
            reals[WEAKEST] = pivot
            if is_regular and not pivot < NEAR_SINGULAR:
                break
            if not is_regular or not _step_beside(tables, flexible, loops, motions, drives, t, at, workspace):
                return command, weakest
        if not is_regular:
            return NO_INERTIA, weakest


@expanded
def _close(
    tables: Tables,
    flexible: FlexibleTables | None,
    loops: Loops,
    motions: Drives,
    drives: np.ndarray,
    t: float,
    share_stiffness: float,
    y: np.ndarray,
    workspace: Workspace,
) -> bool:
    """Close the loops of a state at a time; tell whether that was possible."""
    rest = workspace.work, workspace.modal, workspace.border, workspace.closing
    return close_state(tables, flexible, loops, motions, drives, t, share_stiffness, y, *rest)


@expanded
def _step_beside(
    tables: Tables,
    flexible: FlexibleTables | None,
    loops: Loops,
    motions: Drives,
    drives: np.ndarray,
    t: float,
    at: np.ndarray,
    workspace: Workspace,
) -> bool:
    """Put the nearest closed state in the place of one near a singular position, whose rates are then its own.

    Off the constraints they would be without bounds. Tells whether there is one.
    """
    copy(at, workspace.asked)
    return _close(tables, flexible, loops, motions, drives, t, 0.0, at, workspace)
