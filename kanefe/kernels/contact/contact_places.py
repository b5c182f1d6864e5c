"""What a contact is given in numbers, and where its internal states are: see `kanefe.contact.contact_data`."""

from collections import namedtuple
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from kanefe.kernels.force_elements.places import End, Ends
from kanefe.kernels.language import Behind, Matrix, Record, Rows, Vector, inlined


class Kind(IntEnum):
    """By what is known where the points of a contact are: each by itself, as slots, by shares, or on a patch."""

    POINTS = 0
    BOXES = 1
    HULL = 2
    CONVEX = 3


class ContactNumbers(Record):
    """Numbers of a contact; those of its points follow, then those of a rest, of the shape and of the laws.

    Of what is in the scene: its `Kind`; how many points and ends there are; where the shape begins, and the rest that
    it is looked at about, 0: none, with its softness, m; the velocity of the surface in its own axes, m/s; whether
    events of each point are looked for. Of the normal law: its kind, where its numbers begin, and what counts as its
    stiffness, N/m; where the state is that an impact sets, -1: none, that state times the speed of an impact and the
    least speed (m/s) that counts; whether each point has a branch of a hysteresis, its last state. Of friction: its
    kind, 0: none, and where its numbers begin; whether what sticks stays, and whether a state tells that; states
    against turning; relaxation and spring, 1/s and N/m. Where the states of the points begin, and how many one has;
    where the faces at the corners of a hull begin; and `ContactPoints`.
    """

    kind: float
    count: float
    ends: float
    shape: float
    rests_at: float
    softness: float
    belt: Vector
    reports_points: float
    normal: float
    normal_at: float
    stiffness: float
    impact: float
    impact_number: float
    least_speed: float
    branches: float
    friction: float
    friction_at: float
    holds: float
    has_memory: float
    turning: float
    relaxation: float
    spring: float
    first: float
    each: float
    faces: float
    points: Annotated[Any, Behind()]


class PointNumbers(Record):
    """Numbers of a contact point, see `kanefe.contact.geometry.shape.Probe`, with that of its end first."""

    end: float
    point: Vector
    radius: float
    share: float
    ring: float
    axis: Vector


ContactPoints = Rows[PointNumbers]


class RestNumbers(Record):
    """A point at rest: its places on what touches and on the surface, in their axes, m, and its rotation."""

    material: Vector
    mark: Vector
    turned: Matrix


class FrictionStates(Record):
    """The first states of a contact with friction, and their rates: the slid path, m, and its work, J."""

    slip: float
    work: float


class AnchorStates(Record):
    """The first states of a point with friction, and their rates: the stretch in axes of the surface, and the status.

    The status, 1: it sticks, is there where friction has a memory. Twists and the branch follow.
    """

    stretch: Vector
    sticks: float


Place = namedtuple("Place", "depth normal point share")
"""Place of a point against the surface: depth (m), normal and place in N, and its share of the stiffness."""

AtState = namedtuple("AtState", "own numbers ends states")
"""A contact at a state: its numbers, all that it is given, the motion of its ends, and its internal states."""


@inlined
def point_of(at: AtState, i: int) -> PointNumbers:
    """Return a point."""
    return ContactPoints(at.own.points)[i]


@inlined
def end_of(at: AtState, i: int) -> End:
    """Return the motion of the end of a point."""
    return Ends(at.ends)[int(point_of(at, i).end)]


@inlined
def first_state_of(at: AtState, i: int) -> int:
    """Return the first of the internal states of a point."""
    return int(at.own.first) + int(at.own.each) * i


@inlined
def softened(own: ContactNumbers, depth: Any) -> Any:
    """Return the depth that the normal law is given: ``s ln(1 + exp(depth / s))``, without overflow."""
    softness = own.softness
    if softness > 0.0:
        x = depth / softness
        depth = softness * (x + np.log(1.0 + np.exp(-x)) if x.real > 0.0 else np.log(1.0 + np.exp(x)))
    return depth
