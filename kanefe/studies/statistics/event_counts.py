"""How often something happened in a run: a skid slipped or lifted, a lashing broke, an aircraft toppled."""

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
    """Return a reducer to how many events of a run have names like some patterns.

    With a limit of zero, ``table.operability`` tells how probable it is that there is one: that something slips, lifts
    or breaks, or does what an event of ``simulate={"events": ...}`` looks at, such as the angle at which it topples.

    Parameters
    ----------
    after : float
        Time from which they count, s: after the ramp of a sea.
    **patterns : str
        By name of the output, the name of an event, in which ``*`` stands for anything.

    Raises
    ------
    ModelError
        If an argument makes no sense; when it is called, if the run knows no such event.

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
