"""Cases of a block that are alike: their scenes are built, and their runs evaluated at once, before their outputs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from kanefe.batches.lanes import Planned, SharedMemory, planned_beside
from kanefe.errors import KanefeError
from kanefe.integrate.options import RunOptions
from kanefe.result import Result
from kanefe.studies.workers.case_warnings import CaseWarnings
from kanefe.system import System


@dataclass(eq=False)
class Begun:
    """A case that has begun.

    Attributes
    ----------
    scene, options
        What was built.
    error : Exception, SystemExit or None
        What building has raised.
    plan : Planned or None
        Of the run, where it may be evaluated beside others.
    result : Result or None
        Of the run, where it was.
    warnings : list of str
    wall, cpu : float
        Time that it has taken so far, s.
    """

    scene: System | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    error: BaseException | None = None
    plan: Planned | None = None
    result: Result | None = None
    warnings: list[str] = field(default_factory=list)
    wall: float = 0.0
    cpu: float = 0.0

    def built(self) -> tuple[System, Mapping[str, Any]]:
        """Return what was built, or raise what was raised."""
        if self.error is not None:
            raise self.error
        return cast(System, self.scene), self.options


def begun_at_once(work: Any, cases: Sequence[Mapping[str, Any]]) -> list[Begun]:
    """Return the first cases of a block with their runs, as far as these are evaluated at once.

    Where the first case is not of that kind it is the only one that is returned, without its run; results are those of
    runs one by one.

    Parameters
    ----------
    work : Work
    cases : sequence of dict
        Parameters of each.
    """
    begun: list[Begun] = []
    asked: RunOptions | None = None
    first: Planned | None = None
    for parameters in cases:
        one = Begun()
        begun.append(one)
        with _timed(one):
            try:
                one.scene, one.options = work.built(parameters)
            except (Exception, SystemExit) as error:  # noqa: BLE001 - it is told in the row of the case
                one.error = error
                continue
            own = _asked(one.options)
            asked = asked or own
            if own is not None and _are_same(own, asked):
                one.plan = _planned(one.scene, own, one.options.get("start"), first)
        first = first or one.plan
        if first is None:
            return begun
    plans = [one.plan for one in begun if one.plan is not None]
    if len(plans) > 1:
        runs = SharedMemory(plans[0], cast(RunOptions, asked)).each(plans)
        for one in begun:
            if one.plan is not None:
                with _timed(one):
                    found = next(runs)
                    one.result = None if found is None else Result(one.plan.model, found)
    return begun


@contextmanager
def _timed(one: Begun) -> Iterator[None]:
    """Add time and warnings of what is inside to those of a case."""
    wall, cpu = time.perf_counter(), time.thread_time()
    collected = CaseWarnings()
    with collected:
        yield
    one.warnings += collected.texts
    one.wall, one.cpu = one.wall + time.perf_counter() - wall, one.cpu + time.thread_time() - cpu


def _asked(options: Mapping[str, Any]) -> RunOptions | None:
    """Return the options of a run; None of those that do more than a run, or that the run will refuse."""
    try:
        return RunOptions(**{name: value for name, value in options.items() if name != "start"})
    except (TypeError, KanefeError):
        return None


def _are_same(one: RunOptions, other: RunOptions | None) -> bool:
    """Return whether runs have the same options."""
    names = "span", "method", "rtol", "atol", "step"
    same = other is not None and all(getattr(one, name) == getattr(other, name) for name in names)
    return same and np.array_equal(one.times, cast(RunOptions, other).times)


def _planned(scene: System, asked: RunOptions, start: Any, first: Planned | None) -> Planned | None:
    """Return what a lane takes of a scene; None where its run is not alike, or will tell of an error."""
    try:
        return planned_beside(first, scene.freeze(asked.span[0], start), asked)
    except KanefeError:
        return None
