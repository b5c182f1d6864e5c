"""Rigid contacts: points that cannot penetrate a surface, and slide or stick by Coulomb's set-valued law."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.constraints.rows import METRE, MarkerMotion, Wrenches
from kanefe.contact.contact import OPEN, SLIPS, STICKS, Contact
from kanefe.contact.contact_events import of_point
from kanefe.contact.rigid.meeting import Meeting, meetings_with, turned
from kanefe.contact.rigid.rigid import Rigid
from kanefe.contact.shapes import Plane
from kanefe.errors import ModelError
from kanefe.frames import Vector, cross
from kanefe.kernels.contact.rigid_points import SLIPPING, RigidStates
from kanefe.kernels.values.records import column
from kanefe.loads.action import Action, End
from kanefe.loads.base import Load

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.contact.wanted_contact import WantedContact
    from kanefe.kernels.contact.laws.friction_law import FrictionLaw

REPORTED_EVENTS = "touch", "lift", "slip", "stick", "rest"
"""Events that a run reports for a contact; all but the last also for a contact point."""

REPORTED_CHANGES, EACH = 3, 7
"""Numbers of internal states of a contact (the path slid, the work of friction, and the energy that impacts have taken
between the bodies that touch) and of each of its contact points: its status; the point of the surface where it sticks,
or its direction of slip, whose length is the speed (m/s) up to which it is kept, or first the depth from which an open
one left (m); and the rate of the direction."""

TAKEN = column(RigidStates, "taken")
"""Number of the state of that energy."""

TOO_DEEP = 1e-6
"""Initial depth that is refused, m: a smaller one is closed like a loop."""

NORMAL = 0


def check_rigid(
    shape: SurfaceShape, probes: Sequence[tuple[int, Probe]], friction: FrictionLaw | None, belt: Vector, label: str
) -> None:
    """Raise a ModelError that names what a rigid contact does not have."""
    if not shape.is_smooth:
        raise ModelError(
            f"{label}: a {shape.title} has edges, or is curved in a way that rigid contacts do not follow. Remedy: "
            "planes, spheres or height fields, or a compliant law, kanefe.HuntCrossley(...)"
        )
    is_flat = isinstance(shape, Plane)
    if not is_flat and any(probe.ring > 0.0 for _, probe in probes):
        raise ModelError(f"{label}: rings of rigid contacts roll on planes only. Remedy: a plane, or a ball")
    if not is_flat and np.any(belt):
        raise ModelError(
            f"{label}: a surface velocity of rigid contacts takes a plane. Remedy: kanefe.HuntCrossley(...)"
        )
    if friction is not None and friction.not_rigid:
        raise ModelError(f"{label}: {friction.not_rigid}")


@dataclass(frozen=True, eq=False)
class RigidContact(Load):
    """A rigid contact between a surface and points fixed in other frames.

    It exerts no force by itself: what holds, `rows` give as constraints to the equations of motion. Which of them do,
    its internal states say, which change at impacts and where a force or a slip comes to its end.

    Attributes
    ----------
    name : str
    ends : tuple of Frame
        That of the surface, then those of the probes.
    shape : SurfaceShape
    probes : tuple of (int, Probe)
        Each with the number of its end.
    law : Rigid
    friction : FrictionLaw or None
    belt : ndarray, shape (3,)
        Velocity of the surface in its own axes, m/s.
    reports_points : bool
        Whether a run tells what each probe does too.
    """

    name: str
    ends: tuple[Any, ...]
    shape: SurfaceShape
    probes: tuple[tuple[int, Probe], ...]
    law: Rigid
    friction: FrictionLaw | None
    belt: np.ndarray
    reports_points: bool = False

    kind = "rigid contact"
    straight = None
    input_count = 0
    columns = Contact.columns
    needs_rotation = False

    @classmethod
    def of(cls, wanted: WantedContact) -> Self | None:
        """Return the contact that a scene wants, if its law is rigid; a ModelError says what that does not have."""
        if not isinstance(wanted.normal, Rigid):
            return None
        if wanted.convex is not None:
            raise ModelError(
                f"{wanted.label}: a rigid contact of a {wanted.convex.title} on a {wanted.shape.title} is not "
                "supported. Remedy: a compliant law, such as kanefe.HuntCrossley(1e6)"
            )
        check_rigid(wanted.shape, wanted.probes, wanted.friction, wanted.belt, wanted.label)
        return cls(wanted.name, wanted.ends, wanted.shape, wanted.probes, wanted.normal, wanted.friction, wanted.belt)

    @property
    def title(self) -> str:
        """Kind and name, for messages."""
        return f"{self.kind} {self.name!r}"

    @property
    def initial_states(self) -> Vector:
        """All open: a run finds out what touches at its start."""
        return np.zeros(REPORTED_CHANGES + EACH * len(self.probes))

    def state_scales(self, acceleration: float) -> Vector:
        """Return what counts as large of a path and of a work: the way of one second."""
        scales = np.ones(len(self.initial_states))
        scales[:REPORTED_CHANGES] = max(acceleration, 1e-3)
        return scales

    @property
    def told(self) -> tuple[str, ...]:
        """Reported events, after its name: of the contact, and on request of each of its points."""
        numbers = range(len(self.probes) if self.reports_points else 0)
        return *REPORTED_EVENTS, *(of_point(what, i) for i in numbers for what in REPORTED_EVENTS[:4])

    def in_detail(self) -> RigidContact | None:
        """Return the contact with events of each point; None for one point."""
        return replace(self, reports_points=True) if len(self.probes) > 1 else None

    @property
    def exchanges_energy(self) -> bool:
        """Only by friction: what impacts take is taken into account where they happen."""
        return self.friction is not None

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return nothing: see `kanefe.literal.contact_forces`."""
        return Action(np.zeros((len(ends), 6)), rates=np.zeros(len(states)))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the outputs without forces; the rest comes from `kanefe.literal.contact_forces`."""
        return np.zeros(len(self.columns))

    def started(self, t: float, ends: Sequence[End]) -> RigidContact:
        """Return it; a ModelError says what begins within the surface."""
        zero = np.zeros(3)
        motions = [MarkerMotion(end.p, end.A, zero, zero, zero, zero) for end in ends]
        met = self.met(range(len(self.probes)), motions[0], [motions[number] for number, _ in self.probes])
        gaps = [one.gap for one in met]
        if min(gaps) < -TOO_DEEP:
            raise ModelError(
                f"{self.title} begins {-min(gaps):.3g} m deep in its surface, and has no compliance. Remedy: place it "
                "outside, or kanefe.HuntCrossley(...) in place of Rigid"
            )
        return self

    def met(self, which: Sequence[int], a: MarkerMotion, b: Sequence[MarkerMotion]) -> list[Meeting]:
        """Return where some of the points meet the surface, from the motions of the surface's frame and their own."""
        rows = MarkerMotion(*(np.array(parts) for parts in zip(*b, strict=True)))
        return meetings_with(self.shape, [self.probes[i][1] for i in which], self.belt, a, rows)

    def status(self, z: Vector) -> list[int]:
        """Return OPEN, STICKS or SLIPS of each point from the internal states of the contact."""
        return [SLIPS if x > 1.5 else STICKS if x > 0.5 else OPEN for x in z[REPORTED_CHANGES::EACH]]

    def open_all(self, z: Vector) -> None:
        """Write to the internal states of the contact that all points are open."""
        z[REPORTED_CHANGES::EACH] = OPEN

    def kept(self, z: Vector, i: int) -> Vector:
        """Return where a point sticks, or in which direction it slips and up to which speed, in axes of the surface."""
        at = REPORTED_CHANGES + EACH * i + 1
        return z[at : at + 3]

    def left_of_gap(self, found: Meeting, z: Vector, i: int) -> float:
        """Return the gap of an open point above where it left the surface, which it has touched a little deep, m."""
        return found.gap + float(z[REPORTED_CHANGES + EACH * i + 1])

    def with_status(self, z: Vector, i: int, status: int, kept: Vector, rate: Vector | float = 0.0) -> None:
        """Write the status of a point, and its kept values with their rate, to the internal states of the contact."""
        at = REPORTED_CHANGES + EACH * i
        z[at], z[at + 1 : at + 4], z[at + 4 : at + 7] = status, kept, rate

    def turn(self, z: Vector, i: int, rates: Vector) -> None:
        """Write the rate of the direction in which a point slips to those of the internal states of the contact."""
        at = REPORTED_CHANGES + EACH * i + 1
        rates[at : at + 3] = z[at + 3 : at + 6]

    def has_mark(self, i: int) -> bool:
        """Whether what sticks does so at one place: points do, and balls roll."""
        probe = self.probes[i][1]
        return probe.radius == 0.0 and probe.ring == 0.0 and not self.belt.any()

    def friction_at(self, speed: float) -> float:
        """Return the coefficient of friction at a speed of slipping, m/s."""
        if self.friction is None:
            return 0.0
        return self.friction.coefficient(speed)

    @property
    def static(self) -> float:
        """The coefficient that it sticks by."""
        return 0.0 if self.friction is None else self.friction.holding

    def slip_directions(self, found: Sequence[Meeting], kept: np.ndarray, surface: MarkerMotion) -> np.ndarray:
        """Return the directions of slips over the two directions along the surface, (slips, 2).

        That of a slip that begins is kept. Past the end of a slip, where it would turn round, it is that of before: it
        stays smooth up to there and a little beyond, where the run looks for it.
        """
        rates = np.array([one.rates[1:] for one in found])
        before = turned(np.array([one.axes[1:] for one in found]), turned(surface.A, kept))
        sizes, speeds = _lengths(before), _lengths(rates)
        before = np.divide(before, sizes[:, None], out=np.zeros_like(before), where=sizes[:, None] > 0.0)
        along = (rates * before).sum(axis=1)
        across = _lengths(rates - along[:, None] * before)
        keeps = (sizes == 0.0) | (sizes > SLIPPING.begins) | (across <= SLIPPING.straight * speeds)
        own = np.copysign(1.0, along)[:, None] * rates / np.where(keeps, 1.0, speeds)[:, None]
        return np.where(keeps[:, None], before, own)

    def left_of_slip(self, found: Meeting, kept: Vector, surface: MarkerMotion) -> float:
        """Return a number that is zero where a slip ends or has turned by 60 degrees, and above it before, m/s.

        Of one that begins it is zero where it has the speed from which on it has its own direction, or goes back.
        """
        size, speed = _length(kept), _length(found.rates[1:])
        along = float(found.rates[1:] @ found.axes[1:] @ (surface.A @ kept)) / (size or 1.0)
        if size > SLIPPING.begins:
            return min(along + SLIPPING.back * size, size - speed)
        return along - SLIPPING.turned * speed

    def rows(self, z: Vector, which: Sequence[int], found: Sequence[Meeting], surface: MarkerMotion) -> list[Rows]:
        """Return the constraints of some closed points: normal rows, and rows of sticking."""
        statuses = self.status(z)
        slips = [k for k, i in enumerate(which) if statuses[i] == SLIPS]
        tangentials = dict(zip(slips, self._tangentials(z, which, found, slips, surface), strict=True)) if slips else {}
        return [
            (self._row(i, met, NORMAL, tangential=tangentials[k]),)
            if k in tangentials
            else self._stuck(z, i, met, surface)
            for k, (i, met) in enumerate(zip(which, found, strict=True))
        ]

    def _tangentials(
        self, z: Vector, which: Sequence[int], found: Sequence[Meeting], slips: Sequence[int], surface: MarkerMotion
    ) -> list[Vector]:
        """Return friction per unit normal force of the slipping ones of some points."""
        met = [found[k] for k in slips]
        directions = self.slip_directions(met, np.array([self.kept(z, which[k]) for k in slips]), surface)
        mu = [self.friction_at(_length(one.rates[1:])) for one in met]
        return [-mu[k] * (directions[k] @ one.axes[1:]) for k, one in enumerate(met)]

    def _stuck(self, z: Vector, i: int, found: Meeting, surface: MarkerMotion) -> Rows:
        mark = self.kept(z, i) if self.has_mark(i) else None
        off = None if mark is None else found.axes[1:] @ (surface.A @ (found.place - mark))
        given = -found.axes[1:] @ (surface.A @ self.belt)
        held = [
            self._row(i, found, 1 + k, off=None if off is None else float(off[k]), given=float(given[k]))
            for k in (0, 1)
        ]
        return self._row(i, found, NORMAL), *held

    def _row(self, i: int, found: Meeting, direction: int, **more: Any) -> ContactRow:
        ends = self.ends[0], self.ends[self.probes[i][0]]
        return ContactRow(f"probe {i + 1} of {self.name}", *ends, found, direction, **more)


