"""The state that functions of the user see in order n: motions of all frames from one sweep at the first request."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, Marker
from kanefe.frames import Vector, cross
from kanefe.kernels.scene import memory_size
from kanefe.kernels.sweeps.outward import motions_of_rows
from kanefe.loads.action import End
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.placed import Placed
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

MOTION_NUMBERS = 18
"""Numbers that tell the motion of a row: position, axes, velocity and angular velocity in N."""


class SweptState(SceneState):
    """A state of a scene in order n: see `SceneState`.

    Parameters
    ----------
    kernel : MotionsKernel
    t : float
        s.
    y : ndarray
        Begins with q, u and z.
    """

    def __init__(self, kernel: MotionsKernel, t: float, y: Vector) -> None:
        super().__init__(kernel.route.model, t, *kernel.route.parts(y))
        self._kernel, self._y = kernel, y
        self._swept: np.ndarray | None = None

    @property
    def _rows(self) -> np.ndarray:
        if self._swept is None:  # the lock of a cached property takes longer than this
            self._swept = self._kernel.rows(self.time, self._y)
        return self._swept

    @property
    def frames(self) -> list[Placed]:
        """Motion of every body's frame."""
        return [self._body_frame(number) for number in range(len(self.model.bodies))]

    def _body_frame(self, number: int) -> Placed:
        return _placed(self._kernel.end(self._rows, number, None))

    def placed(self, number: int, frame: InterfaceFrame | None) -> Placed:
        """Return the motion of a body's frame, or of one of its interfaces or nodes (axes of G rotated with it)."""
        if frame is None or not self._kernel.has_row(number, frame):  # a node to which nothing is attached
            return super().placed(number, frame)
        return _placed(self._kernel.end(self._rows, number, frame))

    def _end(self, marker: Marker) -> End:
        is_elsewhere = marker.body < 0 or isinstance(marker, CoordinateMarker)
        if is_elsewhere or (marker.interface is not None and not self._kernel.has_row(marker.body, marker.interface)):
            return super()._end(marker)
        p, A, v, w = self._kernel.end(self._rows, marker.body, marker.interface)
        lever = A @ marker.point
        return End(p + lever, A @ marker.axes, v + cross(w, lever), w)

    def _found(self, number: int, name: str, interface: str) -> End:
        if not interface:
            return self._kernel.end(self._rows, number, None)
        frame, is_turned = self._kernel.interface(number, interface)
        end = self._kernel.end(self._rows, number, frame)
        return end._replace(A=end.A @ frame.axes) if is_turned else end


def _placed(end: End) -> Placed:
    return Placed(end.A, end.p, end.v @ end.A, end.w @ end.A)


class MotionsKernel:
    """The kernel of the motion of all frames at one state, with the tables of a scene; several threads may use it.

    Attributes
    ----------
    route : Evaluated
    """

    def __init__(self, route: Evaluated) -> None:
        self.route = route
        self._idle: list[_MotionsCall] = []
        self._interfaces: dict[tuple[int, str], tuple[InterfaceFrame, bool]] = {}

    def rows(self, t: float, y: Vector) -> np.ndarray:
        """Return position, axes, velocity and angular velocity of all rows in N at a state, (rows, 18)."""
        drives = self.route.drives(t)
        try:
            call = self._idle.pop()
        except IndexError:
            call = _MotionsCall(self.route)
        found = call(drives, y)
        self._idle.append(call)
        return found

    def interface(self, number: int, name: str) -> tuple[InterfaceFrame, bool]:
        """Return an interface of a flexible body, and whether its axes are others than those of G turned with it."""
        found = self._interfaces.get((number, name))
        if found is None:
            model = self.route.model
            frame = model.flexible_terms(model.bodies[number].name).body.interface(name)
            found = self._interfaces[number, name] = frame, not np.array_equal(frame.axes, np.eye(3))
        return found

    def has_row(self, number: int, frame: InterfaceFrame) -> bool:
        """Return whether the kernel tells of a frame of a body's mesh, by the number of the body."""
        return (number, frame.name) in self.route.complete[0].interfaces

    def end(self, rows: np.ndarray, number: int, frame: InterfaceFrame | None) -> End:
        """Return the motion of a body's frame, or of one of its interfaces in axes of G turned with it."""
        where = self.route.complete[0].frame_offset(number, frame)
        if where.row < 0:
            return End(where.place, where.axes, np.zeros(3), np.zeros(3))
        row = rows[where.row]
        p, R, v, w = row[:3], row[3:12].reshape(3, 3), row[12:15], row[15:]
        if where.is_row:
            return End(p, R, v, w)
        lever = R @ where.place
        return End(p + lever, R @ where.axes, v + cross(w, lever), w)


class _MotionsCall:
    """A call whose arrays stay where they are: of one thread at a time."""

    def __init__(self, route: Evaluated) -> None:
        model, (_, scene) = route.model, route.complete
        size, driven = model.coordinate_count + model.free_count, len(model.drives)
        self._state, self._drives = np.empty((1, size)), np.empty((1, driven, 3))
        self._found = np.empty((1, len(scene.tables.rows), MOTION_NUMBERS))
        no_rates, memory = np.zeros((0, model.free_count)), np.empty(memory_size(scene))
        arrays = self._drives, self._state, no_rates, self._found, memory
        self._call = motions_of_rows.bound(scene, *arrays).prepared()

    def __call__(self, drives: np.ndarray, y: Vector) -> np.ndarray:
        self._drives[0], self._state[0] = drives, y[: self._state.shape[1]]
        self._call()
        return self._found[0].copy()
