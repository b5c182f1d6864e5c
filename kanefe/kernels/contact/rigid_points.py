"""Points of rigid contacts: where they meet their surface, how they move past it, and what rubs there.

The equations are those of `kanefe.contact.rigid.meeting` and `kanefe.contact.rigid.rigid_contact`.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.lengths import across, beside, norm
from kanefe.kernels.algebra.vectors import Numbers, as_matrix, as_vector, numbers_of, three, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_shapes import Plane, ShapeKind, distance, normal_rate
from kanefe.kernels.contact.falling import AT, STEADY_NUMBERS, steady_coefficient
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.layout import Y, Z
from kanefe.kernels.loads.markers import MARKER_NUMBERS, axes_of, lever_of, motion_of
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.records import Record, Rows, column
from kanefe.kernels.values.tensors import Vector, cross, dot

ON_SURFACE, OF_PROBE, STATUS, SHAPE, HAS_FRICTION, HAS_MARK, FIRST_STATE, CONTACT, LAW, TELLS = range(10)
"""Columns of the integers of a point: rows of the surface and of the probe (-1: N); where its status is among the
internal states, followed by what it keeps; where its shape begins; whether it rubs, and sticks at one place; where the
states of its contact begin; the number of that among the rigid ones; its law of impact; and whether a run tells what it
does."""
POINT_INTEGERS = 10

STRONGE, NEWTON, POISSON, DISTRIBUTING = range(4)
"""Laws of impact, in the order of `kanefe.contact.rigid.rigid.IMPACT_LAWS`."""

SLIP, WORK, TAKEN = range(3)
"""Indices of the states of a contact: the path slid, the work of friction, and what impacts have taken from the motion
between the bodies that touch (J)."""

KEPT, KEPT_RATE = 1, 4
"""Indices of the states of a point after that of its status: see `kanefe.contact.rigid.rigid_contact`."""

CLOSED_FROM, SLIPS_FROM = 0.5, 1.5
"""Values of a status above which a point is closed, and slips; methods keep it to round-off."""

AT_REST, STRAIGHT = 1e-9, 1e-7
"""Speed (m/s), and its fraction across the kept direction, below which that direction is used. Friction turns a slow
slip into its own direction at a rate that grows without bound as the slip ends, and would amplify round-off."""

BEGINS = 2.0 * AT_REST
"""Lower bound of the length of a direction that is kept from the start of a slip, m/s."""

BACK = 0.01
"""Speed at which a starting slip may reverse by noise of the run, relative to the speed up to which its direction is
kept."""

TURNED = 0.5
"""Cosine of the angle by which a slip turns until its direction is stored again."""

PointConstants = namedtuple(
    "PointConstants", "point radius ring axis share restitution stiffness exponent belt friction"
)
"""Numbers of a point: its centre in the axes of its end, m; then see `kanefe.contact.geometry.shape.Probe`. `stiffness,
exponent`: of an impact that contacts share by them; `belt`: velocity of the surface in its axes, m/s; `friction`:
`SteadyNumbers`."""

OF_POINT = places(PointConstants, point=3, axis=3, belt=3)
HOLDING = int(OF_POINT.friction) + int(AT.holding)
"""Index of the largest coefficient with which a point sticks, among its constants."""
POINT_CONSTANTS = int(OF_POINT.friction) + STEADY_NUMBERS


class Meeting(Record):
    """What is known of a point that meets a surface: see `kanefe.contact.rigid.meeting.Meeting`.

    Attributes
    ----------
    rates, remainder : Vector
        Along the normal and both directions.
    tangential : Vector
        Friction of what slips for a unit of the normal force, in N.
    """

    gap: float
    place: Vector
    point: Vector
    normal: Vector
    first: Vector
    second: Vector
    rates: Vector
    remainder: Vector
    tangential: Vector


Meetings = Rows[Meeting]


_MetNumbers = namedtuple("_MetNumbers", "gap place point normal first second rates remainder tangential")
MET: Any = _MetNumbers._make(column(Meeting, name) for name in Meeting.fields)
MET_NUMBERS = Meeting.number_count


def no_rigid_points() -> RigidPoints:
    """Return the tables of a scene without rigid contacts."""
    integers, markers = np.zeros((0, POINT_INTEGERS), dtype=np.int64), np.zeros((0, MARKER_NUMBERS))
    return RigidPoints(integers, markers, np.zeros((0, POINT_CONSTANTS)), np.zeros(0))


@inlined
def is_closed(points: RigidPoints, p: int, z: np.ndarray) -> bool:
    """Return whether a point touches with internal states z."""
    return z[points.places[p, STATUS]].real > CLOSED_FROM


@inlined
def is_slipping(points: RigidPoints, p: int, z: np.ndarray) -> bool:
    """Return whether a point slips with internal states z."""
    return z[points.places[p, STATUS]].real > SLIPS_FROM


@inlined
def motion_of_marker(  # type: ignore[no-untyped-def]
    markers: np.ndarray, n: int, row: int, lever: Numbers, gravity: np.ndarray, work: np.ndarray
):
    """Return position, axes, velocity, angular velocity, Z and Y of a marker; gravity in Z cancels."""
    axes = axes_of(markers, n, row, work)
    p, v, w = motion_of(row, lever, work)
    zero = 0.0 * lever[0]
    if row < 0:
        fall = (zero - gravity[0], zero - gravity[1], zero - gravity[2])
        return p, axes, v, w, fall, (zero, zero, zero)
    turn, rate, arm = as_vector(vector(work, row, Y)), as_vector(w), as_vector(lever)
    moved = as_vector(vector(work, row, Z)) + cross(turn, arm) + cross(rate, cross(rate, arm))
    return p, axes, v, w, numbers_of(moved), numbers_of(turn)


MarkerMotion = namedtuple("MarkerMotion", "p A v w Z Y")
"""Position, axes, velocity, angular velocity, Z and Y of a marker."""


@inlined
def moving(points: RigidPoints, n: int, row: int, gravity: np.ndarray, work: np.ndarray) -> MarkerMotion:
    """Return how a marker moves."""
    lever = lever_of(points.markers, n, row, work)
    p, A, v, w, Z, Y = motion_of_marker(points.markers, n, row, lever, gravity, work)
    return MarkerMotion(as_vector(p), as_matrix(A), as_vector(v), as_vector(w), as_vector(Z), as_vector(Y))


@kernel
def meet(points: RigidPoints, p: int, gravity: np.ndarray, work: np.ndarray, met: np.ndarray) -> None:
    """Write where and how a point meets its surface, but for what rubs, after an outward sweep."""
    at, own, found = points.places[p], points.numbers[p], Meetings(met)[p]
    a = moving(points, 2 * p, at[ON_SURFACE], gravity, work)
    b = moving(points, 2 * p + 1, at[OF_PROBE], gravity, work)
    shape, ring = at[SHAPE], own[OF_POINT.ring]
    spoke = b.A @ as_vector(three(own, OF_POINT.point))
    spoke_rate = cross(b.w, spoke)
    if ring > 0.0:  # on a plane alone: its normal stays in the surface
        n = a.A @ Plane(points.shapes, shape).normal
        down, down_rate = _lowest(n, cross(a.w, n), b.A @ as_vector(three(own, OF_POINT.axis)), b.w)
        spoke += ring * down
        spoke_rate += ring * down_rate
    arm = b.p + spoke - a.p
    place = a.A.T @ arm
    away = distance(points.shapes, shape, place)
    n = a.A @ away.normal
    n_rate = cross(a.w, n)
    if int(points.shapes[shape]) != ShapeKind.PLANE:
        past = a.A.T @ (b.v + spoke_rate - (a.v + cross(a.w, arm)))
        n_rate += a.A @ normal_rate(points.shapes, shape, place, past)
    first = beside(away.normal)
    second, first = a.A @ cross(away.normal, first), a.A @ first
    radius = own[OF_POINT.radius]
    spoke, spoke_rate = spoke - radius * n, spoke_rate - radius * n_rate
    arm = b.p + spoke - a.p
    v = b.v + cross(b.w, spoke) - (a.v + cross(a.w, arm))
    arm_rate = b.v + spoke_rate - a.v
    left = b.Z + cross(b.Y, spoke) + cross(b.w, spoke_rate) - (a.Z + cross(a.Y, arm) + cross(a.w, arm_rate))
    along, slip = left + cross(v, a.w), v - a.A @ as_vector(three(own, OF_POINT.belt))
    found.gap, found.place, found.point = away.gap - radius, place, b.p + spoke
    found.normal, found.first, found.second = n, first, second
    found.rates = Vector(dot(n, v), dot(first, slip), dot(second, slip))
    found.remainder = Vector(dot(n, left) + dot(n_rate, v), dot(first, along), dot(second, along))


@inlined
def _lowest(n: Vector, n_rate: Vector, axis: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return the direction from the middle of a ring to its lowest point, and its rate; none of one that lies flat."""
    rate, lean = cross(w, axis), dot(axis, n)
    down = lean * axis - n
    down_rate = (dot(rate, n) + dot(axis, n_rate)) * axis + lean * rate - n_rate
    size = norm(down)
    if size.real == 0.0:
        return 0.0 * down, 0.0 * down
    direction = (1.0 / size) * down
    return direction, (1.0 / size) * across(down_rate, direction)


