"""Time by part of a run, that of functions of the user among them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from kanefe.kernels.compiler._numba import seconds_compiling
from kanefe.loads.functions import SPENT

FUNCTIONS, CONTROLLERS = OF_USER = "Python functions", "controllers"
"""Parts of a run in functions of the user, whose time only the user can reduce."""


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
        began, compiled, aside, spent = time.perf_counter(), seconds_compiling(), self._aside, SPENT.seconds
        try:
            yield
        finally:
            compiled = seconds_compiling() - compiled
            spent = SPENT.seconds - spent
            self._add(name, time.perf_counter() - began - compiled - spent - (self._aside - aside))
            if spent > 0.0:
                self._add(FUNCTIONS, spent)
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

    @property
    def share_of_user(self) -> float:
        """Share of the time that was spent in functions of the user."""
        return sum(self.seconds.get(name, 0.0) for name in OF_USER) / max(sum(self.seconds.values()), 1e-300)

    def _add(self, name: str, seconds: float) -> None:
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
