"""What events of loads look at, in states of a run: values of functions of loads between frames."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.arrays import Integers, RealBlocks, RealRows, Reals
from kanefe.kernels.entries import entry
from kanefe.kernels.force_elements.places import END_NUMBERS
from kanefe.kernels.layout import COORDINATES, MODAL_SIZE, SPEEDS, STATES, WORK, FlexibleTables, Tables
from kanefe.kernels.loads_between import END_COUNT, LoadsBetween, evaluate_load
from kanefe.kernels.outward import sweep_outward
from kanefe.kernels.signatures import Variant


@entry(Variant(), Variant(has_flexible=True))
def watch_states(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: LoadsBetween,
    counts: Integers,
    times: Reals,
    drives: RealBlocks,
    inputs: RealRows,
    states: RealRows,
    found: RealRows,
    memory: Reals,
) -> None:
    """Write the values that events of loads look at, in some states.

    Parameters
    ----------
    between : LoadsBetween
        Of these loads, with the addresses of what they are watched by.
    counts : ndarray of int, shape (loads,)
        How many values each has.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, values)
    memory : ndarray, shape (`watch_memory_size`,)
    """
    size = WORK * len(tables.rows)
    work, rest = memory[:size].reshape(-1, WORK), memory[size:]
    modes = len(rest) - between.workspace_size[0]
    modal, acting = rest[:modes], rest[modes:]
    n = tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    k = m + tables.sizes[STATES]
    for row in range(len(states)):
        y = states[row]
        sweep_outward(tables, flexible, drives[row], y[:n], y[n:m], work, modal)
        at = 0
        for load in range(len(between.loads)):
            ends = END_NUMBERS * between.loads[load, END_COUNT]
            own = acting[:ends], acting[ends:]
            evaluate_load(between, load, times[row], inputs[row], y[m:k], drives[row], y[:n], y[n:m], work, *own)
            for i in range(counts[load]):
                found[row, at + i] = acting[ends + i]
            at += counts[load]


def watch_memory_size(tables: Tables, flexible: FlexibleTables | None, between: LoadsBetween) -> int:
    """Return how many numbers the memory of `watch_states` has."""
    modes = 0 if flexible is None else int(flexible.sizes[MODAL_SIZE])
    return WORK * len(tables.rows) + modes + int(np.max(between.workspace_size))
