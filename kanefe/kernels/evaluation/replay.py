"""The rates of the states of a run, all at once: a method of integration that visits states and takes no step."""

import numpy as np

from kanefe.kernels.language import ADVANCE, INTERPOLATE, copy, pointer
from kanefe.kernels.steppers.step_commands import Command, Step, ask

TIME_OF, STATE_OF = 0, 1


@pointer(ADVANCE)
def revisit(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Ask for the rates at one state after the other; write them in the place of the states.

    Rows of the table are a time (s) and a state; `steps` counts those that are done.
    """
    step = Step(integers, reals, vectors)
    if step.stage != 0:
        copy(step.slope, table[step.steps, STATE_OF:])
        step.steps += 1
    if step.steps == len(table):
        return Command.DONE.value
    step.time_at = table[step.steps, TIME_OF]
    copy(table[step.steps, STATE_OF:], step.at)
    return ask(step, Command.RATES, 1)


@pointer(INTERPOLATE)
def between_states(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write nothing: there are no steps to look into."""
