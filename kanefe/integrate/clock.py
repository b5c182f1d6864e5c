"""Time by part of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Clock:
    """Seconds by part; parts do not lie within each other.

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

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Add the time of what is inside to a part."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - began
