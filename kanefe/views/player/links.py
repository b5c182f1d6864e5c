"""Lines between the ends of springs, ropes and other loads between two frames, of a run in memory."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, Marker
from kanefe.frames import rotation_matrix
from kanefe.results.contact_history import is_contact
from kanefe.results.reader import Reader

NODE = "node "
"""How frames at single nodes of a mesh are called, before their number."""


def links(result: Reader, frames: np.ndarray) -> Iterable[tuple[str, np.ndarray, np.ndarray]]:
    """Yield name and both ends, (S, 3) in N, of each load that acts between two points."""
    run = result.run
    if run is None:
        return
    for load in run.model.loads:
        is_line = len(load.ends) == 2 and not any(isinstance(end, CoordinateMarker) for end in load.ends)
        if is_line and not is_contact(load.columns) and "contact" not in load.kind:
            one, two = (_track(result, frames, end) for end in load.ends)
            if one is not None and two is not None:
                yield load.name, one, two


def _track(result: Reader, frames: np.ndarray, end: Any) -> np.ndarray | None:
    """Return where a marker is, (S, 3) in N; None: a frame of which a result does not tell."""
    marker: Marker = end
    if marker.body < 0:
        return np.tile(marker.point, (len(frames), 1))
    name, interface, point = result.bodies[marker.body], "", marker.point
    if marker.interface is not None:
        interface, point = marker.interface.name, marker.interface.axes.T @ marker.point
        if interface not in result.interfaces(name):
            if not interface.startswith(NODE) or point.any():
                return None
            return result.nodal_positions(name, frames, [int(interface.removeprefix(NODE))])[:, 0]
    place = result.position(name, interface or None)[frames]
    turn = result.rotation(name, interface or None)[frames]
    return place + np.array([rotation_matrix(e) @ point for e in turn])
