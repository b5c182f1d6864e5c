"""Normal laws of contacts: what a depth and its rate give."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.calls import call_law
from kanefe.kernels.contact.contact_places import (
    ADDRESS,
    BY_FUNCTION,
    CONSTANTS,
    DAMPING,
    EXPONENT,
    HAS_FRICTION,
    HAS_RESTITUTION,
    HAS_SLOPES,
    IMPACT,
    KELVIN_VOIGT,
    LAW,
    PIECE,
    SOFTNESS,
    STIFFNESS,
    TABLE,
)


@inlined
def pressed(numbers: Any, share: float, depth: Any, rate: Any, states: Any) -> Any:
    """Return the normal force, its elastic part and the energy of that."""
    n, damping = numbers[EXPONENT], 0.0 * depth + numbers[DAMPING]
    softness = numbers[SOFTNESS]
    if softness > 0.0:  # ln(1 + exp(x)), without overflow
        x = depth / softness
        depth = softness * (x + np.log(1.0 + np.exp(-x)) if x.real > 0.0 else np.log(1.0 + np.exp(x)))
    if numbers[LAW] == BY_FUNCTION:
        return of_function(numbers, int(n), share, depth, rate)
    if numbers[HAS_RESTITUTION] > 0.0:
        damping = damping + states[IMPACT if numbers[HAS_FRICTION] > 0.0 else 0]
    if numbers[LAW] == TABLE:
        elastic, energy = of_table(numbers, int(n), share, depth)
    else:
        if n == 1.0:
            power = depth
        elif n == 1.5:
            power = depth * np.sqrt(depth)
        else:
            power = np.exp(n * np.log(depth))
        elastic = share * numbers[STIFFNESS] * power
        energy = elastic * depth / (n + 1.0)
    if numbers[LAW] == KELVIN_VOIGT:
        force = elastic + share * damping * rate
    else:
        force = elastic * (1.0 + damping * rate)
    if force.real < 0.0:
        force = 0.0 * force
    return force, elastic, energy


@kernel
def of_table(numbers: Any, at: int, share: float, depth: Any) -> Any:
    """Return the elastic force and its energy by a table: see `kanefe.contact.laws.table_law.TableLaw`."""
    piece, last = at + 1, at + 1 + PIECE * (int(numbers[at]) - 1)
    while piece < last and depth.real > numbers[piece + PIECE]:
        piece += PIECE
    f0, a, b, c = numbers[piece + 1], numbers[piece + 2], numbers[piece + 3], numbers[piece + 4]
    s = depth - numbers[piece]
    force = f0 + s * (a + s * (b + s * c))
    energy = numbers[piece + 5] + s * (f0 + s * (0.5 * a + s * (b / 3.0 + 0.25 * s * c)))
    return share * force, share * energy


STEP, LEAST_STEP = 1e-5, 1e-6
"""Steps of differences: relative to a depth and a rate, and the least step of a rate, m/s. Truncation and round-off
both leave 1e-10."""


@kernel
def of_function(numbers: Any, at: int, share: float, depth: Any, rate: Any) -> Any:
    """Return force, elastic part and energy by a function of the user, `kanefe.contact.laws.compiled_law.CompiledLaw`.

    It takes real numbers; complex ones, which carry derivatives, are led through its slopes.
    """
    address, own = int(numbers[at + ADDRESS]), at + CONSTANTS
    d, v = depth.real, rate.real
    force, elastic, energy, by_depth, by_rate = call_law(address, d, v, numbers, own)
    if force < 0.0:
        force, by_depth, by_rate = 0.0, 0.0, 0.0
    d_beside, v_beside = depth - d, rate - v
    if numbers[at + HAS_SLOPES] == 0.0 and force > 0.0 and (d_beside.imag != 0.0 or v_beside.imag != 0.0):
        h, h_rate = STEP * d, STEP * abs(v) + LEAST_STEP
        over, under = call_law(address, d + h, v, numbers, own)[0], call_law(address, d - h, v, numbers, own)[0]
        by_depth = (over - under) / (2.0 * h)
        over = call_law(address, d, v + h_rate, numbers, own)[0]
        under = call_law(address, d, v - h_rate, numbers, own)[0]
        by_rate = (over - under) / (2.0 * h_rate)
    press = share * (force + by_depth * d_beside + by_rate * v_beside)
    # what is taken is told, and nothing follows from it: the slope of the force serves for that of its elastic part
    return press, share * (elastic + by_depth * d_beside), share * (energy + elastic * d_beside)
