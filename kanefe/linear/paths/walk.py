"""A walk along a path: steps as long as their corrections allow, which stay on it."""

from __future__ import annotations

import numpy as np

from kanefe.linear.paths.arc_length import PathLost, Stop, stepped
from kanefe.linear.paths.continuity import check_continuity
from kanefe.linear.paths.loaded_scene import LoadedScene

BENT, TOO_BENT = 0.03, 0.2
"""Length of all corrections relative to that of the step: for which the next step is chosen, and which is refused."""

TURNED = 0.7
"""Cosine between successive tangents below which a step is refused: it may have jumped to another path."""

SHORTEST = 1e-6
"""Shortest step relative to the longest."""

BEGINS = 0.01
"""Longest first step, of which no curvature is known: largest change of one coordinate or of the factor, as `longest`.
"""


class Walk:
    """Successive stops of a path, with steps that are as long as their corrections allow.

    Parameters
    ----------
    scene : LoadedScene
    longest : float
        Largest change of one coordinate in a step, rad or scene lengths, and of the factor relative to its range.
    """

    def __init__(self, scene: LoadedScene, longest: float) -> None:
        self.scene, self.longest = scene, longest
        self._length = 0.0

    def next(self, origin: Stop) -> Stop:
        """Return the next stop; a PathLost if the shortest step has none."""
        largest = self.scene.largest(origin.ahead)
        if not 0.0 < largest < np.inf:
            raise PathLost("its tangent overflows")
        unit = 1.0 / largest
        limit = self.longest * unit
        length = min(self._length or BEGINS * unit, limit)
        while True:
            try:
                stop = stepped(self.scene, origin, length, TOO_BENT * length)
                if self.scene.dot(stop.ahead, origin.ahead) < TURNED:
                    raise PathLost("the path turns sharply")
                check_continuity(self.scene, origin, stop)
            except PathLost:
                length *= 0.5
                if length < SHORTEST * limit:
                    raise
                continue
            # the corrections grow with the square of the length, beyond the curvature that is foreseen
            bend = stop.corrected / length
            self._length = length * min(2.0, max(0.5, (BENT / max(bend, 1e-3 * BENT)) ** 0.5))
            return stop

    def shorter(self, length: float) -> None:
        """Let the next step be no longer than this."""
        self._length = length
