"""Points of rigid contacts: where they meet their surface, how they move past it, and what rubs there.

The equations are those of `kanefe.contact.rigid.meeting` and `kanefe.contact.rigid.rigid_contact`.
"""

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.contact.contact_places import FrictionStates
from kanefe.kernels.contact.contact_shapes import Plane, ShapeKind, distance, normal_rate
from kanefe.kernels.contact.falling import SteadyNumbers, steady_coefficient
from kanefe.kernels.language import Matrix, Record, Rows, Vector, across, beside, cross, dot, inlined, kernel, norm
from kanefe.kernels.loads.markers import Marker, motion_of
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.tree import Frames


class ImpactLaw(IntEnum):
    """Laws of impact, in the order of `kanefe.contact.rigid.rigid.IMPACT_LAWS`."""

    STRONGE = 0
    NEWTON = 1
    POISSON = 2
    DISTRIBUTING = 3


class Slipping(NamedTuple):
    """Where a point is closed, slips, and keeps the direction of its slip."""

    closed_from: float = 0.5
    slips_from: float = 1.5
    """Values of a status above which a point is closed, and slips; methods keep it to round-off."""
    at_rest: float = 1e-9
    straight: float = 1e-7
    """Speed (m/s), and its fraction across the kept direction, below which that direction is used. Friction turns a
    slow slip into its own direction at a rate that grows without bound as the slip ends, and would amplify
    round-off."""
    begins: float = 2.0 * at_rest
    """Lower bound of the length of a direction that is kept from the start of a slip, m/s."""
    back: float = 0.01
    """Speed at which a starting slip may reverse by noise of the run, relative to the speed up to which its direction
    is kept."""
    turned: float = 0.5
    """Cosine of the angle by which a slip turns until its direction is stored again."""


SLIPPING = Slipping()


class RigidPoint(Record, is_frozen=True):
    """What is given of a point.

    Attributes
    ----------
    surface, probe : Marker
        The frames of the surface and of what the point is fixed in.
    status, first_state : int
        Where its `PointStates` and the `RigidStates` of its contact are among the internal states.
    shape : int
        Where that of the surface begins in `RigidPoints.shapes`.
    rubs, has_mark : bool
        Whether it has friction, and sticks at one place.
    contact : int
        Number of its contact among the rigid ones.
    law : int
        `ImpactLaw`.
    tells : bool
        Whether a run tells what it does.
    point, radius, ring, axis, share
        See `kanefe.contact.geometry.shape.Probe`; in the axes of the probe.
    restitution, stiffness, exponent : float
        Of impacts; the latter of those that contacts share by them.
    belt : Vector
        Velocity of the surface in its axes, m/s.
    friction : SteadyNumbers
    """

    surface: Marker
    probe: Marker
    status: int
    first_state: int
    shape: int
    rubs: bool
    has_mark: bool
    contact: int
    law: int
    tells: bool
    point: Vector
    radius: float
    ring: float
    axis: Vector
    share: float
    restitution: float
    stiffness: float
    exponent: float
    belt: Vector
    friction: SteadyNumbers


GivenPoints = Rows[RigidPoint]


class PointStates(Record):
    """The internal states of a point: see `kanefe.contact.rigid.rigid_contact`."""

    status: float
    kept: Vector
    rate: Vector


class RigidStates(FrictionStates):
    """The first states of a contact, with what impacts have taken from the motion between the bodies that touch, J."""

    taken: float


