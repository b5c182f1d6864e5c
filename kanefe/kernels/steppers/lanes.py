"""Runs of scenes that are alike, each a lane: one after another in the memory of one method, or several at once.

At once only the rates are evaluated, in vector instructions, see `kanefe.kernels.evaluation.rigid_lanes`: each lane has
the memory of its own step, at a time and with a length of its own, and is what it is alone. Where a lane has come to
its end the next one takes its place.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, Prepared, RealBlocks, RealRows
from kanefe.kernels.language import call_address, copy, entry, inlined, kernel
from kanefe.kernels.steppers.integration import Scene
from kanefe.kernels.steppers.settled_outputs import go_on
from kanefe.kernels.steppers.step_commands import NO_INERTIA, VECTOR, Command, Run, step_of
from kanefe.kernels.sweeps.drives import put_drives


class Lanes(NamedTuple):
    """What each lane has for itself.

    Attributes
    ----------
    integers, reals, vectors : ndarray, shape (lanes, ...)
        Memory of the step of each, see `Run`.
    states : ndarray, shape (lanes, times, state)
        Its outputs.
    commands : ndarray of int, shape (lanes,)
        What its method wants in the end.
    most : ndarray of int, shape (lanes,)
        Count of accepted steps at which it is left for now.
    """

    integers: IntegerRows
    reals: RealRows
    vectors: RealBlocks
    states: RealBlocks
    commands: Integers
    most: Integers


class Slots(NamedTuple):
    """Lanes that are evaluated at once, each in a slot.

    Attributes
    ----------
    lanes : ndarray of int, shape (slots,)
        Which lane is in each; -1: none.
    evaluation : Prepared
        A call of `evaluate_lanes` with the arrays below.
    done_at : int
        Where in its numbers it is told whether all joints have inertia.
    drives, inputs, vectors : ndarray, shape (..., slots)
    constants : ndarray, shape (lanes or 0, constants)
        Numbers of the scene of each lane, where they are others.
    held : ndarray, shape (constants, slots)
        Those of the lanes in the slots.
    values : ndarray, shape (lanes or 1, inputs)
        Values of loads of each lane, the constant ones written.
    """

    lanes: Integers
    evaluation: Prepared
    done_at: int
    drives: RealBlocks
    inputs: RealRows
    vectors: RealBlocks
    constants: RealRows
    held: RealRows
    values: RealRows


@entry()
def run_lanes(going: Prepared, command_at: int, run: Run, lanes: Lanes) -> None:
    """Continue with one lane after another until its method wants what is not to be had in compiled code.

    Parameters
    ----------
    going : Prepared
        A call of `kanefe.kernels.steppers.integration.integrate` with the run.
    command_at : int
        Where in its numbers the command is.
    run : Run
        Its memory is lent to one lane after another.
    lanes : Lanes
    """
    for lane in range(len(lanes.commands)):
        copy(lanes.integers[lane], run.integers)
        copy(lanes.reals[lane], run.reals)
        _copy_rows(lanes.vectors[lane], run.vectors)
        _copy_rows(lanes.states[lane], run.states)
        call_address(going.address, (going.places, going.numbers))
        lanes.commands[lane] = int(going.numbers[command_at])
        copy(run.integers, lanes.integers[lane])
        copy(run.reals, lanes.reals[lane])
        _copy_rows(run.vectors, lanes.vectors[lane])
        _copy_rows(run.states, lanes.states[lane])


@kernel
def _copy_rows(given: np.ndarray, rows: np.ndarray) -> None:
    for i in range(len(rows)):
        copy(given[i], rows[i])


@entry()
def run_lanes_at_once(scene: Scene, run: Run, lanes: Lanes, slots: Slots) -> None:
    """Continue with all lanes until their methods want more than rates, or they have as many steps as they may.

    Parameters
    ----------
    scene : Scene
        Of which drives and values of loads are taken.
    run : Run
        What all lanes share of it.
    lanes : Lanes
    slots : Slots
    """
    waiting, in_slot, evaluation = 0, slots.lanes, slots.evaluation
    in_slot[:] = -1
    while True:
        first = -1
        for slot in range(len(in_slot)):
            if in_slot[slot] >= 0 and not _goes_on(_run_of(run, lanes, in_slot[slot]), lanes, in_slot[slot]):
                in_slot[slot] = -1
            while in_slot[slot] < 0 and waiting < len(lanes.commands):
                if _goes_on(_run_of(run, lanes, waiting), lanes, waiting):
                    in_slot[slot] = waiting
                    _put_constants(slots, waiting, slot)
                waiting += 1
            if in_slot[slot] >= 0:
                _put_state(scene, slots, _run_of(run, lanes, in_slot[slot]), in_slot[slot], slot)
                first = in_slot[slot] if first < 0 else first
        if first < 0:
            return
        for slot in range(len(in_slot)):
            if in_slot[slot] < 0:  # what is left in it may be no numbers any more
                _put_constants(slots, first, slot)
                _put_state(scene, slots, _run_of(run, lanes, first), first, slot)
        call_address(evaluation.address, (evaluation.places, evaluation.numbers))
        is_regular = evaluation.numbers[slots.done_at] != 0.0
        for slot in range(len(in_slot)):
            if in_slot[slot] >= 0:
                _take_rates(slots, step_of(_run_of(run, lanes, in_slot[slot])).slope, slot)
                if not is_regular:  # which of them has no inertia is told by the run of each alone
                    lanes.commands[in_slot[slot]] = NO_INERTIA
                    in_slot[slot] = -1


@inlined
def _run_of(run: Run, lanes: Lanes, lane: int) -> Run:
    """Return the run of a lane."""
    return Run(
        run.advance,
        run.interpolate,
        lanes.integers[lane],
        lanes.reals[lane],
        lanes.vectors[lane],
        run.table,
        run.times,
        lanes.states[lane],
        lanes.most[lane],
        run.clock,
    )


@kernel
def _goes_on(run: Run, lanes: Lanes, lane: int) -> bool:
    """Continue with a lane until it wants rates; tell whether it does, and keep what else it wants."""
    command = go_on(run)
    lanes.commands[lane] = command
    return command == Command.RATES


@kernel
def _put_constants(slots: Slots, lane: int, slot: int) -> None:
    """Write the numbers of the scene of a lane to a slot."""
    if len(slots.constants) > 0:
        for i in range(len(slots.held)):
            slots.held[i, slot] = slots.constants[lane, i]


@kernel
def _put_state(scene: Scene, slots: Slots, run: Run, lane: int, slot: int) -> None:
    """Write the state that a lane asks for to its slot, with drives and values of loads at its time."""
    step, drives, inputs, values = step_of(run), scene.drives, scene.inputs, slots.values
    at = step.at
    longest = put_drives(scene.motions, step.time_at, drives)
    if step.waiting == 0:
        step.largest_of_drives = longest
    if len(inputs) > 0:
        copy(values[lane if len(values) > 1 else 0], inputs)
        scene.fill(step.time_at, at, inputs)
    for i in range(len(drives)):
        for c in range(3):
            slots.drives[i, c, slot] = drives[i, c]
    for i in range(len(inputs)):
        slots.inputs[i, slot] = inputs[i]
    for i in range(len(at)):
        slots.vectors[VECTOR.at, i, slot] = at[i]


@kernel
def _take_rates(slots: Slots, slope: np.ndarray, slot: int) -> None:
    for i in range(len(slope)):
        slope[i] = slots.vectors[VECTOR.slope, i, slot]
