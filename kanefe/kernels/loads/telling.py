"""Outputs of loads between frames in states of a run."""

from __future__ import annotations

from kanefe.kernels.compiler.arrays import Integers, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.force_elements.places import END_NUMBERS
from kanefe.kernels.layout import COORDINATES, MODAL_SIZE, SPEEDS, STATES, WORK, work_size
from kanefe.kernels.loads.loads_between import evaluate_load
from kanefe.kernels.loads.loads_layout import END_COUNT, TEAM, WHOLE, place_of_load
from kanefe.kernels.loads.points import gather_points
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Tables


@entry()
def tell_states(
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    counts: Integers,
    times: Reals,
    drives: RealBlocks,
    inputs: RealRows,
    states: RealRows,
    found: RealRows,
    memory: Reals,
) -> None:
    """Write outputs of loads in some states.

    Parameters
    ----------
    between : LoadsBetween
        Of these loads, with the addresses of the functions that write their outputs.
    counts : ndarray of int, shape (loads,)
        How many outputs each has.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, outputs)
    memory : ndarray, shape (`telling_memory_size`,)
    """
    size = work_size(tables)
    work, rest = memory[:size].reshape(-1, WORK), memory[size:]
    modes = len(rest) - between.workspace_size[WHOLE]
    modal, acting = rest[:modes], rest[modes:]
    n = tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    last = m + tables.sizes[STATES]
    for k in range(len(states)):
        q, u, z, at = states[k, :n], states[k, n:m], states[k, m:last], 0
        given = inputs[min(k, len(inputs) - 1)]
        sweep_outward(tables, flexible, drives[k], q, u, work, modal)
        for i in range(len(between.loads)):
            gather_points(between, flexible, between.loads[i, TEAM], i, i + 1, work, modal, acting)
            evaluate_load(between, i, i, flexible, times[k], given, z, drives[k], q, u, work, acting)
            written = place_of_load(between) + END_NUMBERS * between.loads[i, END_COUNT]
            for c in range(counts[i]):
                found[k, at + c] = acting[written + c]
            at += counts[i]


def telling_memory_size(tables: Tables, flexible: FlexibleTables, between: LoadsBetween) -> int:
    """Return how many numbers the memory of `tell_states` has."""
    modes = int(flexible.sizes[MODAL_SIZE])
    return work_size(tables) + modes + int(between.workspace_size[WHOLE])
