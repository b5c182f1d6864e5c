"""The scenes of the benchmark by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from benchmarks.work_precision import rigid_chain, sliding_crank, spinning_arm, steel_bar, swinging_arm
from benchmarks.work_precision.scene import BenchScene
from kanefe.errors import ModelError

SCENES: dict[str, Callable[[], BenchScene]] = {
    **rigid_chain.SCENES,
    **spinning_arm.SCENES,
    **steel_bar.SCENES,
    **sliding_crank.SCENES,
    **swinging_arm.SCENES,
}

USUAL = ("S1", "S2", "S3", "S4", "C06", "demo")
"""Scenes that are run by default: one of each kind."""


def chosen_scenes(names: Sequence[str]) -> list[str]:
    """Return the names of the scenes asked for, upper and lower case the same; the usual ones if there are none.

    Raises
    ------
    ModelError
        If there is no such scene.
    """
    by_lower = {name.lower(): name for name in SCENES}
    unknown = [name for name in names if name.lower() not in by_lower]
    if unknown:
        raise ModelError(f"the benchmark has no scene {', '.join(unknown)}. It has: {', '.join(SCENES)}")
    return [by_lower[name.lower()] for name in names] or list(USUAL)
