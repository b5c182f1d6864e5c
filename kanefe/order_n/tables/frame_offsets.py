"""Where the frames of a scene sit in the rows of the kernels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Matrix, Vector
from kanefe.order_n.tables.arm_tables import swept_arms
from kanefe.order_n.tables.inputs import InputLayout
from kanefe.order_n.tables.load_points import body_of_points
from kanefe.order_n.tables.modal_constants import ModalConstants
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


@dataclass(frozen=True, eq=False)
class FrameOffset:
    """Where a frame of the model sits in the rows: row (-1: N), axes to those of the row, origin in the row (m)."""

    row: int
    axes: Matrix
    place: Vector

    @cached_property
    def is_row(self) -> bool:
        """Whether the frame is that of the row."""
        return not np.any(self.place) and np.array_equal(self.axes, np.eye(3))


class FrameOffsets:
    """The frame offsets of a model's frames, which tables of loads and constraints ask for.

    Parameters
    ----------
    model : ModelData

    Attributes
    ----------
    frame_offsets : list of FrameOffset
        Of every body's frame.
    interfaces : dict
        Row of an interface by body number and name.
    modes : dict of int to ModalConstants
        Of flexible bodies, by their number in the model.
    flexible_numbers : dict of int to int
        Their numbers among the flexible bodies of the kernels.
    reaches : list of LoadReach or None
        Of loads with kernels that say where they can act.
    point_bodies : list of int
        Whose points all ends of a load but the first are, or -1.
    inputs : InputLayout
        Where the values of loads are.
    arms : dict of int to ndarray
        See `swept_arms`.
    """

    def __init__(self, model: ModelData) -> None:
        self.model = model
        self.frame_offsets: list[FrameOffset] = []
        self.interfaces: dict[tuple[int, str], int] = {}
        self.modes: dict[int, ModalConstants] = {}
        self.flexible_numbers: dict[int, int] = {}
        self.reaches = [load.reach if load.kernel is not None else None for load in model.loads]
        self.point_bodies = [body_of_points(load, reach) for load, reach in zip(model.loads, self.reaches, strict=True)]
        self.inputs = InputLayout(model)
        self.arms = swept_arms(model)
        self._of_interfaces: dict[tuple[int, str], FrameOffset] = {}

    def frame_offset(self, number: int, interface: InterfaceFrame | None) -> FrameOffset:
        """Return where the frame of a body, or of one of its interfaces, sits; number -1 is N."""
        if number < 0:
            return FrameOffset(-1, np.eye(3), np.zeros(3))
        if interface is None:
            return self.frame_offsets[number]
        where = number, interface.name
        if where not in self._of_interfaces:
            self._of_interfaces[where] = FrameOffset(self.interfaces[where], np.eye(3), np.zeros(3))
        return self._of_interfaces[where]

    def marker_numbers(self, marker: Marker) -> tuple[int, np.ndarray]:
        """Return the row of a marker, and its place and axes in that row."""
        frame_offset = self.frame_offset(marker.body, marker.interface)
        return frame_offset.row, np.concatenate(
            (frame_offset.place + frame_offset.axes @ marker.point, (frame_offset.axes @ marker.axes).ravel())
        )
