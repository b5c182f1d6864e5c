"""Stops along joint coordinates, with damping that grows with how far they give way (Eq. 11)."""

from typing import Any

from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends, Wrenches
from kanefe.kernels.language import Record, Vector, called_by_address, inlined


class StopNumbers(Record):
    """Numbers of a stop: limits, N/m or N m/rad, lambda times the speed of an impact, the least speed that counts."""

    lower: float
    upper: float
    stiffness: float
    impact: float
    least_speed: float


@called_by_address(*SIGNATURE)
def coordinate_stop(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the force along the coordinate; see `StopNumbers`."""
    own, done = StopNumbers(numbers), Done(out)
    d, way = beyond(own, ends)
    if d.real <= 0.0:
        return
    rate, elastic = way * Ends(ends)[0].v.x, own.stiffness * d
    push = push_of(elastic, rate, states[0])
    done.potential = 0.5 * elastic * d
    done.taken = (push - elastic) * rate
    Wrenches(done.wrenches)[0].force = Vector(-way * push, 0.0, 0.0)


@called_by_address(*WATCH_SIGNATURE)
def coordinate_stop_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is beyond a limit, for a touch and for a lift."""
    out[0] = out[1] = beyond(StopNumbers(numbers), ends)[0]


@called_by_address(*WATCH_SIGNATURE)
def coordinate_stop_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write lambda as of an impact at the present speed."""
    own = StopNumbers(numbers)
    out[1] = impact_damping(own.impact, own.least_speed, beyond(own, ends)[1] * Ends(ends)[0].v.x)


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
def beyond(own: StopNumbers, ends: Any) -> tuple[Any, float]:
    """Return how far the coordinate is beyond the nearer limit, and the way outward there."""
    at = Ends(ends)[0].p.x
    above, below = at - own.upper, own.lower - at
    if above.real > below.real:
        return above, 1.0
    return below, -1.0
