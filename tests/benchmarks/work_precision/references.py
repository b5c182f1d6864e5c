"""References of the scenes: a run that is refined until it changes no more, kept on disk because it may take a minute.

One method, as two of different orders agree only where both have converged, which their own tolerances do not say.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.clocks import Disagreement
from benchmarks.work_precision.runs import run
from benchmarks.work_precision.scene import BenchScene
from kanefe.equations.model import Model
from kanefe.errors import FileError
from kanefe.storage.digest import digest
from kanefe.storage.files import cache_folder, write_whole

REFINEMENTS = 5
"""Largest number of refinements of a run."""

SAME_RATES = 1e-7
"""Difference of the initial rates, relative to the largest, above which a scene no longer agrees with that of a file.
"""


@dataclass(frozen=True, eq=False)
class Reference:
    """What a scene should give.

    Attributes
    ----------
    values : ndarray, shape (outputs, components)
        Of the quantity, in the unit of the scene.
    methods : (str, str)
        The finest run, whose values they are, and the one before it.
    agreement : float
        Their largest distance: errors near it cannot be told.
    """

    values: np.ndarray
    methods: tuple[str, str]
    agreement: float


def reference(scene: BenchScene, model: Model) -> Reference:
    """Return the reference of a scene, from disk if it was made before.

    Raises
    ------
    Disagreement
        If refining the run changes it by more than the scene allows, however fine it is.
    """
    path = _path(scene)
    rates = model.rhs(0.0, model.initial_state)
    found = _read(path, rates)
    if found is None:
        print(f"making the reference of {scene.name}, from {scene.reference.text} on", file=sys.stderr, flush=True)
        found = _converged(scene, model)
        _write(path, found, rates)
    return found


def _converged(scene: BenchScene, model: Model) -> Reference:
    """Return the first run that differs from the one before it by no more than the scene allows."""
    setting = scene.reference
    values = scene.measured(model, run(model, scene, setting))
    for _ in range(REFINEMENTS):
        before, others, setting = setting, values, setting.finer
        values = scene.measured(model, run(model, scene, setting))
        found = Reference(values, (setting.text, before.text), scene.error(values, others))
        if found.agreement <= scene.agreement:
            return found
    raise Disagreement(
        f"{scene.name} has no reference: {found.methods[0]} and {found.methods[1]} differ by {found.agreement:.2g} "
        f"{scene.unit}, {scene.agreement:.2g} are allowed"
    )


def _path(scene: BenchScene) -> Path:
    key = digest(
        name=scene.name,
        quantity=scene.quantity,
        end=scene.end,
        outputs=scene.outputs,
        parameters=scene.parameters,
        run=scene.reference.text,
        agreement=scene.agreement,
    )
    return cache_folder() / "bench" / f"{scene.name}-{key}.json"


def _read(path: Path, rates: np.ndarray) -> Reference | None:
    """Return the reference in a file; None if there is none, or it is of a scene that moves in another way."""
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        before = np.array(kept["rates"])
        if before.shape != rates.shape or np.abs(before - rates).max() > SAME_RATES * np.abs(rates).max():
            return None
        return Reference(np.array(kept["values"]), (kept["methods"][0], kept["methods"][1]), float(kept["agreement"]))
    except (OSError, ValueError, KeyError, IndexError, TypeError):
        return None


def _write(path: Path, found: Reference, rates: np.ndarray) -> None:
    kept = {
        "methods": found.methods,
        "agreement": found.agreement,
        "rates": rates.tolist(),
        "values": found.values.tolist(),
    }
    try:
        write_whole(path, lambda file: file.write(json.dumps(kept).encode()))
    except FileError as error:  # it is made again in the next run
        print(f"the reference of {path.stem} is not kept: {error}", file=sys.stderr, flush=True)
