"""Scalar constraint equations between two markers, or between joint coordinates: one row each.

A row between markers a and b gives three things from the motion of the two, all in components of N:

    residual   g(q), zero while the constraint holds; only for holonomic rows
    wrenches   force and moment on a and on b of a unit multiplier, which are also its Jacobian:
               dg/dt = force_a . v_a + moment_a . w_a + force_b . v_b + moment_b . w_b
    remainder  the part of d2g/dt2 without du:  d2g/dt2 = J du + remainder

The forces act at the origins of the markers' frames. Referred to the same point, the wrenches on the two bodies are
opposite.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Matrix, Vector
from kanefe.kernels.constraints.constraint_rows import Action, ConstraintRow, RowKind, exert, residual
from kanefe.kernels.constraints.tolerances import HALF_ON
from kanefe.kernels.loads import markers
from kanefe.kernels.values import tensors

METRE, RADIAN = "m", "rad"


class MarkerMotion(NamedTuple):
    """Motion of a marker seen from N, in components of N.

    Attributes
    ----------
    p : ndarray, shape (3,)
        Origin, m.
    A : ndarray, shape (3, 3)
        Rotation matrix from the marker's axes to those of N.
    v, w : ndarray, shape (3,)
        Velocity of the origin (m/s) and angular velocity (rad/s).
    Z, Y : ndarray, shape (3,)
        Remainder accelerations, m/s2 and rad/s2.
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector
    Z: Vector
    Y: Vector


Wrenches = tuple[Vector, Vector, Vector, Vector]
"""Force and moment on a, then force and moment on b."""


def _motion(end: MarkerMotion) -> markers.MarkerMotion:
    rest = (tensors.Vector(*part) for part in end[2:])
    return markers.MarkerMotion(tensors.Vector(*end.p), tensors.Matrix(*end.A.flat), *rest)


class _OfMarkers:
    """Common part of the rows between two markers, by the functions of `kanefe.kernels.constraints.constraint_rows`."""

    kind: ClassVar[int]
    is_ball: bool = False
    presses: ClassVar[bool] = False
    a: Marker
    b: Marker

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The two ends."""
        return self.a, self.b

    @property
    def holds_place(self) -> bool:
        """Whether it is holonomic: it constrains coordinates, and not only speeds."""
        return True

    def fill(self, row: ConstraintRow) -> ConstraintRow:
        """Write kind and numbers to a row of a table, which is returned."""
        row.kind, row.is_ball = self.kind, self.is_ball
        for name in [n for n in ("e", "f", "side", "cosine", "length", "lead", "radius") if hasattr(self, n)]:
            value = getattr(self, name)
            setattr(row, name, tensors.Vector(*value) if isinstance(value, np.ndarray) else value)
        return row

    @cached_property
    def _row(self) -> ConstraintRow:
        count = ConstraintRow.integer_count
        return self.fill(ConstraintRow(np.zeros(count, dtype=np.int64), np.zeros(ConstraintRow.number_count)))

    def residual(self, a: MarkerMotion, b: MarkerMotion) -> float:
        """Return g in the unit of the row, if it is holonomic."""
        return float(residual(self._row, _motion(a), _motion(b)))

    def terms(self, a: MarkerMotion, b: MarkerMotion) -> tuple[Wrenches, float]:
        """Return the wrenches of a unit multiplier, and the part of d2g/dt2 without du (m/s2, 1/s2)."""
        action = Action(np.zeros(Action.number_count))
        exert(self._row, _motion(a), _motion(b), action)
        force, moment_a, moment_b = (np.array(one.numbers) for one in (action.force, action.moment_a, action.moment_b))
        return (-force, moment_a, force, moment_b), float(action.remainder)

    def wrenches(self, a: MarkerMotion, b: MarkerMotion) -> Wrenches:
        """Return the wrenches of a unit multiplier."""
        return self.terms(a, b)[0]

    def remainder(self, a: MarkerMotion, b: MarkerMotion) -> float:
        """Return the part of d2g/dt2 without du, m/s2 or 1/s2."""
        return self.terms(a, b)[1]


@dataclass(frozen=True, eq=False)
class PointRow(_OfMarkers):
    """``g = e . (p_b - p_a)``: b's origin stays on a plane fixed in a.

    Attributes
    ----------
    label : str
        Name in reports.
    a, b : Marker
    e : ndarray, shape (3,)
        Normal of the plane in a's axes.
    """

    kind: ClassVar[int] = RowKind.POINT
    unit: ClassVar[str] = METRE
    label: str
    a: Marker
    b: Marker
    e: Vector


@dataclass(frozen=True, eq=False)
class DirectionRow(_OfMarkers):
    """``g = e . f - cosine``: the angle between a direction of a and one of b is constant.

    Attributes
    ----------
    label : str
    a, b : Marker
    e, f : ndarray, shape (3,)
        Unit vectors in a's and in b's axes.
    cosine : float
        Cosine of the angle between them.
    """

    kind: ClassVar[int] = RowKind.DIRECTION
    unit: ClassVar[str] = RADIAN
    label: str
    a: Marker
    b: Marker
    e: Vector
    f: Vector
    cosine: float = 0.0


@dataclass(frozen=True, eq=False)
class DistanceRow(_OfMarkers):
    """``g = |p_b - p_a| - length``: a massless rod with a ball joint at each end.

    Attributes
    ----------
    label : str
    a, b : Marker
    length : float
        m, above zero.
    """

    kind: ClassVar[int] = RowKind.DISTANCE
    unit: ClassVar[str] = METRE
    label: str
    a: Marker
    b: Marker
    length: float


@dataclass(frozen=True, eq=False)
class ScrewRow(_OfMarkers):
    """``g = e . (p_b - p_a) - lead / (2 pi) angle``: b advances along a's axis as it rotates about it.

    Further rows keep the two axes on one line. The number of full turns is not stored: the angle is the one nearest to
    that of the advance, so that a screw can turn without limit.

    Attributes
    ----------
    label : str
    a, b : Marker
    e : ndarray, shape (3,)
        Axis, the same components in a's and b's axes.
    side : ndarray, shape (3,)
        A unit vector across the axis, from which the angle is measured.
    lead : float
        Advance in a full turn, m, not zero.
    """

    kind: ClassVar[int] = RowKind.SCREW
    unit: ClassVar[str] = METRE
    label: str
    a: Marker
    b: Marker
    e: Vector
    side: Vector
    lead: float


NORMAL, FIRST, SECOND = "normal", "first", "second"
DIRECTIONS = {NORMAL: 2, FIRST: 0, SECOND: 1}
"""Axis of the plane's marker for each kind of rolling row."""


