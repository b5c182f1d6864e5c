"""Controllers in a run: what they read, when they are called, when their drives begin to act, and a log of all that."""

from __future__ import annotations

import math
import time
from copy import deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.readings import reader
from kanefe.integrate.run_checks.drive_growth import DriveGrowth
from kanefe.integrate.sampled_tables import LOG_ROWS, sample_tables
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.steppers.sampling import (
    AT_TIME,
    BY,
    VALUES,
    Sampled,
    controllers_of,
    next_sample,
    progress_of,
    sample_at,
)
from kanefe.kernels.values.records import column
from kanefe.loads.offered_function import CompiledByNumba
from kanefe.tree.reading_terms import terms_of
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.kernels.steppers.sampling import Samples
    from kanefe.loads.controller import Controller

AT_ONCE = 1e-9
"""Time difference, relative to the shortest sampling interval, below which samples are simultaneous, such as 3 times
0.1 s and 15 times 0.02 s."""

ROW = column(Sampled, "row")
"""Column of the row of the log of a controller that is being sampled."""

LEVELS = 2.0
"""Factor by which drives have to grow once more until they are looked at again."""


@dataclass(frozen=True, eq=False)
class ControllerLog:
    """All samples of a controller in a run, K of them.

    Attributes
    ----------
    times : ndarray, shape (K,)
        s.
    reads, drives : ndarray, shape (K, reads) and (K, drives)
        What it was given and what it gave; drives begin to act its delay later.
    read_names, drive_names : tuple of str
        With units in brackets.
    """

    times: np.ndarray
    reads: np.ndarray
    drives: np.ndarray
    read_names: tuple[str, ...]
    drive_names: tuple[str, ...]

    def __repr__(self) -> str:
        return f"{len(self.times)} samples of {', '.join(self.read_names)}; drives {', '.join(self.drive_names)}"


class Sampler:
    """The controllers of a model in a run.

    Parameters
    ----------
    model : Model
    start, stop : float
        s.

    Attributes
    ----------
    samples : Samples
        For compiled code.
    keeps_instants : bool
        Whether `taken_instants` will be asked for.
    """

    def __init__(self, model: Model, start: float, stop: float) -> None:
        self._model = model
        sampled = [one for one in model.controllers if one.is_sampled]
        together = AT_ONCE * min((one.every for one in sampled), default=0.0)
        self.samples, memories = sample_tables(model, sampled, start, stop, together)
        self._progress = progress_of(self.samples)
        self._controllers = [_Sampled(model, one, memory) for one, memory in zip(sampled, memories, strict=True)]
        self._seconds, self.keeps_instants = 0.0, False
        self._instants = list[np.ndarray]()
        self._y = np.zeros(model.coordinate_count + model.free_count + model.state_count)
        self._sample_at = sample_at.bound(self.samples, LATER, self._y)

    def aim(self, stop: float) -> None:
        """Let the run end at another time, s."""
        self._progress.end = stop

    @property
    def next(self) -> float:
        """When the next sample is, or drives begin to act, s; the end of the run if there is none before."""
        return float(next_sample(self.samples))

    @property
    def is_asking(self) -> bool:
        """Whether a sample has been begun and functions are to be called yet."""
        return bool(self._progress.asked >= 0)

    @property
    def has_alarm(self) -> bool:
        """Whether drives have grown so that `growth` is to be looked at."""
        return bool(self._progress.is_alarmed)

    def end_alarm(self) -> None:
        """Have drives looked at again when they have grown once more."""
        self._progress.is_alarmed = False
        for own in controllers_of(self.samples):
            own.level *= LEVELS

    def sampled(self, t: float, y: Vector) -> Vector:
        """Return the state with the drives as they are from time t (s) on, after what is to be sampled there."""
        found, progress = y.copy(), self._progress
        if max(progress.logged, progress.acted) >= LOG_ROWS:
            self._empty()
        self._y[:] = y[: len(self._y)]
        while self._sample_at(t) >= 0:
            self.answer(t, y)
        found[: len(self._y)] = self._y
        return found

    def answer(self, t: float, y: Vector) -> None:
        """Call the function that compiled code asks for, or empty the log if it asks for none."""
        began = time.perf_counter()
        asked = self._progress.asked
        if asked < 0:
            self._empty()
        else:
            one, samples = self._controllers[asked], self.samples
            row = samples.log[samples.controllers[asked, ROW]]
            if one.readers:
                state = _SeenOnce(self._model, t, y.copy())
                row[VALUES : VALUES + one.reads] = [read(t, y, state) for read in one.readers]
            values = one.called(t, row[VALUES : VALUES + one.reads].copy())
            row[samples.drives_at : samples.drives_at + len(values)] = values
            self._progress.asked = asked + 1
        self._seconds += time.perf_counter() - began

    def taken_seconds(self) -> float:
        """Return the time in functions of the user since this was asked, s."""
        found, self._seconds = self._seconds, 0.0
        return found

    def _empty(self) -> None:
        """Take what is in the log."""
        samples, progress = self.samples, self._progress
        count, own_rows = progress.logged, samples.controllers[:, ROW]
        done = int(own_rows[own_rows >= 0].min(initial=count)) if self.is_asking else count
        if progress.acted and self.keeps_instants:
            self._instants.append(samples.acted[: progress.acted].copy())
        if done:
            rows = samples.log[:done]
            for number, one in enumerate(self._controllers):
                own = rows if len(self._controllers) == 1 else rows[rows[:, BY] == number]
                one.take(own[:, AT_TIME], own[:, VALUES:], samples.drives_at - VALUES)
        samples.log[: count - done] = samples.log[done:count].copy()  # a sample that is begun stays
        own_rows[own_rows >= 0] -= done
        progress.logged, progress.acted = count - done, 0

    def taken_instants(self) -> np.ndarray:
        """Return the times at which drives began to act since this was asked, and the states of loads from then on."""
        self._empty()
        found, self._instants = self._instants, []
        return np.concatenate(found) if found else np.zeros((0, self.samples.acted.shape[1]))

    def snapshot(self) -> tuple[object, ...]:
        """Return what is needed to continue; lists that only grow are represented by their length."""
        self._empty()
        return tuple(x.copy() for x in _kept(self.samples)), tuple(one.snapshot() for one in self._controllers)

    def resume(self, snapshot: tuple[Any, ...]) -> None:
        """Continue from a snapshot, of this run or of another of the same scene."""
        arrays, controllers = snapshot
        addresses = [own.address for own in controllers_of(self.samples)]  # which are those of a process
        for array, kept in zip(_kept(self.samples), arrays, strict=True):
            array[:] = kept
        for own, address in zip(controllers_of(self.samples), addresses, strict=True):
            own.address = address
        for one, of_one in zip(self._controllers, controllers, strict=True):
            one.resume(of_one)

    def growth(self, times: float) -> tuple[str, str] | None:
        """Return the description and the remedy of a run in which the drives of a controller have grown by a factor."""
        self._empty()
        for one in self._controllers:
            grown = one.growth.grown(times)
            if grown is not None:
                controller = one.controller
                return (
                    f"controller {controller.name!r} now changes {controller.drives[grown.drive]!r} by "
                    f"{grown.change:.2g} from one sample to the next, {grown.times:.2g} times as much as at the start: "
                    "the sampled loop may be unstable",
                    f"smaller gains or a shorter every= of controller {controller.name!r} (now {controller.every:g} s)",
                )
        return None

    def logs(self) -> dict[str, ControllerLog]:
        """Return all samples so far, by the names of the controllers."""
        self._empty()
        return {one.controller.name: one.log() for one in self._controllers}


