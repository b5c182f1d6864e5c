"""The method that suits a scene: what method="auto" takes, and why."""

from __future__ import annotations

import math

from kanefe.integrate.generalised_alpha import stiffest_rate
from kanefe.integrate.scales import modal_frequencies
from kanefe.model import Model

MOST_EXPLICIT_STEPS = 2000.0
"""Steps that the explicit method would need for the elastic modes, above which an implicit one is taken."""

MOST_SPEEDS = 150
"""Of a scene that Radau's method, whose work grows with their cube, is taken for."""

LEAST_RTOL_OF_SWEEPS = 3e-6
"""Below which vibrations have to be followed that the extrapolation resolves with more work than Radau's method."""


def suited(model: Model, start: float, stop: float, rtol: float | None) -> tuple[str, str]:
    """Return the name of the method that suits a scene, and the reason in words; for fixed steps without rtol.

    Not stiff: the explicit method of order 8. Stiff: the extrapolation, which treats modes and joint springs within the
    order-n sweep. Where something stiff is outside it (springs between frames), or the tolerance is too tight for it,
    Radau's method; where that is too much work, or forces have kinks, which both may step over, generalised-alpha.
    """
    if model.has_unreduced:
        return "generalised-alpha", "the highest modes of an unreduced body are stiff"
    rate = _fastest(model, start, stop)
    if not _is_stiff(rate, start, stop):
        return "dop853", "no stiff elastic modes"
    reason = f"elastic modes up to {rate / (2 * math.pi):.3g} Hz are stiff over {stop - start:g} s"
    if model.has_stops:
        return "generalised-alpha", f"{reason}, with stops or dry friction"
    beyond = {
        "springs between frames": model.has_interactions,
        "bodies in the nodal form": model.order_n is None,
    }
    names = [what for what, is_so in beyond.items() if is_so]
    if not names and (rtol is None or rtol >= LEAST_RTOL_OF_SWEEPS):
        return "extrapolation", reason
    reason += f", with {' and '.join(names)}" if names else f", and rtol={rtol:g} follows their vibrations"
    if model.free_count <= MOST_SPEEDS:
        return "radau5", reason
    return "generalised-alpha", f"{reason}, and {model.free_count} speeds are too many for radau5"


def _is_stiff(rate: float, start: float, stop: float) -> bool:
    # DOP853 is stable up to |h w| = 6, but where modes are excited its error control asks for |h w| of about 2
    return (stop - start) * rate / 2.0 > MOST_EXPLICIT_STEPS


def _fastest(model: Model, start: float, stop: float) -> float:
    """Return a rate in rad/s that the scene has at least, good enough to tell whether it is stiff."""
    is_elastic = any(body.flexible is not None or body.has_coordinate_forces for body in model.bodies)
    if not (is_elastic or model.has_interactions):
        return 0.0
    # of the bodies alone: motions of the whole scene are faster still, and need the mass of all of it
    alone = float(modal_frequencies(model).max(initial=0.0))
    return alone if _is_stiff(alone, start, stop) else stiffest_rate(model, start)
