"""Generalised-alpha and HHT on the rotation group, of order 2: see `generalised_alpha_state` for the formula.

Stable for elastic modes of any frequency, which are damped where the step does not resolve them. The unknowns are
iterated until ``M du1 = F`` at the end of the step. Where all that is stiff are modes, springs, dampers and stops along
joints, a linearly implicit sweep is a Newton step in order n, with matrices that are never old:

    (M + s C + r K) x = F + (s C + r K) du1,    x the next du1.

What it does not know (gyroscopic terms, functions of the user) converges with the step, and by Anderson's mixing. With
loads between frames the few directions in which they stiffen it are added. Arms of viscoelastic bodies that pull on one
mode each are part of the sweep, and their states follow from the coordinates. Else, with many of them, contacts of
flexible bodies, or loops and loads, the Newton matrix is made from the Jacobian. Directions and Jacobians are kept over
steps as long as the iteration converges fast: see `generalised_alpha_systems`.

An iteration has a bounded number of evaluations. One of a fixed step that has come near enough is left there, and
counted; a free step is shortened. Free steps follow the third-order part of the move, filtered by the same matrix so
that modes that they do not resolve do not hold them down.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import ADVANCE, copy, inlined, kernel, pointer
from kanefe.kernels.steppers import generalised_alpha_steps
from kanefe.kernels.steppers.breakpoints import has_jumped
from kanefe.kernels.steppers.generalised_alpha_state import AHEAD_SHARE, AlphaStep, know_step, span_of
from kanefe.kernels.steppers.generalised_alpha_systems import are_factored, factorise_newton, solve_newton
from kanefe.kernels.steppers.mixing import mix
from kanefe.kernels.steppers.step_commands import Command, ask, ask_rates


class Limits(NamedTuple):
    """From where on corrections count in a step."""

    first_share: float = 1e-4
    """First step of a run that chooses its steps, relative to its length."""
    converged: float = 1e-3
    """Largest correction that is the last one, in the displacement that it causes, relative to the error allowed."""
    slow: float = 0.25
    """Convergence rate above which an iteration has a new Jacobian."""
    most_halvings: int = 4
    """Number of times that a Newton step is halved."""


LIMITS = Limits()


@kernel
def _start(step: AlphaStep) -> int:
    """Take in the rates at the start, or those behind a jump."""
    n, moving, _ = span_of(step)
    slope, quadratures = step.slope, step.size - 2
    copy(slope[n:], step.left[n:])
    copy(slope[n:moving], step.at_start[n:moving])
    copy(step.state[moving:], step.at_start[moving:])
    copy(slope[quadratures:], step.known[quadratures:])
    step.has_jerk, step.step_of_a, step.step_before = False, 0.0, 0.0
    if step.next_step <= 0.0:
        step.next_step = LIMITS.first_share * (step.stop - step.time)
    return _go_on(step)


@kernel
def _go_on(step: AlphaStep) -> int:
    """Begin the next step, or end."""
    _, moving, end = span_of(step)
    copy(step.state[moving:end], step.at_start[moving:end])
    if step.time >= step.stop:
        return ask(step, Command.DONE, generalised_alpha_steps.Stage.AFTER)
    return generalised_alpha_steps.begin_step(step)


@kernel
def _take_ahead(step: AlphaStep) -> int:
    """Write the rate of change of a, from the rates a little later, before what the step does not resolve is taken."""
    (n, moving, end), jerk, slope, at_start = span_of(step), step.jerk, step.slope, step.at_start
    for i in range(n, moving):
        jerk[i] = (slope[i] - at_start[i]) / (AHEAD_SHARE * step.h)
    copy(at_start[n:moving], step.found[n:moving])
    jerk[moving:end] = 0.0
    copy(step.state, step.at)
    step.time_at = step.time
    is_made = step.has_jacobian and (step.most_directions == 0 or are_factored(step))
    if step.takes_jacobian and not is_made:
        return generalised_alpha_steps.ask_jacobian(step, generalised_alpha_steps.Stage.OF_JERK)
    return _filter_jerk(step)


@kernel
def _filter_jerk(step: AlphaStep) -> int:
    asked = generalised_alpha_steps.filter_row(step, step.jerk, generalised_alpha_steps.Stage.JERK_FILTERED)
    return asked if asked != Command.START else _use_jerk(step)


@kernel
def _use_jerk(step: AlphaStep) -> int:
    step.has_jerk = True
    know_step(step)
    return generalised_alpha_steps.ask_end(step)


@kernel
def _needs_jacobian(step: AlphaStep, is_differentiated: bool) -> bool:
    """Return whether there is no Jacobian, or no directions for this length of the step."""
    is_old = step.most_directions > 0 and not (is_differentiated or are_factored(step))
    return bool(step.is_wanted or is_old or not step.has_jacobian)


@kernel
def _iterate(step: AlphaStep, is_differentiated: bool) -> int:
    """Take the iteration that a linearly implicit evaluation has done, with what directions of loads add."""
    (n, moving, end), change, slope, found, new = span_of(step), step.change, step.slope, step.found, step.new
    for i in range(n, moving):
        change[i] = slope[i] - found[i]
    change[moving:end] = 0.0  # arms follow
    if step.takes_jacobian:
        if _needs_jacobian(step, is_differentiated):
            return generalised_alpha_steps.ask_jacobian(step, generalised_alpha_steps.Stage.DIFFERENTIATED)
        if not (are_factored(step) or factorise_newton(step)):
            return generalised_alpha_steps.shorten(step, 0.5 * step.h)
        solve_newton(step, change)
    size = generalised_alpha_steps.size_of(step, change)
    if not size < np.inf:
        return generalised_alpha_steps.shorten(step, 0.25 * step.h)
    is_slow = step.iteration > 0 and size > max(LIMITS.converged, LIMITS.slow * step.correction)
    if is_slow and step.takes_jacobian and not step.is_fresh:
        step.mixed_from = step.iteration
        return generalised_alpha_steps.ask_jacobian(step, generalised_alpha_steps.Stage.DIFFERENTIATED)
    copy(found, new)
    for i in range(n, moving):
        new[i] += change[i]
    if size <= LIMITS.converged:
        copy(new[n:moving], found[n:moving])
        return generalised_alpha_steps.finish(step)
    mix(step.memory, step.iteration - step.mixed_from, step.residual, new, found)
    return generalised_alpha_steps.go_on_or_leave(step, size)


@kernel
def _correct(step: AlphaStep, is_differentiated: bool) -> int:
    """Take a Newton step, after seeing to its matrix, or go back half of the last one if that has led away.

    Away is where the same matrix gives a larger correction (Deuflhard, Newton Methods for Nonlinear Problems, 2011,
    3.1): friction that begins to hold, or a contact that closes, sends Newton's method to and fro.
    """
    if _needs_jacobian(step, is_differentiated):
        return generalised_alpha_steps.ask_jacobian(step, generalised_alpha_steps.Stage.DIFFERENTIATED)
    if not (are_factored(step) or factorise_newton(step)):
        return generalised_alpha_steps.shorten(step, 0.5 * step.h)
    size = _newton_step(step)
    if not size < np.inf:
        return generalised_alpha_steps.shorten(step, 0.25 * step.h)
    share = 1.0
    if step.iteration > 0 and size > LIMITS.converged and not is_differentiated:
        if step.is_fixed and size > step.correction and step.halvings < LIMITS.most_halvings:
            step.halvings += 1
            share = -0.5
        elif size > LIMITS.slow * step.correction and (step.is_fixed or not step.is_fresh):
            return generalised_alpha_steps.ask_jacobian(step, generalised_alpha_steps.Stage.DIFFERENTIATED)
    _take_newton_step(step, share)
    if size <= LIMITS.converged:
        return generalised_alpha_steps.finish(step)
    return generalised_alpha_steps.go_on_or_leave(step, size if share > 0.0 else step.correction)


@kernel
def _newton_step(step: AlphaStep) -> float:
    """Write a Newton step to `tried`; return its size."""
    (n, moving, end), tried, found, slope, known = span_of(step), step.tried, step.found, step.slope, step.known
    for i in range(n, moving):
        tried[i] = found[i] - slope[i]
    for i in range(moving, end):
        tried[i] = found[i] - known[i] - step.share_of_rates * slope[i]
    solve_newton(step, tried)
    return generalised_alpha_steps.size_of(step, tried)


@kernel
def _take_newton_step(step: AlphaStep, share: float) -> None:
    """Take the step that is tried; with a share below zero go back so much of the last one."""
    (n, _, end), change, found = span_of(step), step.change, step.found
    if share > 0.0:
        copy(step.tried[n:end], change[n:end])
        step.halvings = 0
    for i in range(n, end):
        change[i] *= abs(share)
        found[i] -= change[i] if share > 0.0 else -change[i]


@inlined
def _take_jacobian(step: AlphaStep, is_fresh: bool) -> None:
    step.has_jacobian, step.is_fresh, step.is_wanted, step.factored = True, is_fresh, False, 0.0


@kernel
def _take_rates(step: AlphaStep, is_differentiated: bool) -> int:
    """Take in an evaluation of the end of the step."""
    if is_differentiated:
        _take_jacobian(step, True)
    # friction that begins to hold is not smooth: nothing is to be learnt for it from the last iterations
    if step.takes_jacobian and (step.most_directions == 0 or step.followed > 0):
        return _correct(step, is_differentiated)
    return _iterate(step, is_differentiated)


@pointer(ADVANCE)
def advance_generalised_alpha(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    step = AlphaStep(integers, reals, vectors)
    stage = step.stage
    if stage == generalised_alpha_steps.Stage.ITERATED or stage == generalised_alpha_steps.Stage.DIFFERENTIATED:
        return _take_rates(step, stage == generalised_alpha_steps.Stage.DIFFERENTIATED)
    if stage == generalised_alpha_steps.Stage.FILTERED:
        generalised_alpha_steps.take_filtered(step, step.tried)
        return generalised_alpha_steps.judge(step)
    if stage == generalised_alpha_steps.Stage.AFTER and step.has_loops:
        return ask(step, Command.PROJECT, generalised_alpha_steps.Stage.PROJECTED)
    if stage == generalised_alpha_steps.Stage.AFTER or stage == generalised_alpha_steps.Stage.PROJECTED:
        return ask_rates(step, generalised_alpha_steps.Stage.FIRST) if has_jumped(step) else _go_on(step)
    if stage == generalised_alpha_steps.Stage.BEGIN:
        return ask_rates(step, generalised_alpha_steps.Stage.FIRST)
    if stage == generalised_alpha_steps.Stage.FIRST:
        return _start(step)
    if stage == generalised_alpha_steps.Stage.AHEAD:
        return _take_ahead(step)
    if stage == generalised_alpha_steps.Stage.OF_JERK:
        _take_jacobian(step, False)  # it is that of the start
        return _filter_jerk(step)
    generalised_alpha_steps.take_filtered(step, step.jerk)
    return _use_jerk(step)
