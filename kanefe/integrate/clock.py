"""Time by part of a run, that of functions of the user among them."""

from __future__ import annotations

import time

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

    def part(self, name: str) -> _Part:
        """Return what adds the time of what is inside to a part."""
        return _Part(self, name)

    def set_aside(self, name: str, seconds: float) -> None:
        """Take some time (s) from the part around it, and add it to a part of its own."""
        self._add(name, seconds)
        self._aside += seconds

    @property
    def share_of_user(self) -> float:
        """Share of the time that was spent in functions of the user."""
        return sum(self.seconds.get(name, 0.0) for name in OF_USER) / max(sum(self.seconds.values()), 1e-300)

    def _add(self, name: str, seconds: float) -> None:
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds


class _Part:
    """The time of a part: a class, since a generator takes three times as long."""

    __slots__ = ("_aside", "_began", "_clock", "_compiled", "_name", "_spent")

    def __init__(self, clock: Clock, name: str) -> None:
        self._clock, self._name = clock, name

    def __enter__(self) -> None:
        self._compiled, self._aside, self._spent = seconds_compiling(), self._clock._aside, SPENT.seconds
        self._began = time.perf_counter()

    def __exit__(self, *error: object) -> None:
        clock, seconds = self._clock, time.perf_counter() - self._began
        compiled, spent = seconds_compiling() - self._compiled, SPENT.seconds - self._spent
        clock._add(self._name, seconds - compiled - spent - (clock._aside - self._aside))
        if spent > 0.0:
            clock._add(FUNCTIONS, spent)
        if compiled > 0.0:
            clock._add("compiling", compiled)
