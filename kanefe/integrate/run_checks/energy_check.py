"""What a run is to be judged by: its balance of energy, and how far its bodies were bent."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationWarning, outside
from kanefe.integrate.status import NOTED, UNFIT
from kanefe.integrate.trajectory import Trajectory
from kanefe.tree.bending import Bending, worst_bending
from kanefe.tree.model_data import ModelData
from kanefe.tree.resolution import Resolution, worst_resolution
from kanefe.tree.scales import kept_of_scene, scene_length

ROUND_OFF = 1e-15
"""Energy relative to the largest possible one of the scene, including that of its weight, below which it has not moved.
"""


def account(model: Model, run: Trajectory) -> None:
    """Add "energy_balance", "bending" and "resolution" to the statistics of a run; warn of what is far off.

    "energy_balance": what is missing at the end, J, and its share of the largest energy of motion and deformation, or
    that was exchanged. "bending": the `Bending` of the body that is nearest to its reach, or farthest beyond.
    "resolution": the `Resolution` of the beam that bends far with the largest doubt.
    """
    bending = worst_bending(model, run.times, run.coordinates, run.bent)
    resolution = worst_resolution(model, run.times, run.coordinates)
    found = {"energy_balance": _balance(model, run), "bending": bending, "resolution": resolution}
    # lists, as files give them back
    run.statistics.update((name, list(told)) for name, told in found.items() if told)
    for text in remarks(run.statistics, model):
        warnings.warn(text, SimulationWarning, stacklevel=outside())
    if any(body.flexible is not None for body in model.bodies):
        from kanefe.equations.unstiffened import warn_of_axial_forces

        warn_of_axial_forces(model, run.times, run.coordinates, run.speeds)


def remarks(statistics: Mapping[str, Any], model: Model) -> list[str]:
    """Return a sentence with a remedy for each thing that is far off."""
    found = []
    missing, share = statistics.get("energy_balance", (0.0, 0.0))
    rtol = statistics.get("rtol")
    if rtol is not None and share > max(NOTED, UNFIT * rtol):
        doubtful = _doubtful(model)
        found.append(
            f"{statistics['method']} {'lost' if missing < 0.0 else 'gained'} {share:.2g} of the energy, which does not "
            f"fit rtol={rtol:g}. "
            + (f"It may be of {', or '.join(doubtful)}. Remedy: check that, and else" if doubtful else "Remedy:")
            + " a smaller rtol"
        )
    if "bending" in statistics and (bending := Bending(*statistics["bending"])).is_too_far:
        found.append(bending.remark)
    if "resolution" in statistics and (resolution := Resolution(*statistics["resolution"])).is_coarse:
        found.append(resolution.remark)
    return found


def _doubtful(model: Model) -> list[str]:
    """Return what takes part in a scene whose energy the run cannot know, or which only the user can tell."""
    found = [f"{load.kind} {load.name!r}, {load.unbooked}" for load in model.loads if load.unbooked]
    found += [
        f"load {load.name!r}, where its action does not tell all the power that it dissipates or gives"
        for load in model.loads
        if type(load).__module__.partition(".")[0] != "kanefe"
    ]
    return found + [
        f"{what}, where it jumps or its speed and acceleration are not the rates of its position"
        for motion, what in model.motions
        if motion.pieces is None
    ]


def _balance(model: Model, run: Trajectory) -> tuple[float, float] | None:
    """Return the energy that is missing at the end in J, and its share; of three states, since each takes a sweep."""
    rows = sorted({0, len(run.times) // 2, len(run.times) - 1})
    if len(rows) < 2:
        return None
    states = np.concatenate((run.coordinates[rows], run.speeds[rows], run.internal[rows]), axis=1)
    swept = model.route.sweeps(run.times[rows], states)
    if swept is not None:
        energies = swept.balances[:, :3].tolist()
    else:
        energies = [[*model.route.energy(float(run.times[i]), y)] for i, y in zip(rows, states, strict=True)]
    # of three numbers, for which Python takes less time than numpy
    totals = [kinetic + elastic + gravity for kinetic, elastic, gravity in energies]
    exchanged = (run.dissipated[rows] - run.work[rows]).tolist()
    missing = totals[-1] + exchanged[-1] - totals[0] - exchanged[0]
    scale = max(
        *(kinetic + elastic for kinetic, elastic, _ in energies),
        *(abs(total - totals[0]) for total in totals),
        float(run.dissipated.max()),
        float(run.work.max()),
        -float(run.work.min()),
    )
    least = ROUND_OFF * max(*map(abs, totals), _weight(model) * scene_length(model))
    if not (scale > least and math.isfinite(scale) and math.isfinite(missing)):
        return None
    return missing, abs(missing) / scale


@kept_of_scene
def _weight(model: ModelData) -> float:
    """Return the weight of all bodies, N."""
    mass = sum(
        part.mass for body in model.bodies for part in (body.rigid, body.flexible and body.flexible.body) if part
    )
    return float(mass * np.linalg.norm(model.gravity))
