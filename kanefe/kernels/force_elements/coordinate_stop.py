"""Stops along joint coordinates, with damping that grows with how far they give way (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from kanefe.kernels.algebra.vectors import Numbers
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import POTENTIAL, SIGNATURE, TAKEN, WATCH_SIGNATURE, WRENCHES, P, V

StopNumbers = namedtuple("StopNumbers", "lower upper stiffness impact least_speed")
"""Numbers of a stop: limits, N/m or N m/rad, lambda times the speed of an impact, and the least speed (m/s or rad/s)
that counts."""

AT = places(StopNumbers)


@called_by_address(*SIGNATURE)
def coordinate_stop(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the force along the coordinate; see `StopNumbers`."""
    d, way = beyond(numbers, ends)
    if d.real <= 0.0:
        return
    rate, elastic = way * ends[V], numbers[AT.stiffness] * d
    push = push_of(elastic, rate, states[0])
    out[POTENTIAL] = 0.5 * elastic * d
    out[TAKEN] = (push - elastic) * rate
    out[WRENCHES] = -way * push


@called_by_address(*WATCH_SIGNATURE)
def coordinate_stop_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is beyond a limit, for a touch and for a lift."""
    out[0] = out[1] = beyond(numbers, ends)[0]


@called_by_address(*WATCH_SIGNATURE)
def coordinate_stop_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write lambda as of an impact at the present speed."""
    out[1] = impact_damping(numbers[AT.impact], numbers[AT.least_speed], beyond(numbers, ends)[1] * ends[V])


@inlined
def impact_damping(impact: float, least_speed: float, speed: float) -> float:
    """Return lambda (s/m) of an impact at a speed (m/s), from lambda times the speed."""
    return impact / max(speed, least_speed)


@inlined
def push_of(elastic: Any, rate: Any, damping: Any) -> Any:
    """Return what a stop pushes back with, of what its spring does alone, at a rate outward; it does not pull."""
    push = elastic * (1.0 + damping * rate)
    return push if push.real >= 0.0 else 0.0 * push


@inlined
def beyond(numbers: Any, ends: Any) -> Numbers:
    """Return how far the coordinate is beyond the nearer limit, and the way outward there."""
    above, below = ends[P] - numbers[AT.upper], numbers[AT.lower] - ends[P]
    if above.real > below.real:
        return above, 1.0
    return below, -1.0
