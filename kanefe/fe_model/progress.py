"""The stages of a long computation: a bar while they run, and how long each took.

Whoever computes names its stages; whoever was asked for the whole shows them. In between nothing is passed on.
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
        How many there will be.
    wanted : bool or None
        Whether to show them; None: on a terminal, once `is_large` is told.

    Attributes
    ----------
    seconds : dict of str to float
        Time of each stage, s.
    """

    def __init__(self, total: int, wanted: bool | None) -> None:
        self.seconds: dict[str, float] = {}
        self._total, self._done = total, 0
        self._wanted = wanted
        self._bar: Any = None

    def is_large(self, size: int) -> None:
        """Take in the number of degrees of freedom, which decides where nothing else was said."""
        if self._wanted is None:
            self._wanted = size > LARGE and is_watched()

    def begin(self, name: str) -> None:
        """Show that a stage begins."""
        if self._wanted and self._bar is None:
            layout = "{desc}: {percentage:3.0f}%|{bar}| {n}/{total} stages [{elapsed}]"
            self._bar = progress_bar(
                total=self._total, initial=self._done, bar_format=layout, leave=False, disable=False
            )
        if self._bar is not None:
            self._bar.set_description_str(name)

    def end(self, name: str, seconds: float) -> None:
        """Show that a stage is done."""
        self._done += 1
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
        if self._bar is not None:
            self._bar.update(min(1, self._total - self._bar.n))

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.close()


_shown: ContextVar[Stages | None] = ContextVar("stages", default=None)


@contextmanager
def stages(total: int, wanted: bool | None = None) -> Iterator[Stages]:
    """Show the stages that are named inside, and note their times.

    Parameters
    ----------
    total : int
        How many there will be.
    wanted : bool, optional
        Default: when the standard error is a terminal and `size_in_words` told of a large body.

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
    """Name what is computed inside; costs nothing where nobody shows it."""
    shown = _shown.get()
    if shown is None:
        yield
        return
    shown.begin(name)
    start = time.perf_counter()
    yield
    shown.end(name, time.perf_counter() - start)


def size_in_words(size: int) -> None:
    """Return the number of degrees of freedom in words as soon as it is known."""
    shown = _shown.get()
    if shown is not None:
        shown.is_large(size)