@dataclass(frozen=True, eq=False)
class ContactRow:
    """A point stays on a surface, or does not move along it in one direction; computed at one state.

    Attributes
    ----------
    label : str
    a, b : Marker
        Of the surface, and of the probe.
    found : Meeting
    direction : int
        Which of its axes.
    tangential : ndarray, shape (3,), or None
        Friction of what slips for a unit of the normal force, in N: the force that holds the row is not along it.
    off : float or None
        How far what sticks is from where it does, m; None: it holds speeds alone.
    given : float
        Rate along the row beside that of its ends, m/s: that of a belt, reversed.
    """

    label: str
    a: Marker
    b: Marker
    found: Meeting
    direction: int
    tangential: Vector | None = None
    off: float | None = None
    given: float = 0.0
    unit: ClassVar[str] = METRE

    @property
    def presses(self) -> bool:
        """Whether its force is normal to a surface."""
        return self.direction == NORMAL

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The two ends."""
        return self.a, self.b

    @property
    def holds_place(self) -> bool:
        """Whether it holds coordinates, and not speeds alone."""
        return self.direction == NORMAL or self.off is not None

    def residual(self, a: MarkerMotion, b: MarkerMotion) -> float:
        """Return the gap, or how far it is off, m."""
        return self.found.gap if self.direction == NORMAL else float(self.off or 0.0)

    def wrenches(self, a: MarkerMotion, b: MarkerMotion) -> Wrenches:
        """Return the wrenches of a unit force along the row: its Jacobian."""
        return self._of(self.found.axes[self.direction], a, b)

    def forces(self, a: MarkerMotion, b: MarkerMotion) -> Wrenches:
        """Return the wrenches of a unit multiplier: with the friction of what slips."""
        e = self.found.axes[self.direction]
        return self._of(e if self.tangential is None else e + self.tangential, a, b)

    def _of(self, e: Vector, a: MarkerMotion, b: MarkerMotion) -> Wrenches:
        return _on_ends(e, self.found.point, a, b)

    def remainder(self, a: MarkerMotion, b: MarkerMotion) -> float:
        """Return what is left of the rate of the row's rate without du, m/s2."""
        return float(self.found.remainder[self.direction])


