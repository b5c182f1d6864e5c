"""Radau IIA of order 5: three stages, implicit, stable for modes of any frequency and damping.

Changes Z of the state at three nodes satisfy ``Z = h (A x I) F(Z)``. A transformation of the stages makes one real and
one complex system of the size of the state out of the Newton matrix (Hairer & Wanner, Solving Ordinary Differential
Equations II, 1996, IV.8, also for the choice of steps, for the error estimate and for when matrices are kept):

    (g - J) x = r,    g = gamma / h and (alpha + i beta) / h,    J = d(dy/dt)/dy.

`kanefe.kernels.steppers.radau_systems` reduces both to the size of the speeds. Euler parameters are integrated as they
are, and brought back to unit length after each step.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import ADVANCE, Matrix, Vector, copy, kernel, pointer
from kanefe.kernels.steppers.breakpoints import accept, clip, has_jumped
from kanefe.kernels.steppers.radau_polynomial import FARTHEST, STAGES, RadauStep, guess_changes, normalise
from kanefe.kernels.steppers.radau_systems import factorise_systems, solve_complex, solve_real
from kanefe.kernels.steppers.step_commands import (
    Command,
    Reason,
    ask,
    ask_rates,
    first_step,
    scaled_size,
    wish,
)


class Limits(NamedTuple):
    """From where on numbers count in a step."""

    largest_iterations: int = 7
    largest_if_fixed: int = 30
    """Largest number of iterations of a step, which is then shortened, and of a fixed step."""
    slow: float = 0.1
    """Convergence rate above which the Jacobian is computed again for the next step. It is large, since a Jacobian
    costs two to four evaluations per speed, and an iteration three."""
    outgrown: float = 10.0
    """Growth of the step since the last Jacobian that requires a new one. If stiffness has disappeared, such as that of
    a contact, an iteration seems to converge, because its matrix makes the remaining correction look small."""
    kept: float = 1.2
    """Growth of the step up to which the step and the factors are kept."""
    same: float = 1e-6
    """Difference of two steps, relative to them, that factors are kept over: those between samples differ by round-off,
    and the rate at which an iteration converges changes by no more than that."""
    safety: float = 0.9
    longer: float = 8.0
    shorter: float = 0.2


LIMITS = Limits()

ANEW, HELD_JUMPS = 1, 2
"""Number that tells of the first step whether it follows a start, an event or a jump; or a sample, where what is held
changes."""


class Newton(IntEnum):
    """What comes of an iteration."""

    GOES_ON = 0
    CONVERGED = 1
    DIVERGED = 2
    """Numbers of what comes of an iteration."""


class Stage(IntEnum):
    """Where to go on."""

    BEGIN = 0
    FIRST = 1
    DIFFERENTIATED = 2
    ITERATING = 3
    REFINED = 4
    AFTER = 5
    PROJECTED = 6


@kernel
def _transform(by: Matrix, source: np.ndarray, target: np.ndarray) -> None:
    """Write the products of a 3 x 3 matrix with three rows, also in place."""
    (a, b, c), (x, y, z) = (source[0], source[1], source[2]), (target[0], target[1], target[2])
    for i in range(len(a)):
        found = by @ Vector(a[i], b[i], c[i])
        x[i], y[i], z[i] = found.x, found.y, found.z


@kernel
def _shorten(step: RadauStep, share: float) -> bool:
    """Choose a share of the step for another try of it; return whether there is one."""
    step.rejected += 1
    step.is_wanted = step.rate_of_convergence > LIMITS.slow and not step.is_fresh
    if step.is_fixed:  # the Jacobian of an earlier state may be what is wrong
        step.reason = Reason.NO_CONVERGENCE
        return not step.is_fresh
    step.reason = Reason.TOO_SMALL
    step.next_step = share * step.h
    clip(step, step.next_step)
    return step.next_step >= step.smallest


@kernel
def _begin_step(step: RadauStep) -> int:
    """Begin a step, or the same step again with another length: see to its matrices, guess its changes."""
    while True:
        if step.is_wanted or (step.h > LIMITS.outgrown * step.differentiated_step and not step.is_fresh):
            step.jacobians += 1
            copy(step.state, step.at)
            step.time_at = step.time
            return ask(step, Command.JACOBIAN, Stage.DIFFERENTIATED)
        if abs(step.factored - step.h) <= LIMITS.same * step.h:
            break
        if factorise_systems(step):
            break
        step.rate_of_convergence = np.inf
        if not _shorten(step, 0.5):
            return ask(step, Command.FAILED, Stage.AFTER)
    guess_changes(step)
    _transform(step.T_inverse, step.changes, step.transformed)
    step.iteration = 0
    step.rate_of_convergence = 0.0
    # of how a much shorter step has converged nothing is known for this one
    is_like_last = step.has_polynomial and step.h <= FARTHEST * step.polynomial_step
    step.remaining = max(step.remaining, 1e-15) ** 0.8 if is_like_last else 1.0
    return _ask_node(step, 0)


@kernel
def _ask_node(step: RadauStep, node: int) -> int:
    step.node = node
    _put_state(step, step.changes[node])
    step.time_at = step.time + step.nodes[node] * step.h
    return ask(step, Command.RATES, Stage.ITERATING)


@kernel
def _put_state(step: RadauStep, change: np.ndarray) -> None:
    """Put a state that differs from the last one."""
    at, state = step.at, step.state
    for i in range(len(at)):
        at[i] = state[i] + change[i]


@kernel
def _solve(step: RadauStep) -> float:
    """Write the next correction of the transformed changes over the rates at the nodes; return its size."""
    h, rates, known = step.h, step.rates_at, step.transformed
    gamma, alpha, beta = step.gamma / h, step.alpha / h, step.beta / h
    _transform(step.T_inverse, rates, rates)
    a, b, c = rates[0], rates[1], rates[2]
    for i in range(len(a)):
        a[i] -= gamma * known[0, i]
        b[i] -= alpha * known[1, i] - beta * known[2, i]
        c[i] -= alpha * known[2, i] + beta * known[1, i]
    solve_real(step, a)
    solve_complex(step, b, c)
    size = 0.0
    for k in range(STAGES):
        size = max(size, scaled_size(step, rates[k], step.state, step.state))
    return size


@kernel
def _converges(step: RadauStep, size: float, enough: float) -> float:
    """Take in the size of a correction; return the share of the step to try instead, 0 where it converges."""
    iteration = step.iteration
    step.iteration += 1
    # what a jump of held drives does to stiff parts may push others once, by matrices of before: that tells no rate
    first = 2 if step.is_first == HELD_JUMPS and not step.is_fresh else 1
    if iteration < first:
        return 0.0
    ratio = size / step.correction
    rate = ratio if iteration == first else np.sqrt(ratio * step.ratio)
    step.ratio, step.rate_of_convergence = ratio, rate
    if not rate < 0.99:
        return 0.5
    step.remaining = rate / (1.0 - rate)
    left = (LIMITS.largest_if_fixed if step.is_fixed else LIMITS.largest_iterations) - 1 - iteration
    if left < 0:
        return 0.5
    missed = step.remaining * size * rate**left / enough
    if missed >= 1.0:  # it would take too many iterations
        return float(0.8 * min(max(missed, 1e-4), 20.0) ** (-1.0 / (4.0 + left)))
    return 0.0


@kernel
def _correct(step: RadauStep) -> tuple[int, float]:
    """Take one simplified Newton iteration; return what comes of it and, where it diverges, a share of the step."""
    size = _solve(step)
    if not size < np.inf:
        return Newton.DIVERGED, 0.5
    enough = max(1e-14 / step.relative, min(0.03, np.sqrt(step.relative)))
    share = _converges(step, size, enough)
    if share > 0.0:
        return Newton.DIVERGED, share
    step.correction = size
    transformed, corrections = step.transformed, step.rates_at
    for k in range(STAGES):
        for i in range(transformed.shape[1]):
            transformed[k, i] += corrections[k, i]
    _transform(step.T, transformed, step.changes)
    return (Newton.CONVERGED if step.remaining * size <= enough else Newton.GOES_ON), 0.0


@kernel
def _error(step: RadauStep, rates: np.ndarray) -> float:
    """Return the size of the error: the difference to a formula of order 3, which stiff parts are filtered out of."""
    error, weights, changes, h = step.estimate, step.weights, step.changes, step.h
    for i in range(len(error)):
        change = weights[0] * changes[0, i] + (weights[1] * changes[1, i] + weights[2] * changes[2, i])
        error[i] = change / h + rates[i]
    solve_real(step, error)
    _put_state(step, changes[2])
    return scaled_size(step, error, step.state, step.at)


@kernel
def _try_again(step: RadauStep, share: float) -> int:
    """Have the step begun again with a share of its length."""
    return Command.START.value if _shorten(step, share) else ask(step, Command.FAILED, Stage.AFTER)


@kernel
def _judge(step: RadauStep, error: float) -> int:
    """Accept a step and choose the next one, or reject it and return START."""
    h = step.h
    step.error = error
    most = 2.0 * LIMITS.largest_iterations
    safety = min(LIMITS.safety, LIMITS.safety * (1.0 + most) / (step.iteration + most))
    bounded = max(error, 1e-10)
    shrunk = bounded**0.25 / safety if error < np.inf else np.inf
    if not error < 1.0:
        step.was_rejected = True
        return _try_again(step, 0.1 if step.is_first == ANEW else max(1.0 / shrunk, LIMITS.shorter))
    shrunk = min(max(shrunk, 1.0 / LIMITS.longer), 1.0 / LIMITS.shorter)
    if step.is_first == 0:  # Gustafsson's predictive controller
        foreseen = step.old_step / h * (bounded * bounded / step.old_error) ** 0.25 / LIMITS.safety
        shrunk = max(shrunk, min(max(foreseen, 1.0 / LIMITS.longer), 1.0 / LIMITS.shorter))
    step.old_step, step.old_error = h, max(1e-2, error)
    grown = min(h / shrunk, h) if step.was_rejected else h / shrunk
    wish(step, h if step.rate_of_convergence <= LIMITS.slow and h <= grown <= LIMITS.kept * h else grown)
    return _finish(step)


@kernel
def _finish(step: RadauStep) -> int:
    """Accept the step; its polynomial stays."""
    for k in range(STAGES):
        copy(step.changes[k], step.polynomial[k])
    step.polynomial_step = step.h
    step.has_polynomial, step.is_first, step.was_rejected, step.is_fresh = True, 0, False, False
    step.is_wanted = step.rate_of_convergence > LIMITS.slow
    _put_state(step, step.changes[2])
    normalise(step, step.at)
    return accept(step, step.at, Stage.AFTER)


@kernel
def _take_node(step: RadauStep) -> int:
    """Take in the rates at a node; after the last one iterate, or judge the step. START: it is to begin again."""
    node = step.node
    copy(step.slope, step.rates_at[node])
    if node + 1 < STAGES:
        return _ask_node(step, node + 1)
    outcome, share = _correct(step)
    if outcome == Newton.GOES_ON:
        return _ask_node(step, 0)
    if outcome == Newton.DIVERGED:
        step.rate_of_convergence = np.inf
        step.was_rejected = True  # the error of what is left would ask for a step that fails again
        return _try_again(step, share)
    if step.is_fixed:
        return _finish(step)
    error = _error(step, step.start)
    if error >= 1.0 and (step.is_first != 0 or step.was_rejected):
        # once more from a state behind the transient, which the formula of order 3 does not damp well
        _put_state(step, step.estimate)
        step.time_at = step.time
        return ask(step, Command.RATES, Stage.REFINED)
    return _judge(step, error)


@kernel
def _begin(step: RadauStep) -> int:
    """Begin at the start, or behind an event or a sample."""
    if step.continues and step.differentiated_step > 0.0:
        # matrices and step are as good as before, but how the last iteration has converged tells nothing of the next
        step.is_first = HELD_JUMPS
    else:
        step.is_first, step.is_wanted, step.has_polynomial = ANEW, True, False
    step.remaining = 1.0
    return ask_rates(step, Stage.FIRST)


@kernel
def _take_first(step: RadauStep) -> int:
    copy(step.slope, step.start)
    if step.next_step <= 0.0:
        step.next_step = first_step(step, step.start)
    clip(step, step.next_step)
    return Command.START.value


@kernel
def _go_on(step: RadauStep) -> int:
    """Go on behind an accepted step, and once more when its loops are closed."""
    if step.stage == Stage.AFTER:
        step.share_stiffness = step.h**2  # in a metric of masses alone the loops would push stiff modes
        if step.time >= step.stop:
            return ask(step, Command.DONE, Stage.AFTER)
        if step.has_loops:
            return ask(step, Command.PROJECT, Stage.PROJECTED)
    if has_jumped(step):
        # vibrations may begin, which a long step would damp unseen; the Jacobian is that of before
        step.is_first, step.has_polynomial, step.remaining, step.next_step = ANEW, False, 1.0, 0.0
    return ask_rates(step, Stage.FIRST)


@pointer(ADVANCE)
def advance_radau(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    step = RadauStep(integers, reals, vectors)
    stage, command = step.stage, Command.START.value
    if stage == Stage.ITERATING:
        command = _take_node(step)
    elif stage == Stage.REFINED:
        command = _judge(step, _error(step, step.slope))
    elif stage == Stage.DIFFERENTIATED:
        step.is_wanted, step.is_fresh, step.factored = False, True, 0.0
        step.differentiated_step = step.h
    elif stage == Stage.BEGIN:
        return _begin(step)
    elif stage == Stage.FIRST:
        command = _take_first(step)
    else:
        return _go_on(step)
    return _begin_step(step) if command == Command.START else command
