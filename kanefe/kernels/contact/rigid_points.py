"""Points of rigid contacts: where they meet their surface, how they move past it, and what rubs there.

The equations are those of `kanefe.contact.rigid.meeting` and `kanefe.contact.rigid.rigid_contact`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    minus,
    norm,
    plus,
    put,
    rotated,
    rotated_back,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_shapes import PLANE, distance, normal_rate
from kanefe.kernels.contact.falling import AT, STEADY_NUMBERS, steady_coefficient
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.layout import Y, Z
from kanefe.kernels.loads.markers import MARKER_NUMBERS, axes_of, lever_of, motion_of
from kanefe.kernels.tables import RigidPoints

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


class PointConstants(NamedTuple):
    """Numbers of a point: its centre in the axes of its end, m; then see `kanefe.contact.geometry.shape.Probe`.

    Attributes
    ----------
    restitution : float
    stiffness, exponent : float
        Of an impact that contacts share by them.
    belt : ndarray, shape (3,)
        Velocity of the surface in its axes, m/s.
    friction : ndarray
        `SteadyNumbers`.
    """

    point: Any
    radius: Any
    ring: Any
    axis: Any
    share: Any
    restitution: Any
    stiffness: Any
    exponent: Any
    belt: Any
    friction: Any


OF_POINT = places(PointConstants, point=3, axis=3, belt=3)
HOLDING = int(OF_POINT.friction) + int(AT.holding)
"""Index of the largest coefficient with which a point sticks, among its constants."""
POINT_CONSTANTS = int(OF_POINT.friction) + STEADY_NUMBERS


class MetNumbers(NamedTuple):
    """What is known of a point that meets a surface: see `kanefe.contact.rigid.meeting.Meeting`.

    Attributes
    ----------
    tangential : ndarray, shape (3,)
        Friction of what slips for a unit of the normal force, in N.
    """

    gap: Any
    place: Any
    point: Any
    normal: Any
    first: Any
    second: Any
    rates: Any
    remainder: Any
    tangential: Any


MET = places(MetNumbers, place=3, point=3, normal=3, first=3, second=3, rates=3, remainder=3)
MET_NUMBERS = int(MET.tangential) + 3


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
    turn = vector(work, row, Y)
    return p, axes, v, w, plus(vector(work, row, Z), plus(cross(turn, lever), cross(w, cross(w, lever)))), turn


@kernel
def meet(points: RigidPoints, p: int, gravity: np.ndarray, work: np.ndarray, met: np.ndarray) -> None:
    """Write where and how a point meets its surface, but for what rubs, after an outward sweep."""
    at, own = points.places[p], points.numbers[p]
    row_a, row_b = at[ON_SURFACE], at[OF_PROBE]
    lever_a, lever_b = lever_of(points.markers, 2 * p, row_a, work), lever_of(points.markers, 2 * p + 1, row_b, work)
    p_a, A_a, v_a, w_a, Z_a, Y_a = motion_of_marker(points.markers, 2 * p, row_a, lever_a, gravity, work)
    p_b, A_b, v_b, w_b, Z_b, Y_b = motion_of_marker(points.markers, 2 * p + 1, row_b, lever_b, gravity, work)
    spoke = rotated(A_b, three(own, OF_POINT.point))
    spoke_rate = cross(w_b, spoke)
    shape, zero = at[SHAPE], 0.0 * p_a[0]
    if own[OF_POINT.ring] > 0.0:  # on a plane alone: its normal stays in the surface
        n0 = three(points.shapes, shape + 1)
        down, down_rate = _lowest(rotated(A_a, n0), cross(w_a, rotated(A_a, n0)), A_b, three(own, OF_POINT.axis), w_b)
        spoke = plus(spoke, times(own[OF_POINT.ring], down))
        spoke_rate = plus(spoke_rate, times(own[OF_POINT.ring], down_rate))
    arm = minus(plus(p_b, spoke), p_a)
    place = rotated_back(A_a, arm)
    found = distance(points.shapes, shape, place)
    own_normal = (found[1], found[2], found[3])
    n = rotated(A_a, own_normal)
    n_rate = cross(w_a, n)
    if int(points.shapes[shape]) != PLANE:
        past = rotated_back(A_a, minus(plus(v_b, spoke_rate), plus(v_a, cross(w_a, arm))))
        n_rate = plus(n_rate, rotated(A_a, normal_rate(points.shapes, shape, place, past)))
    x, y, least = abs(own_normal[0].real), abs(own_normal[1].real), abs(own_normal[2].real)
    helper = (zero, zero, zero + 1.0)
    if x <= y and x <= least:
        helper = (zero + 1.0, zero, zero)
    elif y <= least:
        helper = (zero, zero + 1.0, zero)
    first = cross(own_normal, helper)
    first = times(1.0 / norm(first), first)
    second = rotated(A_a, cross(own_normal, first))
    first = rotated(A_a, first)
    radius = own[OF_POINT.radius]
    spoke, spoke_rate = minus(spoke, times(radius, n)), minus(spoke_rate, times(radius, n_rate))
    arm = minus(plus(p_b, spoke), p_a)
    v = minus(plus(v_b, cross(w_b, spoke)), plus(v_a, cross(w_a, arm)))
    arm_rate = minus(plus(v_b, spoke_rate), v_a)
    of_b = plus(Z_b, plus(cross(Y_b, spoke), cross(w_b, spoke_rate)))
    left = minus(of_b, plus(Z_a, plus(cross(Y_a, arm), cross(w_a, arm_rate))))
    belt, swept = rotated(A_a, three(own, OF_POINT.belt)), cross(v, w_a)
    met[p, MET.gap] = found[0] - radius
    put(met, p, MET.place, place)
    put(met, p, MET.point, plus(p_b, spoke))
    put(met, p, MET.normal, n)
    put(met, p, MET.first, first)
    put(met, p, MET.second, second)
    put(met, p, MET.rates, (dot(n, v), dot(first, minus(v, belt)), dot(second, minus(v, belt))))
    along = plus(left, swept)
    put(met, p, MET.remainder, (dot(n, left) + dot(n_rate, v), dot(first, along), dot(second, along)))


@inlined
def _lowest(n: Numbers, n_rate: Numbers, A_b: Numbers, axis: Numbers, w: Numbers) -> tuple[Numbers, Numbers]:
    """Return the direction from the middle of a ring to its lowest point, and its rate; none of one that lies flat."""
    s = rotated(A_b, axis)
    s_rate, lean = cross(w, s), dot(s, n)
    down = minus(times(lean, s), n)
    lean_rate = dot(s_rate, n) + dot(s, n_rate)
    down_rate = minus(plus(times(lean_rate, s), times(lean, s_rate)), n_rate)
    size = norm(down)
    zero = 0.0 * size
    if size.real == 0.0:
        return (zero, zero, zero), (zero, zero, zero)
    unit = times(1.0 / size, down)
    return unit, times(1.0 / size, minus(down_rate, times(dot(unit, down_rate), unit)))


@kernel
def rub_along(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> None:
    """Write the friction of a point for a unit of its normal force: of one that slips, after `meet`."""
    zero = 0.0 * met[p, MET.gap]
    put(met, p, MET.tangential, (zero, zero, zero))
    if not is_slipping(points, p, z) or points.places[p, HAS_FRICTION] == 0:
        return
    a, b, speed = slip_direction(points, p, z, work, met)
    mu = steady_coefficient(points.numbers[p], OF_POINT.friction, speed)
    along = plus(times(a, vector(met, p, MET.first)), times(b, vector(met, p, MET.second)))
    put(met, p, MET.tangential, times(-mu, along))


@inlined
def kept_along(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> tuple[Any, Any]:
    """Return what a point keeps along both directions of its surface."""
    row = points.places[p, ON_SURFACE]
    kept = rotated(axes_of(points.markers, 2 * p, row, work), three(z, points.places[p, STATUS] + KEPT))
    return dot(vector(met, p, MET.first), kept), dot(vector(met, p, MET.second), kept)


@inlined
def slip_direction(
    points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray
) -> tuple[Any, Any, Any]:
    """Return the direction of a slip over both directions along the surface, and its speed."""
    a, b = kept_along(points, p, z, work, met)
    size, x, y = np.sqrt(a * a + b * b), met[p, MET.rates + 1], met[p, MET.rates + 2]
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
    return met[p, MET.gap] + z[points.places[p, STATUS] + KEPT]


@inlined
def left_of_slip(points: RigidPoints, p: int, z: np.ndarray, work: np.ndarray, met: np.ndarray) -> Any:
    """Return what is zero where a slip ends or has turned too far: see `RigidContact.left_of_slip`."""
    a, b = kept_along(points, p, z, work, met)
    size, x, y = norm(three(z, points.places[p, STATUS] + KEPT)), met[p, MET.rates + 1], met[p, MET.rates + 2]
    speed = np.sqrt(x * x + y * y)
    along = (x * a + y * b) / (size if size > 0.0 else 1.0)
    return min(along + BACK * size, size - speed) if size > BEGINS else along - TURNED * speed
