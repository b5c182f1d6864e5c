"""How exactly modes are followed: relative to the largest force that the modes of their body have had.

A force is a stiffness times a deflection. Where a body is bent by a ten-thousandth of its length, an error that is a
share of the length is ten thousand times that share of the force. An error e of a mode makes the force ``m omega^2 e``,
so that allowed along it is, with the tolerance r of the run,

    e = r F / omega^2,    F = max over the run so far of |omega^2 eta|,

with deflections eta relative to what moves the body by its size, for which m is the same of all modes; and no more than
the tolerance of positions.
"""

import numpy as np

from kanefe.kernels.language import inlined, kernel
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.steppers.step_commands import Step


@kernel
def put_force_scales(step: Step) -> None:
    """Write what is allowed along the modes of each body whose force is larger than before in the state."""
    n, moves, state, unit, forces = step.coordinates, step.moves, step.state, step.unit, step.largest_forces
    scale, large, row = step.scale, step.large, 0
    while row < len(moves):
        body, first, total = _body(step, row), row, 0.0
        while row < len(moves) and _body(step, row) == body:
            at, i = moves[row, 1], n + moves[row, 2]
            total += (state[at] * unit[at] * _square(large, at, i)) ** 2
            row += 1
        at = moves[first, 1]
        if body == 0.0 or total <= forces[at]:
            continue
        forces[at] = total
        for k in range(first, row):
            at, i = moves[k, 1], n + moves[k, 2]
            allowed = step.of_forces * np.sqrt(total) / _square(large, at, i)
            scale[at] = min(max(allowed, step.least_allowed) / unit[at], large[at])
            scale[i] = scale[at] * large[i] / large[at]


@inlined
def _square(large: np.ndarray, at: int, i: int) -> float:
    """Return the square of the frequency of a mode, at least 1: scales of speeds are those of places times that."""
    return float((large[i] / large[at]) ** 2)


@inlined
def _body(step: Step, row: int) -> float:
    """Return the number of the body whose mode is in a row of the moves; 0 of joints."""
    moves = step.moves
    return 0.0 if moves[row, 0] != STRAIGHT else float(step.unit[step.coordinates + moves[row, 2]])