def _kept(samples: Samples) -> tuple[np.ndarray, ...]:
    """Return the arrays of which a run is made up that goes on; the log is emptied before."""
    kept = samples.controllers, samples.times, samples.progress, samples.limits, samples.memory
    return *kept, samples.late, samples.changes


class _SeenOnce:
    """The state of a scene at a time, made on request: joints are read without it."""

    def __init__(self, model: Model, t: float, y: Vector) -> None:
        self._given = model, t, y
        self._state: SceneState | None = None

    def __call__(self) -> SceneState:
        if self._state is None:
            model, t, y = self._given
            self._state = model.route.state(t, y)
        return self._state


class _Sampled:
    """One controller in a run: its function, memory and log. `memory` is that of a compiled function."""

    def __init__(self, model: Model, controller: Controller, memory: np.ndarray | None) -> None:
        self.controller, self.reads, self._drives = controller, len(controller.reads), controller.drive_count
        self._memory: Any = controller.new_memory() if memory is None else memory
        self._taken: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        is_plain = all(terms_of(model, reading) is not None for reading in controller.reads)
        self.readers = [] if is_plain else [reader(model, reading) for reading in controller.reads]
        self.growth = DriveGrowth(controller.drive_count)

    def take(self, times: np.ndarray, values: np.ndarray, most_reads: int) -> None:
        """Take what was sampled."""
        if len(times):
            drives = values[:, most_reads : most_reads + self._drives].copy()
            self._taken.append((times.copy(), values[:, : self.reads].copy(), drives))
            self.growth.take(drives)

    def snapshot(self) -> tuple[object, ...]:
        """Return what is needed to continue."""
        return deepcopy(self._memory), tuple(self._taken)

    def resume(self, snapshot: tuple[Any, ...]) -> None:
        """Continue from a snapshot."""
        memory, taken = snapshot
        if isinstance(self._memory, dict):
            self._memory = deepcopy(memory)
        self._taken = list(taken)

    def called(self, t: float, reads: Vector) -> Vector | tuple[float, ...]:
        """Return what the function gives."""
        controller = self.controller
        try:
            given = controller.function(t, reads, self._memory)
        except Exception as error:
            if not isinstance(controller.function, CompiledByNumba):
                error.add_note(f"the function of controller {controller.name!r} at t = {t:.6g} s")
                raise
            text = f"{type(error).__name__}: {error} at t = {t:.6g} s"  # it has no line in Python
            raise ModelError(f"the compiled function of controller {controller.name!r} raised {text}") from error
        plain = given if type(given) is tuple else (given,)
        if len(plain) == self._drives and all(
            isinstance(x, float) and math.isfinite(x) for x in plain
        ):  # the usual case
            return plain
        try:
            values = np.atleast_1d(np.asarray(given, dtype=float))
        except (TypeError, ValueError):
            values = np.zeros(0)
        if values.shape != (self._drives,) or not np.all(np.isfinite(values)):
            wanted = "one finite number" if self._drives == 1 else f"{self._drives} finite numbers"
            raise ModelError(
                f"controller {controller.name!r} must give {wanted} ({', '.join(controller.drives)}); at t = {t:.6g} s "
                f"it gave {given!r}"
            )
        return values

    def log(self) -> ControllerLog:
        """Return all samples so far."""
        controller = self.controller
        widths = (), (len(controller.reads),), (controller.drive_count,)
        times, reads, drives = (
            np.concatenate([np.zeros((0, *width)), *(taken[i] for taken in self._taken)])
            for i, width in enumerate(widths)
        )
        return ControllerLog(
            times, reads, drives, tuple(reading.label for reading in controller.reads), controller.drives
        )
