"""Runs with an accuracy: ``scene.simulate(..., accuracy=1e-3, of=[...])``."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.certified.bodies_made import BodiesMade
from kanefe.certified.body_sources import body_sources
from kanefe.certified.choice import Choice, Kept, Levels, Source, settings
from kanefe.certified.friction_sources import anchor_sources, put_anchors
from kanefe.certified.limits import Limits
from kanefe.certified.quantity import Of, Quantity, quantities_of
from kanefe.certified.report_of_search import accuracy_of
from kanefe.certified.run_sources import looks_over_time, output_source, step_source
from kanefe.certified.search import Search
from kanefe.certified.trial import Trial, timed
from kanefe.certified.values import Values, check_names, values_of
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.integrate.options import RunOptions
from kanefe.integrate.trajectory import Trajectory
from kanefe.result import Result
from kanefe.storage.watched import is_watched, progress_bar
from kanefe.tree.model_data import QUADRATURES

REFUSED = {
    "record_file": "no file: each evaluation would write it",
    "checkpoint": "no checkpoints: it is made of several runs",
    "resume": "no checkpoints: it is made of several runs",
    "most_steps": "no limit of steps. Remedy: most_seconds=",
}
"""Options that a run with an accuracy does not take, and why."""

EVERY = 4
"""Number of outputs of which one is looked at; it shows what is missed between them: see `kanefe.certified.pairs`."""


def certified_run(
    scene: Any,
    t_span: tuple[float, float],
    accuracy: float | None,
    of: Of | Sequence[Of] | Mapping[str, Of],
    options: dict[str, Any],
) -> Result:
    """Return the result of the last of several runs of a scene, with its `Accuracy`.

    Parameters
    ----------
    scene : System
    t_span : (float, float)
        s.
    accuracy : float or None
        Relative, of quantities that have none of their own.
    of : quantities
        See `kanefe.certified.quantity.quantities_of`.
    options : dict
        Other keywords of `kanefe.System.simulate`.

    Raises
    ------
    ModelError
        If an option, a name or an accuracy is not valid; nothing has run then.
    """
    for name, why in REFUSED.items():
        if options.get(name) is not None:
            raise ModelError(f"{name} was given with an accuracy, which has {why}")
    quantities = quantities_of(of, accuracy)
    limits = Limits(options.pop("most_seconds", None), options.pop("most_memory", None))
    stiffer, progress = options.pop("stiffer", ()), options.pop("progress", None)
    of_run = {name: value for name, value in options.items() if name not in {"start", "record", "record_file"}}
    asked = RunOptions(t_span=t_span, **of_run)
    _check_quantities(scene, asked, options.get("start"), quantities)
    sources, kept = _sources(scene, asked, options, quantities, stiffer)
    runs = _Runs(scene, t_span, options, asked, quantities, sources)
    with shown(progress) as tell:
        search = Search(runs.evaluate, sources, quantities, limits, tell, kept)
        search.run()
    return _told(search)


def _told(search: Search) -> Result:
    """Return the best result with its accuracy; warn of what its run told, and of an accuracy that is not met."""
    best = search.best
    for text in best.texts:
        warnings.warn(text.message, text.category, stacklevel=outside())
    result: Result = best.answer
    result._accuracy = found = accuracy_of(search)
    if not found.is_met:
        warnings.warn(f"accuracy not met: {search.reason}", AccuracyWarning, stacklevel=outside())
    return result


def _check_quantities(scene: Any, asked: RunOptions, start: Any, quantities: Sequence[Quantity]) -> None:
    """Refuse channels that the scene has not, from its state at the start."""
    start = start(scene.copy()) if callable(start) else start
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = scene.copy().freeze(asked.span[0], start)
    state = np.concatenate((model.initial_state, np.zeros(QUADRATURES)))[None]
    first = Trajectory.of_states(model, np.array([asked.span[0]]), state, statistics={})
    check_names(quantities, Result(model, first))


def _sources(
    scene: Any, asked: RunOptions, options: Mapping[str, Any], quantities: Sequence[Quantity], stiffer: Sequence[str]
) -> tuple[tuple[Source, ...], list[Kept]]:
    of_bodies, kept = body_sources(scene)
    anchors, others = anchor_sources(scene, stiffer)
    found = [step_source(asked, options, quantities), *of_bodies, *anchors]
    if looks_over_time(quantities):
        found.append(output_source(asked))
    return tuple(found), [*kept, *others]


class _Runs:
    """Runs of a scene at levels of its sources."""

    def __init__(
        self,
        scene: Any,
        t_span: tuple[float, float],
        options: Mapping[str, Any],
        asked: RunOptions,
        quantities: Sequence[Quantity],
        sources: tuple[Source, ...],
    ) -> None:
        self._scene, self._span, self._options, self._asked = scene, t_span, options, asked
        self._quantities, self._sources = quantities, sources
        self._bodies = BodiesMade(scene)

    def evaluate(self, levels: Levels) -> Trial:
        """Return the run at some levels."""
        chosen = settings(self._sources, levels)
        bodies, making = self._bodies.of(chosen)
        (result, values, sampled), seconds, texts = timed(lambda: self._read(self._run(chosen, bodies)))
        whole = result.status.kind != "failed" and "Ctrl-C" not in result.status.reason
        return Trial(
            levels, result, values, np.array(sampled), _order(result), seconds + making, texts, whole, *_steps(result)
        )

    def _read(self, result: Result) -> tuple[Result, list[Values], list[float]]:
        """Return a result with its quantities, and how far these change with every second output alone."""
        values: list[Values] = []
        sampled: list[float] = []
        if result.status.kind == "failed":
            return result, values, sampled
        dense = _halvings(self._asked.times, result.times)
        fewer = [_thinned(result, first) for first in range(EVERY)] if len(result.times) > 2 * EVERY else []
        for quantity in self._quantities:
            own = values_of(quantity, result, dense)
            values += own
            missed = np.zeros(len(own))
            for thin in fewer if looks_over_time([quantity]) else []:
                pairs = zip(own, values_of(quantity, thin), strict=True)
                apart = [a.apart(b) if a.values.shape == b.values.shape else 0.0 for a, b in pairs]
                missed = np.maximum(missed, apart)
            sampled += missed.tolist()
        return result, values, sampled

    def _run(self, chosen: Choice, bodies: Mapping[str, Any]) -> Result:
        scene = self._scene.with_bodies(bodies) if bodies else self._scene.copy()
        put_anchors(scene, chosen.anchors)
        options = {**self._options, **chosen.options, "progress": False}
        if "output_times" in chosen.options:
            options.pop("output_step", None)
        elif options.get("output_times") is None and options.get("output_step") is None:
            options["output_times"] = self._asked.times  # the same for steps of any length
        if callable(start := options.get("start")):
            options["start"] = start(scene)
        result: Result = scene.simulate(self._span, **options)
        return result


def _steps(result: Result) -> tuple[str, int]:
    """Return method and number of steps of a run."""
    return str(result.statistics["method"]), int(result.statistics["steps"])


def _halvings(asked: np.ndarray, times: np.ndarray) -> int:
    """Return how many outputs there are for each that was asked for."""
    return max(1, round((len(times) - 1) / max(len(asked) - 1, 1)))


def _thinned(result: Result, first: int) -> Result:
    """Return a result with every fourth of its output times, from a first one on, and with both ends."""
    run: Any = result.run
    own = run.trajectory
    count = len(own.times)
    chosen = np.unique(np.concatenate(([0], np.arange(first, count, EVERY), [count - 1])))
    names = ("times", "coordinates", "speeds", "dissipated", "work", "internal")
    rows = {name: np.ascontiguousarray(getattr(own, name)[chosen]) for name in names}
    rates = None if own.accelerations is None else np.ascontiguousarray(own.accelerations[chosen])
    return Result(run.model, replace(own, **rows, accelerations=rates))


def _order(result: Result) -> tuple[str, ...]:
    """Return the names of events in the order of time."""
    found = sorted((float(t), name) for name, times in result.events.items() for t in np.atleast_1d(times))
    return tuple(name for _, name in found)


@contextmanager
def shown(wanted: bool | None) -> Iterator[Callable[[int, float], None]]:
    """Give what shows the bound as it falls."""
    if not (is_watched() if wanted is None else wanted):
        yield lambda count, bound: None
        return
    with progress_bar(bar_format="{desc}", leave=False) as bar:
        yield lambda count, bound: bar.set_description_str(
            f"accuracy: {count} evaluations, bound {bound:.2g} of what is allowed"
        )
