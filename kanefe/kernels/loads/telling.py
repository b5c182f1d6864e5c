"""Outputs of loads between frames in states of a run."""

from typing import NamedTuple

from kanefe.kernels.language import Integers, RealBlocks, RealRows, Reals, entry, inlined
from kanefe.kernels.loads.acting import acting_in, loads_of
from kanefe.kernels.loads.loads_between import evaluate_alone
from kanefe.kernels.scene import Scene, State, state_in, work_in
from kanefe.kernels.sweeps.outward import sweep_outward


class States(NamedTuple):
    """States of a run, and what else is given of their times."""

    times: Reals  # (T,): s
    drives: RealBlocks  # (T, driven, 3)
    inputs: RealRows  # (T or 1, inputs)
    states: RealRows  # (T, state): each begins with q, u and z


@entry()
def tell_states(scene: Scene, counts: Integers, states: States, found: RealRows, memory: Reals) -> None:
    """Write outputs of loads in some states.

    Parameters
    ----------
    scene : Scene
        With these loads alone between frames, and the addresses of the functions that write their outputs.
    counts : ndarray of int, shape (loads,)
        How many outputs each has.
    states : States
    found : ndarray, shape (T, outputs)
    memory : ndarray
        For `Work`.
    """
    work, loads = work_in(scene, memory), loads_of(scene)
    done = acting_in(scene, work).done
    for k in range(len(states.states)):
        state, at = state_at(scene, states, k), 0
        sweep_outward(scene, state, work, False)
        for n in range(len(loads)):
            evaluate_alone(scene, state, work, n)
            for c in range(counts[n]):
                found[k, at + c] = done[c]
            at += counts[n]


@inlined
def state_at(scene: Scene, states: States, k: int) -> State:
    """Return one of some states."""
    inputs = states.inputs[min(k, len(states.inputs) - 1)]
    return state_in(scene.tables, states.times[k], states.states[k], states.drives[k], inputs)
