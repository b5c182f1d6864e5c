"""Maps of the stability of a scene over its speed and a parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.linear.over_speed.modes_over_speed import ascending_speeds, modes_over_speed
from kanefe.linear.over_speed.stability_over_speed import StabilityMap, growth_of, stability_onsets

if TYPE_CHECKING:
    from kanefe.linear.state import Freezable


@checked
def stability_map(
    build: Callable[[float, float], Freezable | Model],
    speeds: Sequence[float] | np.ndarray,
    values: Sequence[float] | np.ndarray,
    *,
    balance: bool = True,
) -> StabilityMap:
    """Return the ranges of speed in which a scene is stable, for some values of a parameter.

    The limits between the given speeds are found as zeros of the growth of the fastest mode.

    Parameters
    ----------
    build : callable
        (speed in rad/s, value of the parameter) -> scene: see `campbell`.
    speeds : array_like, shape (S,)
        Ascending, at least two, rad/s. An instability between two of them is not detected.
    values : array_like, shape (P,)
        Values of the parameter.
    balance : bool
        As in `campbell`.

    Raises
    ------
    ModelError
        If speeds or values are not valid, or nothing rotates.
    SimulationError
        If a scene has no balance at a speed.

    Examples
    --------
    ``kf.stability_map(rotor, np.linspace(0, 600, 13), [500.0, 1000.0]).plot("stability.png")``
    """
    at = ascending_speeds(speeds, "a stability map")
    of = numbers(values)
    if of.ndim != 1 or not len(of) or not np.all(np.isfinite(of)):
        raise ModelError(f"the values of a stability map must be finite numbers, shape (P,), not {values!r}")
    if not callable(build):
        raise ModelError(f"stability_map needs a function of speed and value that returns a scene, not {build!r}")
    rows, found = [], []
    for value in of.tolist():
        scene = modes_over_speed(lambda speed, value=value: build(speed, value), at, balance)  # type: ignore[misc]
        modes = [scene.modes(float(speed)) for speed in at]
        # growth within round-off counts as zero
        rows.append(
            [growth if one.grows.any() else min(growth, 0.0) for one in modes for growth, _ in (growth_of(one),)]
        )
        scene.warn("stability_map")
        found.append(tuple(stability_onsets(scene.modes, at)))
    return StabilityMap(at, of, np.array(rows), tuple(found))
