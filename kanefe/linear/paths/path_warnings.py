"""What a path is warned of: where it ended, and where its points are beyond what the bodies can show."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import AccuracyWarning, SimulationWarning, outside
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.kane.unstiffened import warn_of_axial_forces
from kanefe.linear.paths.path_settings import WHAT
from kanefe.tree.bending import worst_bending
from kanefe.tree.resolution import worst_resolution

if TYPE_CHECKING:
    from kanefe.linear.paths.path_of_equilibria import EquilibriumPath


def warn_of_path(path: EquilibriumPath) -> None:
    """Warn of a path that ended early, of loads whose stiffness is not whole, and of what its bodies cannot show."""
    if not path.is_whole:
        warnings.warn(
            f"{WHAT}: the path ended {path.ended}. Remedy: more points=, or a shorter longest=; where a contact closes "
            "and bends it sharply, a softer one",
            SimulationWarning,
            stacklevel=outside(),
        )
    turning = [name for name, load in path.loaded.raised.items() if load is not None and load.is_spread and load.turns]
    if turning:
        warnings.warn(
            f"{WHAT}: {', '.join(turning)} turns with the frame of its body, and how the surface itself deforms is "
            "left out. Remedy: a chain of several bodies, each of which turns with its own frame",
            AccuracyWarning,
            stacklevel=outside(),
        )
    _warn_of_bodies(path)


def _warn_of_bodies(path: EquilibriumPath) -> None:
    """Warn of deformations beyond what bodies can show: each kind once, at its worst point or under the most load."""
    t, model = path.loaded.t, path.loaded.model
    q = np.array(list(path.coordinates.values())).reshape(-1, len(path)).T
    numbers = np.arange(len(path), dtype=float)  # instead of times: which point it is
    bending, resolution = worst_bending(model, numbers, q), worst_resolution(model, numbers, q)
    if bending is not None and bending.is_too_far:
        _warn_at(path, int(bending.time), bending._replace(time=t).remark)
    if resolution is not None and resolution.is_coarse:
        _warn_at(path, int(resolution.time), resolution._replace(time=t).remark)
    most = int(np.abs(path.factors).argmax())
    there, what = path.point(most), f"{WHAT}, at {path.factors[most]:.6g} times the loads"
    warn_of_missed(there, what)
    warn_of_axial_forces(there.model, np.array([t]), there.q[None], there.u[None], f"{what}: ")


def _warn_at(path: EquilibriumPath, number: int, remark: str) -> None:
    warnings.warn(
        f"{WHAT}, at {path.factors[number]:.6g} times the loads: {remark}", AccuracyWarning, stacklevel=outside()
    )
