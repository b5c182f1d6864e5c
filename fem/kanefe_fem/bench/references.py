"""References of the scenes: two methods of the library that agree, kept on disk because they may take a minute."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import FileError
from kanefe.storage.digest import digest
from kanefe.storage.files import cache_folder, write_whole
from kanefe_fem.bench.clocks import Disagreement
from kanefe_fem.bench.runs import run
from kanefe_fem.bench.scene import BenchScene, Setting
from kanefe_fem.bench.settings import method_names

SAME_RATES = 1e-7
"""Difference of the rates at the start, as a part of the largest, above which a scene is no longer that of a file."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What a scene should give.

    Attributes
    ----------
    values : ndarray, shape (outputs, components)
        Of the quantity, in the unit of the scene.
    methods : (str, str)
        The two runs; the values are those of the first.
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
        If the two methods differ by more than the scene allows.
    """
    first, second = _pair(scene)
    path = _path(scene, first, second)
    rates = model.rhs(0.0, model.initial_state)
    found = _read(path, rates)
    if found is None:
        print(f"making the reference of {scene.name}: {first.text}; {second.text}", file=sys.stderr, flush=True)
        values, others = (scene.measured(model, run(model, scene, setting)) for setting in (first, second))
        found = Reference(values, (first.text, second.text), scene.error(values, others))
        if not found.agreement <= scene.agreement:
            raise Disagreement(
                f"{scene.name} has no reference: {first.text} and {second.text} differ by {found.agreement:.2g} "
                f"{scene.unit}, {scene.agreement:.2g} are allowed"
            )
        _write(path, found, rates)
    return found


def _pair(scene: BenchScene) -> tuple[Setting, Setting]:
    """Return the two runs for the reference: of different methods, both there."""
    there = method_names()
    by_method = {setting.method: setting for setting in reversed(scene.references) if setting.method in there}
    ordered = [setting for setting in scene.references if by_method.get(setting.method) is setting]
    if len(ordered) < 2:
        raise Disagreement(f"{scene.name} has no reference: it needs two of {[s.method for s in scene.references]}")
    return ordered[0], ordered[1]


def _path(scene: BenchScene, first: Setting, second: Setting) -> Path:
    key = digest(
        name=scene.name,
        quantity=scene.quantity,
        end=scene.end,
        outputs=scene.outputs,
        parameters=scene.parameters,
        runs=[first.text, second.text],
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
