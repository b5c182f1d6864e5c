"""Lines of springs, ropes and other loads between frames, of a run in memory: where their laws have them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.loads.base import Load
from kanefe.results.contact_history import is_contact
from kanefe.results.reader import Reader

TAUT, SLACK, GONE = 0, 1, 2
"""How a line is: of a spring or a rope that pulls, of a rope that does not, of one that has broken."""

SLACKNESS = "slack [1]"
"""The column of a load that tells whether it is slack."""


class LoadLine(NamedTuple):
    """The line of a load at some output times.

    Attributes
    ----------
    name : str
    points : ndarray, shape (S, ends, 3)
        Where its ends are, in their order, in N, m.
    states : ndarray of uint8, shape (S,)
        TAUT, SLACK or GONE.
    """

    name: str
    points: np.ndarray
    states: np.ndarray


def load_lines(result: Reader, frames: np.ndarray) -> list[LoadLine]:
    """Return the lines of the loads that act along one, at output times given by number.

    They go through the ends that the law itself is given, so that a rope's line is as long as the law says.
    """
    run = result.run
    if run is None:
        return []
    loads = {number: load for number, load in enumerate(run.model.loads) if _is_line(load)}
    if not loads:
        return []
    lines = {
        number: LoadLine(load.name, np.empty((len(frames), len(load.ends), 3)), np.zeros(len(frames), dtype=np.uint8))
        for number, load in loads.items()
    }
    for row, state in enumerate(run.placed(frames)):
        for number, load in loads.items():
            ends, line = state.load_ends(number), lines[number]
            line.points[row] = [end.p for end in ends]
            if SLACKNESS in load.columns:
                told = load.tell(state.time, ends, state.load_states(number))
                line.states[row] = SLACK if told[load.columns.index(SLACKNESS)] else TAUT
    for line in lines.values():
        for time in result.events.get(f"{line.name} breaks", ()):
            line.states[result.times[frames] >= time] = GONE
    return list(lines.values())


def dashes(points: np.ndarray, length: float) -> np.ndarray:
    """Return the ends of dashes along a line over points (n, 3), each and each gap about so long, (d, 2, 3) in m."""
    found = []
    for a, b in pairwise(points):
        count = max(1, round(0.5 * float(np.linalg.norm(b - a)) / length))
        shares = (np.arange(count)[:, None] + np.array((0.25, 0.75))) / count
        found.append(a + shares[:, :, None] * (b - a))
    return np.concatenate(found)


def _is_line(load: Load) -> bool:
    ends = load.ends
    if is_contact(load.columns) or "contact" in load.kind or any(isinstance(end, CoordinateMarker) for end in ends):
        return False
    return len(ends) == 2 or load.runs_over_ends
