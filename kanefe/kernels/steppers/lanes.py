"""Runs of one scene from several starts, one after another in the memory of one method: each is a lane."""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import IntegerRows, Integers, Prepared, RealRows, call_address, copy, entry, kernel
from kanefe.kernels.steppers.step_commands import Run


class Lanes(NamedTuple):
    """What each lane has for itself.

    Attributes
    ----------
    integers, reals, vectors : ndarray, shape (lanes, ...)
        Memory of the step of each, see `Run`; all vectors of a lane in one row.
    states : ndarray, shape (lanes, times * state)
        Its outputs.
    commands : ndarray of int, shape (lanes,)
        What its method wants in the end.
    """

    integers: IntegerRows
    reals: RealRows
    vectors: RealRows
    states: RealRows
    commands: Integers


@entry()
def run_lanes(going: Prepared, command_at: int, run: Run, lanes: Lanes) -> None:
    """Continue with each lane until its method wants what is not to be had in compiled code.

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
        _put_rows(lanes.vectors[lane], run.vectors)
        _put_rows(lanes.states[lane], run.states)
        call_address(going.address, (going.places, going.numbers))
        lanes.commands[lane] = int(going.numbers[command_at])
        copy(run.integers, lanes.integers[lane])
        copy(run.reals, lanes.reals[lane])
        _take_rows(run.vectors, lanes.vectors[lane])
        _take_rows(run.states, lanes.states[lane])


@kernel
def _put_rows(numbers: np.ndarray, rows: np.ndarray) -> None:
    width = rows.shape[1]
    for i in range(len(rows)):
        copy(numbers[i * width : (i + 1) * width], rows[i])


@kernel
def _take_rows(rows: np.ndarray, numbers: np.ndarray) -> None:
    width = rows.shape[1]
    for i in range(len(rows)):
        copy(rows[i], numbers[i * width : (i + 1) * width])
