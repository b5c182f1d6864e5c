"""Tasks of workers: build a case, run it, and record its results. They do not depend on the caller.

A row is a line of JSON: the parameters, the outputs, how the run ended, its warnings and times.
"""

from __future__ import annotations

import os
import pickle
import socket
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe._version import __version__
from kanefe.errors import KanefeError, ModelError, SimulationError
from kanefe.result import Result
from kanefe.storage.digest import code_stamp
from kanefe.storage.sealed import sealed
from kanefe.studies.workers.at_once import Begun, begun_at_once
from kanefe.studies.workers.case_warnings import CaseWarnings
from kanefe.studies.workers.time_limit import TimeIsUp, within
from kanefe.system import System

PACKAGE = Path(__file__).parents[2]

OF_STUDIES = ("checkpoint", "resume", "progress")
"""Options of runs that a study refuses, because it continues from its store."""

SCREENED = "screened"
"""Option with which the runs of a study are those of `kanefe.screen`."""

OF_SCREENED = ("spacing",)
"""Options that screened runs take and others do not."""


@dataclass(frozen=True)
class Work:
    """The work for each case.

    Attributes
    ----------
    build : function
        From the parameters to a System, or to (System, options of simulate).
    outputs : function
        From the Result to a dict of numbers.
    options : dict
        Options of ``System.simulate``.
    most_seconds : float or None
        Time limit of a case.
    """

    build: Callable[..., Any]
    outputs: Callable[[Result], Any]
    options: Mapping[str, Any]
    most_seconds: float | None = None

    @property
    def may_be_at_once(self) -> bool:
        """Whether cases may begin together: there is no time limit of each."""
        return self.most_seconds is None

    def built(self, parameters: Mapping[str, Any]) -> tuple[System, dict[str, Any]]:
        """Return the scene of a case, and the options of its run.

        Raises
        ------
        ModelError
            If build returns something else.
        """
        made = self.build(**parameters)
        made, own = made if isinstance(made, tuple) and len(made) == 2 else (made, {})
        if not isinstance(made, System) or not isinstance(own, Mapping):
            raise ModelError(
                f"build returned {type(made).__name__}, not a scene. Remedy: return the System, or (System, options of "
                "simulate)"
            )
        options = {**self.options, **own}
        refused = [name for name in OF_STUDIES if name in options]
        if refused:
            raise ModelError(
                f"{', '.join(refused)} cannot be given to the runs of a study, which continues from its store"
            )
        if "t_span" not in options:
            raise ModelError("the runs have no time span. Remedy: Study(..., duration=...) in s")
        return made, options

    def result(self, parameters: Mapping[str, Any], progress: bool | None) -> Result:
        """Return the full result of a case."""
        scene, options = self.built(parameters)
        return simulated(scene, options, progress)


def simulated(scene: System, options: Mapping[str, Any], progress: bool | None) -> Result:
    """Return the result of a scene, of a full or a screened run."""
    given = dict(options)
    if not given.pop(SCREENED, False):
        return scene.simulate(**given, progress=progress)
    from kanefe.screening.windows import screen

    return screen(scene, given.pop("t_span"), **given).result


class Case(NamedTuple):
    """One case: its number in the study, its key, and its parameters."""

    number: int
    key: str
    parameters: dict[str, Any]


class Done(NamedTuple):
    """Result of a block of cases: their lines, their number, the number of failures, and the duration (s)."""

    lines: str
    cases: int
    failed: int
    seconds: float


@cache
def stamp() -> str:
    """Return the identity of this kanefe: its version and a digest of its code."""
    return f"{__version__} ({code_stamp(PACKAGE)[:8]})"


def run_block(work: Work | bytes, expected: str, cases: Sequence[Case]) -> Done:
    """Run some cases, and return a line of JSON for each.

    Parameters
    ----------
    work : Work or bytes
        Pickled if it came from another process.
    expected : str
        The stamp of the calling kanefe.
    cases : sequence of Case

    Raises
    ------
    SimulationError
        If this worker has another kanefe, before any case is run.
    """
    task = ready(work, expected)
    began = time.perf_counter()
    begun = begun_at_once(task, [case.parameters for case in cases]) if task.may_be_at_once and len(cases) > 1 else []
    rows = [run_case(task, case, one) for case, one in zip_longest(cases, begun)]
    lines = "".join(f"{sealed(row)}\n" for row in rows)
    return Done(lines, len(rows), sum(row["status"] == "failed" for row in rows), time.perf_counter() - began)


