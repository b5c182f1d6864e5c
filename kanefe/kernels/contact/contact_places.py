"""What a contact is given in numbers, and where its internal states are: see `kanefe.contact.contact_data`."""

from __future__ import annotations

from collections import namedtuple
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.force_elements.places import End, Ends
from kanefe.kernels.values.records import Behind, Record, Rows
from kanefe.kernels.values.tensors import Matrix, Vector


class Kind(IntEnum):
    """By what is known where the points of a contact are: each by itself, as slots, by shares, or on a patch."""

    POINTS = 0
    BOXES = 1
    HULL = 2
    CONVEX = 3


class ContactNumbers(Record):
    """Numbers of a contact; those of its points follow, then those of a rest, of the shape and of the laws.

    Attributes
    ----------
    kind : float
        See `Kind`.
    count, ends : float
        How many points and ends there are.
    shape, rests_at : float
        Where the shape begins; where the rest does that it is looked at about, 0: none.
    softness : float
        m: see `kanefe.contact.rest.Rest`.
    belt : Vector
        Velocity of the surface in its own axes, m/s.
    reports_points : float
        Whether events of each point are looked for.
    normal, normal_at : float
        Kind of the normal law, and where its numbers begin.
    stiffness : float
        What counts as that of the normal law, N/m.
    impact : float
        Where the state is that an impact sets; -1: there is none.
    impact_number, least_speed : float
        That state times the speed of an impact, and the least speed (m/s) that counts.
    branches : float
        Whether each point has a branch of a hysteresis, its last state.
    friction, friction_at : float
        Kind of friction, 0: none, and where its numbers begin.
    holds, has_memory, turning : float
        Of friction: whether what sticks stays; whether a state tells that; states against turning.
    relaxation, spring : float
        1/s and N/m: see `kanefe.kernels.contact.laws.friction_law.FrictionLaw`.
    first, each : float
        Where the states of the points begin, and how many one has.
    faces : float
        Where the faces at the corners of a hull begin; 0: none.
    points : list
        `ContactPoints`.
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
"""Where a point is to the surface: depth (m), normal and place in N, and its share of the stiffness."""

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
