"""The stages of a long computation: a progress bar while they run, and the time of each.

The outermost function opens `stages`; functions at any depth below name their part by `stage`, without an argument that
is passed down.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from kanefe.storage.watched import is_watched, progress_bar

LARGE = 50_000
"""Number of degrees of freedom from which the stages are shown on a terminal."""


class Stages:
    """The stages of one computation.

    Parameters
    ----------
    total : int
        Expected number.
    wanted : bool or None
        Whether to show them; None: on a terminal, if `set_size` reports a large body.

    Attributes
    ----------
    seconds : dict of str to float
        Time of each stage, s.
    told : list of str
        What was told of stages before they were done, such as their time and memory.
    """

    def __init__(self, total: int, wanted: bool | None) -> None:
        self.seconds: dict[str, float] = {}
        self.told: list[str] = []
        self._total, self._done, self._name = total, 0, ""
        self._wanted = wanted
        self._bar: Any = None

    def set_size(self, size: int) -> None:
        """Set the number of degrees of freedom, which decides whether stages are shown if the caller did not."""
        if self._wanted is None:
            self._wanted = size > LARGE and is_watched()

    def begin(self, name: str) -> None:
        """Show that a stage begins."""
        self._name = name
        if self._wanted and self._bar is None:
            layout = "{desc}: {percentage:3.0f}%|{bar}| {n}/{total} stages [{elapsed}]"
            self._bar = progress_bar(
                total=self._total, initial=self._done, bar_format=layout, leave=False, disable=False
            )
        if self._bar is not None:
            self._bar.set_description_str(name)

    def tell(self, text: str) -> None:
        """Show a text beside the name of the stage."""
        if self._bar is not None:
            self._bar.set_description_str(f"{self._name}: {text}")

    def end(self, name: str, seconds: float) -> None:
        """Show that a stage is done."""
        self._done += 1
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
        if self._bar is not None:
            self._bar.update(min(1, self._total - self._bar.n))

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.close()


_shown: ContextVar[Stages | None] = ContextVar("stages", default=None)


@contextmanager
def stages(total: int, wanted: bool | None = None) -> Iterator[Stages]:
    """Show the stages of the block, and record their times.

    Parameters
    ----------
    total : int
        Expected number.
    wanted : bool, optional
        Whether to show them. Default: if the standard error is a terminal and `report_size` reports a large body.

    Examples
    --------
    >>> with stages(2) as done:
    ...     with stage("cut"):
    ...         pass
    ...     with stage("glue"):
    ...         pass
    >>> list(done.seconds)
    ['cut', 'glue']
    """
    found = Stages(total, wanted)
    token = _shown.set(found)
    try:
        yield found
    finally:
        found.close()
        _shown.reset(token)


@contextmanager
def stage(name: str) -> Iterator[None]:
    """Name the computation of the block as a stage; without effect outside of `stages`."""
    shown = _shown.get()
    if shown is None:
        yield
        return
    shown.begin(name)
    start = time.perf_counter()
    yield
    shown.end(name, time.perf_counter() - start)


def report_size(size: int) -> None:
    """Report the number of degrees of freedom to the enclosing `stages`."""
    shown = _shown.get()
    if shown is not None:
        shown.set_size(size)


def tell(text: str, *, is_noted: bool = True) -> None:
    """Show a text beside the name of the stage that runs; also note it in `Stages.told`, unless it soon changes."""
    shown = _shown.get()
    if shown is not None:
        shown.tell(text)
        if is_noted:
            shown.told.append(text)
