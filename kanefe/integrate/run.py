"""A run of a model in time: options in, trajectory out."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationWarning, outside
from kanefe.frames import Matrix, Vector
from kanefe.integrate.auto.choice import Choice
from kanefe.integrate.clock import Clock
from kanefe.integrate.events.event import Event
from kanefe.integrate.events.requested_events import with_asked_events
from kanefe.integrate.loop import RunLoop
from kanefe.integrate.options import RunKeywords, RunOptions
from kanefe.integrate.pace import Limits, Poles
from kanefe.integrate.run_checks.bushing_turns import of_bushings
from kanefe.integrate.run_checks.convergence_check import of_fixed_steps
from kanefe.integrate.run_checks.functions_of_user import across_jump, changed_by_run, values_of_functions
from kanefe.integrate.run_checks.stiff_contacts import warn_of_stiff_contacts
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.integrate.sampling import Sampler
from kanefe.integrate.set_up import SetUp, give_back, set_up
from kanefe.integrate.shared_states import RecordsStates, SharedStates
from kanefe.integrate.status import RunStatus
from kanefe.integrate.stepper import Stepper, tries_others
from kanefe.integrate.trajectory import Trajectory
from kanefe.kernels.compiler.compiled_functions import CompiledFunction, foreseen
from kanefe.storage.watched import is_watched, progress_bar
from kanefe.tree.model_data import QUADRATURES

if TYPE_CHECKING:
    from kanefe.integrate.checkpoint import CheckpointFile, Progress


def integrate(model: Model, t_span: tuple[float, float], **options: Unpack[RunKeywords]) -> Trajectory:
    """Run a model in time.

    Parameters
    ----------
    model : Model
    t_span : (float, float)
        Start and end in s.
    **options
        Those of `kanefe.System.simulate`.

    Raises
    ------
    ModelError, SimulationError, FileError
        See `run`.
    """
    return run(model, RunOptions(t_span=t_span, **options))


def run(
    model: Model, options: RunOptions, poles: Poles | None = None, recorder: RecordsStates | None = None
) -> Trajectory:
    """Run a model in time.

    Parameters
    ----------
    model : Model
    options : RunOptions
    poles : callable, optional
        Describes the poles of a sampled loop whose drives grow.
    recorder : RecordsStates, optional
        Takes states as the run goes on.

    Raises
    ------
    ModelError
        If an option makes no sense for the model.
    SimulationError
        If the run cannot begin.
    FileError
        If the checkpoint cannot be written at the start, or the one to go on from cannot be read or is of another run.
    """
    model = with_asked_events(model, options.watched)
    with one_count(model, options):
        try:
            return _run(model, options, poles, recorder)
        except BaseException:
            if recorder is not None:
                recorder.leave()
            raise


def one_count(model: Model, options: RunOptions) -> AbstractContextManager[None]:
    """Have what methods of a run need built with the first of the rest that is missing; see `foreseen`."""

    def needed() -> list[CompiledFunction]:
        from kanefe.integrate.auto.choice import functions_of_methods

        return functions_of_methods(model, options)

    return foreseen(needed)


def _run(model: Model, options: RunOptions, poles: Poles | None, recorder: RecordsStates | None) -> Trajectory:
    (start, stop), wanted, clock = options.span, options.times, Clock()
    warn_of_stiff_contacts(model)
    warn_of_structural_damping(model)
    with clock.part("set-up"):
        begun = set_up(model, options)
    stepper = begun.stepper
    model.route.check_outputs(len(wanted))
    begins = None if model.route.is_autonomous else (stepper.t, stepper.state())
    given = {} if begins is None else values_of_functions(model, *begins)
    file, saved = _checkpoints(model, begun.choice, options, begun.told)
    times = wanted if wanted[-1] == stop else np.append(wanted, stop)
    taker = None if recorder is None else _taker(model, begun, times, recorder)
    with _progress_bar(options.progress, stop - start) as bar:
        with clock.part("set-up"):
            begun.start()
            limits = Limits(options.most_steps, options.most_seconds)
            sampler = Sampler(model, start, stop) if model.controllers else None
            times = times if taker is None else taker.times
            watched = stepper, times, begun.watch, limits, clock, bar, sampler, poles
            loop = RunLoop(begun.dynamics, *watched, begun.chunk, taker)
            if saved is not None:
                loop.resume(saved)
        status = loop.go(file)
    kept = _stored(loop, taker, wanted)
    status = _checked(model, begun, loop, *kept[:2], status)
    texts = [str(status)] if status.kind == "failed" or loop.is_interrupted else []
    _warn([*texts, *_of_functions(model, stepper, begins, given)])
    times, states, rates = _with_last(loop, *kept)
    statistics, watch = _statistics(model, begun, loop, clock), begun.watch
    events = {event.name: np.array(watch.times[event.name]) for event in begun.told} if watch else {}
    _warn([*(watch.telling.impacts.warnings if watch else ()), *of_fixed_steps(model, statistics, events)])
    logs, records = sampler.logs() if sampler else {}, {} if recorder is None else recorder.end(status)
    told = {"statistics": statistics, "events": events, "controllers": logs, "bent": stepper.bent, "records": records}
    found = Trajectory.of_states(model, times, states, accelerations=rates, status=status, **told)
    begun.chunk = loop.chunk
    give_back(model, options, begun)
    return found


def _warn(texts: Iterable[str]) -> None:
    for text in texts:
        warnings.warn(text, SimulationWarning, stacklevel=outside())


def _taker(model: Model, begun: SetUp, times: Vector, recorder: RecordsStates) -> SharedStates:
    """Return what takes the states for a recorder."""
    recorder.begin([event.name for event in begun.told])
    return SharedStates(times, len(model.initial_state) + QUADRATURES, recorder)


def _with_last(
    loop: RunLoop, times: Vector, states: Matrix, rates: Matrix | None
) -> tuple[Vector, Matrix, Matrix | None]:
    """Return the same with where the run has ended, if that is behind them."""
    if loop.last is None or (len(times) and loop.last[0] <= times[-1]):
        return times, states, rates
    if rates is not None and loop.last_accelerations is not None:
        rates = np.vstack((rates, loop.last_accelerations))
    return np.append(times, loop.last[0]), np.vstack((states, loop.last[1])), rates


def _stored(loop: RunLoop, taker: SharedStates | None, wanted: Vector) -> tuple[Vector, Matrix, Matrix | None]:
    """Return the times passed of those that are wanted, and states and accelerations there."""
    rows = loop.rows
    states, rates, stored = rows.states, rows.accelerations, rows.stored
    if taker is not None:
        rows.give_rest()
        states, rates, stored = taker.states, taker.accelerations, taker.stored
    stored = min(stored, len(wanted))
    return wanted[:stored], states[:stored], None if rates is None else rates[:stored]


def _checked(model: Model, begun: SetUp, loop: RunLoop, times: Vector, states: Matrix, status: RunStatus) -> RunStatus:
    """Return how a run ended, after a look at what its states say of contacts and bushings."""
    if status.kind == "failed":
        return status
    choice = begun.choice
    if model.rigid_contacts:
        from kanefe.integrate.run_checks.contact_check import of_contacts

        counted, rtol = int(loop.statistics["evaluations"]), choice.control.get("rtol")
        status = of_contacts(model, times, states, choice.name, counted, rtol) or status
    return status if status.kind == "failed" else of_bushings(model, times, states) or status


def _statistics(model: Model, begun: SetUp, loop: RunLoop, clock: Clock) -> dict[str, Any]:
    choice, stepper, looking = begun.choice, begun.stepper, begun.dynamics.seconds_looking
    return {
        "method": stepper.name,
        "reason": choice.reason,
        "route": model.route.name,
        "route_reason": model.route.reason,
        **choice.control,
        **loop.statistics,
        **loop.told_of_steps,
        **({"left_out": choice.left_out} if choice.left_out else {}),
        **({"tried": stepper.told, "tried_share": stepper.tried_share} if tries_others(stepper) else {}),
        **({"seconds_looking": looking} if looking > 0.0 else {}),
        "seconds": sum(clock.seconds.values()),
        "seconds_by_part": dict(clock.seconds),
    }


def _of_functions(
    model: Model, stepper: Stepper, begins: tuple[float, Vector] | None, given: Mapping[str, Vector]
) -> Iterator[str]:
    """Yield what is told after a run of functions of the user that are none of time and state."""
    if unanswered := stepper.unanswered:
        first, _, remedy = unanswered[0].partition(". Remedy: ")
        yield (
            f"{first}; the method went on with shorter steps, {len(unanswered)} times. Remedy: "
            f"{remedy or 'a function that gives a number wherever a method may ask'}"
        )
    if begins is not None and (text := changed_by_run(model, *begins, given)):
        yield text
    if text := across_jump(model, stepper.hardest):
        yield text


def _checkpoints(
    model: Model, choice: Choice, options: RunOptions, watched: Sequence[Event]
) -> tuple[CheckpointFile | None, Progress | None]:
    """Return the file that the run writes, and the progress of the run that it continues."""
    if choice.is_plugged and model.controllers:
        raise ModelError(
            f"{choice.name} does not end its steps at the samples of controller {model.controllers[0].name!r}. "
            "Remedy: method='auto', or 'radau5'"
        )
    if options.checkpoint is None and options.resume is None:
        return None, None
    if model.controllers:
        raise ModelError(
            f"controller {model.controllers[0].name!r} keeps its memory in Python, so that its runs have no "
            "checkpoints. Remedy: a run in parts, each with start= the end of the one before"
        )
    if choice.is_plugged:
        raise ModelError(
            f"{choice.name} does not expose its history of earlier steps, so that its runs have no "
            "checkpoints. Remedy: method='radau5'"
        )
    from kanefe.integrate.checkpoint import CheckpointFile, identity, read_checkpoint

    of = identity(model, choice, options.span, options.times, watched)
    saved = None if options.resume is None else read_checkpoint(options.resume, of)
    every = float(options.checkpoint_seconds)
    return None if options.checkpoint is None else CheckpointFile(options.checkpoint, of, every), saved


def _progress_bar(wanted: bool | None, span: float) -> Any:
    """Return a progress bar in simulated seconds; a silent one off a terminal."""
    if not (is_watched() if wanted is None else wanted):
        return SilentBar()
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
    return progress_bar(total=span, desc="simulate", bar_format=layout, leave=False)


class SilentBar(AbstractContextManager["SilentBar"]):
    """A progress bar that nobody sees."""

    n = 0.0

    def update(self, seconds: float) -> None:
        """Say nothing."""

    def __exit__(self, *error: object) -> None:
        return None
