"""Rows of constraints: what is given of each, what it exerts and how far it is open, kind by kind.

See `kanefe.constraints.rows`.
"""

from enum import IntEnum
from typing import Any

import numpy as np

from kanefe.kernels.language import ZERO, Record, Rows, Vector, cross, dot, inlined
from kanefe.kernels.loads.markers import Marker, MarkerMotion


class RowKind(IntEnum):
    """Kinds of rows."""

    POINT = 0
    DIRECTION = 1
    DISTANCE = 2
    SCREW = 3
    ROLLING = 4
    COUPLER = 5
    CONTACT = 6


class ConstraintRow(Record, is_frozen=True):
    """A row of a constraint; its numbers are zero where its kind has none such.

    Attributes
    ----------
    kind : int
        `RowKind`.
    a, b : Marker
    is_ball : bool
    holds_place : bool
        Whether it holds coordinates, and not speeds alone.
    is_angle : bool
        Whether its residual is an angle.
    switch : int
        Its switch among the internal states; -1: it always holds.
    goes_on : bool
        Whether it is of the same constraint as the row before, between the same markers.
    first_term, term_count : int
        Of a coupler.
    point, direction : int
        Of a contact: number of its point, and which of its directions; 0: the normal.
    first_visit, last_visit, common : int
        Its visits, see `kanefe.kernels.tables.RowPaths`, and the first of those to what carries both
        its ends.
    e, f, side, cosine, length, lead, radius, constant
        See `kanefe.constraints.rows`.
    """

    kind: int
    a: Marker
    b: Marker
    is_ball: bool
    holds_place: bool
    is_angle: bool
    switch: int
    goes_on: bool
    first_term: int
    term_count: int
    point: int
    direction: int
    first_visit: int
    last_visit: int
    common: int
    e: Vector
    f: Vector
    side: Vector
    cosine: float
    length: float
    lead: float
    radius: float
    constant: float


class ConstraintRows(Rows[ConstraintRow]):
    """The rows of all constraints: of `Loops.rows` and `Loops.numbers`."""


class Term(Record, is_frozen=True):
    """A coordinate of a coupler.

    Attributes
    ----------
    speed : int
        The driven ones come after all that are free.
    coordinate : int
        Of a driven one -1 - drive.
    coefficient : float
    """

    speed: int
    coordinate: int
    coefficient: float


class Terms(Rows[Term]):
    """The coordinates of all couplers: of `Loops.terms` and `Loops.coefficients`."""


class Action(Record):
    """What a unit multiplier of a row exerts.

    Attributes
    ----------
    force : Vector
        On b, in N; that on a is opposite.
    moment_a, moment_b : Vector
        On a and on b, about the origins of their rows.
    remainder : float
        Acceleration along the row that is not linear in du.
    """

    force: Vector
    moment_a: Vector
    moment_b: Vector
    remainder: float


class Actions(Rows[Action]):
    """What all rows exert."""


