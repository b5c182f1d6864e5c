"""Runs of a scene on the clock: CPU time, error, and what the method counted."""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.clocks import seconds
from benchmarks.goals import median
from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory

OURS = "kanefe"

WANTED_SECONDS, MOST_RUNS = 0.1, 9
"""Clock time until which a short run is repeated, s, and the largest number of repetitions."""

LOST = 1.0
"""Error as large as the bodies, m: the run failed."""

COUNTS = ("steps", "rejected", "evaluations", "factorisations", "jacobians")


class TookTooLong(Exception):
    """A run was ended for its time, which says nothing of its error."""


@dataclass(frozen=True)
class Point:
    """One run of a curve.

    Attributes
    ----------
    scene, side : str
        Name of the scene; who ran it.
    method : str
        As it was asked for.
    setting : str
        Tolerance or step.
    rtol, step : float or None
    error : float
        In the unit of the scene; NaN if the run failed.
    seconds : float
        CPU time, median; NaN if the run failed.
    chosen : str
        The method that "auto" chose, or the method itself.
    counts : dict
        What the method counted, as far as it does.
    remark : str
        Why a run failed.
    """

    scene: str
    side: str
    method: str
    setting: str
    rtol: float | None
    step: float | None
    error: float
    seconds: float
    chosen: str
    counts: dict[str, int]
    remark: str = ""

    @property
    def is_good(self) -> bool:
        """Whether the run came to its end."""
        return bool(np.isfinite(self.error))


def run(model: Model, scene: BenchScene, setting: Setting, most_seconds: float | None = None) -> Trajectory:
    """Run a model of a scene to its end.

    Raises
    ------
    SimulationError
        If it does not get there.
    TookTooLong
        If it takes more seconds than these by the clock on the wall.
    """
    found = _integrated(model, scene, setting, most_seconds=most_seconds)
    if found.status is not None and found.status.kind == "stopped":
        raise TookTooLong(f"{scene.name} by {setting.text}: {found.status}")
    found.raise_for_status()
    return found


def warm_up(model: Model, scene: BenchScene, setting: Setting) -> None:
    """Take one step: what is compiled for a method is not part of its runs."""
    with suppress(SimulationError):
        _integrated(model, scene, setting, most_steps=1)


def _integrated(model: Model, scene: BenchScene, setting: Setting, **limits: float | None) -> Trajectory:
    options: dict[str, Any] = {**setting.options, **limits}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # a run that fails is an answer here
        return integrate(model, (0.0, scene.end), output_step=scene.end / scene.outputs, progress=False, **options)


def point(
    model: Model,
    scene: BenchScene,
    setting: Setting,
    exact: np.ndarray,
    runs: int = MOST_RUNS,
    most_seconds: float | None = None,
) -> Point:
    """Return error and median time of a setting.

    Raises
    ------
    TookTooLong
        If a run takes more seconds than these by the clock on the wall.
    """
    made = partial(
        Point,
        scene=scene.name,
        side=OURS,
        method=setting.method,
        setting=setting.size,
        rtol=setting.rtol,
        step=setting.step,
    )
    kept: list[Trajectory] = []
    try:
        first = seconds(lambda: kept.append(run(model, scene, setting, most_seconds)))
    except SimulationError as failure:
        return made(error=np.nan, seconds=np.nan, chosen=setting.method, counts={}, remark=str(failure))
    times: list[float] = []
    # a long first run is as good as its repetition, but for what it compiled
    while len(times) < runs and (not times or sum(times) < WANTED_SECONDS):
        times.append(seconds(lambda: run(model, scene, setting)))
    told = kept[0].statistics
    error = scene.error(scene.measured(model, kept[0]), exact)
    return made(
        error=error if error < LOST else np.nan,
        remark="" if error < LOST else "left all bounds",
        seconds=min(first, median(times)) if len(times) == 1 else median(times),
        chosen=str(told["method"]),
        counts=counts_of(told),
    )


def counts_of(statistics: dict[str, Any]) -> dict[str, int]:
    """Return what a method counted."""
    return {name: int(statistics[name]) for name in COUNTS if name in statistics}
