"""Where the numbers and internal states of a contact are: see `kanefe.contact.contact_data`."""

from __future__ import annotations

from typing import Any, NamedTuple

from kanefe.kernels.force_elements.blocks import places


class ContactNumbers(NamedTuple):
    """Numbers of a contact; those of its points follow, then those of a rest, of the shape and of the laws.

    Attributes
    ----------
    points, ends : float
        How many there are.
    shape, rests_at : float
        Where the shape begins; where the rest does that it is looked at about, 0: none.
    softness : float
        m: see `kanefe.contact.rest.Rest`.
    belt : ndarray, shape (3,)
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
    """

    points: float
    ends: float
    shape: float
    rests_at: float
    softness: float
    belt: Any
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


AT = places(ContactNumbers, belt=3)
POINTS = AT.faces + 1


class PointNumbers(NamedTuple):
    """Numbers of a contact point, see `kanefe.contact.geometry.shape.Probe`, with that of its end first."""

    end: float
    point: Any
    radius: float
    share: float
    ring: float
    axis: Any


OF_POINT = places(PointNumbers, point=3)
POINT_NUMBERS = OF_POINT.axis + 3

REST_NUMBERS, TURNED = 15, 6
"""Number of values of a point at rest: its contact positions on both sides, and index of its rotation there."""

SLIP, WORK = range(2)
"""Indices of the internal states of friction: the slid path and its work; those of an impact and of the points follow.
"""
