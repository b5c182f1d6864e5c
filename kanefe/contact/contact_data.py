"""A contact as data: shape, points and laws, where its internal states are, and its numbers for compiled code."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.contact.contact_places import ContactNumbers, Kind, PointNumbers
from kanefe.kernels.values.filled import filled
from kanefe.loads.base import Load

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.contact.rest import Rest
    from kanefe.kernels.contact.laws.friction_law import FrictionLaw
    from kanefe.kernels.contact.laws.normal_law import NormalLaw

LARGE_PATH = 100.0
"""Slid path, in multiples of the largest anchor stretch, that counts as large."""


@dataclass(frozen=True, eq=False)
class ContactData(Load):
    """A contact between a surface and points, balls and rings fixed in other frames: its laws and their states.

    Its internal states are the path that it slid and the work of its friction (J), where it has any; lambda, where its
    normal law has a restitution; then of each probe the stretch of its anchor's spring in the axes of the surface, 1
    while it sticks, where that is to be known, twists about the normal and of rolling, where friction holds those, and
    the branch of a hysteresis.

    Attributes
    ----------
    name : str
    ends : tuple of Frame
        That of the surface, then those of the probes.
    shape : SurfaceShape
        Of the surface.
    probes : tuple of (int, Probe)
        Each with the number of its end.
    normal : NormalLaw
    friction : FrictionLaw or None
    belt : ndarray, shape (3,)
        Velocity of the surface in its own axes, m/s.
    mass : float
        Of what it holds, kg: what moves on both sides, in series.
    rest : Rest or None
        Of a contact that is looked at about a rest.
    slides : tuple of int
        Probes that slip or do not touch at the start.
    reports_points : bool
        Whether its events are those of each probe too.
    """

    name: str
    ends: tuple[Any, ...]
    shape: SurfaceShape
    probes: tuple[tuple[int, Probe], ...]
    normal: NormalLaw
    friction: FrictionLaw | None
    belt: np.ndarray
    mass: float = 1.0
    rest: Rest | None = None
    slides: tuple[int, ...] = ()
    reports_points: bool = False

    kind = "contact"
    columns = (
        *(f"force {c} [N]" for c in "xyz"),
        "normal [N]",
        "tangential [N]",
        "penetration [m]",
        "slip [m]",
        *(f"point {c} [m]" for c in "xyz"),
        "work [J]",
        "status [1]",
    )
    needs_rotation = False
    acts_at_once = True
    may_part = True

    @property
    def impact_state(self) -> int:
        """Where the state is that an impact sets; -1: there is none."""
        return (0 if self.friction is None else 2) if self.normal.has_impact else -1

    @property
    def begins(self) -> int:
        """Index of the first state of the first point."""
        return (0 if self.friction is None else 2) + self.normal.has_impact

    @property
    def each(self) -> int:
        """Number of states of a contact point."""
        law = self.friction
        return self.normal.has_branch + (0 if law is None else 3 + law.has_memory + law.turning_states)

    @property
    def events_of_each(self) -> int:
        """Number of its events, and of those of each of its points if these are requested."""
        return 4 if self.friction is not None and self.friction.holds else 2

    @property
    def initial_states(self) -> Vector:
        """Unstretched; held, but for what slips or does not touch."""
        states = np.zeros(self.begins + self.each * len(self.probes))
        if self.friction is not None and self.friction.has_memory:
            states[self.begins + 3 :: self.each] = [float(i not in self.slides) for i in range(len(self.probes))]
        return states

    def state_scales(self, acceleration: float) -> Vector:
        """Return what counts as large: of a stretch that of friction under the weight, so that loose runs hold too."""
        scales = np.ones(len(self.initial_states))
        if self.friction is not None:
            law = self.friction
            stretch = law.large_stretch(self.mass * acceleration)
            # of the path too: a trial of a step that leaves the cone would be told as a slip
            scales[0] = LARGE_PATH * stretch
            for first in range(self.begins, len(scales), self.each):
                scales[first : first + 3] = stretch
            for i, (_, probe) in enumerate(self.probes):
                scales[self.turning(i)] = [stretch / arm for arm in law.arms(probe.lever)]
        return scales

    @property
    def straight(self) -> float | None:
        """Stiffness of its normal law where that is a straight line, N/m."""
        return self.normal.straight

    @property
    def at_most(self) -> tuple[float, float] | None:
        """Stiffness and damping of all its points at once, closed and sticking; None if not known before a run."""
        k, c = self.straight, 0.0
        if self.friction is not None and k is not None:
            if self.friction.at_most is None:
                return None
            along, c = self.friction.at_most
            k = max(k, along)
        return None if k is None else (k, c)

    @property
    def has_rates(self) -> bool:
        """Those of its anchors and branches; about a rest anchors follow from places, and branches stay."""
        return self.rest is None and (self.friction is not None or self.normal.has_branch)

    def turning(self, i: int) -> slice:
        """Indices of the states that resist turning of a contact point."""
        last = self.begins + self.each * (i + 1) - self.normal.has_branch
        return slice(last - (0 if self.friction is None else self.friction.turning_states), last)

    @cached_property
    def numbers(self) -> Vector:
        """What compiled code is given of it."""
        return contact_numbers(self)

    @cached_property
    def listed(self) -> list[float]:
        """Return the numbers in a list, which Python reads faster."""
        return self.numbers.tolist()

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def surface_numbers(self) -> Vector:
        """What compiled code is given of the shape: its kind and numbers."""
        return np.append(float(self.shape.kind), self.shape.numbers)

    @property
    def face_numbers(self) -> Vector:
        """What compiled code is given of the faces at its points, of those that share the stiffness by them."""
        return np.zeros(0)

    @property
    def found_as(self) -> Kind:
        """By what kernels know where its points are."""
        return Kind.BOXES if self.probes[0][1].ring < 0.0 else Kind.POINTS


def contact_numbers(contact: ContactData) -> Vector:
    """Return the numbers of a contact: see `ContactNumbers`."""
    law, friction, rest = contact.normal, contact.friction, contact.rest
    points = [filled(PointNumbers, end=end, **probe._asdict()) for end, probe in contact.probes]
    parts = [np.concatenate(points)]
    begin = [0, ContactNumbers.number_count + len(parts[0])]  # of these, and of what comes next

    def put(part: Any) -> float:
        parts.append(np.ravel(part))
        begin.append(begin[-1] + len(parts[-1]))
        return float(begin[-2])

    rests_at = 0.0
    if rest is not None:
        rests_at = put(np.hstack((rest.material, rest.marks, rest.turns.reshape(-1, 9))))
    rubs = dict.fromkeys(("friction", "friction_at", "holds", "has_memory", "turning", "relaxation", "spring"), 0.0)
    if friction is not None:
        rubs |= {name: getattr(friction, name) for name in ("holds", "has_memory", "relaxation", "spring")}
        rubs |= {"friction": friction.kind, "friction_at": put(friction.block), "turning": friction.turning_states}
    head = filled(
        ContactNumbers,
        kind=contact.found_as,
        count=len(points),
        ends=len(contact.ends),
        shape=put(contact.surface_numbers),
        rests_at=rests_at,
        softness=0.0 if rest is None else rest.softness,
        belt=contact.belt,
        reports_points=contact.reports_points,
        normal=law.kind,
        normal_at=put(law.block),
        stiffness=law.stiffness,
        impact=contact.impact_state,
        impact_number=law.impact_number,
        least_speed=law.least_speed,
        branches=law.has_branch,
        first=contact.begins,
        each=contact.each,
        faces=put(contact.face_numbers) if len(contact.face_numbers) else 0.0,
        points=(),
        **rubs,
    )
    return np.concatenate((head, *parts))
