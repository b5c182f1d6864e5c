"""Reactions of joints, and loads of joints that follow them: friction from a joint's own load."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    accumulate,
    cross,
    matrix,
    minus,
    plus,
    rotated,
    rotated_back,
    symmetric,
    symmetric_times,
    vector,
)
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.force_elements.coordinate_friction import put_load_rates
from kanefe.kernels.layout import ACCELERATION, ALPHA, FORCE, MOMENT, H, J, M, R
from kanefe.kernels.loads.loads_between import put_coordinates
from kanefe.kernels.loads.loads_layout import FIRST_NUMBER, FIRST_STATE, STATE_COUNT, place_of_load
from kanefe.kernels.tables import LoadsBetween

REACTION = 6

# Columns of the integers of a bearing, and of its numbers
LOAD, ROW, HAS_MOMENT = range(3)
PLACE, AXIS = 0, 3


@kernel
def add_reactions(between: LoadsBetween, work: np.ndarray, reactions: np.ndarray) -> None:
    """Add what joints exert on their bodies, about the origins of rows in N, after a sweep of accelerations.

    `reactions`, (bearings, REACTION). Accelerations are linear in forces, so that reactions of several sweeps add up.
    Moments that do not count are left out.
    """
    for b in range(len(between.bearings)):
        i = between.bearings[b, ROW]
        a, alpha, h = vector(work, i, ACCELERATION), vector(work, i, ALPHA), matrix(work, i, H)
        force = plus(symmetric_times(symmetric(work, i, M), a), rotated(h, alpha))
        accumulate(reactions, b, 0, plus(vector(work, i, FORCE), force))
        if between.bearings[b, HAS_MOMENT]:
            moment = plus(rotated_back(h, a), symmetric_times(symmetric(work, i, J), alpha))
            accumulate(reactions, b, 3, plus(vector(work, i, MOMENT), moment))


@kernel
def follow_reactions(
    between: LoadsBetween,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    states: np.ndarray,
    work: np.ndarray,
    reactions: np.ndarray,
    workspace: np.ndarray,
    rates: np.ndarray,
) -> None:
    """Write the rates of the loads that follow reactions of joints."""
    for b in range(len(between.bearings)):
        n, row = between.bearings[b, LOAD], between.bearings[b, ROW]
        axes = matrix(work, row, R)
        axis = rotated(axes, vector(between.bearing_places, b, AXIS))
        force, moment = vector(reactions, b, 0), vector(reactions, b, 3)
        if between.bearings[b, HAS_MOMENT]:
            moment = minus(moment, cross(rotated(axes, vector(between.bearing_places, b, PLACE)), force))
        put_coordinates(between, n, drives, q, u, workspace)
        ends = workspace[place_of_load(between) :]
        first, numbers = between.loads[n, FIRST_STATE], between.numbers[between.loads[n, FIRST_NUMBER] :]
        own = slice(first, first + between.loads[n, STATE_COUNT])
        put_load_rates(numbers, axis, force, moment, ends, states[own], rates[own])