@inlined
def exert(row: ConstraintRow, a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """Write what a row between two markers exerts, moments about their origins."""
    kind, e = row.kind, a.A @ row.e
    if kind == RowKind.DIRECTION:
        _exert_across(e, b.A @ row.f, a, b, action)
    elif kind == RowKind.DISTANCE:
        _exert_between(a, b, action)
    elif kind == RowKind.ROLLING:
        _exert_rolling(row, e, a, b, action)
    else:
        _exert_along(e, a, b, action)
        if kind == RowKind.SCREW:
            _exert_about(row.lead / (2.0 * np.pi), e, a, b, action)


@inlined
def _exert_along(e: Vector, a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """Of a point row."""
    d, turning = b.p - a.p, cross(a.w, e)
    bend = cross(a.Y, e) + cross(a.w, turning)
    action.force, action.moment_a, action.moment_b = e, cross(e, d), ZERO
    action.remainder = dot(e, b.Z - a.Z) + 2.0 * dot(turning, b.v - a.v) + dot(bend, d)


@inlined
def _exert_about(pitch: float, e: Vector, a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """What a screw exerts more than a point row."""
    action.moment_a += pitch * e
    action.moment_b = -pitch * e
    action.remainder -= pitch * (dot(e, b.Y - a.Y) + dot(cross(a.w, e), b.w - a.w))


@inlined
def _exert_across(e: Vector, f: Vector, a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """Of a direction row."""
    moment, turning = cross(f, e), cross(cross(b.w, f), e) + cross(f, cross(a.w, e))
    action.force, action.moment_a, action.moment_b = ZERO, -moment, moment
    action.remainder = dot(moment, b.Y - a.Y) + dot(turning, b.w - a.w)


@inlined
def _exert_between(a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """Of a distance row."""
    d, rate = b.p - a.p, b.v - a.v
    distance = np.sqrt(dot(d, d))
    direction = (1.0 / distance) * d
    along = dot(direction, rate)
    action.force, action.moment_a, action.moment_b = direction, ZERO, ZERO
    action.remainder = dot(direction, b.Z - a.Z) + (dot(rate, rate) - along * along) / distance


@inlined
def _exert_rolling(row: ConstraintRow, e: Vector, a: MarkerMotion, b: MarkerMotion, action: Action) -> None:
    """Of a rolling row."""
    rate, spoke, spoke_rate = b.v - a.v, _spoke(row, a.A.z, b.A.z), _spoke_rate(row, a, b)
    arm, arm_rate = b.p - a.p + spoke, rate + spoke_rate
    slip = rate + cross(b.w, spoke) - cross(a.w, arm)
    of_b = cross(b.Y, spoke) + cross(b.w, spoke_rate)
    of_a = cross(a.Y, arm) + cross(a.w, arm_rate)
    action.force, action.moment_a, action.moment_b = e, cross(e, arm), cross(spoke, e)
    action.remainder = dot(e, b.Z - a.Z + of_b - of_a) + dot(cross(a.w, e), slip)


@inlined
def _spoke(row: ConstraintRow, n: Vector, s: Vector) -> Vector:
    """Return the vector from the hub to the lowest point: n is the normal of the plane, s the axis of a wheel."""
    if row.is_ball:
        spoke = -row.radius * n
    else:
        across = n - dot(n, s) * s
        spoke = (-row.radius / np.sqrt(dot(across, across))) * across
    return spoke


@inlined
def _spoke_rate(row: ConstraintRow, a: MarkerMotion, b: MarkerMotion) -> Vector:
    """Return its rate."""
    n, s = a.A.z, b.A.z
    n_rate, s_rate = cross(a.w, n), cross(b.w, s)
    if row.is_ball:
        rate = -row.radius * n_rate
    else:
        lean = dot(n, s)
        across, lean_rate = n - lean * s, dot(n_rate, s) + dot(n, s_rate)
        across_rate, size = n_rate - lean_rate * s - lean * s_rate, np.sqrt(dot(across, across))
        unit = (1.0 / size) * across
        rate = (-row.radius / size) * (across_rate - dot(unit, across_rate) * unit)
    return rate


@inlined
def residual(row: ConstraintRow, a: MarkerMotion, b: MarkerMotion) -> Any:
    """Return g of a row between two markers that holds places, in its unit."""
    kind, d = row.kind, b.p - a.p
    if kind == RowKind.DISTANCE:
        g = np.sqrt(dot(d, d)) - row.length
    elif kind == RowKind.DIRECTION:
        g = dot(a.A @ row.e, b.A @ row.f) - row.cosine
    elif kind == RowKind.ROLLING:
        g = dot(a.A.z, d + _spoke(row, a.A.z, b.A.z))
    else:
        e = a.A @ row.e
        g = dot(e, d)
        if kind == RowKind.SCREW:
            side, turned = a.A @ row.side, b.A @ row.side
            angle = np.arctan2(dot(turned, cross(e, side)), dot(turned, side))
            turns = g / row.lead - angle / (2.0 * np.pi)
            g = (turns - np.rint(turns)) * row.lead
    return g
