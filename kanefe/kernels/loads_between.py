"""Loads between frames and along joint coordinates (Eq. 11): ends gathered, functions called, wrenches applied."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.calls import call_address
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    TAKEN,
    WRENCH,
    WRENCHES,
    A,
    P,
    V,
    W,
)
from kanefe.kernels.layout import FlexibleTables
from kanefe.kernels.loads import push
from kanefe.kernels.markers import MARKER_NUMBERS, axes_of, lever_of, motion_of
from kanefe.kernels.vectors import cross, plus, put_three, three

# Columns of the integers of a load
FIRST_END, END_COUNT, FIRST_NUMBER, INPUT, FIRST_STATE, STATE_COUNT = range(6)
LOAD_INTEGERS = 6
REAL, COMPLEX = range(2)

COORDINATE = -2
"""In the place of the row of an end that is a joint coordinate."""
AT, SPEED = range(2)
"""Numbers of the marker of such an end: where the coordinate is in q (-1 - drive: it is driven), and its speed."""


class LoadsBetween(NamedTuple):
    """Loads between frames of a scene; None in its place leaves out their code.

    Attributes
    ----------
    loads : ndarray of int, shape (n, LOAD_INTEGERS)
        First end and number of ends, first of its numbers, first input, first internal state and number of states.
    addresses : ndarray of int, shape (n, 2)
        Of its function for real and for complex numbers.
    rows : ndarray of int, shape (ends,)
        Row of each end (-1: N, COORDINATE: it is a joint coordinate).
    markers : ndarray, shape (ends, MARKER_NUMBERS)
    numbers : ndarray
        Constants of all loads.
    workspace_size : ndarray of int, shape (1,)
        How many numbers the workspace of a load has: see `load_workspace_size`.
    """

    loads: IntegerRows
    addresses: IntegerRows
    rows: Integers
    markers: RealRows
    numbers: Reals
    workspace_size: Integers


def no_loads_between() -> LoadsBetween:
    """Return the tables of a scene without such loads."""
    none = np.zeros((0, LOAD_INTEGERS), dtype=np.int64), np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64)
    return LoadsBetween(*none, np.zeros((0, MARKER_NUMBERS)), np.zeros(0), np.zeros(1, dtype=np.int64))


def load_workspace_size(ends: int, states: int) -> int:
    """Return how many numbers the workspace of a load with so many ends and internal states has."""
    return ends * (END_NUMBERS + WRENCH) + WRENCHES + states


@kernel
def add_loads_between(
    between: LoadsBetween,
    rows: np.ndarray,
    flexible: FlexibleTables | None,
    t: float,
    inputs: np.ndarray,
    states: np.ndarray,
    rates: np.ndarray,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    workspace: np.ndarray,
) -> tuple[Any, Any]:
    """Apply loads between frames and write the rates of their states; return the power taken and the power given."""
    taken = given = 0.0 * work[0, 0]
    for n in range(len(between.loads)):
        first, count = between.loads[n, FIRST_END], between.loads[n, END_COUNT]
        out = workspace[END_NUMBERS * count :]
        evaluate_load(between, n, t, inputs, states, drives, q, u, work, workspace[: END_NUMBERS * count], out)
        taken += out[TAKEN]
        given += out[GIVEN]
        for i in range(count):
            row = between.rows[first + i]
            if row == COORDINATE:
                applied[int(between.markers[first + i, SPEED])] += out[WRENCHES + WRENCH * i]
                continue
            force, moment = three(out, WRENCHES + WRENCH * i), three(out, WRENCHES + WRENCH * i + 3)
            lever = lever_of(between.markers, first + i, row, work)
            push(rows, flexible, row, force, plus(moment, cross(lever, force)), work, modal)
        of_states = between.loads[n, FIRST_STATE]
        for i in range(between.loads[n, STATE_COUNT]):
            rates[of_states + i] = out[WRENCHES + WRENCH * count + i]
    return taken, given


@kernel
def potential_between(
    between: LoadsBetween,
    t: float,
    inputs: np.ndarray,
    states: np.ndarray,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    workspace: np.ndarray,
) -> Any:
    """Return the energy in loads between frames."""
    energy = 0.0 * work[0, 0]
    for n in range(len(between.loads)):
        ends = END_NUMBERS * between.loads[n, END_COUNT]
        evaluate_load(between, n, t, inputs, states, drives, q, u, work, workspace[:ends], workspace[ends:])
        energy += workspace[ends + POTENTIAL]
    return energy


@kernel
def evaluate_load(
    between: LoadsBetween,
    n: int,
    t: float,
    inputs: np.ndarray,
    states: np.ndarray,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    ends: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the motion of the ends of a load, and what it does: see `kanefe.kernels.force_elements.places`."""
    first, count = between.loads[n, FIRST_END], between.loads[n, END_COUNT]
    for i in range(count):
        row, at = between.rows[first + i], END_NUMBERS * i
        if row == COORDINATE:
            put_coordinate(between.markers[first + i], drives, q, u, ends[at : at + END_NUMBERS])
            continue
        p, v, w = motion_of(row, lever_of(between.markers, first + i, row, work), work)
        axes = axes_of(between.markers, first + i, row, work)
        put_three(ends, at + P, p)
        for c in range(9):
            ends[at + A + c] = axes[c]
        put_three(ends, at + V, v)
        put_three(ends, at + W, w)
    out[:] = 0.0
    address = between.addresses[n, COMPLEX if np.iscomplexobj(work) else REAL]
    own = between.numbers[between.loads[n, FIRST_NUMBER] :]
    given, z = inputs[between.loads[n, INPUT] :], states[between.loads[n, FIRST_STATE] :]
    call_address(address, (t, own, given, ends, z, out))


@inlined
def put_coordinate(marker: np.ndarray, drives: np.ndarray, q: np.ndarray, u: np.ndarray, end: np.ndarray) -> None:
    """Write a joint coordinate as the motion of an end: it and its rate are x of position and velocity."""
    end[:] = 0.0
    end[A] = end[A + 4] = end[A + 8] = 1.0
    at = int(marker[AT])
    if at >= 0:
        end[P], end[V] = q[at], u[int(marker[SPEED])]
    else:
        end[P], end[V] = drives[-1 - at, 0], drives[-1 - at, 1]
