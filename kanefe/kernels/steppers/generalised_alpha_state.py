"""What the generalised-alpha method keeps, the state that its unknowns lead to, and the one within a step.

Unknown are the accelerations du1 at the end of a step and, where loads have internal states that move, these: z1. With
the algorithmic accelerations a and the coefficients (Bruels, Cardona & Arnold 2012),

    (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) du1 + alpha_f du0,
    u1 = u0 + h ((1 - gamma) a0 + gamma a1),    q1 = q0 moved by  h u0 + h^2 ((1/2 - beta) a0 + beta a1).

Internal states are integrated by the backward difference of order 2, with the ratio r of the step to the one before:

    z1 = ((1 + r)^2 z0 - r^2 z_before + (1 + r) h dz1/dt) / (1 + 2 r);

what relaxes faster than a step is forgotten at once. The first step, and the one after an event, is Euler's.
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import INTERPOLATE, Array, copy, inlined, kernel, pointer
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING
from kanefe.kernels.steppers.moves import move, move_within
from kanefe.kernels.steppers.step_commands import DirectedStep, Row

AHEAD_SHARE = 1e-4
"""Time over which the rate of change of the accelerations is found, relative to the step."""


class AlphaStep(DirectedStep):
    """A step of the generalised-alpha method; most rows have what is of speeds and internal states in their places."""

    followed: int  # internal states
    takes_jacobian: bool  # a sweep does not know all that is stiff: the Newton matrix comes from the Jacobian
    has_stiffness: bool  # of modes or joints
    iteration: int
    mixed_from: int  # iterations before the last Jacobian, which are not mixed with others
    has_jacobian: bool
    is_fresh: bool  # the Jacobian was made in this step
    is_wanted: bool  # a Jacobian for the next iteration
    has_jerk: bool
    unconverged: int  # steps that were left before their iteration had converged
    halvings: int  # of the last Newton step
    jacobian_rows: int
    factor_size: int
    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    step_of_a: float  # after which a was found
    step_before: float  # the last state, 0: none
    factored: float  # step and share of the rates of the factors, 0: none
    factored_share: float
    correction: float  # size of the last one, of what is allowed
    first_unconverged: (
        float  # times of steps that were left early, and the largest correction such a one would have had
    )
    last_unconverged: float
    largest_left: float
    allowed: Row
    found: Row  # the unknowns
    at_start: Row
    before: Row  # at the start of the step before; with the quadratures the powers there, in `known` those of this step
    left: Row  # a and dz/dt at the start, as the last step left them
    begun: Row  # a as the step takes it, and at its end
    ends: Row
    jerk: Row  # rate of change of a
    way: Row  # move of the step
    known: Row  # part of z1
    change: Row  # the last correction
    tried: Row  # the next one, or the error
    residual: Row  # the same of what is allowed
    new: Row  # state at the end
    arm_rate: Row  # of states that follow a mode alone, see `kanefe.kernels.bodies.Arm`; 0: others
    arm_pull: Row
    arm_eta: Row  # places of the coordinate and of its speed in a row
    arm_deta: Row
    memory: Annotated[np.ndarray, Array(ROWS_OF_MIXING, "size")]
    jacobian: Annotated[np.ndarray, Array("jacobian_rows", "size")]  # or Z, W and X of directions
    factors: Annotated[np.ndarray, Array("factor_size", "factor_size")]
    pivots: Annotated[np.ndarray, Array("factor_size")]
    columns: Annotated[np.ndarray, Array("factor_size")]
    rest: Annotated[np.ndarray, Array("followed")]


@inlined
def span_of(step: AlphaStep) -> tuple[int, int, int]:
    """Return where in a row what belongs to speeds begins, and where it and internal states end."""
    n, m = step.coordinates, step.speeds
    return n, n + m, n + m + step.followed


@inlined
def _delay(step: AlphaStep, h: float) -> float:
    """Return by how much the time of a is after that of the state, s; below zero.

    So chosen at the start and where the step changes, it leaves order 2 to speeds, accelerations and constraint forces
    from the first step on (Arnold, Bruels & Cardona 2015).
    """
    return (step.alpha_m - step.alpha_f) * h


@kernel
def know_step(step: AlphaStep) -> None:
    """Write what a step has by its length: shares of C, K and of rates, the known part of z1, and a first guess."""
    (n, moving, end), h, last = span_of(step), step.h, step.step_before
    ratio = (1.0 - step.alpha_f) / (1.0 - step.alpha_m)  # derivative of a1 by du1
    step.share_damping = step.gamma * ratio * h
    step.share_stiffness = step.beta * ratio * h * h
    r = h / last if last > 0.0 else 0.0
    step.share_of_rates = (1.0 + r) * h / (1.0 + 2.0 * r) if step.followed > 0 else 0.0
    at_start, before, known, found = step.at_start, step.before, step.known, step.found
    for i in range(n, end):
        start = at_start[i]
        known[i] = ((1.0 + r) ** 2 * start - r * r * before[i]) / (1.0 + 2.0 * r)
        found[i] = start + r * (start - before[i])
    begun, left, jerk = step.begun, step.left, step.jerk
    later = _delay(step, h) - _delay(step, step.step_of_a) if step.has_jerk else 0.0
    for i in range(n, moving):
        begun[i] = left[i] + later * jerk[i]


@kernel
def reach(step: AlphaStep, out: np.ndarray) -> None:
    """Write a1, the move and the state that follow from the unknowns; the quadratures stay."""
    (n, moving, end), h, state, found = span_of(step), step.h, step.state, step.found
    alpha_m, alpha_f, gamma, beta = step.alpha_m, step.alpha_f, step.gamma, step.beta
    begun, ends, at_start, way = step.begun, step.ends, step.at_start, step.way
    for i in range(n, moving):
        a = begun[i]
        ends[i] = ((1.0 - alpha_f) * found[i] + alpha_f * at_start[i] - alpha_m * a) / (1.0 - alpha_m)
        way[i] = h * (state[i] + h * ((0.5 - beta) * a + beta * ends[i]))
        out[i] = state[i] + h * ((1.0 - gamma) * a + gamma * ends[i])
    move(step, state, way, n, out)
    _follow_arms(step, out)
    for i in range(moving, len(out)):
        out[i] = found[i] if i < end else state[i]


@kernel
def _follow_arms(step: AlphaStep, out: np.ndarray) -> None:
    """Write z1 of arms, which follows from the coordinates: a sweep has their stiffness."""
    (_, moving, end), found, known, rate, pull = span_of(step), step.found, step.known, step.arm_rate, step.arm_pull
    for i in range(moving, end):
        if rate[i] > 0.0:
            share = step.share_of_rates * rate[i]
            found[i] = (known[i] + share * pull[i] * out[int(step.arm_eta[i])]) / (1.0 + share)


@kernel
def move_arms(step: AlphaStep, row: np.ndarray) -> None:
    """Displace the states that are evaluated by what is left of changes of arms in a row while nothing else moves."""
    (_, moving, end), at, rate = span_of(step), step.at, step.arm_rate
    for i in range(moving, end):
        if rate[i] > 0.0:
            at[i] += row[i] / (1.0 + step.share_of_rates * rate[i])


@kernel
def answer_of_arms(step: AlphaStep, row: np.ndarray) -> None:
    """Write to a row what changes of arms in it become with the changes of accelerations in it."""
    (_, moving, end), rate, pull = span_of(step), step.arm_rate, step.arm_pull
    for i in range(moving, end):
        if rate[i] > 0.0:
            share = step.share_of_rates * rate[i]
            moved = step.share_stiffness * row[int(step.arm_deta[i])]
            row[i] = (row[i] + share * pull[i] * moved) / (1.0 + share)


@kernel
def put_end(step: AlphaStep) -> None:
    """Put what is to be evaluated: the end of the step, and for a linearly implicit evaluation what it is pushed by."""
    reach(step, step.at)
    push_by(step, step.found)
    step.time_at = step.time + step.h


@kernel
def push_by(step: AlphaStep, accelerations: np.ndarray) -> None:
    """Put the pushes with which a linearly implicit evaluation gives x of ``M x = F`` where x are the accelerations."""
    s, r, by_damping, by_stiffness = (
        step.share_damping, step.share_stiffness, step.damping_direction, step.stiffness_direction
    )  # fmt: skip
    for i in range(step.coordinates, step.coordinates + step.speeds):
        by_damping[i], by_stiffness[i] = s * accelerations[i], r * accelerations[i]


@kernel
def put_ahead(step: AlphaStep) -> None:
    """Put the state a little later, for the rate of change of the accelerations."""
    (n, moving, end), e = span_of(step), AHEAD_SHARE * step.h
    at, state, du, way, slope = step.at, step.state, step.at_start, step.way, step.slope
    copy(state, at)
    for i in range(n, moving):
        way[i] = e * (state[i] + 0.5 * e * du[i])
        at[i] = state[i] + e * du[i]
    move(step, state, way, n, at)
    for i in range(moving, end):
        at[i] += e * slope[i]
    step.time_at = step.time + e


@pointer(INTERPOLATE)
def interpolate_generalised_alpha(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: of third order, on the rotation group; powers are straight lines."""
    step = AlphaStep(integers, reals, vectors)
    copy(step.state, out)
    if t == step.time:
        return
    h, old, new, before, known = step.time - step.time_old, step.state_old, step.state, step.before, step.known
    x = (t - step.time_old) / h
    move_within(step, step.way, t, out)
    for i in range(step.coordinates + step.speeds, len(out) - 2):
        out[i] = (1.0 - x) * old[i] + x * new[i]
    for i in range(len(out) - 2, len(out)):
        out[i] = old[i] + h * x * (before[i] + 0.5 * x * (known[i] - before[i]))
