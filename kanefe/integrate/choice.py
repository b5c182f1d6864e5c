"""The method that suits a scene: what method="auto" takes, and why."""

from __future__ import annotations

import math

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha import stiffest_rate
from kanefe.integrate.vibrations import FIRST_SHARE, are_seen
from kanefe.tree.scales import modal_frequencies, state_scales

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


def suited(model: Model, start: float, stop: float, rtol: float | None, atol: float) -> tuple[str, str]:
    """Return the name of the method that suits a scene, and the reason in words; for fixed steps without rtol.

    `atol` is that of `StepControl`.

    Not stiff: the explicit method of order 8. Stiff: the extrapolation, which treats modes and joint springs within the
    order-n sweep, and steps over vibrations; Radau's method, which follows them with less work, where they are larger
    than the tolerance at the start or the run lasts few of their periods, and where something stiff is outside the
    sweep (springs between frames). Where that is outside and Radau's method too much work, or forces have kinks, which
    both may step over, generalised-alpha.
    """
    if not model.route.is_dense:
        return "generalised-alpha", "the highest modes of an unreduced body are stiff"
    rate = _fastest(model, start, stop)
    if not _is_stiff(rate, start, stop):
        return "dop853", "no stiff elastic modes"
    reason = f"elastic modes up to {rate / (2 * math.pi):.3g} Hz are stiff over {stop - start:g} s"
    if model.has_stops:
        return "generalised-alpha", f"{reason}, with stops or dry friction"
    beyond = {
        "springs between frames": bool(model.loads),
        "bodies in the nodal form": not model.route.has_sweeps,
    }
    names = [what for what, is_so in beyond.items() if is_so]
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
