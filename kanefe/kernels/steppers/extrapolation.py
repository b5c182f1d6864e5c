"""The linearly implicit Euler method, extrapolated: order and step adaptive, one sweep a substep, no Newton iteration.

A substep treats the stiffness and damping of modes and joints implicitly, everything else explicitly:

    (M + h C + h^2 K) z = F - h K u,    u+ = u + h z,    q+ = q moved by h u+  (rotations by the exponential map).

Its error has an expansion in powers of h, whatever part of the forces is in C and K, so that the results of 1, 2, 3,
... substeps extrapolate to any order (Deuflhard 1985; Hairer & Wanner, Solving Ordinary Differential Equations II,
1996, IV.9). Stiff modes do not hold the step down. The dense output is a polynomial through the state at the start and
the state and its derivatives at the end, extrapolated from backward differences (Hairer & Ostermann 1990).
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import ADVANCE, copy, inlined, kernel, pointer
from kanefe.kernels.steppers import extrapolation_dense
from kanefe.kernels.steppers.breakpoints import accept, clip, end_of
from kanefe.kernels.steppers.moves import STRAIGHT, move, turn
from kanefe.kernels.steppers.step_commands import Command, Reason, ask, fail, scaled_size, wish


class Limits(NamedTuple):
    """Columns of a step, and from where on its errors count."""

    least_beside_kinks: int = 4
    largest_beside_kinks: int = 6
    """Least and largest number of columns for scenes whose forces have kinks: across a kink, the differences of many
    columns are no error estimate, and those of few are easily too small."""
    most_filterings: int = 2
    """Largest number of filterings of an error: each divides unresolved vibrations by their frequency times the
    substep."""
    near: float = 30.0
    """Error, in multiples of the tolerance, of the previous column below which the error of a column next to kinks is
    accepted."""
    kink: float = 100.0
    """Largest difference between the rates at the end of a step, relative to the step, and those of its dense output,
    in multiples of the tolerance. Without a kink it is below 10."""


LIMITS = Limits()


class Stage(IntEnum):
    """Where to go on."""

    BEGIN = 0
    MOVING = 1
    FILTERING = 2
    LOOKING = 3
    AFTER = 4
    PROJECTED = 5


@kernel
def _begin_column(step: extrapolation_dense.ExtrapolationStep, column: int) -> int:
    step.column, step.substep = column, 0
    copy(step.state, step.at)
    return _ask_substep(step)


@kernel
def _ask_substep(step: extrapolation_dense.ExtrapolationStep) -> int:
    n, h, at, by_damping, by_stiffness = (
        step.coordinates, step.h / step.column, step.at, step.damping_direction, step.stiffness_direction
    )  # fmt: skip
    for i in range(n, n + step.speeds):
        by_stiffness[i] = -h * at[i]
        by_damping[i] = 0.0
    step.share_damping, step.share_stiffness = h, h * h
    step.time_at = step.time + step.substep * h
    return ask(step, Command.IMPLICIT, Stage.MOVING)


@kernel
def _take_substep(step: extrapolation_dense.ExtrapolationStep) -> None:
    n, column, at, slope, way = step.coordinates, step.column, step.at, step.slope, step.stiffness_direction
    h = step.h / column
    if step.substep == 0:
        copy(slope, step.first_slope)
    for i in range(n, len(at)):
        at[i] += h * slope[i]
        way[i] = h * at[i]
    move(step, at, way, n, at)
    copy(at, step.substates[extrapolation_dense.first_substate(column) + step.substep])
    step.substep += 1


@kernel
def _take_column(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Put the result of the column into the tableau, and judge it."""
    column, new = step.column, step.at
    extrapolation_dense.extrapolate(step.tableau, column, 1, new, step.difference)
    step.error = np.inf
    if column > 1:
        step.filterings = 0
        step.error = scaled_size(step, step.difference, step.state, new)
    if step.is_fixed:
        return _begin_column(step, column + 1) if column < step.aim else _finish(step)
    return _begin_column(step, 2) if column == 1 else _filter_or_judge(step)


@kernel
def _most_columns(step: extrapolation_dense.ExtrapolationStep) -> int:
    return LIMITS.largest_beside_kinks if step.has_kinks else extrapolation_dense.LARGEST_COLUMNS


