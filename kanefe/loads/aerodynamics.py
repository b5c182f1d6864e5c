"""Wind forces on a moving frame, by tables over the wind angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, shaped_numbers
from kanefe.kernels.force_elements.aerodynamics import AerodynamicsNumbers, aerodynamics, areas_at, blown
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel
from kanefe.loads.base import Load
from kanefe.loads.by_kernel import numbers_of
from kanefe.loads.wind import Wind

AIR = 1.225
"""Density of air at sea level, kg/m3."""

ODD = np.array((1.0, -1.0, 1.0, -1.0, 1.0, -1.0))
"""Signs of forces and moments of a symmetric body in wind from the opposite side."""

SAME = 1e-9
"""Difference below which two angles are the same, rad."""


@checked("name", "is_symmetric")
@dataclass(frozen=True, eq=False)
class Aerodynamics(Load):
    """Forces and moments of the wind by a table over the wind angle, for example of a fuselage, a crate or a sail.

    With the relative wind ``r = A^T (wind - v)`` in the frame's axes (x forward, y to port and z up), and the angle
    ``atan2(-ry, -rx)`` from which it blows (0 from ahead, pi/2 from port):

        (F, M) = density / 2 (rx^2 + ry^2) C(angle) + density / 2 flat_area |rz| rz (0, 0, 1; 0, 0, 0)

    about the frame's origin, along its axes. Between the points of the table C is a periodic monotone cubic
    interpolation (Fritsch and Carlson 1980), without overshoot. The work of the wind counts as work of loads.

    Parameters
    ----------
    name : str
        Unique among the loads between frames of a scene.
    on : Frame
        Frame to which forces and moments of the table refer.
    wind : Wind
    angles : array_like, shape (n,)
        Within one turn, rad, ascending; for symmetric bodies from 0 to pi.
    areas : array_like, shape (n, 6)
        C: forces along x, y and z over the dynamic pressure (m2), and moments about them (m3). Drag is negative along x
        for wind from ahead.
    is_symmetric : bool
        Whether port and starboard side are equal: the table is for wind from port; for wind from starboard y of the
        force and x and z of the moment change their sign.
    flat_area : float
        Drag area for wind along z, m2.
    density : float
        kg/m3.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    A plate of 2 m2 on a spring of 500 N/m in a wind of 10 m/s from ahead:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> spring = kf.CoordinateForce(stiffness=500.0, damping=50.0)
    >>> plate = scene.add_point("plate", 5.0, joint=kf.Prismatic("x", forces=spring))
    >>> areas = [(-2, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0, 0), (2, 0, 0, 0, 0, 0)]
    >>> wind = kf.Wind((-10, 0, 0))
    >>> table = {"angles": (0, np.pi / 2, np.pi), "areas": areas, "is_symmetric": True}
    >>> scene.add(kf.Aerodynamics("wind", plate, wind, **table))
    >>> float(kf.equilibrium(scene).position("plate")[0].round(3))  # m: -1.225 / 2 * 10^2 * 2 / 500
    -0.245
    """

    name: str
    on: Any
    wind: Wind
    angles: Any = field(kw_only=True)
    areas: Any = field(kw_only=True)
    is_symmetric: bool = field(default=False, kw_only=True)
    flat_area: float = field(default=0.0, kw_only=True)
    density: float = field(default=AIR, kw_only=True)
    ends: tuple[Any, ...] = field(init=False)
    pieces: np.ndarray = field(init=False, repr=False)

    kind = "aerodynamics"
    columns = (
        "wind [m/s]",
        "angle [rad]",
        "force along x [N]",
        "force along y [N]",
        "force along z [N]",
        "moment about x [N m]",
        "moment about y [N m]",
        "moment about z [N m]",
    )

    def __post_init__(self) -> None:
        label = f"aerodynamics {self.name!r}"
        if not isinstance(self.wind, Wind):
            raise ModelError(f"the wind of {label} must be a kanefe.Wind, not {self.wind!r}")
        for what in ("flat_area", "density"):
            if shaped_numbers(getattr(self, what), (), f"{what} of {label}") < 0.0:
                raise ModelError(f"{what} of {label} must be >= 0, not {getattr(self, what)!r}")
        object.__setattr__(self, "pieces", _pieces(*self._table(label)))
        object.__setattr__(self, "ends", (self.on,))

    def _table(self, label: str) -> tuple[np.ndarray, np.ndarray]:
        """Return angles from -pi on, within one turn, and the areas there."""
        angles = numbers(self.angles)
        if angles.ndim != 1 or len(angles) < 2 or not np.all(np.isfinite(angles)) or np.any(np.diff(angles) <= 0.0):
            raise ModelError(
                f"angles of {label} must be two or more finite numbers that rise, rad, not {self.angles!r}"
            )
        areas = shaped_numbers(self.areas, (len(angles), 6), f"areas of {label}")
        if self.is_symmetric:
            if abs(angles[0]) > SAME or abs(angles[-1] - math.pi) > SAME:
                raise ModelError(f"angles of {label}, which is symmetric, must be from 0 to pi")
            areas[[0, -1]] *= 0.5 * (1.0 + ODD)  # antisymmetric components are zero in the plane of symmetry
            angles, areas = np.append(-angles[:0:-1], angles[:-1]), np.vstack((ODD * areas[:0:-1], areas[:-1]))
        if angles[-1] - angles[0] > 2.0 * math.pi + SAME:
            raise ModelError(f"angles of {label} are of more than one turn. Remedy: radians")
        if angles[-1] - angles[0] > 2.0 * math.pi - SAME:
            if np.abs(areas[0] - areas[-1]).max() > SAME * np.abs(areas).max():
                raise ModelError(f"areas of {label} differ at the first and last angle, which are one")
            angles, areas = angles[:-1], areas[:-1]
        wrapped = np.mod(angles + math.pi, 2.0 * math.pi) - math.pi
        order = np.argsort(wrapped)
        return wrapped[order], areas[order]

    def coefficients(self, angle: float) -> Vector:
        """Return C at an angle (rad), shape (6,), m2 and m3."""
        force, moment = areas_at(AerodynamicsNumbers(self.kernel.numbers), angle, angle)
        return np.array((*force, *moment))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> None:
        """Return None: its stiffness and damping are small."""

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return speed and angle of the wind relative to the frame, and force and moment along its axes."""
        (end,) = ends
        r = np.array((*blown(t, AerodynamicsNumbers(self.kernel.numbers), numbers_of(ends)),))
        own = self.action(t, ends, states).wrenches.reshape(2, 3) @ end.A
        return np.array((float(np.linalg.norm(r)), math.atan2(-r[1], -r[0]), *own.ravel()))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        rest = np.concatenate((self.wind.numbers, self.pieces.ravel()))
        given = filled_from(self, AerodynamicsNumbers, piece_count=len(self.pieces), wind=rest)
        return LoadKernel(aerodynamics, given, aerodynamics)


def _pieces(angles: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """Return the start of each piece of a table, and the six components of rising powers, (n, 25)."""
    from scipy.interpolate import PchipInterpolator

    n, turn = len(angles), 2.0 * math.pi
    around = np.concatenate((angles - turn, angles, angles + turn))
    curve = PchipInterpolator(around, np.vstack((areas,) * 3))
    powers = curve.c[::-1, n : 2 * n]  # (4, n, 6), of the turn in the middle
    return np.column_stack((angles, powers.transpose(1, 0, 2).reshape(n, 24)))
