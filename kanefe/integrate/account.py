"""What a run is to be judged by: its balance of energy, and how far linear bodies were bent."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationWarning
from kanefe.integrate.status import UNFIT
from kanefe.integrate.trajectory import Trajectory
from kanefe.tree.scales import displacement_scales, scene_length

NOTED = 0.01
"""Of the energy: what a run misses at least for a warning."""

BENT = 0.5
"""Of its length: deflections of a body above which a linear one says little."""


ROUND_OFF = 1e-15
"""Of the energy, weight included, that a scene has or might have: what moved less than that has not moved."""


def accounted(model: Model, run: Trajectory) -> Trajectory:
    """Return a run with "energy_balance" and "deflection" in its statistics; warn of what is far off.

    "energy_balance": what is missing at the end, J, and its share of the largest energy of motion and deformation, or
    that was exchanged. "deflection": the name of the body that is bent the most, and by how much of its length.
    """
    found = {"energy_balance": _balance(model, run), "deflection": _deflection(model, run)}
    # lists, as files give them back
    of_run = replace(run, statistics=run.statistics | {name: list(told) for name, told in found.items() if told})
    for text in remarks(of_run.statistics):
        warnings.warn(text, SimulationWarning, stacklevel=3)
    return of_run


def remarks(statistics: Mapping[str, Any]) -> list[str]:
    """Return a sentence with a remedy for each thing that is far off."""
    found = []
    missing, share = statistics.get("energy_balance", (0.0, 0.0))
    rtol = statistics.get("rtol")
    if rtol is not None and share > max(NOTED, UNFIT * rtol):
        found.append(
            f"{statistics['method']} {'lost' if missing < 0.0 else 'gained'} {share:.2g} of the energy, which does not "
            f"fit rtol={rtol:g}. Remedy: a smaller rtol"
        )
    name, bent = statistics.get("deflection", ("", 0.0))
    if bent > BENT:
        found.append(
            f"body {name!r} deflects by {bent:.3g} of its length, and a linear body holds to about a tenth of it. "
            "Remedy: check what drives it; a chain of several bodies where it is truly so soft"
        )
    return found


def _balance(model: Model, run: Trajectory) -> tuple[float, float] | None:
    """Return the energy that is missing at the end in J, and its share; of three states, since each takes a sweep."""
    rows = sorted({0, len(run.times) // 2, len(run.times) - 1})
    if len(rows) < 2:
        return None
    states = np.hstack((run.coordinates, run.speeds, run.internal))[rows]
    swept = model.route.sweeps(run.times[rows], states)
    if swept is not None:
        energies = swept.balances[:, :3]
    else:
        energies = np.array([model.route.energy(float(run.times[i]), y) for i, y in zip(rows, states, strict=True)])
    totals = energies.sum(axis=1)
    exchanged = run.dissipated[rows] - run.work[rows]
    balance = totals + exchanged - totals[0] - exchanged[0]
    scale = max(
        *(energies[:, 0] + energies[:, 1]),
        *np.abs(totals - totals[0]),
        float(run.dissipated.max()),
        float(np.abs(run.work).max()),
    )
    least = ROUND_OFF * max(float(np.abs(totals).max()), _weight(model) * scene_length(model))
    if not (scale > least and math.isfinite(scale) and math.isfinite(balance[-1])):
        return None
    return float(balance[-1]), float(abs(balance[-1]) / scale)


def _deflection(model: Model, run: Trajectory) -> tuple[str, float] | None:
    """Return the body that is bent the most, and by how much: as the amplitude of all its coordinates."""
    scales, worst = displacement_scales(model), ("", 0.0)
    for body in model.bodies:
        if body.flexible is not None:
            bent = run.coordinates[:, body.flexible.eta] / scales[body.flexible.speeds]
            worst = max(worst, (body.name, float(np.sqrt(np.square(bent).sum(axis=1)).max())), key=lambda pair: pair[1])
    return worst if worst[1] > 0.0 else None


def _weight(model: Model) -> float:
    """Return the weight of all bodies, N."""
    mass = sum(
        part.mass for body in model.bodies for part in (body.rigid, body.flexible and body.flexible.body) if part
    )
    return float(mass * np.linalg.norm(model.gravity))
