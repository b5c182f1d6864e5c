"""The energy-momentum method: implicit midpoint on the group, with what the motion keeps kept by every step.

A step solves for accelerations z, and where the scene flies freely for a rigid motion r = (v, w) and a shift d of it:

    u+ = u + h z + b i + R r,    q+ = q moved by  s = h u' + b h^2/4 (R g - j) + T d,    u' = (u + u+) / 2,
    M z = F  where q is moved by s / 2, with the speeds u' and at half the step,
    energy + dissipated - work, momentum, angular momentum and straight flight of the centre of mass as at the start.

Columns of R and T are rigid motions and translations of the whole scene, i and j the parts of u' and z beyond those of
one rigid body, and g turns that body: with given momenta its energy depends on its attitude alone. So b changes the
energy by ``2 E_kin(i) + h^2/2 (E_kin(j) + E_kin(g))``, which is zero only where nothing changes. b, r and d are of the
size of the error of the midpoint rule, h^3, and order 2 stays (Hairer, Lubich & Wanner, Geometric Numerical
Integration, 2006, IV.4). All directions are those in the middle: the step is symmetric (V.4.1), a run backwards
returns.

Accelerations are iterated by the linearly implicit sweep, ``(M + h/2 C + h^2/4 K) dz = F - M z``: at once right for
stiff modes and springs; what is gyroscopic converges with the step. The end of the step is weighed with the z just
found, in which these are in balance with b and r: with the z before, a change of b strains modes by ``b i h / 2``,
whose energy is many times what b changes in truth, and b runs away as soon as ``h omega > 1``. z, b and r together are
then mixed by Anderson's acceleration, which finds the few directions in which they answer each other. They start
straight on from the last two steps; z of a mode turns by ``2 atan(h omega / 2)`` in each, and is turned on by that.

Loops are held by z in the middle, and those of the end of the step are closed before it is weighed.

What is kept is compared with its value at the start of the run, so that neither round-off nor an iteration left early
adds up over the steps.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import ADVANCE, INTERPOLATE, Vector, copy, dot, kernel, pointer
from kanefe.kernels.steppers.breakpoints import accept, clip
from kanefe.kernels.steppers.kept_quantities import (
    CLOSE,
    PUSH,
    SHARE,
    KeepingStep,
    along_and_about,
    correct,
    finish,
    keep,
    put_middle,
    put_z,
)
from kanefe.kernels.steppers.mixing import mix
from kanefe.kernels.steppers.moves import move, move_within
from kanefe.kernels.steppers.step_commands import Command, Reason, ask, fail, largest_share


class Limits(NamedTuple):
    """How far a step is solved."""

    many_sweeps: int = 30
    most_sweeps: int = 60
    solved: float = 10.0
    """Tolerance of the unknowns in multiples of `CLOSE`; the conserved quantities do not depend on it."""
    rough: float = 1e7
    """Accuracy of the accelerations, in multiples of `CLOSE`, that suffices to see which quantities are not
    conserved."""


LIMITS = Limits()


class Stage(IntEnum):
    """Where to go on."""

    BEGIN = 0
    REFERENCE = 1
    ITERATED = 2
    OF_MIDDLE = 3
    OF_Z = 4
    WEIGHED = 5
    NEXT = 6
    CLOSED = 7


@kernel
def _put_step(step: KeepingStep, x: np.ndarray) -> None:
    """Write the speeds in the middle and at the end and the move of the coordinates that follow from unknowns x."""
    n, h, b, keeps = step.coordinates, step.h, x[SHARE], step.keeps_momenta
    state, at, new, s, directions = step.state, step.at, step.new, step.way, step.directions
    turn = 0.25 * b * h * h
    push = Vector(0.0, 0.0, 0.0)
    spin = shift = shift_about = push
    if keeps:
        push = Vector(x[PUSH], x[PUSH + 1], x[PUSH + 2]) - b * step.v
        spin = Vector(x[PUSH + 3], x[PUSH + 4], x[PUSH + 5]) - b * step.w
        shift, shift_about = turn * step.v_of_z + step.shift, turn * step.w_of_z
    for i in range(n, n + step.speeds):
        pushed, shifted = h * x[i], -turn * x[i]
        if keeps:
            along, about = along_and_about(directions, i)
            pushed += dot(push, along) + dot(spin, about)
            shifted += dot(shift, along) + dot(shift_about, about)
        at[i] = (state[i] + 0.5 * pushed) / (1.0 - 0.5 * b)
        new[i] = 2.0 * at[i] - state[i]
        s[i] = h * at[i] + shifted


@kernel
def _ask_middle(step: KeepingStep) -> int:
    """Ask for z in the middle of the step."""
    n, m, h, state, at, z, half = step.coordinates, step.speeds, step.h, step.state, step.at, step.tried, step.slope
    by_damping, by_stiffness, way = step.damping_direction, step.stiffness_direction, step.way
    _put_step(step, z)
    for i in range(n, n + m):
        half[i] = 0.5 * way[i]
        by_damping[i] = 0.5 * h * z[i]
        by_stiffness[i] = 0.25 * h * h * z[i]
    move(step, state, half, n, at)
    copy(state[n + m :], at[n + m :])
    step.share_damping, step.share_stiffness = 0.5 * h, 0.25 * h * h
    step.time_at = step.time + 0.5 * h
    step.sweeps += 1
    return ask(step, Command.IMPLICIT, Stage.ITERATED)


@kernel
def _take_over(step: KeepingStep) -> float:
    """Write what is found of z, and the residual; return by how much the speeds change by it, of what is round-off."""
    n, end, h, state, scale = step.coordinates, step.coordinates + step.speeds, step.h, step.state, step.scale
    tried, found, slope, residual = step.tried, step.found, step.slope, step.residual
    copy(tried, found)
    for i in range(n, end):
        found[i] = slope[i]
        residual[i] = h * (slope[i] - tried[i]) / (CLOSE * abs(state[i]) + 0.1 * scale[i])
    return largest_share(step, residual, n, end)


@kernel
def _weigh_end(step: KeepingStep) -> int:
    """Write the state at the end of the step that follows from what is found, and ask for its balance."""
    n, m, h, state, new, slope = step.coordinates, step.speeds, step.h, step.state, step.new, step.slope
    _put_step(step, step.found)
    move(step, state, step.way, n, new)
    for i in range(n + m, len(new)):
        new[i] = state[i] + h * slope[i]
    if not step.has_loops:
        return _ask_balance(step)
    # closed is the state that there is: for that the end of the step takes its place
    copy(state, step.begun)
    copy(new, state)
    step.begun_at, step.time = step.time, step.time + h
    return ask(step, Command.PROJECT, Stage.CLOSED)


@kernel
def _take_closed(step: KeepingStep) -> int:
    """Take over the end of the step with its loops closed, and ask for its balance."""
    copy(step.state, step.new)
    copy(step.begun, step.state)
    step.time = step.begun_at
    return _ask_balance(step)


@kernel
def _ask_balance(step: KeepingStep) -> int:
    """Ask for the balance of the end of the step."""
    copy(step.new, step.at)
    step.time_at = step.time + step.h
    return ask(step, Command.BALANCE, Stage.WEIGHED)


@kernel
def _begin_step(step: KeepingStep) -> int:
    """Begin a step: straight on from the unknowns of the last two; modes that it does not resolve turn in each step."""
    if step.time >= step.stop:
        return ask(step, Command.DONE, Stage.NEXT)
    clip(step, step.next_step)
    tried, found, old, frequencies = step.tried, step.found, step.old, step.frequencies
    for i in range(len(tried)):
        square = (0.5 * step.h * frequencies[i]) ** 2
        tried[i] = 2.0 * (1.0 - square) / (1.0 + square) * found[i] - old[i]
    copy(found, old)
    step.sweeps = step.corrections = 0
    step.has_directions, step.change_left = False, np.inf
    return _ask_middle(step)


@kernel
def _iterate(step: KeepingStep) -> int:
    """Take in z of the middle of the step; weigh the end of the step where it is near enough."""
    before = step.change_left
    step.change_left = change = _take_over(step)
    diverges = step.sweeps > 4 and change > max(1e12, 0.5 * before)
    if diverges or not change < np.inf or step.sweeps > LIMITS.most_sweeps:
        return fail(step, Reason.NO_CONVERGENCE, Stage.NEXT)
    if step.has_directions:
        return _weigh_end(step)
    if change > LIMITS.rough:
        copy(step.found, step.tried)
        return _ask_middle(step)
    _put_step(step, step.found)
    return ask(step, Command.BALANCE, Stage.OF_MIDDLE)


@kernel
def _judge(step: KeepingStep) -> int:
    """Correct the unknowns by what the balance at the end says; accept the step where nothing is missing."""
    missing = correct(step)
    if not missing < np.inf:
        return fail(step, Reason.NO_CONVERGENCE, Stage.NEXT)
    # where round-off is above what is aimed at, what many sweeps leave is small enough
    if max(missing, step.change_left / LIMITS.solved) > (1.0 if step.sweeps < LIMITS.many_sweeps else 1e2):
        mix(step.memory, step.corrections, step.residual, step.found, step.tried)
        step.corrections += 1
        return _ask_middle(step)
    if step.keeps_momenta:
        finish(step)
    return accept(step, step.new, Stage.NEXT)


@pointer(ADVANCE)
def advance_keeping(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    step = KeepingStep(integers, reals, vectors)
    stage, n = step.stage, step.coordinates
    if stage == Stage.BEGIN:
        copy(step.state, step.at)
        step.time_at = step.time
        return ask(step, Command.BALANCE, Stage.REFERENCE)
    if stage == Stage.ITERATED:
        return _iterate(step)
    if stage == Stage.OF_MIDDLE:
        put_middle(step)
        copy(step.found[n : n + step.speeds], step.at[n:])
        return ask(step, Command.BALANCE, Stage.OF_Z)
    if stage == Stage.OF_Z:
        put_z(step)
        step.has_directions = True
        return _weigh_end(step)
    if stage == Stage.CLOSED:
        return _take_closed(step)
    if stage == Stage.WEIGHED:
        return _judge(step)
    if stage == Stage.REFERENCE:
        keep(step)
    return _begin_step(step)


@pointer(INTERPOLATE)
def interpolate_keeping(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: a cubic move that meets the speeds at both ends."""
    step = KeepingStep(integers, reals, vectors)
    copy(step.state, out)
    if t == step.time:
        return
    old, new, x = step.state_old, step.state, (t - step.time_old) / (step.time - step.time_old)
    move_within(step, step.way, t, out)
    for i in range(step.coordinates + step.speeds, len(out)):
        out[i] = (1.0 - x) * old[i] + x * new[i]
