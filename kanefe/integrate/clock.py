"""Time by part of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from kanefe.kernels._numba import seconds_compiling


class Clock:
    """Seconds by part; parts do not lie within each other. What is compiled in one of them is a part by itself.

    Examples
    --------
    >>> clock = Clock()
    >>> with clock.part("steps"):
    ...     pass
    >>> list(clock.seconds)
    ['steps']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._aside = 0.0

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Add the time of what is inside to a part."""
        began, compiled, aside = time.perf_counter(), seconds_compiling(), self._aside
        try:
            yield
        finally:
            compiled = seconds_compiling() - compiled
            self._add(name, time.perf_counter() - began - compiled - (self._aside - aside))
            if compiled > 0.0:
                self._add("compiling", compiled)

    @contextmanager
    def aside(self, name: str) -> Iterator[None]:
        """Take the time of what is inside from the part around it, and add it to a part of its own."""
        began = time.perf_counter()
        try:
            yield
        finally:
            seconds = time.perf_counter() - began
            self._add(name, seconds)
            self._aside += seconds

    def _add(self, name: str, seconds: float) -> None:
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
