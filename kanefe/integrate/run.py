"""A run of a model in time: options in, trajectory out."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationWarning
from kanefe.integrate.checkpoint import CheckpointFile, identity, read_checkpoint
from kanefe.integrate.choice import choose
from kanefe.integrate.clock import Clock
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.event_watch import EventWatch
from kanefe.integrate.events import Event, checked_events
from kanefe.integrate.load_events import events_of_loads
from kanefe.integrate.loop import Limits, RunLoop
from kanefe.integrate.trajectory import Trajectory, checked_span, wanted_times
from kanefe.tree.model_data import WORKS

LARGEST_STORE = 2**32
"""Bytes of states and accelerations of unreduced bodies above which a run asks for fewer outputs."""


def integrate(
    model: Model,
    t_span: tuple[float, float],
    *,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    step: float | None = None,
    output_step: float | None = None,
    output_times: Sequence[float] | np.ndarray | None = None,
    events: Sequence[Event] | Event = (),
    checkpoint: str | Path | None = None,
    checkpoint_seconds: float = 30.0,
    resume: str | Path | None = None,
    most_steps: int | None = None,
    most_seconds: float | None = None,
    progress: bool | None = None,
) -> Trajectory:
    """Run a model in time: the options are those of `kanefe.System.simulate`.

    Raises
    ------
    ModelError
        If an option makes no sense.
    SimulationError
        If the run cannot begin.
    FileError
        If the checkpoint cannot be written at the start, or the one to go on from cannot be read or is of another run.
    """
    start, stop = checked_span(t_span)
    choice = choose(model, method, start, stop, rtol, step, atol)
    wanted = wanted_times(start, stop, output_step, output_times, step)
    watched = checked_events(events, events_of_loads(model))
    limits = _checked_limits(most_steps, most_seconds)
    _check_room(model, wanted)
    file, saved = None, None
    if checkpoint is not None or resume is not None:
        if choice.is_plugged:
            raise ModelError(
                f"{choice.name} keeps what it remembers of earlier steps to itself, so that its runs have no "
                "checkpoints. Remedy: method='radau5'"
            )
        of = identity(model, choice, (start, stop), wanted, watched)
        saved = read_checkpoint(resume, of) if resume is not None else None
        file = CheckpointFile(checkpoint, of, _seconds(checkpoint_seconds)) if checkpoint is not None else None
    times = wanted if wanted[-1] == stop else np.append(wanted, stop)
    clock = Clock()
    with _progress_bar(progress, stop - start) as bar:
        dynamics = Dynamics(model)
        with clock.part("set-up"):
            stepper = choice.make(dynamics)
            watch = EventWatch(model, watched, stop - start) if watched else None
            loop = RunLoop(dynamics, stepper, times, watch, limits, clock, bar)
            if saved is not None:
                loop.resume(saved)
        status = loop.go(file)
    if status.kind == "failed":
        warnings.warn(str(status), SimulationWarning, stacklevel=3)
    stored, states, rates = min(loop.stored, len(wanted)), loop.states, loop.accelerations
    times, states = times[:stored], states[:stored]
    if rates is not None:
        rates = rates[:stored]
    if loop.last is not None and (not stored or loop.last[0] > times[-1]):
        times, states = np.append(times, loop.last[0]), np.vstack((states, loop.last[1]))
        if rates is not None and loop.last_accelerations is not None:
            rates = np.vstack((rates, loop.last_accelerations))
    n, m = model.coordinate_count, model.free_count
    return Trajectory(
        times=times,
        coordinates=states[:, :n],
        speeds=states[:, n : n + m],
        dissipated=states[:, -WORKS],
        work=states[:, -1],
        statistics={
            "method": choice.name,
            "reason": choice.reason,
            "route": model.route.name,
            "route_reason": model.route.reason,
            **choice.control,
            **loop.statistics,
            "seconds": sum(clock.seconds.values()),
            "seconds_by_part": dict(clock.seconds),
        },
        accelerations=rates,
        status=status,
        internal=states[:, n + m : -WORKS],
        events={name: np.array(found) for name, found in watch.times.items()} if watch else {},
    )


def _checked_limits(steps: int | None, seconds: float | None) -> Limits:
    if steps is not None and not (isinstance(steps, (int, np.integer)) and steps > 0):
        raise ModelError(f"most_steps must be a whole number above zero, not {steps!r}")
    return Limits(None if steps is None else int(steps), None if seconds is None else _seconds(seconds))


def _seconds(value: float) -> float:
    if not (isinstance(value, (int, float, np.number)) and np.isfinite(value) and value >= 0):
        raise ModelError(f"checkpoint_seconds and most_seconds must be zero s or more, not {value!r}")
    return float(value)


def _check_room(model: Model, times: np.ndarray) -> None:
    size = 24 * model.free_count * len(times)
    if not model.route.is_dense and size > LARGEST_STORE:
        raise ModelError(
            f"{len(times)} states of {model.free_count} speeds take {size / 2**30:.1f} GiB. Remedy: a larger "
            f"output_step, which leaves at most {LARGEST_STORE // (24 * model.free_count)} of them"
        )


def _progress_bar(wanted: bool | None, span: float) -> Any:
    """Return a progress bar in simulated seconds; a silent one off a terminal."""
    from tqdm import tqdm

    shown = sys.stderr.isatty() if wanted is None else wanted
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
    return tqdm(total=span, desc="simulate", disable=not shown, bar_format=layout, leave=False)
