"""Curves of error against CPU time: every method of a scene over its tolerances or steps."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from benchmarks.work_precision.references import Reference
from benchmarks.work_precision.runs import MOST_RUNS, Point, TookTooLong, point, warm_up
from benchmarks.work_precision.scene import BenchScene, Setting
from benchmarks.work_precision.settings import AUTO
from kanefe.errors import MissingDependency, ModelError

LONGEST, LONGEST_QUICK = 10.0, 1.0
"""CPU time of a run above which a curve ends, s; the second value is for quick runs."""

PATIENCE = 10.0
"""Wall-clock time after which a run is ended, in multiples of the CPU time above."""

FLOOR = 3.0
"""Error at which a curve ends, in multiples of the error of the reference."""

HOPELESS = 6
"""Number of successive failures from the start after which a method is skipped: an unstable method needs a small step.
"""


@dataclass(frozen=True)
class Limits:
    """How much a benchmark takes on.

    Parameters
    ----------
    quick : bool
        Every other tolerance or step, fewer repetitions, short runs only.
    """

    quick: bool = False

    @property
    def longest(self) -> float:
        """CPU time of a run in s above which a curve ends."""
        return LONGEST_QUICK if self.quick else LONGEST

    @property
    def runs(self) -> int:
        """How often a short run is repeated at most."""
        return 3 if self.quick else MOST_RUNS


def curve(scene: BenchScene, settings: Sequence[Setting], exact: Reference, limits: Limits) -> Iterator[Point]:
    """Yield the points of the settings of a method until one is as good as the reference or takes too long."""
    model, failures, slow = scene.build(), 0, 0
    for setting in settings:
        try:
            if setting is settings[0] or setting.method == AUTO:  # which may be another one from a tolerance on
                warm_up(model, scene, setting)
            found = point(model, scene, setting, exact.values, limits.runs, PATIENCE * limits.longest)
        except (ModelError, MissingDependency) as refusal:
            print(f"{scene.name}, {setting.text}: {refusal}", file=sys.stderr, flush=True)
            return
        except TookTooLong:
            slow += 1
            if slow > 1:
                return
            continue
        failures = 0 if found.is_good else failures + 1
        slow += found.seconds > limits.longest
        yield found
        # a coarse run of an explicit method may take longer than a fine one, and fail
        if failures > HOPELESS or (slow and found.is_good) or slow > 1 or found.error < FLOOR * exact.agreement:
            return


def settled(points: Iterable[Point], error: float) -> Point | None:
    """Return the fastest run that is at least this good, as all finer runs of its curve are; None if there is none.

    A coarse run may be good by luck: a finer one that is worse shows that it was.
    """
    kept: dict[tuple[str, bool], list[Point]] = {}
    for p in points:
        of = p.method, p.step is None
        if p.is_good and p.error <= error:
            kept.setdefault(of, []).append(p)
        else:
            kept[of] = []
    return min((p for good in kept.values() for p in good), key=lambda p: p.seconds, default=None)
