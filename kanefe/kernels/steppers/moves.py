"""How coordinates move along the speeds: straight, or by turning Euler parameters."""

import numpy as np

from kanefe.kernels.joints.ball import put_turned
from kanefe.kernels.language import kernel
from kanefe.kernels.steppers.step_commands import Step

STRAIGHT = 0
"""Number of the kind of a move in which one coordinate follows one speed; else four parameters follow three."""


@kernel
def move(step: Step, q: np.ndarray, way: np.ndarray, first: int, moved: np.ndarray) -> None:
    """Write coordinates moved along the speeds by ``way[first:]``; rotations by the exponential map."""
    moves = step.moves
    for row in range(len(moves)):
        at, speed = moves[row, 1], first + moves[row, 2]
        if moves[row, 0] == STRAIGHT:
            moved[at] = q[at] + way[speed]
        else:
            put_turned(moved, at, q, way[speed], way[speed + 1], way[speed + 2])


@kernel
def move_within(step: Step, s: np.ndarray, t: float, out: np.ndarray) -> None:
    """Write coordinates and speeds at a time in the last step, of move s: a cubic that meets the speeds at both ends.

    The rates of the step serve as workspace.
    """
    n, h, old, new, part = step.coordinates, step.time - step.time_old, step.state_old, step.state, step.slope
    x = (t - step.time_old) / h
    for i in range(n, n + step.speeds):
        start, end = h * old[i], h * new[i]
        part[i] = x * (1.0 - x) ** 2 * start + x * x * (x - 1.0) * end + x * x * (3.0 - 2.0 * x) * s[i]
        out[i] = ((1.0 - x) * (1.0 - 3.0 * x) * start + x * (3.0 * x - 2.0) * end + 6.0 * x * (1.0 - x) * s[i]) / h
    move(step, old, part, n, out)


@kernel
def turn(step: Step, q: np.ndarray, h: float, speeds: np.ndarray, first: int, changes: np.ndarray) -> None:
    """Add to small changes of the coordinates q those of speeds ``speeds[first:]`` in a time h, to first order."""
    moves = step.moves
    for row in range(len(moves)):
        at, speed = moves[row, 1], first + moves[row, 2]
        if moves[row, 0] == STRAIGHT:
            changes[at] += h * speeds[speed]
            continue
        x, y, z = 0.5 * h * speeds[speed], 0.5 * h * speeds[speed + 1], 0.5 * h * speeds[speed + 2]
        e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
        changes[at] -= e1 * x + e2 * y + e3 * z
        changes[at + 1] += e0 * x + e2 * z - e3 * y
        changes[at + 2] += e0 * y - e1 * z + e3 * x
        changes[at + 3] += e0 * z + e1 * y - e2 * x