def ready(work: Work | bytes, expected: str) -> Work:
    """Return the work, unpickled; raise a SimulationError on a worker with another kanefe."""
    if stamp() != expected:
        raise SimulationError(
            f"the worker {worker()} has kanefe {stamp()}, the study has {expected}. Remedy: the same version everywhere"
        )
    return work if isinstance(work, Work) else _unpickled(work)


@lru_cache(maxsize=2)
def _unpickled(work: bytes) -> Work:
    found: Work = pickle.loads(work)
    return found


def run_case(work: Work, case: Case, begun: Begun | None = None) -> dict[str, Any]:
    """Return the row of a case, which may have begun. Any error is recorded there, and does not stop other cases."""
    row: dict[str, Any] = {"case": case.number, "key": case.key, "parameters": case.parameters}
    wall, cpu = time.perf_counter(), time.thread_time()
    doing, collected = ["build"], CaseWarnings()

    def outcome() -> dict[str, Any]:
        with collected:
            return _outcome(work, case.parameters, doing, begun)

    try:
        row |= within(work.most_seconds, outcome)
    except TimeIsUp:
        row |= _failed(f"{doing[0]} was not done after {work.most_seconds:g} s (most_seconds=)")
    collected.close()
    before = begun or Begun()
    row["warnings"] = list(dict.fromkeys((*before.warnings, *collected.texts)))
    wall, cpu = time.perf_counter() - wall + before.wall, time.thread_time() - cpu + before.cpu
    return row | {"wall": wall, "cpu": cpu, "worker": worker()}


def failed_row(case: Case, reason: str) -> dict[str, Any]:
    """Return the row of a case that no worker could report."""
    row: dict[str, Any] = {"case": case.number, "key": case.key, "parameters": case.parameters}
    return row | _failed(reason) | {"warnings": [], "wall": 0.0, "cpu": 0.0, "worker": ""}


def _outcome(work: Work, parameters: Mapping[str, Any], doing: list[str], begun: Begun | None) -> dict[str, Any]:
    """Return the outcome of a case, which may have begun; `doing` holds the present phase."""
    try:
        scene, options = work.built(parameters) if begun is None else begun.built()
        doing[0] = "simulate"
        result = begun.result if begun is not None else None
        result = result or simulated(scene, options, progress=False)
        status = result.status
        if status.kind == "stopped" and status.reason == "by Ctrl-C":
            raise KeyboardInterrupt
        if status.kind == "failed":  # an incomplete run has no valid outputs
            return _failed(str(status), float(status.time))
        doing[0] = "outputs"
        outputs = checked_outputs(work.outputs(result), parameters)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - any error of a case is recorded
        return _failed(_reason(doing[0], error))
    reason = "" if status.is_finished else str(status)
    return {"status": status.kind, "reason": reason, "simulated": float(status.time), "outputs": outputs}


def _failed(reason: str, simulated: float | None = None) -> dict[str, Any]:
    return {"status": "failed", "reason": reason, "simulated": simulated, "outputs": {}}


def _reason(doing: str, error: BaseException) -> str:
    """Return the error, and its place unless it is an error of kanefe."""
    if isinstance(error, KanefeError):
        return f"{doing}: {error}"
    if isinstance(error, SystemExit):
        return f"{doing} {exit_in_words(error)}"
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{doing} raised {type(error).__name__}: {error} ({Path(place.filename).name}, line {place.lineno})"


def exit_in_words(error: SystemExit) -> str:
    """Return the description of a call of sys.exit."""
    return f"called sys.exit({'' if error.code is None else repr(error.code)})"


def checked_outputs(outputs: Any, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the outputs as Python's own numbers, texts and lists of numbers.

    Raises
    ------
    ModelError
        If they are no dict, have the name of a parameter or column, or a value of another type.
    """
    from kanefe.studies.cases import COLUMNS

    if not isinstance(outputs, Mapping):
        raise ModelError(f"it returned {type(outputs).__name__}, not a dict of numbers by name")
    for name in outputs:
        if not isinstance(name, str) or name in parameters or name in COLUMNS:
            raise ModelError(f"{name!r} is a parameter or another column of the table. Remedy: another name")
    return {name: _number(name, value) for name, value in outputs.items()}


def _number(name: str, value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple)):
        return [_number(name, item) for item in value]
    raise ModelError(f"{name!r} is a {type(value).__name__}, not a number, text, or array of numbers")


@cache
def worker() -> str:
    """Return the name of this process among all machines."""
    return f"{socket.gethostname()}:{os.getpid()}"
