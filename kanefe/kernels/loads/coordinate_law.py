"""The law of a spring, a damper and stops along one joint coordinate: force, energy and slopes."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from kanefe.kernels.algebra.vectors import Numbers
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.force_elements.blocks import places

CoordinateLaw = namedtuple("CoordinateLaw", "stiffness damping rest lower upper stop_stiffness stop_damping")
"""Numbers of the law: N/m, N s/m and m, or with N m and rad in the place of N and m."""

AT = places(CoordinateLaw)


@inlined
def coordinate_force(law: Any, position: Any, rate: Any) -> Numbers:
    """Return the conservative and the dissipative force along a coordinate."""
    conservative = -law[AT.stiffness] * (position - law[AT.rest])
    dissipative = -law[AT.damping] * rate
    beyond = 0.0 * position
    if position.real > law[AT.upper]:
        beyond = position - law[AT.upper]
    elif position.real < law[AT.lower]:
        beyond = position - law[AT.lower]
    if beyond.real != 0.0:
        stop, brake = -law[AT.stop_stiffness] * beyond, -law[AT.stop_damping] * rate
        if (stop + brake).real * beyond.real > 0.0:  # a stop never pulls
            brake = -stop
        conservative += stop
        dissipative += brake
    return conservative, dissipative


@inlined
def coordinate_potential(law: Any, position: Any) -> Any:
    """Return the energy in the spring and in the stops, J."""
    stretch = position - law[AT.rest]
    beyond = max(0.0, position - law[AT.upper], law[AT.lower] - position)
    return 0.5 * law[AT.stiffness] * stretch * stretch + 0.5 * law[AT.stop_stiffness] * beyond * beyond


@inlined
def coordinate_slopes(law: Any, position: float, rate: float) -> tuple[float, float]:
    """Return stiffness and damping at a coordinate and its rate: minus the slopes of the force."""
    stiffness, damping = law[AT.stiffness], law[AT.damping]
    beyond = 0.0
    if position > law[AT.upper]:
        beyond = position - law[AT.upper]
    elif position < law[AT.lower]:
        beyond = position - law[AT.lower]
    if beyond != 0.0 and (law[AT.stop_stiffness] * beyond + law[AT.stop_damping] * rate) * beyond > 0.0:
        stiffness += law[AT.stop_stiffness]
        damping += law[AT.stop_damping]
    return stiffness, damping
