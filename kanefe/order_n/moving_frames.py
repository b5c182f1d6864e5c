"""Motion of the frames of bodies at one state, from one sweep at the first request."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np

from kanefe.frames import Vector, cross
from kanefe.kernels.sweeps.outward import motion_memory_size, motions_of_rows
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.tables.frame_offsets import FrameOffset
from kanefe.tree.placed import Placed


class MovingFrames(Sequence[Placed]):
    """Motion of every body's frame at a state."""

    def __init__(self, kernel: MotionsKernel, t: float, y: Vector) -> None:
        self._kernel, self._t, self._y = kernel, t, y
        self._rows: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self._kernel.frame_offsets)

    @overload
    def __getitem__(self, number: int) -> Placed: ...

    @overload
    def __getitem__(self, number: slice) -> list[Placed]: ...

    def __getitem__(self, number: int | slice) -> Placed | list[Placed]:
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        if self._rows is None:
            self._rows = self._kernel.rows(self._t, self._y)
        return _placed(self._rows, self._kernel.frame_offsets[number])


class MotionsKernel:
    """The kernel of the motion of all rows at one state, with the tables of a scene; several threads may use it.

    Attributes
    ----------
    frame_offsets : list of FrameOffset
        Of every body's frame.
    """

    def __init__(self, route: Evaluated) -> None:
        self._route, self.frame_offsets = route, route.places.frame_offsets
        self._idle: list[_MotionsCall] = []

    def rows(self, t: float, y: Vector) -> np.ndarray:
        """Return position, axes, velocity and angular velocity of all rows in N at a state (q, u, ...), (rows, 18)."""
        drives = self._route.drives(t)
        try:
            call = self._idle.pop()
        except IndexError:
            call = _MotionsCall(self._route)
        found = call(drives, y)
        self._idle.append(call)
        return found


class _MotionsCall:
    """A call whose arrays stay where they are: of one thread at a time."""

    def __init__(self, route: Evaluated) -> None:
        model, tables, flexible = route.model, route.tables, route.flexible
        size, driven = model.coordinate_count + model.free_count, len(model.drives)
        self._state, self._drives = np.empty((1, size)), np.empty((1, driven, 3))
        self._found, memory = np.empty((1, len(tables.rows), 18)), np.empty(motion_memory_size(tables, flexible))
        no_rates, given = np.zeros((0, model.free_count)), np.empty((driven, 3))
        arrays = self._drives, self._state, no_rates, self._found, given, memory
        self._call = motions_of_rows.bound(tables, flexible, *arrays).prepared()

    def __call__(self, drives: np.ndarray, y: Vector) -> np.ndarray:
        self._drives[0], self._state[0] = drives, y[: self._state.shape[1]]
        self._call()
        return self._found[0].copy()


def _placed(work: np.ndarray, frame_offset: FrameOffset) -> Placed:
    if frame_offset.row < 0:
        return Placed(frame_offset.axes, frame_offset.place, np.zeros(3), np.zeros(3))
    p, R, v, w = (
        work[frame_offset.row, :3],
        work[frame_offset.row, 3:12].reshape(3, 3),
        work[frame_offset.row, 12:15],
        work[frame_offset.row, 15:18],
    )
    lever, A = R @ frame_offset.place, R @ frame_offset.axes
    return Placed(A, p + lever, A.T @ (v + cross(w, lever)), A.T @ w)
