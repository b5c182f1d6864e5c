"""How much the small motions of a scene change as it moves, that is, with the azimuth of a rotor."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.linear.modes.eigenpairs import rate_weights
from kanefe.linear.small_motions import SmallMotions

SAMPLES = (0.37, 1.1, 2.6, 5.3)
"""Distances at which small motions are compared: rad or m of the fastest speed, or s."""

CONSTANT = 1e-7
"""Change of A relative to its rates that counts as zero: differences and projected loops leave about 1e-9."""

AT_REST = 1e-4
"""Change, likewise relative, of a scene at rest whose loads change with time, below which nothing is said."""


def times_ahead(model: Model, t: float, u: Vector) -> list[float]:
    """Return the later times (s) at which small motions are compared, from the fastest speed and the explicit time."""
    driven = model.driven_speeds(t)[0] if model.driven_count else np.zeros(0)
    fastest = float(max(np.abs(u).max(initial=0.0), np.abs(driven).max(initial=0.0)))
    times = [tau / fastest for tau in SAMPLES] if fastest > 0.0 else []
    if not model.route.is_constant or model.motions:
        times += list(SAMPLES)
    return [tau for tau in times if all(t + tau <= motion.span[1] for motion, _ in model.motions)]


def moved_on(model: Model, t: float, q: Vector, u: Vector, tau: float) -> tuple[Vector, Vector]:
    """Return the state after a time (s) with constant speeds, and with closed loops."""
    q_later = model.advance(q, tau * u)
    if not model.is_constrained:
        return q_later, u
    return model.literal.closed(t + tau, q_later, u)


def change_ahead(small: SmallMotions) -> float:
    """Return the change of A as the scene moves, relative to its largest rates, along one direction.

    All states take part in this random direction, with weights that make rates and positions comparable, so that any
    change of A changes the rates.
    """
    model, t = small.model, small.t
    weights = rate_weights(small.state_matrix(), len(small.positions.leading), arms=len(small.arms))
    direction = np.random.default_rng(0).standard_normal(len(weights)) / weights
    here = weights * small.rates_along(direction)
    size = float(np.abs(here).max(initial=0.0))
    still = small.u.copy()
    for body in model.bodies:
        if body.flexible is not None:
            still[body.flexible.speeds] = 0.0
    largest = 0.0
    for tau in times_ahead(model, t, still):
        try:
            q, u = moved_on(model, t, small.q, still, tau)
        except SimulationError:  # a mechanism that cannot move so far does change
            return 1.0
        later = SmallMotions(model, t + tau, q, np.where(still != 0.0, u, small.u), small.drives)
        if not np.array_equal(later.positions.leading, small.positions.leading):
            return 1.0
        change = weights * later.rates_along(direction) - here
        largest = max(largest, float(np.abs(change).max(initial=0.0)) / max(size, 1e-300))
    return 0.0 if largest < AT_REST and not small.is_moving else largest
