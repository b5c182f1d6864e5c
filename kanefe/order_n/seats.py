"""Where the frames of a scene sit in the rows of the kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.bodies.marker import CoordinateMarker, Marker
from kanefe.frames import Matrix, Vector
from kanefe.kernels.loads_between import AT, COORDINATE, SPEED
from kanefe.kernels.markers import MARKER_NUMBERS
from kanefe.order_n.inputs import InputLayout
from kanefe.tree.model_data import ModelData


@dataclass(frozen=True, eq=False)
class Seat:
    """Where a frame of the model sits in the rows: row (-1: N), axes to those of the row, origin in the row (m)."""

    row: int
    axes: Matrix
    place: Vector


class Seats:
    """The seats of a model's frames, which tables of loads and constraints ask for.

    Parameters
    ----------
    model : ModelData

    Attributes
    ----------
    seats : list of Seat
        Of every body's frame.
    interfaces : dict
        Row of an interface by body number and name.
    inputs : InputLayout
        Where the values of loads are.
    """

    def __init__(self, model: ModelData) -> None:
        self.model = model
        self.seats: list[Seat] = []
        self.interfaces: dict[tuple[int, str], int] = {}
        self.inputs = InputLayout(model)

    def seat(self, number: int, interface: InterfaceFrame | None) -> Seat:
        """Return where the frame of a body, or of one of its interfaces, sits; number -1 is N."""
        if number < 0:
            return Seat(-1, np.eye(3), np.zeros(3))
        if interface is None:
            return self.seats[number]
        return Seat(self.interfaces[number, interface.name], np.eye(3), np.zeros(3))

    def marker_numbers(self, marker: Marker) -> tuple[int, np.ndarray]:
        """Return the row of a marker, and its place and axes in that row; of a joint coordinate where it is."""
        if isinstance(marker, CoordinateMarker):
            numbers = np.zeros(MARKER_NUMBERS)
            numbers[[AT, SPEED]] = self.model.coordinate_places(marker.body)[marker.coordinate]
            return COORDINATE, numbers
        seat = self.seat(marker.body, marker.interface)
        return seat.row, np.concatenate((seat.place + seat.axes @ marker.point, (seat.axes @ marker.axes).ravel()))