@kernel
def rub_along(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> None:
    """Write the friction of a point for a unit of its normal force: of one that slips, after `meet`."""
    found = Meetings(met)[p]
    found.tangential = 0.0 * found.first
    if is_slipping(points, p, z) and points.places[p, HAS_FRICTION] != 0:
        a, b, speed = slip_direction(points, p, z, work, met)
        mu = steady_coefficient(points.numbers[p], OF_POINT.friction, speed)
        found.tangential = -mu * (a * found.first + b * found.second)


@inlined
def kept_along(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> tuple[Any, Any]:
    """Return what a point keeps along both directions of its surface."""
    found, at = Meetings(met)[p], points.places[p]
    A = as_matrix(axes_of(points.markers, 2 * p, at[ON_SURFACE], work))
    kept = A @ as_vector(three(z, at[STATUS] + KEPT))
    return dot(found.first, kept), dot(found.second, kept)


@inlined
def slip_direction(
    points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray
) -> tuple[Any, Any, Any]:
    """Return the direction of a slip over both directions along the surface, and its speed."""
    a, b = kept_along(points, p, z, work, met)
    rates = Meetings(met)[p].rates
    size, x, y = np.sqrt(a * a + b * b), rates.y, rates.z
    speed = np.sqrt(x * x + y * y)
    if size.real > 0.0:
        a, b = a / size, b / size
    along = x * a + y * b
    off_x, off_y = x - along * a, y - along * b
    off = np.sqrt((off_x * off_x + off_y * off_y).real)
    if not (size.real == 0.0 or size.real > BEGINS or off <= STRAIGHT * speed.real):
        sign = -1.0 if along.real < 0.0 else 1.0
        a, b = sign * x / speed, sign * y / speed
    return a, b, speed


@inlined
def left_of_gap(points: RigidPoints, p: int, z: np.ndarray, met: np.ndarray) -> Any:
    """Return the gap of an open point above where it left the surface: see `RigidContact.left_of_gap`."""
    return Meetings(met)[p].gap + z[points.places[p, STATUS] + KEPT]


@inlined
def left_of_slip(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> Any:
    """Return what is zero where a slip ends or has turned too far: see `RigidContact.left_of_slip`."""
    a, b = kept_along(points, p, z, work, met)
    rates, size = Meetings(met)[p].rates, norm(as_vector(three(z, points.places[p, STATUS] + KEPT)))
    x, y = rates.y, rates.z
    speed = np.sqrt(x * x + y * y)
    along = (x * a + y * b) / (size if size > 0.0 else 1.0)
    return min(along + BACK * size, size - speed) if size > BEGINS else along - TURNED * speed