@kernel
def _filter_or_judge(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Have an error filtered that decides on the step, and could be one of vibrations only; else judge by it."""
    decides = 1.0 < step.error < np.inf and step.column >= step.aim - 1
    if decides and step.is_stiff and step.filterings < LIMITS.most_filterings:
        return _ask_filter(step)
    return _judge(step)


@kernel
def _ask_filter(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Request the sweep of the first substep again, with directional products for the last difference."""
    n, h, state, difference, moves = step.coordinates, step.h / step.column, step.state, step.difference, step.moves
    by_damping, by_stiffness = step.damping_direction, step.stiffness_direction
    copy(state, step.at)
    for i in range(n, n + step.speeds):
        by_damping[i] = h * difference[i]
        by_stiffness[i] = h * (h * difference[i] - state[i])
    for row in range(len(moves)):
        if moves[row, 0] == STRAIGHT:
            by_stiffness[n + moves[row, 2]] += h * difference[moves[row, 1]]
    step.time_at = step.time
    return ask(step, Command.IMPLICIT, Stage.FILTERING)


@kernel
def _filter(step: extrapolation_dense.ExtrapolationStep) -> None:
    """Replace the difference (a, b) of coordinates and speeds by what a substep makes of it, and find its size.

    That is ``b' = (M + h C + h^2 K)^-1 (M b - h K a)`` and ``a' = a + h b'``: slow motions stay, vibrations which the
    substep does not resolve are damped. They are damped in the result too, so that they need not hold the step down
    (as in Hairer & Wanner 1996, IV.8, for RADAU5).
    """
    n, difference, slope, first = step.coordinates, step.difference, step.slope, step.first_slope
    for i in range(n, n + step.speeds):
        difference[i] -= slope[i] - first[i]
    turn(step, step.state, step.h / step.column, difference, n, difference)
    step.error = scaled_size(step, difference, step.state, step.tableau[step.column - 1])
    step.filterings += 1


@inlined
def _work(column: int) -> float:
    """Return how many sweeps so many columns take."""
    return 0.5 * column * (column + 1)


@inlined
def _work_per_time(step: extrapolation_dense.ExtrapolationStep, column: int) -> float:
    return _work(column) / step.proposed[column]


@kernel
def _choose_next(step: extrapolation_dense.ExtrapolationStep) -> None:
    """Choose columns and length of the next step: the least work for the time (Hairer & Wanner 1996, IV.9)."""
    column, proposed, most = step.column, step.proposed, _most_columns(step) - 1
    best = min(column, most)
    if column > 2 and _work_per_time(step, column - 1) < 0.8 * _work_per_time(step, column):
        best = column - 1
    elif column > 2 and _work_per_time(step, column) < 0.9 * _work_per_time(step, column - 1):
        best = min(column + 1, most)
    if column == 2:
        best = 3
    if step.has_kinks:
        best = max(best, LIMITS.least_beside_kinks)
    if step.was_rejected:
        best = min(best, column)
        wanted = min(step.h, proposed[best])
    else:
        wanted = proposed[best] if best <= column else proposed[column] * _work(best) / _work(column)
    step.aim = best
    wish(step, wanted)


@kernel
def _begin_step(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Begin the next step, or the same one again with another length."""
    if step.time >= step.stop:
        return ask(step, Command.DONE, Stage.AFTER)
    if min(step.next_step, step.largest, step.largest_of_drives) < _least(step):
        return fail(step, Reason.TOO_SMALL, Stage.AFTER)
    clip(step, step.next_step)
    return _begin_column(step, 1)


@pointer(ADVANCE)
def advance_extrapolating(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    step = extrapolation_dense.ExtrapolationStep(integers, reals, vectors)
    stage = step.stage
    if stage == Stage.MOVING:
        _take_substep(step)
        return _ask_substep(step) if step.substep < step.column else _take_column(step)
    if stage == Stage.FILTERING:
        _filter(step)
        return _filter_or_judge(step)
    if stage == Stage.LOOKING:
        return _accept_last(step) if _kink(step) <= LIMITS.kink else _reject(step, 0.2)
    if stage == Stage.AFTER and step.has_loops:
        step.share_stiffness = (step.h / step.taken) ** 2  # in a metric of masses the loops would push stiff modes
        return ask(step, Command.PROJECT, Stage.PROJECTED)
    if stage == Stage.BEGIN and step.aim == 0:
        step.aim = min(6, _most_columns(step) - 1)
    return _begin_step(step)


@kernel
def _judge(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Accept the last result, continue with the next column, or give the step up for a shorter one."""
    column, aim, error = step.column, step.aim, step.error
    bounded = min(max(error, 1e-12), 1e12)
    step.proposed[column] = step.h * min(10.0, max(0.02, 0.94 * (0.65 / bounded) ** (1.0 / column)))
    before, step.error_before = step.error_before, error
    if error <= 1.0 and column >= aim - 1:
        if not step.has_kinks:
            return _finish(step)
        if column > 2 and before < LIMITS.near:
            return _look_ahead(step)
        if column < LIMITS.largest_beside_kinks:
            return _begin_column(step, column + 1)
    # the error that the columns to come would have to take away
    hopeless = 1.0
    for j in range(column + 1, aim + 2):
        hopeless *= j
    is_last = column >= min(aim + 1, _most_columns(step))
    if not is_last and ((column < aim - 1 and error < 1e8) or error <= 4.0 * hopeless):
        return _begin_column(step, column + 1)
    return _give_up(step)


@kernel
def _give_up(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Choose columns and length for another try of the step."""
    column = step.column
    best = min(max(min(step.aim, column), 2), _most_columns(step) - 1)
    is_cheaper = best > 2 and column >= best and _work_per_time(step, best - 1) < 0.8 * _work_per_time(step, best)
    if is_cheaper and not step.is_stiff:
        best -= 1
    step.aim = max(best, LIMITS.least_beside_kinks) if step.has_kinks else best
    # an error of vibrations hardly falls with the step until it resolves them: the longer steps are tried first
    least = 0.25 if step.is_stiff else 0.02
    return _reject(step, min(max(step.proposed[best] / step.h, least), 0.7))


@kernel
def _least(step: extrapolation_dense.ExtrapolationStep) -> float:
    """Return the smallest step for the columns aimed at: what they let grow, they do up to a step in proportion."""
    return step.smallest * min(step.aim + 1, extrapolation_dense.LARGEST_COLUMNS) / extrapolation_dense.LARGEST_COLUMNS


@kernel
def _reject(step: extrapolation_dense.ExtrapolationStep, share: float) -> int:
    """Give the step up for a share of it."""
    step.rejected += 1
    step.was_rejected = True
    step.next_step = share * step.h
    return fail(step, Reason.TOO_SMALL, Stage.AFTER) if step.next_step < _least(step) else _begin_step(step)


@kernel
def _finish(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Accept the last result of the tableau."""
    copy(step.tableau[step.column - 1], step.difference)
    left = end_of(step) - step.next_output
    if step.wants_dense or left > 0.0 or (left == 0.0 and step.settles != 0):
        extrapolation_dense.derive(step)
    return _accept_last(step)


@kernel
def _accept_last(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Accept the result that `_finish` or `_look_ahead` has kept."""
    if not step.is_fixed:
        _choose_next(step)
        step.was_rejected = False
    step.taken = step.column
    return accept(step, step.difference, Stage.AFTER)


@kernel
def _look_ahead(step: extrapolation_dense.ExtrapolationStep) -> int:
    """Ask for the rates at the end: what begins behind the last substep, such as a contact, no column has seen."""
    n, by_damping, by_stiffness = step.coordinates, step.damping_direction, step.stiffness_direction
    copy(step.tableau[step.column - 1], step.difference)
    extrapolation_dense.derive(step)
    copy(step.difference, step.at)
    for i in range(n, n + step.speeds):
        by_stiffness[i] = by_damping[i] = 0.0
    step.share_damping = step.share_stiffness = 0.0
    step.time_at = end_of(step)
    return ask(step, Command.IMPLICIT, Stage.LOOKING)


@kernel
def _kink(step: extrapolation_dense.ExtrapolationStep) -> float:
    """Return by how much of the tolerance the speeds change more over a step at the rates at its end than they did."""
    n, slope, change, first = step.coordinates, step.slope, step.substates[0], step.tableau[1]  # substates are free
    change[:] = 0.0
    for i in range(n, n + step.speeds):
        change[i] = step.h * slope[i] - first[i]
    return scaled_size(step, change, step.state, step.difference)