Rows = tuple[ContactRow, ...]
"""Rows of one closed contact point."""


def wrenches_of(rows: Sequence[ContactRow], a: MarkerMotion, b: MarkerMotion, *, is_pushed: bool = False) -> Wrenches:
    """Return the wrenches of rows between the same two ends, one a row of each array; pushed: with what rubs."""
    along = np.array([row.found.axes[row.direction] for row in rows])
    if is_pushed:
        along = along + np.array([row.tangential if row.tangential is not None else np.zeros(3) for row in rows])
    return _on_ends(along, np.array([row.found.point for row in rows]), a, b)


def rigid_contacts(loads: Sequence[Load]) -> Iterator[tuple[int, RigidContact]]:
    """Yield the rigid contacts among loads, each with its number there."""
    return ((i, load) for i, load in enumerate(loads) if isinstance(load, RigidContact))


def _length(x: Vector) -> float:
    return math.sqrt(float(x @ x))


def _lengths(x: np.ndarray) -> Vector:
    """Return the length of each row."""
    return np.asarray(np.sqrt((x * x).sum(axis=1)))


def _on_ends(e: Vector, point: Vector, a: MarkerMotion, b: MarkerMotion) -> Wrenches:
    return -e, cross(e, point - a.p), e, cross(point - b.p, e)


__all__ = [
    "EACH",
    "OPEN",
    "REPORTED_CHANGES",
    "SLIPPING",
    "SLIPS",
    "STICKS",
    "TAKEN",
    "ContactRow",
    "RigidContact",
    "rigid_contacts",
    "wrenches_of",
]
