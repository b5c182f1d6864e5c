"""The method of a run and its options, checked: the one asked for, or what method="auto" takes, and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha import stiffest_rate
from kanefe.integrate.methods.method import Method
from kanefe.integrate.methods.table import own_methods, row_for, serving
from kanefe.integrate.options import AUTO, RunOptions
from kanefe.integrate.stepper import StepControl, Stepper
from kanefe.integrate.vibrations import FIRST_SHARE, are_seen
from kanefe.tree.scales import modal_frequencies, state_scales

DEFAULT_RTOL = 1e-6

ATOL_SHARE = 0.1
"""Of rtol: the absolute tolerance where none is given."""

MOST_EXPLICIT_STEPS = 2000.0
"""Steps that the explicit method would need for the elastic modes, above which an implicit one is taken."""

MOST_SPEEDS = 150
"""Of a scene that Radau's method, whose work grows with their cube, is taken for."""

LOOSE_RTOL = 1e-4
"""From which on the extrapolation has less work than Radau's method, whatever vibrates."""

LEAST_RTOL_OF_SWEEPS = 1e-7
"""Below which vibrations have to be followed that any motion excites."""

FEW_PERIODS = 30.0
"""Of the slowest mode in a run: so many steps any method takes, which then follow its vibrations."""


@dataclass(frozen=True)
class Choice:
    """The method of a run.

    Attributes
    ----------
    name, reason : str
    make : callable
        (dynamics) -> stepper at the start of the run.
    control : dict of str to float
        The options that it follows, with their defaults.
    is_plugged : bool
        See `Method`.
    """

    name: str
    reason: str
    make: Callable[[Dynamics], Stepper]
    control: dict[str, float]
    is_plugged: bool = False


def choose(model: Model, options: RunOptions) -> Choice:
    """Return the method of a run.

    Raises
    ------
    ModelError
        If the method does not serve the scene, or an option makes no sense for it.
    """
    rtol, step, (start, stop) = options.rtol, options.step, options.span
    allowed = DEFAULT_RTOL if rtol is None else rtol
    control = StepControl(allowed, ATOL_SHARE * allowed if options.atol is None else options.atol, step)
    name, reason = options.method, "asked for"
    if name == AUTO:
        name, reason = suited(model, start, stop, allowed if step is None else None, control.atol)
    row = row_for(model, name)
    _check_options(row, options)
    make = partial(_stepper, row, start, stop, control)
    return Choice(name, reason, make, {"rtol": allowed} if step is None else {"step": step}, row.is_plugged)


def _stepper(row: Method, start: float, stop: float, control: StepControl, dynamics: Dynamics) -> Stepper:
    return row.make(dynamics, start, stop, control)


def _check_options(method: Method, options: RunOptions) -> None:
    """Refuse what a method does not follow, rather than ignore it."""
    rtol, atol, step = options.rtol, options.atol, options.step
    if rtol is not None and rtol < method.least_rtol:
        raise ModelError(
            f"rtol={rtol:g} is below the round-off of {method.name}. Remedy: {method.least_rtol:g} or more, or 'dop853'"
        )
    if step is None and not method.has_error_control:
        raise ModelError(f"{method.name} needs a step in s")
    if step is not None and not method.has_fixed_steps:
        raise ModelError(f"step has no meaning for {method.refuses_step or f'{method.name}, which chooses its own'}")
    if step is not None and rtol is not None:
        raise ModelError(f"rtol has no meaning for {method.name}, whose steps are fixed. Remedy: leave it out")
    if atol is not None and (step is not None or not method.takes_atol):
        raise ModelError(
            f"atol has no meaning for {method.name}, which "
            f"{'has no error control' if step is not None else 'scales errors by the size of the bodies'}. "
            "Remedy: leave it out"
        )


def suited(model: Model, start: float, stop: float, rtol: float | None, atol: float) -> tuple[str, str]:
    """Return the name of the method that suits a scene, and the reason in words; for fixed steps without rtol.

    `atol` is that of `StepControl`.

    Not stiff: the explicit method of order 8. Stiff: the extrapolation, which treats modes and joint springs within the
    order-n sweep, and steps over vibrations; Radau's method, which follows them with less work, where they are larger
    than the tolerance at the start or the run lasts few of their periods, and where something stiff is outside the
    sweep (springs between frames). Where that is outside and Radau's method too much work, or forces have kinks, which
    both may step over, generalised-alpha.
    """
    own = serving(model, *own_methods())
    if len(own) == 1:
        return own[0], f"the only one for {model.route.reason}"
    rate = _fastest(model, start, stop)
    if not _is_stiff(rate, start, stop):
        return "dop853", "no stiff elastic modes"
    reason = f"elastic modes up to {rate / (2 * math.pi):.3g} Hz are stiff over {stop - start:g} s"
    if model.states_move:
        return serving(model, "extrapolation", "dop853")[0], f"{reason}, and internal states of loads are followed"
    if model.has_stops:
        return "generalised-alpha", f"{reason}, with stops or dry friction"
    names = ["springs between frames"] if model.loads else []
    names += [obstacle.kind for obstacle in model.route.obstacles]
    if not names:
        followed = _followed(model, start, stop, rtol, atol)
        if not followed:
            return "extrapolation", reason
        reason += f", and {followed}"
    else:
        reason += f", with {' and '.join(names)}"
    if model.free_count <= MOST_SPEEDS:
        return "radau5", reason
    name = "generalised-alpha" if names else "extrapolation"
    return name, f"{reason}, and {model.free_count} speeds are too many for radau5"


def _followed(model: Model, start: float, stop: float, rtol: float | None, atol: float) -> str:
    """Return in words why vibrations are to be followed; nothing where they are not."""
    if rtol is None or rtol >= LOOSE_RTOL:
        return ""
    if rtol < LEAST_RTOL_OF_SWEEPS:
        return f"rtol={rtol:g} follows their vibrations"
    frequencies = modal_frequencies(model)
    if not np.any(frequencies > 0.0):
        return "vibrations on springs of joints are followed"
    slowest = float(frequencies[frequencies > 0.0].min())
    if (stop - start) * slowest < 2.0 * math.pi * FEW_PERIODS:
        return f"the slowest, of {slowest / (2 * math.pi):.3g} Hz, is followed"
    dynamics = Dynamics(model)
    y = dynamics.initial_state(start)
    if are_seen(dynamics, start, y, FIRST_SHARE * (stop - start), rtol, atol * state_scales(model)):
        return f"vibrate by more than rtol={rtol:g} at the start"
    return ""


def _is_stiff(rate: float, start: float, stop: float) -> bool:
    # DOP853 is stable up to |h w| = 6, but where modes are excited its error control asks for |h w| of about 2
    return (stop - start) * rate / 2.0 > MOST_EXPLICIT_STEPS


def _fastest(model: Model, start: float, stop: float) -> float:
    """Return a rate in rad/s that the scene has at least, good enough to tell whether it is stiff."""
    is_elastic = any(body.flexible is not None or body.has_coordinate_forces for body in model.bodies)
    if not (is_elastic or model.loads):
        return 0.0
    # of the bodies alone: motions of the whole scene are faster still, and need the mass of all of it
    alone = float(modal_frequencies(model).max(initial=0.0))
    return alone if _is_stiff(alone, start, stop) else stiffest_rate(model, start)
