"""The extrapolation of linearly implicit Euler steps: see `kanefe.kernels.steppers.extrapolation`."""

from __future__ import annotations

from functools import cache

from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.kernel_set import Kernels, Memory
from kanefe.integrate.methods.method import Method, no_reactions
from kanefe.tree.route import Form

COLUMNS_OF_FIXED_STEPS = 6
"""Number of columns of an extrapolation with fixed steps: order 6."""


@cache
def _kernels() -> Kernels:
    from kanefe.kernels.steppers import extrapolation, extrapolation_dense

    return Kernels(
        advance=extrapolation.advance_extrapolating,
        interpolate=extrapolation_dense.interpolate_extrapolating,
        record=extrapolation_dense.ExtrapolationStep,
        is_implicit=True,
        settles_outputs=True,
        prepare=_prepare,
        restart_share=1.0,
        first_step=_first_step,
    )


def _prepare(memory: Memory) -> None:
    """Write what the estimate of errors has to know of forces, and the number of columns of fixed steps.

    After an event vibrations may begin, of which a long step would damp the estimate: it is followed by a radian of the
    fastest.
    """
    step, model = memory.step, memory.dynamics.model
    if (fastest := _fastest(memory)) > 0.0:
        step.longest_restart = 1.0 / fastest
    step.is_stiff = any(body.flexible is not None or body.has_coordinate_forces for body in model.bodies)
    step.has_kinks = memory.dynamics.has_kinks
    step.aim = COLUMNS_OF_FIXED_STEPS if step.is_fixed else 0


def _first_step(memory: Memory) -> float:
    """Return the first step: a long one would damp all vibrations, unseen by the estimate."""
    from kanefe.integrate.auto.vibrations import FIRST_SHARE, are_seen

    step = memory.step
    long = FIRST_SHARE * float(step.stop - step.time)
    if are_seen(memory.dynamics, float(step.time), step.state, long, float(step.relative), step.scale):
        return min(long, 1.0 / _fastest(memory))
    return long


def _fastest(memory: Memory) -> float:
    """Return the highest frequency of the bodies, rad/s; zero if none is flexible."""
    from kanefe.tree.scales import modal_frequencies

    return float(modal_frequencies(memory.dynamics.model).max(initial=0.0))


METHOD = Method(
    name="extrapolation",
    about="linearly implicit, one order-n sweep per substep: for stiff scenes",
    stepper=Compiled(_kernels),
    order=COLUMNS_OF_FIXED_STEPS,
    has_fixed_steps=True,
    takes_atol=True,
    least_rtol=1e-9,
    form=Form.SWEEPS,
    serves=no_reactions,
)
