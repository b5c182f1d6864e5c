"""Bearings of rotating shafts, with stiffness and damping coefficients that are constant or depend on the speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.kernels.force_elements.bearing import (
    BearingNumbers,
    BearingRow,
    bearing,
    held_in,
    speed_of,
    watch_bearing,
)
from kanefe.kernels.force_elements.bushing import in_blocks
from kanefe.kernels.values.filled import filled
from kanefe.loads.action import End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent
from kanefe.loads.bushing import check_damps, principal_tangent, relative_rows
from kanefe.loads.by_kernel import EventByKernel, numbers_of

AXES = ("x", "y", "z")


@checked("name")
@dataclass(frozen=True, eq=False)
class Bearing(Load):
    """A bearing: force and moment on a shaft from its displacement and tilt, with coefficients over its speed.

    With x = (d, tilt), d from the origin of the bearing to that of the shaft and ``tilt = e x e'`` of their axes, all
    in the axes of the bearing,

        (force, F_tilt) = -K(speed) x - C(speed) dx/dt,    moment = e' x (F_tilt x e) - drag speed e'

    where the power of the moment is ``F_tilt dtilt/dt``. About its axis the shaft rotates freely, except for a drag.
    The opposite force and moment act on the bearing, at the same point. With constant coefficients the symmetric part
    of K has a potential; the work of the rest, and of all springs of a table, counts as work of loads.

    Attributes
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : (Frame, Frame) or (Frame, Frame, Frame)
        The bearing, whose axes are used; the shaft; and optionally the frame whose speed of rotation is used instead of
        the shaft's, such as a disc that spins on a shaft that does not.
    stiffness, damping : array_like, shape (2, 2), (6, 6), or (S, 2, 2), (S, 6, 6) of a table
        Over the two directions across the axis, in cyclic order (y, z for an axis x; z, x for y; x, y for z), or over
        x, y, z and the tilts about them: N/m, N/rad, N m/m, N m/rad; N s/m and so on. Rows force, columns motion; they
        need not be symmetric. In (6, 6) row and column of the rotation about the axis are zero, except for the drag in
        the damping, N m s/rad.
    speeds : array_like, shape (S,), optional
        Speeds of rotation of a table, ascending, rad/s, with monotone cubic interpolation. The run ends at a speed
        outside the table.
    axis : 'x', 'y' or 'z'
        Axis of rotation, of both frames.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    A journal bearing with cross-coupled stiffness, N/m, at three speeds:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> rotor = scene.add_rigid_body("rotor", 5.0, (0.02, 0.01, 0.01), joint=kf.Free(angular_velocity=(100.0, 0, 0)))
    >>> K = 1e6 * np.array([[[2.0, c], [-c, 2.0]] for c in (0.1, 0.3, 0.5)])
    >>> C = np.array(3 * [1e3 * np.eye(2)])
    >>> scene.add(kf.Bearing("journal", (scene.ground, rotor), K, C, speeds=(0.0, 200.0, 400.0)))
    >>> kf.linearise(scene).modes().frequencies.round(1)[-2:]
    array([100.7, 100.7])
    """

    name: str
    ends: tuple[Any, ...]
    stiffness: Any
    damping: Any = None
    speeds: Any = None
    axis: str = "x"

    kind = "bearing"
    columns = (
        *(f"displacement {c} [m]" for c in "xyz"),
        *(f"tilt {c} [rad]" for c in "xyz"),
        *(f"force {c} [N]" for c in "xyz"),
        *(f"moment {c} [N m]" for c in "xyz"),
        "speed [rad/s]",
    )

    def __post_init__(self) -> None:
        label = f"bearing {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) not in (2, 3):
            raise ModelError(
                f"ends of {label} must be the bearing, the shaft, and optionally the spinning body, not {self.ends!r}"
            )
        object.__setattr__(self, "ends", tuple(self.ends))
        if not isinstance(self.axis, str) or self.axis not in AXES:
            raise ModelError(f"axis of {label} must be 'x', 'y' or 'z', not {self.axis!r}")
        if self.speeds is not None:
            speeds = numbers(self.speeds)
            if speeds.ndim != 1 or len(speeds) < 2 or not np.all(np.isfinite(speeds)) or np.any(np.diff(speeds) <= 0.0):
                raise ModelError(f"speeds of {label} must be two or more that ascend, rad/s, not {self.speeds!r}")
            object.__setattr__(self, "speeds", speeds)
        rows = () if self.speeds is None else (len(self.speeds),)
        for what in ("stiffness", "damping"):
            given = getattr(self, what)
            given = np.zeros((*rows, 2, 2)) if given is None else given
            object.__setattr__(self, what, self._wide(given, rows, f"{what} of {label}"))
        i = 3 + AXES.index(self.axis)
        coupled = self.damping.copy()
        coupled[..., i, i] = 0.0
        if (
            self.stiffness[..., i, :].any()
            or self.stiffness[..., i].any()
            or coupled[..., i, :].any()
            or coupled[..., i].any()
        ):
            raise ModelError(
                f"{label} resists the turn about its axis {self.axis}: row and column r{self.axis} must be zero, but "
                "for the drag in the damping. Remedy: a bushing, for limited rotation"
            )
        check_damps(self.damping, label)
        if not self.stiffness.any() and not self.damping.any():
            raise ModelError(f"{label} does nothing. Remedy: give stiffness or damping")

    def _wide(self, given: object, rows: tuple[int, ...], what: str) -> np.ndarray:
        """Return coefficients over all six directions."""
        array = numbers(given)
        if array.shape not in ((*rows, 2, 2), (*rows, 6, 6)) or not np.all(np.isfinite(array)):
            of_speeds = f" for each of the {rows[0]} speeds" if rows else " (no speeds= are given)"
            raise ModelError(f"{what} must be finite numbers, shape (2, 2) or (6, 6){of_speeds}, not {given!r}")
        if array.shape[-1] == 6:
            return array
        found, i = np.zeros((*rows, 6, 6)), AXES.index(self.axis)
        across = np.array(((i + 1) % 3, (i + 2) % 3))
        found[..., across[:, None], across] = array
        return found

    @property
    def exchanges_energy(self) -> bool:
        """Whether it dissipates or supplies energy."""
        is_even = np.array_equal(self.stiffness, np.swapaxes(self.stiffness, -1, -2))
        return bool(self.damping.any() or not is_even or self.speeds is not None)

    @cached_property
    def _curves(self) -> PchipInterpolator:
        return PchipInterpolator(self.speeds, np.stack((self.stiffness, self.damping), axis=1), axis=0)

    @checked("speed")
    def coefficients(self, speed: float) -> tuple[Matrix, Matrix]:
        """Return stiffness and damping at a speed of rotation (rad/s), (6, 6) each; beyond a table those at its end."""
        return self._at(speed)

    def _at(self, speed: float) -> tuple[Matrix, Matrix]:
        if self.speeds is None:
            return self.stiffness, self.damping
        K, C = self._curves(np.clip(speed, self.speeds[0], self.speeds[-1]))
        return K, C

    def _speed(self, ends: Sequence[End]) -> float:
        """Return the speed of rotation relative to the bearing, about its axis, on which coefficients depend, rad/s."""
        return float(speed_of(BearingNumbers(self.kernel.numbers), numbers_of(ends)))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return stiffness and damping along their principal directions, without the skew parts."""
        rows = np.hstack((relative_rows(*ends[:2]), np.zeros((6, 6 * (len(ends) - 2)))))
        return principal_tangent(rows, *self._at(self._speed(ends)))

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """The event of a speed outside its table, which ends the run."""
        slip_margin = EventByKernel(self, watch_bearing, 0)
        return () if self.speeds is None else (LoadEvent("leaves its table", slip_margin, -1, self._left),)

    def _left(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        raise SimulationError(self._words(t, self._speed(ends)))

    def _words(self, t: float, speed: float) -> str:
        return (
            f"the coefficients of bearing {self.name!r} reach from {self.speeds[0]:.6g} to {self.speeds[-1]:.6g} "
            f"rad/s, and it turns at {speed:.6g} rad/s at t = {t:.6g} s. Remedy: speeds= that cover it"
        )

    def started(self, t: float, ends: Sequence[End]) -> Bearing:
        """Return the bearing itself, if its table covers the speed at the start."""
        if any(event.function(t, ends, np.zeros(0)) < 0.0 for event in self.events):
            raise ModelError(self._words(t, self._speed(ends)))
        return self

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return displacement and tilt, force and moment on the shaft, in the axes of the bearing, and the speed."""
        d, axis = held_in(BearingNumbers(self.kernel.numbers), numbers_of(ends))
        tilt = np.cross(np.eye(3)[AXES.index(self.axis)], [*axis])
        on_shaft = self.action(t, ends, states).wrenches[1]
        return np.array((*d, *tilt, *(on_shaft[:3] @ ends[0].A), *(on_shaft[3:] @ ends[0].A), self._speed(ends)))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers: one row of coefficients, or a row for each speed."""
        if self.speeds is None:
            none = np.zeros((6, 6))
            rows = [_row(0.0, (self.stiffness, self.damping), (none, none))]
        else:
            rows = list(map(_row, self.speeds, self._curves(self.speeds), self._curves.derivative()(self.speeds)))
        axis, count = np.eye(3)[AXES.index(self.axis)], len(self.speeds) if self.events else 0
        given = filled(BearingNumbers, axis=axis, ends=len(self.ends), speeds=count, rows=rows)
        return LoadKernel(bearing, given, bearing, watch_bearing if self.events else None)


def _row(speed: float, at: Sequence[Matrix], slopes: Sequence[Matrix]) -> Vector:
    """Return the numbers of stiffness and damping at a speed, with their slopes."""
    (K, C), (K_slope, C_slope) = map(in_blocks, at), map(in_blocks, slopes)
    return filled(BearingRow, speed=speed, stiffness=(K, K_slope), damping=(C, C_slope))
