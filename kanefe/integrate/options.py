"""The options of a run, checked once when they are given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypedDict

import numpy as np

from kanefe.arguments import plain_numbers
from kanefe.errors import ModelError
from kanefe.integrate.events.event import Event, checked_events
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.trajectory import checked_span, is_finite_number, wanted_times


class StepKeywords(TypedDict, total=False):
    """How steps are taken: keywords of `kanefe.System.simulate`, `kanefe.System.start` and others."""

    method: str
    rtol: float | None
    atol: float | None
    step: float | None


class WindowKeywords(StepKeywords, total=False):
    """Keywords that the windows of a screened run take too."""

    most_steps: int | None
    most_seconds: float | None
    progress: bool | None


class RunKeywords(WindowKeywords, total=False):
    """Keywords of a run, which `kanefe.System.simulate` describes; `RunOptions` has their defaults."""

    output_step: float | None
    output_times: Sequence[float] | np.ndarray | None
    events: Sequence[Event | str] | Event | str
    checkpoint: str | Path | None
    checkpoint_seconds: float
    resume: str | Path | None


AUTO = "auto"
"""Name in place of a method that chooses one for the scene."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunOptions:
    """What the user asks for, as `kanefe.System.simulate` describes it.

    Whether the method serves the scene, and the tolerances the method, is told by
    `kanefe.integrate.auto.choice.choose`.

    Attributes
    ----------
    span : (float, float)
        Start and end in s.
    times : ndarray, shape (T,)
        Of the stored states, ascending, s.
    watched : tuple of Event
        Those of the user; of loads only those that are asked for by name, which have no function.

    Raises
    ------
    ModelError
        If an option makes no sense.
    """

    t_span: tuple[float, float]
    method: str = AUTO
    rtol: float | None = None
    atol: float | None = None
    step: float | None = None
    output_step: float | None = None
    output_times: Sequence[float] | np.ndarray | None = None
    events: Sequence[Event | str] | Event | str = ()
    checkpoint: str | Path | None = None
    checkpoint_seconds: float = 30.0
    resume: str | Path | None = None
    most_steps: int | None = None
    most_seconds: float | None = None
    progress: bool | None = None
    span: tuple[float, float] = field(init=False)
    times: np.ndarray = field(init=False)
    watched: tuple[Event, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Refuse what makes no sense, and derive the rest."""
        derive = partial(object.__setattr__, self)
        derive("span", checked_span(self.t_span))
        start, stop = self.span
        if self.method != AUTO and self.method not in METHODS:
            raise ModelError(f"there is no method {self.method!r}. Remedy: auto, {', '.join(sorted(METHODS))}")
        for name, value, top in (("rtol", self.rtol, 1.0), ("atol", self.atol, math.inf)):
            if value is not None and not (is_finite_number(value) and 0 < value < top):
                bounds = "lie between 0 and 1" if name == "rtol" else "be above zero"
                raise ModelError(f"{name} must {bounds}, not {value!r}")
        if self.step is not None and not (is_finite_number(self.step) and 0 < self.step <= stop - start):
            raise ModelError(f"step must be above zero s and within the span, not {self.step!r}")
        plain_numbers(self)
        derive("times", wanted_times(start, stop, self.output_step, self.output_times, self.step))
        derive("watched", checked_events(self.events))
        if self.most_steps is not None and not (isinstance(self.most_steps, (int, np.integer)) and self.most_steps > 0):
            raise ModelError(f"most_steps must be a whole number above zero, not {self.most_steps!r}")
        for seconds in (self.checkpoint_seconds, self.most_seconds):
            if seconds is not None and not (is_finite_number(seconds) and seconds >= 0):
                raise ModelError(f"checkpoint_seconds and most_seconds must be zero s or more, not {seconds!r}")
