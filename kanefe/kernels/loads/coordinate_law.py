"""The law of a spring, a damper and stops along one joint coordinate: force, energy and slopes."""

from typing import Any

from kanefe.kernels.language import Record, Rows, excess, held_brake, inlined


class CoordinateLaw(Record):
    """Numbers of the law: N/m, N s/m and m, or with N m and rad in the place of N and m."""

    stiffness: float
    damping: float
    rest: float
    lower: float
    upper: float
    stop_stiffness: float
    stop_damping: float


class CoordinateLaws(Rows[CoordinateLaw]):
    """The laws of a scene: of `Tables.laws`."""


@inlined
def beyond_stop(law: CoordinateLaw, position: Any) -> Any:
    """Return how far a coordinate is beyond a stop, below zero at the lower one."""
    return excess(position, law.lower, law.upper)


@inlined
def coordinate_force(law: CoordinateLaw, position: Any, rate: Any) -> tuple[Any, Any]:
    """Return the conservative and the dissipative force along a coordinate."""
    conservative, dissipative = -law.stiffness * (position - law.rest), -law.damping * rate
    beyond = beyond_stop(law, position)
    stop = -law.stop_stiffness * beyond
    return conservative + stop, dissipative + held_brake(stop, -law.stop_damping * rate, beyond)


@inlined
def coordinate_potential(law: CoordinateLaw, position: Any) -> Any:
    """Return the energy in the spring and in the stops, J."""
    stretch, beyond = position - law.rest, beyond_stop(law, position)
    return 0.5 * law.stiffness * stretch * stretch + 0.5 * law.stop_stiffness * beyond * beyond


@inlined
def coordinate_slopes(law: CoordinateLaw, position: float, rate: float) -> tuple[float, float]:
    """Return stiffness and damping at a coordinate and its rate: minus the slopes of the force."""
    beyond = beyond_stop(law, position)
    if beyond != 0.0 and (law.stop_stiffness * beyond + law.stop_damping * rate) * beyond > 0.0:
        return law.stiffness + law.stop_stiffness, law.damping + law.stop_damping
    return law.stiffness, law.damping
