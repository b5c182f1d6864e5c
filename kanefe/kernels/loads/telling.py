"""Outputs of loads between frames in states of a run."""

from __future__ import annotations

from kanefe.kernels.compiler.arrays import Integers, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.force_elements.places import END_NUMBERS
from kanefe.kernels.loads.loads_between import evaluate_load
from kanefe.kernels.loads.loads_layout import END_COUNT, TEAM, place_of_load
from kanefe.kernels.loads.points import gather_points
from kanefe.kernels.scene import Scene, state_in, work_in
from kanefe.kernels.sweeps.outward import sweep_outward


@entry()
def tell_states(
    scene: Scene,
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
    scene : Scene
        With these loads alone between frames, and the addresses of the functions that write their outputs.
    counts : ndarray of int, shape (loads,)
        How many outputs each has.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T or 1, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, outputs)
    memory : ndarray
        For `Work`.
    """
    work, between = work_in(scene, memory), scene.between
    for k in range(len(states)):
        state, at = state_in(scene.tables, times[k], states[k], drives[k], inputs[min(k, len(inputs) - 1)]), 0
        sweep_outward(scene, state, work, False)
        for i in range(len(between.loads)):
            gather_points(scene, work, between.loads[i, TEAM], i, i + 1)
            evaluate_load(scene, state, work, i, i)
            written = place_of_load(between) + END_NUMBERS * between.loads[i, END_COUNT]
            for c in range(counts[i]):
                found[k, at + c] = work.acting[written + c]
            at += counts[i]
