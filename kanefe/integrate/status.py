"""How a run ended.

A run told in a few lines: how it ended, what did it, and what it cost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from kanefe.errors import SimulationError
from kanefe.integrate.clock import OF_USER
from kanefe.tree.bending import Bending
from kanefe.tree.resolution import Resolution

Kind = Literal["finished", "stopped", "failed"]


@dataclass(frozen=True)
class RunStatus:
    """How a run ended, and what to do about it. Its text is one or two sentences.

    Attributes
    ----------
    kind : "finished", "stopped" or "failed"
        Stopped: by a terminal event or a limit that the call gave. Failed: it could not go on.
    time : float
        Up to which there are results, s.
    reason : str
        Why it ended before the end of the span; empty if it did not.
    remedy : str
        What to try.

    Examples
    --------
    >>> status = RunStatus("failed", 0.5, "no step is small enough", "check loads for jumps")
    >>> print(status)
    the run failed at t = 0.5 s: no step is small enough. Remedy: check loads for jumps
    >>> status.is_finished
    False
    """

    kind: Kind
    time: float
    reason: str = ""
    remedy: str = ""

    @property
    def is_finished(self) -> bool:
        """Whether the whole span was run."""
        return self.kind == "finished"

    def raise_if_failed(self) -> None:
        """Raise a SimulationError with the text of this status if the run failed."""
        if self.kind == "failed":
            raise SimulationError(str(self))

    def __str__(self) -> str:
        text = f"the run {'' if self.is_finished else 'was ' if self.kind == 'stopped' else ''}{self.kind}"
        text += f" at t = {self.time:.6g} s"
        if self.reason:
            text += f": {self.reason}"
        return text + (f". Remedy: {self.remedy}" if self.remedy else "")

    @classmethod
    def of_error(cls, time: float, error: Exception) -> RunStatus:
        """Return the status of a run that an error ended, whose text may hold a remedy."""
        reason, _, remedy = str(error).partition(". Remedy: ")
        return cls("failed", time, reason, remedy or "check what the functions of the scene give there")


def raised_by_user(time: float, error: Exception) -> RunStatus | None:
    """Return the status of a run at whose time (s) a function of the user raised an error; None: it was not one of it.

    It is one if the last call that this package made led to code that is of no other package either.
    """
    import sysconfig
    import traceback

    own, installed = str(Path(__file__).parents[1]), (sysconfig.get_paths()["stdlib"], "<frozen")
    frames = traceback.extract_tb(error.__traceback__)
    last = max((i for i, frame in enumerate(frames) if frame.filename.startswith(own)), default=len(frames))
    theirs = [
        frame
        for frame in frames[last + 1 :]
        if not frame.filename.startswith(installed) and "-packages" not in frame.filename
    ]
    if not theirs:
        return None
    notes = getattr(error, "__notes__", [])
    what = notes[0] if notes else f"a function of the user at t = {time:.6g} s"
    told = " ".join(str(error).split()) or "without a word"
    place = f"{theirs[-1].name}, line {theirs[-1].lineno} of {Path(theirs[-1].filename).name}"
    remedy = f"mend {theirs[-1].name}; what was found up to there is kept"
    if isinstance(error, ValueError) and "read-only" in told:
        remedy = "change a copy: functions look at the state of a run, and only what an action returns changes it"
    return RunStatus("failed", time, f"{what} raised {type(error).__name__}: {told[:300]} ({place})", remedy)


UNFIT = 10.0
"""Relative error of the energy, in multiples of rtol, that is permitted without a remark."""

SUMMED = 2.0
"""Relative error of the energy, in multiples of rtol, that a step may leave: it is of the state squared. Errors of
all steps add up at worst, and no method promises less."""

NOTED = 0.01
"""Smallest relative error of the energy for which a warning is issued."""

LISTED_EVENTS = 8
"""Number of events that a summary counts individually."""

LEAST_SECONDS = 5e-4
"""Time below which a part of a run is not reported, s."""


def _counted(events: Mapping[str, np.ndarray]) -> str:
    """Return how often each event happened; of many those that did most often."""
    if len(events) <= LISTED_EVENTS:
        return ", ".join(f"{name} {len(times)}" for name, times in events.items())
    often = sorted(events, key=lambda name: -len(events[name]))[:LISTED_EVENTS]
    shown = ", ".join(f"{name} {len(events[name])}" for name in events if name in often)
    total = sum(map(len, events.values()))
    return f"{shown} and others, {total} in all"


def summary(status: RunStatus, statistics: Mapping[str, Any], events: Mapping[str, np.ndarray]) -> str:
    """Return some lines about a run.

    Examples
    --------
    >>> counts = {"steps": 214, "rejected": 3, "evaluations": 2390, "factorisations": 0, "jacobians": 0}
    >>> told = {"method": "dop853", "reason": "no stiff elastic modes", "rtol": 1e-6, **counts, "seconds": 0.0125}
    >>> told |= {"route": "order n", "route_reason": "all parts of the scene have kernels"}
    >>> told["seconds_by_part"] = {"set-up": 0.0025, "steps": 0.01}
    >>> told["energy_balance"] = -2.5e-7, 3e-8
    >>> print(summary(RunStatus("finished", 5.0), told, {"floor": np.array([0.45, 1.2])}))
    the run finished at t = 5 s
      method  dop853 (no stiff elastic modes), rtol 1e-06
      route   order n (all parts of the scene have kernels)
      counts  214 steps, 3 rejected, 2390 evaluations
      time    0.0125 s: set-up 0.0025, steps 0.01
      energy  balance -2.5e-07 J at the end, 3e-08 of what moved
      events  floor 2
    """
    control = [f"{name} {statistics[name]:g}" for name in ("rtol", "step") if name in statistics]
    counts = [
        f"{value} {name}" for name, value in statistics.items() if isinstance(value, int) and (value or name == "steps")
    ]
    lines = [
        str(status),
        "  method  " + ", ".join((f"{statistics['method']} ({statistics['reason']})", *control)),
        f"  route   {statistics['route']} ({statistics['route_reason']})",
        "  counts  " + ", ".join(counts),
        _of_time(statistics),
    ]
    for name, tell in TOLD.items():
        if name in statistics:
            lines += tell(statistics)
    if events:
        lines.append("  events  " + _counted(events))
    return "\n".join(lines)


Statistics = Mapping[str, Any]


def _of_time(statistics: Statistics) -> str:
    parts = []
    for name, seconds in statistics["seconds_by_part"].items():
        if seconds >= LEAST_SECONDS:
            share = f" ({seconds / statistics['seconds']:.0%})" if name in OF_USER else ""
            parts.append(f"{name} {seconds:.3g}{share}")
    told = f"  time    {statistics['seconds']:.3g} s" + (f": {', '.join(parts)}" if parts else "")
    if "step_seconds" in statistics:
        most, longest = (f"{1e6 * seconds:.3g} us" for seconds in statistics["step_seconds"])
        told += f"; 99.9 % of the steps within {most}, all within {longest}"
    return told


def _of_trials(statistics: Statistics) -> list[str]:
    lines = [f"  {'tried' if i == 0 else '':7} {text}" for i, text in enumerate(statistics["tried"])]
    if not lines:
        return []
    return [*lines, f"          trials in all: {statistics['tried_share']:.1%} of the work of the run"]


def _of_iterations(statistics: Statistics) -> list[str]:
    count, first, last, largest = statistics["unconverged"]
    where = f"{count:.0f} steps, from t = {first:.6g} s to {last:.6g} s"
    return [f"  left    before the iteration had converged: {where}, by up to {largest:.1g} of the bodies' size"]


def _of_contacts(statistics: Statistics) -> list[str]:
    deepest, left = statistics["penetration"], statistics["contact_residual"]
    lowered, literal = statistics.get("restitution_lowered"), statistics.get("steps_in_python")
    more = f"; restitution lowered {lowered} times, where impacts would have made energy" if lowered else ""
    more += f"; {literal} steps in Python" if literal else ""
    return [f"  contact up to {deepest:.3g} m deep, impulses to {left:.2g} of the largest speed{more}"]


def _of_energy(statistics: Statistics) -> list[str]:
    missing, share = statistics["energy_balance"]
    rtol = statistics.get("rtol")
    fits = share if rtol is None else rtol * max(UNFIT, min(SUMMED * statistics["steps"], NOTED / rtol))
    unfit = f", more than fits rtol {rtol:g}" if share > fits else ""
    return [f"  energy  balance {missing:+.3g} J at the end, {share:.2g} of what moved{unfit}"]


def _of_forces(statistics: Statistics) -> list[str]:
    quantity, name, part, error, largest, is_least = statistics["force_error"]
    size = f"{'at least' if is_least else 'about'} {error / largest:.1g}"
    return [f"  forces  error {size} of the largest, of {part} in {quantity} {name!r}"]


def _of_bending(statistics: Statistics) -> list[str]:
    bending = Bending(*statistics["bending"])
    return [f"  bending {bending}{', beyond its valid range' if bending.is_too_far else ''}"]


TOLD: dict[str, Callable[[Statistics], list[str]]] = {
    "tried": _of_trials,
    "unconverged": _of_iterations,
    "penetration": _of_contacts,
    "energy_balance": _of_energy,
    "force_error": _of_forces,
    "force_error_unknown": lambda statistics: [f"  forces  {statistics['force_error_unknown']}"],
    "bending": _of_bending,
    "resolution": lambda statistics: [f"  strains {Resolution(*statistics['resolution'])}"],
}
"""Columns of the summary of some runs, in this order."""
