"""The law of a spring, a damper and stops along one joint coordinate: force, energy and slopes."""

from typing import Any

from kanefe.kernels.language import Record, Rows, inlined


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
    if position.real > law.upper:
        return position - law.upper
    if position.real < law.lower:
        return position - law.lower
    return 0.0 * position


@inlined
def coordinate_force(law: CoordinateLaw, position: Any, rate: Any) -> tuple[Any, Any]:
    """Return the conservative and the dissipative force along a coordinate."""
    conservative, dissipative = -law.stiffness * (position - law.rest), -law.damping * rate
    beyond = beyond_stop(law, position)
    if beyond.real != 0.0:
        stop, brake = -law.stop_stiffness * beyond, -law.stop_damping * rate
        if (stop + brake).real * beyond.real > 0.0:  # a stop never pulls
            brake = -stop
        conservative += stop
        dissipative += brake
    return conservative, dissipative


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
