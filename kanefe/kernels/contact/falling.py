"""Friction that falls with the speed of slipping (Stribeck 1902; Bo & Pavelescu 1982), at an anchor that slips."""

from typing import Any

import numpy as np

from kanefe.kernels.language import Record, inlined
from kanefe.kernels.values.filled import filled

MOST_TRIALS, CLOSE = 60, 1e-15
"""Largest number of trials of Newton's method, and round-off relative to a speed or an anchor force."""


@inlined
def still_to_fall(slip: Any, speed: float, exponent: float) -> tuple[Any, Any]:
    """Return ``x = (slip / speed)^exponent`` and ``exp(-x)``: the share of the fall from rest that is still to come."""
    x = slip / speed
    x = x * x if exponent == 2.0 or x.real <= 0.0 else np.exp(exponent * np.log(x))
    return x, np.exp(-x)


class SteadyNumbers(Record):
    """Coefficients in steady sliding.

    Attributes
    ----------
    mu, holding : float
        Of fast sliding, and of the slowest.
    speed, exponent : float
        Over which speed one falls to the other (m/s; 0: at once), and how.
    viscous : float
        What the coefficient grows by with the speed, s/m.
    """

    mu: float
    holding: float
    speed: float
    exponent: float
    viscous: float


def steady_numbers(
    mu: float, holding: float, speed: float = 0.0, exponent: float = 2.0, viscous: float = 0.0
) -> SteadyNumbers:
    """Return coefficients by their numbers."""
    return SteadyNumbers(filled(SteadyNumbers, mu=mu, holding=holding, speed=speed, exponent=exponent, viscous=viscous))


@inlined
def steady_coefficient(friction: SteadyNumbers, slip: Any) -> Any:
    """Return the coefficient of friction in steady sliding at a speed, m/s."""
    mu = friction.mu + friction.viscous * slip
    if friction.speed > 0.0:
        mu += (friction.holding - friction.mu) * still_to_fall(slip, friction.speed, friction.exponent)[1]
    return mu


@inlined
def slip_speed(pull: Any, least: Any, fall: Any, damping: Any, speed: float, exponent: float) -> Any:
    """Return how fast an anchor slips (m/s): the root of ``c s + F(s) = pull``, 0 if there is none.

    ``F(s) = least + fall exp(-(s/speed)^exponent)``. Newton's method from above, halved where it would leave.

    Parameters
    ----------
    pull : float
        What spring and damper of the anchor ask for, N, above 0.
    least, fall : float
        Friction of fast slipping, and how much more it is at rest, N.
    damping : float
        Of the anchor, with what of friction grows with the speed, N s/m.
    speed : float
        In which it falls, m/s.
    exponent : float
    """
    s = pull / damping
    for _ in range(MOST_TRIALS):
        x, share = still_to_fall(s, speed, exponent)
        slope = damping - exponent * fall * share * x / s
        value = damping * s + least + fall * share - pull
        step = value / slope if slope.real > 0.0 else 0.5 * s
        is_found = abs(step.real) <= CLOSE * s.real or abs(value.real) <= CLOSE * pull.real
        s = s - step if (s - step).real > 0.5 * s.real else 0.5 * s
        if s.real * damping.real < 1e-12 * pull.real:
            return 0.0 * s
        if is_found:
            break
    return s
