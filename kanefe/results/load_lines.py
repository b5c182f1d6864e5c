"""Lines of springs, ropes and other loads between frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Vector
from kanefe.loads.base import Load
from kanefe.results.contact_history import is_contact

if TYPE_CHECKING:
    from kanefe.tree.model_data import ModelData
    from kanefe.tree.run_sweeps import RunSweeps
    from kanefe.tree.scene_state import SceneState

TAUT, SLACK, GONE = 0, 1, 2
"""States of a line: a spring or a rope in tension, a slack rope, a broken rope."""

SLACKNESS = "slack [1]"
"""Column of a load that shows whether it is slack."""


class LoadLine(NamedTuple):
    """The line of a load at some output times.

    Attributes
    ----------
    name : str
    points : ndarray, shape (S, ends, 3)
        Its ends, in order, in N, m.
    states : ndarray of uint8, shape (S,)
        TAUT, SLACK or GONE.
    """

    name: str
    points: np.ndarray
    states: np.ndarray

    def at(self, rows: np.ndarray | int) -> LoadLine:
        """Return the line at some of the times, or at one, without the axis of times."""
        return LoadLine(self.name, self.points[rows], self.states[rows])


class PlacedRun(Protocol):
    """Requirements on a run in memory: `kanefe.results.channels.RunChannels`."""

    @property
    def model(self) -> ModelData: ...  # noqa: D102
    @property
    def times(self) -> Vector: ...  # noqa: D102
    @property
    def events(self) -> Mapping[str, Vector]: ...  # noqa: D102
    @property
    def swept(self) -> RunSweeps: ...  # noqa: D102
    @property
    def is_swept(self) -> bool: ...  # noqa: D102
    def placed(self, rows: np.ndarray) -> Iterator[SceneState]: ...  # noqa: D102
    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray: ...  # noqa: D102


def lines_of_run(run: PlacedRun, rows: np.ndarray) -> tuple[LoadLine, ...]:
    """Return the lines of the loads that act along one, at output times given by number.

    They go through the ends that the law uses, so that a rope's line has the length in its law.
    """
    loads = {number: load for number, load in enumerate(run.model.loads) if _is_line(load)}
    if not loads:
        return ()
    lines = {
        number: LoadLine(load.name, np.empty((len(rows), len(load.ends), 3)), np.zeros(len(rows), dtype=np.uint8))
        for number, load in loads.items()
    }
    for number, load in loads.items():
        if run.is_swept:
            for end, marker in enumerate(load.ends):
                frame = run.swept.frame(marker.body, marker.interface)
                turn = np.eye(3) if marker.interface is None else marker.interface.axes.T  # frames have those axes
                lines[number].points[:, end] = frame.position[rows] + frame.axes[rows] @ (turn @ marker.point)
        if SLACKNESS in load.columns:
            is_slack = run.read("load", load.name)[rows, load.columns.index(SLACKNESS)]
            lines[number].states[:] = np.where(is_slack, SLACK, TAUT)
    if not run.is_swept:
        for row, state in enumerate(run.placed(rows)):
            for number in loads:
                lines[number].points[row] = [end.p for end in state.load_ends(number)]
    for line in lines.values():
        for time in run.events.get(f"{line.name} breaks", ()):
            line.states[run.times[rows] >= time] = GONE
    return tuple(lines.values())


def _is_line(load: Load) -> bool:
    ends = load.ends
    if is_contact(load.columns) or "contact" in load.kind or any(isinstance(end, CoordinateMarker) for end in ends):
        return False
    return len(ends) == 2 or load.runs_over_ends
