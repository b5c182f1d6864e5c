"""What a path is warned of: where it ended, and where its points are beyond what the bodies can show."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.unstiffened import warn_of_axial_forces
from kanefe.errors import AccuracyWarning, SimulationWarning, outside
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.linear.paths.path_settings import WHAT
from kanefe.tree.bending import worst_bending
from kanefe.tree.resolution import worst_resolution

if TYPE_CHECKING:
    from collections.abc import Callable

    from kanefe.linear.equilibrium.rest import Equilibrium
    from kanefe.linear.paths.loaded_scene import LoadedScene
    from kanefe.linear.paths.traced import Traced


def warn_of_path(loaded: LoadedScene, found: Traced, point: Callable[[int], Equilibrium]) -> None:
    """Warn of a path that ended early, of loads whose stiffness is not whole, and of what its bodies cannot show.

    `point` gives a point of the path as an equilibrium.
    """
    if not found.is_whole:
        warnings.warn(
            f"{WHAT}: the path ended {found.ended}. Remedy: more points=, or a shorter longest=; where a contact "
            "closes and bends it sharply, a softer one",
            SimulationWarning,
            stacklevel=outside(),
        )
    turning = [name for name, load in loaded.raised.items() if load is not None and load.turns_with_frame]
    if turning:
        warnings.warn(
            f"{WHAT}: {', '.join(turning)} turns with the frame of its body, and how the surface itself deforms is "
            "left out. Remedy: add_pressure(..., follows=True), or a chain of several bodies, each of which turns with "
            "its own frame",
            AccuracyWarning,
            stacklevel=outside(),
        )
    _warn_of_bodies(loaded, found, point)


def _warn_of_bodies(loaded: LoadedScene, found: Traced, point: Callable[[int], Equilibrium]) -> None:
    """Warn of deformations beyond what bodies can show: each kind once, at its worst point or under the most load."""
    t, model, factors = loaded.t, loaded.model, [stop.factor for stop in found.stops]
    q = np.array([stop.q for stop in found.stops])
    numbers = np.arange(len(q), dtype=float)  # instead of times: which point it is
    bending, resolution = worst_bending(model, numbers, q), worst_resolution(model, numbers, q)
    if bending is not None and bending.is_too_far:
        _warn_at(factors[int(bending.time)], bending._replace(time=t).remark)
    if resolution is not None and resolution.is_coarse:
        _warn_at(factors[int(resolution.time)], resolution._replace(time=t).remark)
    most = int(np.abs(factors).argmax())
    there, what = point(most), f"{WHAT}, at {factors[most]:.6g} times the loads"
    warn_of_missed(there, what)
    warn_of_axial_forces(there.model, np.array([t]), there.q[None], there.u[None], f"{what}: ")


def _warn_at(factor: float, remark: str) -> None:
    warnings.warn(f"{WHAT}, at {factor:.6g} times the loads: {remark}", AccuracyWarning, stacklevel=outside())
