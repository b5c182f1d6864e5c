"""Ends of loads that are points of flexible bodies: they are not links, and are evaluated where their load can act."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.loads.base import Load
from kanefe.order_n.tables.modal_constants import ModalConstants

if TYPE_CHECKING:
    from kanefe.loads.reach import LoadReach


def body_of_points(load: Load, reach: LoadReach | None) -> int:
    """Return the body whose points all ends of a load but the first are, or -1.

    Such a load tells where it can act. The first end is what is touched. Interfaces of the second order have rows.
    """
    if reach is None or len(load.ends) < 2:
        return -1
    bodies = {marker.body for marker in load.ends[1:]}
    interfaces = [marker.interface for marker in load.ends[1:]]
    is_linear = all(interface is not None and interface.is_linear for interface in interfaces)
    return int(bodies.pop()) if is_linear and len(bodies) == 1 else -1


def point_numbers(loads: Sequence[Load], modes: ModalConstants) -> tuple[dict[str, int], np.ndarray]:
    """Return what `Team` has of the points of loads on one body, in the kernels' order, and their numbers."""
    frames = [marker for load in loads for marker in load.ends[1:]]
    motions = [modes.of_interface(frame.interface.motion[:, : modes.count]) for frame in frames]
    turns = any(motion[3:].any() for motion in motions)
    is_plain = all(not frame.point.any() and np.array_equal(frame.axes, np.eye(3)) for frame in frames)
    places = np.array([frame.interface.position for frame in frames])
    basis = np.concatenate([motion if turns else motion[:3] for motion in motions])
    counts = {"point_count": len(frames), "mode_count": modes.count, "column_count": len(basis)}
    return counts | {"turns": turns, "is_plain": is_plain}, np.concatenate((places.T.ravel(), basis.T.ravel()))
