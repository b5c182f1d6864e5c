"""Counts of events in a run: a skid slipped or lifted, a lashing broke, an aircraft toppled."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from kanefe.errors import ModelError
from kanefe.result import Result
from kanefe.studies.statistics.reducers import finite


@dataclass(frozen=True)
class EventCounts:
    """See `events`."""

    patterns: dict[str, str]
    after: float

    def __call__(self, result: Result) -> dict[str, int]:
        """Return the counts of a run by name."""
        found = {}
        for name, pattern in self.patterns.items():
            times = [at for event, at in result.events.items() if fnmatchcase(event, pattern)]
            if not times:
                raise ModelError(f"the run has no event {pattern!r}. It has: {', '.join(result.events) or 'none'}")
            found[name] = int(sum(np.count_nonzero(at >= self.after) for at in times))
        return found


def events(*, after: float = 0.0, **patterns: str) -> EventCounts:
    """Return a reducer to the numbers of events whose names match patterns.

    With a limit of zero, ``table.operability`` estimates the probability of at least one event: that something slips,
    lifts or breaks, or an event of ``simulate={"events": ...}``, such as an angle at which it topples.

    Parameters
    ----------
    after : float
        Time from which events count, s, such as after the ramp of a sea.
    **patterns : str
        Names of events, in which ``*`` matches anything, by name of the output.

    Raises
    ------
    ModelError
        If an argument is not valid; when called, if the run has no such event.

    Examples
    --------
    >>> from kanefe.studies import events
    >>> counts = events(slips="* slip", lifts="* lift", broken="* breaks", after=30.0)
    >>> study = kf.Study(build, counts, ...)                                         # doctest: +SKIP
    >>> study.run().operability({"slips": 0, "lifts": 0, "broken": 0})               # doctest: +SKIP
    """
    after = finite(after, "after")
    if not patterns or not all(isinstance(pattern, str) and pattern for pattern in patterns.values()):
        raise ModelError(f"events are by name, such as slips='* slip', not {patterns!r}. Remedy: texts")
    return EventCounts(patterns, after)
