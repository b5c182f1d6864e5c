"""Many runs at once: of one scene from many starts, or of many scenes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.batches.lanes import Planned, SharedMemory, lanes_of_scene, planned_alike, why_in_python
from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationError, SimulationWarning, outside
from kanefe.integrate.options import RunKeywords, RunOptions
from kanefe.integrate.run import SilentBar, run
from kanefe.integrate.run_checks.energy_check import account
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory
from kanefe.kernels.compiler.processors import processors_here
from kanefe.result import Result
from kanefe.storage.watched import is_watched, progress_bar
from kanefe.system import System
from kanefe.tree.model_data import QUADRATURES

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start

OF_ONE_RUN = ("checkpoint", "checkpoint_seconds", "resume")
"""Options of a run that many runs at once do not take: they are continued by the caller."""

NOT_BEGUN = "the run could not begin"
"""Reason of the method of a run without a step."""

FIRST = "the first run, which chooses the method"
LEFT = "it differs from the others in more than numbers, or needs more than rates on its way"
OTHERS = "events of loads or joints, or scenes that differ in more than numbers"
"""Why a run is not beside others."""

BLOCKS = 4
"""Number of blocks of runs for each thread, so that none waits long for the last one."""

MOST_AT_ONCE = 1000
"""Largest number of runs in a block: the states of all are in memory twice."""

NAMED = 5
"""Largest number of failed runs that a warning names."""


@checked("scenes", "starts", "threads", "progress", "method", "output_times")
def simulate_many(
    scenes: System | Sequence[System],
    t_span: tuple[float, float],
    starts: Sequence[Start] | np.ndarray | None = None,
    *,
    threads: int | None = None,
    **options: Unpack[RunKeywords],
) -> tuple[Result, ...]:
    """Run one scene from many starts, or many scenes that are alike, at once.

    Runs of one scene share everything that does not depend on the start, and stay in compiled code together. Of rigid
    bodies in trees without loads between frames, explicit methods evaluate several runs at once, in vector
    instructions: of one scene, or of scenes that differ in numbers alone. ``result.statistics["lanes"]`` is how many,
    "lanes_reason" why not. Several processors are used where the scene has no functions in Python. A result is that of
    `System.simulate`, whatever is beside it. A run that fails does not stop the others: a warning says which have.

    Parameters
    ----------
    scenes : System or sequence of System
        One scene for all starts; or a scene for each run, with the same coordinates and speeds in the same order, such
        as those of several seeds or masses.
    t_span : (float, float)
        Start and end of each run in s.
    starts : sequence of states, or ndarray of shape (runs, state), optional
        Start of each run: see `System.simulate`. Default: those of the scenes.
    threads : int, optional
        Number of runs that are computed at once. Default: one per processor.
    **options
        Others of `System.simulate`, but for checkpoints and records. With method="auto" the first run chooses, and
        tries other methods, and all others take the method that it has ended with. Limits hold for each run.

    Returns
    -------
    tuple of Result
        In the order of the starts or scenes.

    Raises
    ------
    ModelError
        If there are no starts or scenes, a scene, a start or an option is not valid (the message has the number of the
        run), or scenes differ in their coordinates.

    Warns
    -----
    SimulationWarning
        If runs have failed or could not begin, with their numbers.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> results = kf.simulate_many(scene, (0.0, 1.0), starts=[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0]])
    >>> [round(float(result.joint_coordinates("rod")[-1, 0]), 3) for result in results]
    [-2.94, -2.757, -3.091]
    """
    refused = [name for name in OF_ONE_RUN if name in options]
    if refused:
        raise ModelError(f"many runs at once take no {refused[0]}=. Remedy: simulate, or kanefe.Study with a store")
    if threads is not None and threads < 1:
        raise ModelError(f"threads must be one or more, not {threads}")
    asked = RunOptions(t_span=t_span, **options)
    models = _models(scenes, starts, asked.span[0])
    with progress_of(asked.progress, len(models)) as bar:
        found = _ran(models, replace(asked, progress=False), threads or processors_here(), bar)
    _warn_of_failed(found)
    return tuple(Result(model, done) for model, done in zip(models, found, strict=True))


def _models(scenes: System | Sequence[System], starts: Any, t: float) -> list[Model]:
    """Return the model of each run, at its start at time t (s)."""
    if isinstance(scenes, System):
        if starts is None:
            raise ModelError("simulate_many of one scene needs starts=, one a run. Remedy: simulate, for one run")
        of_runs = [(scenes, start) for start in starts]
    else:
        own = [None] * len(scenes) if starts is None else [*starts]
        if len(own) != len(scenes):
            raise ModelError(f"starts= has {len(own)} states, and there are {len(scenes)} scenes. Remedy: one for each")
        of_runs = list(zip(scenes, own, strict=True))
    if not of_runs:
        raise ModelError("simulate_many has no run. Remedy: one start or scene at least")
    found: list[Model] = []
    for number, (scene, start) in enumerate(of_runs):
        try:
            found.append(scene.freeze(t, start))
        except ModelError as error:
            raise ModelError(f"run {number}: {error}") from error
        if found[number].state_names != found[0].state_names:
            raise ModelError(f"{_difference(found[0], found[number], number)}. Remedy: a call for each kind of scene")
    return found


def _difference(first: Model, other: Model, number: int) -> str:
    ours, theirs = first.state_names, other.state_names
    if len(ours) != len(theirs):
        return f"the scene of run {number} has {len(theirs)} coordinates and speeds, that of run 0 has {len(ours)}"
    at = next(i for i, (a, b) in enumerate(zip(ours, theirs, strict=True)) if a != b)
    return f"the scene of run {number} has {theirs[at]!r} where that of run 0 has {ours[at]!r}"


def _ran(models: Sequence[Model], options: RunOptions, threads: int, bar: Any) -> list[Trajectory]:
    """Return all runs. The first that begins says what is the same for all."""
    found: list[Trajectory] = []
    while len(found) < len(models) and (not found or has_not_begun(found[-1])):
        found.append(_alone(models[len(found)], options, FIRST))
        bar.update(1)
    rest = models[len(found) :]
    lanes = lanes_of_scene(rest, options, found[-1]) if rest else None
    alike: dict[int, Planned] = {}
    if rest and lanes is None:
        plans = planned_alike(rest, options, found[-1].statistics["method"])
        alike = {id(one.model): one for one in plans if one is not None}
        lanes = SharedMemory(next(iter(alike.values())), options) if len(alike) > 1 else None
    blocks = _blocks_of(rest, threads, lanes is not None and not lanes.reason)

    def run_block(block: Sequence[Model]) -> list[Trajectory]:
        if lanes is None:
            done: list[Trajectory | None] = [None] * len(block)
        elif not alike:
            done = lanes.run(block)
        else:
            runs = [alike[id(model)] for model in block if id(model) in alike]
            at_once = iter(lanes.run_all(runs))
            done = [next(at_once) if id(model) in alike else None for model in block]
        why = LEFT if lanes is not None else why_in_python(block[0], options) or OTHERS
        return [_alone(model, options, why) if one is None else one for model, one in zip(block, done, strict=True)]

    if threads == 1 or not _is_compiled(models, options):
        for block in blocks:
            found += run_block(block)
            bar.update(len(block))
        return found
    pool = ThreadPoolExecutor(threads)
    try:
        for done in pool.map(run_block, blocks):
            found += done
            bar.update(len(done))
    finally:
        pool.shutdown(cancel_futures=True)
    return found


def _blocks_of(models: Sequence[Model], threads: int, are_at_once: bool) -> list[Sequence[Model]]:
    """Return models in blocks for threads: as few as there are threads where those of a block are run at once."""
    size = max(1, math.ceil(len(models) / (threads if threads == 1 or are_at_once else BLOCKS * threads)))
    size = min(size, MOST_AT_ONCE)
    return [models[i : i + size] for i in range(0, len(models), size)]


def _alone(model: Model, options: RunOptions, why: str) -> Trajectory:
    """Return a run as `System.simulate` has it, with why it is not beside others; its start if it cannot begin."""
    try:
        done = run(model, options)
    except SimulationError as error:
        start = options.span[0]
        state = np.concatenate((model.initial_state, np.zeros(QUADRATURES)))
        status, route = RunStatus.of_error(start, error), model.route
        told: dict[str, Any] = {"method": options.method, "reason": NOT_BEGUN}
        told |= {"route": route.name, "route_reason": route.reason}
        told |= {"steps": 0, "seconds": 0.0, "seconds_by_part": {}}
        return Trajectory.of_states(model, np.array([start]), state[None], status=status, statistics=told)
    if done.status is not None and done.status.reason == "by Ctrl-C":
        raise KeyboardInterrupt
    account(model, done)
    done.statistics.update(lanes=1, lanes_reason=why)
    return done


def has_not_begun(run: Trajectory) -> bool:
    """Return whether a run has but its start."""
    return bool(run.statistics["reason"] == NOT_BEGUN)


def _is_compiled(models: Sequence[Model], options: RunOptions) -> bool:
    """Return whether nothing of the user is called, which may not bear several threads, and holds Python anyway."""
    own = any(event.function is not None for event in options.watched)
    return not own and all(model.route.is_autonomous and not model.controllers for model in models)


def progress_of(wanted: bool | None, count: int) -> AbstractContextManager[Any]:
    """Return a progress bar in runs; a silent one off a terminal."""
    if not (is_watched() if wanted is None else wanted):
        return SilentBar()
    bar: AbstractContextManager[Any] = progress_bar(total=count, desc="simulate_many", unit="run", leave=False)
    return bar


def _warn_of_failed(runs: Sequence[Trajectory]) -> None:
    failed = [(i, run.status) for i, run in enumerate(runs) if run.status is not None and run.status.kind == "failed"]
    if not failed:
        return
    told = "; ".join(f"run {i}: {status}" for i, status in failed[:NAMED])
    more = f"; and {len(failed) - NAMED} more" if len(failed) > NAMED else ""
    warnings.warn(f"{len(failed)} of {len(runs)} runs failed: {told}{more}", SimulationWarning, stacklevel=outside())
