"""MOVED"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Matrix, Vector
from kanefe.order_n.tables import TableBuilder

if TYPE_CHECKING:
    from kanefe.order_n.tables import TableBuilder


@dataclass(frozen=True, eq=False)
class Seat:
    """Where a frame of the model sits in the rows: row (-1: N), axes to those of the row, origin in the row (m)."""

    row: int
    axes: Matrix
    place: Vector


def marker_numbers(builder: TableBuilder, marker: Marker) -> tuple[int, np.ndarray]:
    """Return the row of a marker, and its place and axes in that row."""
    seat = builder.seat(marker.body, marker.interface)
    return seat.row, np.concatenate((seat.place + seat.axes @ marker.point, (seat.axes @ marker.axes).ravel()))
