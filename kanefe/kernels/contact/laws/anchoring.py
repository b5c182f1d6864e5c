"""What friction by an anchor makes of a pull (Eq. 11): see `kanefe.kernels.contact.laws.friction_law`."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, plus, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.constraints.tolerances import HELD_BEYOND


@inlined
def pull_of(k: Any, c: Any, normal: Numbers, along: Numbers, w: Numbers) -> Numbers:
    """Return what spring and damper of an anchor ask for, of a stretch w and a velocity along the surface."""
    return plus(times(k, minus(w, times(dot(w, normal), normal))), times(c, along))


@inlined
def kept_of(size: Any, limit: Any, waits: bool) -> Any:
    """Return the share of a pull that friction can take, at most 1; beyond its limit where an event ends the stick."""
    most = HELD_BEYOND * limit if waits else limit
    if size.real <= 0.0 or size.real <= most.real:
        return 0.0 * size + 1.0
    return most / size


@inlined
def given_way(k: Any, c: Any, pull: Numbers, w: Numbers, kept: Any) -> tuple[Numbers, Numbers]:
    """Return the drag of a pull of which a share is kept, and the rate of the stretch."""
    tangential = times(kept, pull)
    return tangential, times(1.0 / c, minus(tangential, times(k, w)))