@dataclass(frozen=True, eq=False)
class RollingRow(_OfMarkers):
    """Rolling of a wheel or ball on a plane: the material point of b at the contact has no velocity relative to a.

    The plane is z = 0 of marker a, the body above it. Its ``normal`` row is holonomic: ``g`` is the height of the
    lowest point. The ``first`` and ``second`` rows, along x and y of a, are not: they have no g.

    Attributes
    ----------
    label : str
    a, b : Marker
        Markers of the plane and of the hub; a wheel spins about b's z axis.
    radius : float
        m.
    direction : "normal", "first" or "second"
    is_ball : bool
        Whether it is a ball, in contact below its centre; else a thin wheel, in contact at the lowest point of its rim.
    """

    kind: ClassVar[int] = RowKind.ROLLING
    unit: ClassVar[str] = METRE
    label: str
    a: Marker
    b: Marker
    radius: float
    direction: str
    is_ball: bool

    @property
    def e(self) -> Vector:
        """Its direction in the axes of the plane."""
        return np.eye(3)[DIRECTIONS[self.direction]]

    @property
    def holds_place(self) -> bool:
        """Whether it is the row along the normal."""
        return self.direction == NORMAL


@dataclass(frozen=True, eq=False)
class CouplerRow:
    """``g = sum c_i q_i - constant`` over joint coordinates whose rates are speeds: gears, racks, differentials.

    Attributes
    ----------
    label : str
    terms : tuple of (int, int, float)
        Number of a body, number of the coordinate of its joint, and the coefficient c.
    constant : float
    unit : str
        Unit of g.
    """

    label: str
    terms: tuple[tuple[int, int, float], ...]
    constant: float
    unit: str = RADIAN
    presses: ClassVar[bool] = False
    markers: ClassVar[tuple[Marker, ...]] = ()
    holds_place: ClassVar[bool] = True
    kind: ClassVar[int] = RowKind.COUPLER

    def fill(self, row: ConstraintRow) -> None:
        """Write kind and numbers to a row of a table."""
        row.kind, row.constant = self.kind, self.constant


MarkerRow = PointRow | DirectionRow | DistanceRow | ScrewRow | RollingRow
Row = MarkerRow | CouplerRow


@dataclass(frozen=True, eq=False)
class Constraint:
    """A loop joint or coupler: rows under one name.

    Attributes
    ----------
    name : str
        Unique among the constraints of the scene.
    kind : str
        Such as "revolute loop joint" or "gear".
    rows : tuple of Row
    a, b : Marker or None
        The two ends; None for a coupler of joint coordinates.
    facing : tuple of ndarray, each (3,)
        Directions that must be the same in a and b. The rows alone would allow the opposite ones too.
    starts_on : bool or None
        Whether a constraint that can be switched in a run holds at the start. None: it always holds.
    switch : int
        Index of its switch among the internal states, 1 if it holds and 0 if not; -1: it always holds.
    """

    name: str
    kind: str
    rows: tuple[Row, ...]
    a: Marker | None = None
    b: Marker | None = None
    facing: tuple[Vector, ...] = ()
    starts_on: bool | None = None
    switch: int = -1

    @property
    def ends(self) -> tuple[Marker, ...]:
        """Its two ends; a coupler has none."""
        return () if self.a is None or self.b is None else (self.a, self.b)

    @property
    def terms(self) -> tuple[tuple[int, int, float], ...]:
        """Of a coupler: number of a body, of the coordinate of its joint, and coefficient; else none."""
        return tuple(term for row in self.rows if isinstance(row, CouplerRow) for term in row.terms)

    @property
    def title(self) -> str:
        """Kind, name and ends in words, for messages."""
        ends = "" if self.a is None or self.b is None else f" between {self.a.label} and {self.b.label}"
        return f"{self.kind} {self.name!r}{ends}"

    def holds(self, z: Vector) -> bool:
        """Return whether it holds with internal states z, (states,)."""
        return self.switch < 0 or bool(z[self.switch] > HALF_ON)