class Meeting(Record):
    """What is known of a point that meets a surface: see `kanefe.contact.rigid.meeting.Meeting`.

    Attributes
    ----------
    rates, remainder : Vector
        Along the normal and both directions.
    surface : Matrix
        Axes of the surface.
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
    surface: Matrix
    tangential: Vector


class Meetings(Rows[Meeting]):
    """How all points meet their surfaces."""


def no_rigid_points() -> RigidPoints:
    """Return the tables of a scene without rigid contacts."""
    integers = np.zeros((0, RigidPoint.integer_count), dtype=np.int64)
    return RigidPoints(integers, np.zeros((0, RigidPoint.number_count)), np.zeros(0))


@inlined
def given_points(points: RigidPoints) -> GivenPoints:
    """Return what is given of all points."""
    return GivenPoints(points.places, points.numbers)


@inlined
def is_closed(given: RigidPoint, z: np.ndarray) -> bool:
    """Return whether a point touches with internal states z."""
    return PointStates(z, given.status).status.real > SLIPPING.closed_from


@inlined
def is_slipping(given: RigidPoint, z: np.ndarray) -> bool:
    """Return whether a point slips with internal states z."""
    return PointStates(z, given.status).status.real > SLIPPING.slips_from


@inlined
def is_rubbing(given: RigidPoint, z: np.ndarray) -> bool:
    """Return whether a point slips with friction."""
    return given.rubs and is_slipping(given, z)


@inlined
def touches(points: GivenPoints, z: np.ndarray) -> bool:
    """Return whether any point touches."""
    found = False
    for p in range(len(points)):
        found = found or is_closed(points[p], z)
    return found


@inlined
def along(met: Meeting, direction: int) -> Vector:
    """Return the normal of a surface, or one of the directions along it (1, 2)."""
    return met.normal if direction == 0 else met.first if direction == 1 else met.second


@inlined
def part_of(a: Vector, direction: int) -> Any:
    """Return the part of rates along such a direction."""
    return a.x if direction == 0 else a.y if direction == 1 else a.z


@kernel
def meet(given: RigidPoint, shapes: np.ndarray, frames: Frames, found: Meeting) -> None:
    """Write where and how a point meets its surface, but for what rubs, after an outward sweep."""
    a, b, shape = motion_of(given.surface, frames), motion_of(given.probe, frames), given.shape
    spoke = b.A @ given.point
    spoke_rate = cross(b.w, spoke)
    if given.ring > 0.0:  # on a plane alone: its normal stays in the surface
        n = a.A @ Plane(shapes, shape).normal
        down, down_rate = _lowest(n, cross(a.w, n), b.A @ given.axis, b.w)
        spoke += given.ring * down
        spoke_rate += given.ring * down_rate
    arm = b.p + spoke - a.p
    place = a.A.T @ arm
    away = distance(shapes, shape, place)
    n = a.A @ away.normal
    n_rate = cross(a.w, n)
    if int(shapes[shape]) != ShapeKind.PLANE:
        past = a.A.T @ (b.v + spoke_rate - (a.v + cross(a.w, arm)))
        n_rate += a.A @ normal_rate(shapes, shape, place, past)
    first = beside(away.normal)
    second, first = a.A @ cross(away.normal, first), a.A @ first
    spoke, spoke_rate = spoke - given.radius * n, spoke_rate - given.radius * n_rate
    arm = b.p + spoke - a.p
    v = b.v + cross(b.w, spoke) - (a.v + cross(a.w, arm))
    left = b.Z + cross(b.Y, spoke) + cross(b.w, spoke_rate)
    left -= a.Z + cross(a.Y, arm) + cross(a.w, b.v + spoke_rate - a.v)
    beyond, slip = left + cross(v, a.w), v - a.A @ given.belt
    found.gap, found.place, found.point, found.surface = away.gap - given.radius, place, b.p + spoke, a.A
    found.normal, found.first, found.second = n, first, second
    found.rates = Vector(dot(n, v), dot(first, slip), dot(second, slip))
    found.remainder = Vector(dot(n, left) + dot(n_rate, v), dot(first, beyond), dot(second, beyond))


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


@inlined
def rub_along(given: RigidPoint, z: np.ndarray, met: Meeting) -> None:
    """Write the friction of a point for a unit of its normal force: of one that slips, after `meet`."""
    met.tangential = 0.0 * met.first
    if is_rubbing(given, z):
        a, b, speed = slip_direction(given, z, met)
        mu = steady_coefficient(given.friction, speed)
        met.tangential = -mu * (a * met.first + b * met.second)


@inlined
def kept_along(given: RigidPoint, z: np.ndarray, met: Meeting) -> tuple[Any, Any]:
    """Return what a point keeps along both directions of its surface."""
    kept = met.surface @ PointStates(z, given.status).kept
    return dot(met.first, kept), dot(met.second, kept)


@inlined
def slip_direction(given: RigidPoint, z: np.ndarray, met: Meeting) -> tuple[Any, Any, Any]:
    """Return the direction of a slip over both directions along the surface, and its speed."""
    a, b = kept_along(given, z, met)
    size, x, y = np.sqrt(a * a + b * b), met.rates.y, met.rates.z
    speed = np.sqrt(x * x + y * y)
    if size.real > 0.0:
        a, b = a / size, b / size
    ahead = x * a + y * b
    off_x, off_y = x - ahead * a, y - ahead * b
    off = np.sqrt((off_x * off_x + off_y * off_y).real)
    if not (size.real == 0.0 or size.real > SLIPPING.begins or off <= SLIPPING.straight * speed.real):
        sign = -1.0 if ahead.real < 0.0 else 1.0
        a, b = sign * x / speed, sign * y / speed
    return a, b, speed


@inlined
def left_of_gap(given: RigidPoint, z: np.ndarray, met: Meeting) -> Any:
    """Return the gap of an open point above where it left the surface: see `RigidContact.left_of_gap`."""
    return met.gap + PointStates(z, given.status).kept.x


@inlined
def left_of_slip(given: RigidPoint, z: np.ndarray, met: Meeting) -> Any:
    """Return what is zero where a slip ends or has turned too far: see `RigidContact.left_of_slip`."""
    a, b = kept_along(given, z, met)
    size, x, y = norm(PointStates(z, given.status).kept), met.rates.y, met.rates.z
    speed = np.sqrt(x * x + y * y)
    ahead = (x * a + y * b) / (size if size > 0.0 else 1.0)
    return (
        min(ahead + SLIPPING.back * size, size - speed) if size > SLIPPING.begins else ahead - SLIPPING.turned * speed
    )
