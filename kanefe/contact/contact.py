"""Contacts: probes of some frames press on a surface, and slide on it or stick to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.contact.box_pair import BoxPair, meeting, slot_of
from kanefe.contact.contact_anchors import anchored, anchors_of
from kanefe.contact.contact_events import Watched
from kanefe.contact.contact_numbers import kernel_of
from kanefe.contact.friction_couples import couple_of, rested_states
from kanefe.contact.laws.bristles import LuGre
from kanefe.contact.laws.friction_laws import Coulomb
from kanefe.contact.rest import Rest
from kanefe.contact.shapes import Box, Plane
from kanefe.contact.starts import warn_of_start
from kanefe.contact.touching_point import Touch, along_surface, velocity_past
from kanefe.frames import Vector, cross
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.loads.base import Action, End, Load, LoadEvent, LoadKernel, Tangent
from kanefe.loads.reach import LoadReach

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.contact.laws.normal_laws import NormalLaw
    from kanefe.loads.anchors import Anchor

OPEN, STICKS, SLIPS = range(3)

LARGE_PATH = 100.0
"""Stretches: a path that counts as large."""

ON_ITS_AXIS = 1e-9

MOST_TURNS, SAME_NORMAL = 100, 1e-15
"""Of the search for the lowest place of a ring on curved ground: each time the normal there says where it is. What it
is off shrinks by the radius of the ring over that of the ground, and counts by its square."""


@dataclass(frozen=True, eq=False)
class Contact(Load):
    """A contact between a surface and probes: points, balls and rings fixed in other frames.

    Its internal states are the path that it slid and the work of its friction (J), where it has any; lambda, where its
    normal law has a restitution; then of each probe the stretch of its anchor's spring in the axes of the surface, 1
    while it sticks, where that is to be known, and twists about the normal and of rolling, where friction holds those.

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
    friction : Coulomb, LuGre or None
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
    friction: Coulomb | LuGre | None
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
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene or gives it."""
        return True

    @property
    def begins(self) -> int:
        """Where the states of the first probe are."""
        return (0 if self.friction is None else 2) + (self.normal.restitution is not None)

    @property
    def each(self) -> int:
        """How many states a probe has."""
        law = self.friction
        return 0 if law is None else 3 + law.has_memory + law.turning_states

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
            if isinstance(law, LuGre):
                stretch = law.static / law.sigma0
            else:
                stretch = law.sliding * self.mass * acceleration / float(law.stiffness or 1.0) or 1.0
            # of the path too: a trial of a step that leaves the cone would be told as a slip
            scales[0] = LARGE_PATH * stretch
            for first in range(self.begins, len(scales), self.each):
                scales[first : first + 3] = stretch
            for i, (_, probe) in enumerate(self.probes):
                scales[self.turning(i)] = [stretch / arm for arm in law.arms(probe.lever)]
        return scales

    @property
    def has_rates(self) -> bool:
        """Those of its anchors, which follow from places about a rest."""
        return self.friction is not None and self.rest is None

    def touches(self, ends: Sequence[End], states: Vector) -> list[Touch]:
        """Return what each probe does."""
        surface, met = ends[0], None
        if isinstance(self.shape, Box) and self.probes[0][1].ring < 0.0:
            number, probe = self.probes[0]
            met = meeting(surface, 0.5 * self.shape.size, ends[number], probe.axis)
        found = []
        for i, (number, probe) in enumerate(self.probes):
            end = ends[number]
            depth, n, point = self._located(surface, end, probe, met)
            at = self.begins + self.each * i
            if depth <= 0.0 and (self.rest is None or self.rest.softness == 0.0):
                left = self._left(Touch(depth, number, point, n), surface, probe, states[at : at + 3])
                found.append(self._turned(left, i, surface, end, states))
                continue
            v = velocity_past(surface, end, point)
            rate = -float(v @ n)
            damping = self.normal.damping
            if self.normal.restitution is not None:
                damping = damping + states[self.begins - 1]
            effective = depth if self.rest is None else self.rest.depth(depth)
            press, elastic, potential = self.normal.pressed(effective, rate, probe.share, damping)
            touch = Touch(depth, number, point, n, press, elastic, potential, rate)
            if self.friction is not None:
                stretch = surface.A @ states[at : at + 3]
                if self.rest is not None:
                    stretch = stretch + self.rest.gone(i, surface, end)
                is_held = not self.friction.has_memory or bool(states[at + 3] > 0.5)
                touch = self._held(touch, self.friction, surface, probe, v, stretch, is_held)
            found.append(self._turned(touch, i, surface, end, states))
        return found

    def turning(self, i: int) -> slice:
        """Where the states are of what holds a probe against turning."""
        last = self.begins + self.each * (i + 1)
        return slice(last - (0 if self.friction is None else self.friction.turning_states), last)

    def _turned(self, touch: Touch, i: int, surface: End, end: End, states: Vector) -> Touch:
        """Return a probe with what friction does to it by couples."""
        law, probe = self.friction, self.probes[i][1]
        if not isinstance(law, Coulomb) or law.turning_states == 0 or (self.rest is not None and touch.press == 0.0):
            return touch
        gone = np.zeros(3) if self.rest is None else self.rest.turned(i, surface, end)
        couple = couple_of(
            law,
            *self.anchor(law, probe),
            probe.lever,
            surface.A,
            touch.normal,
            end.w - surface.w,
            touch.press,
            states[self.turning(i)],
            gone,
        )
        return touch._replace(couple=couple)

    def _located(self, surface: End, end: End, probe: Probe, met: BoxPair | None) -> tuple[float, Vector, Vector]:
        """Return depth, normal and place of a probe."""
        if met is not None and isinstance(self.shape, Box):
            return slot_of(met, -1 - int(probe.ring), surface, 0.5 * self.shape.size, end, probe.axis)
        centre = end.p + end.A @ probe.point
        phi, n = self._distance(surface, centre)
        if probe.ring > 0.0:
            axis, middle = end.A @ probe.axis, centre
            for _ in range(1 if isinstance(self.shape, Plane) else MOST_TURNS):
                down = (axis @ n) * axis - n
                length = float(np.linalg.norm(down))
                if length <= ON_ITS_AXIS:
                    break
                before, centre = n, middle + probe.ring / length * down
                phi, n = self._distance(surface, centre)
                if (n - before) @ (n - before) <= SAME_NORMAL**2:
                    break
        return probe.radius - phi, n, centre - probe.radius * n

    def _distance(self, surface: End, x: Vector) -> tuple[float, Vector]:
        phi, n = self.shape.distance(surface.A.T @ (x - surface.p))
        return phi, surface.A @ n

    def _left(self, touch: Touch, surface: End, probe: Probe, stretch: Vector) -> Touch:
        """Return a probe that does not touch: its anchor follows it."""
        if self.friction is None or self.rest is not None:
            return touch
        k, c = self.anchor(self.friction, probe)
        w = surface.A @ stretch
        if isinstance(self.friction, LuGre):
            return touch._replace(stretch=w, stretch_rate=-self.friction.sigma0 / self.friction.sigma1 * w)
        return touch._replace(stretch=w, stretch_rate=-k / c * w, potential=0.5 * k * float(w @ w))

    def _held(
        self, touch: Touch, law: Coulomb | LuGre, surface: End, probe: Probe, v: Vector, w: Vector, is_held: bool
    ) -> Touch:
        """Return a probe that touches with what friction does to it."""
        n, A = touch.normal, surface.A
        carried = along_surface(A @ self.belt, n)
        along = v + touch.rate * n - carried
        if isinstance(law, LuGre):
            drag, rate, beyond = law.bent(n, along, w, self.rest is not None)
            return touch._replace(
                along=along,
                carried=carried,
                drag=touch.press * drag,
                stretch=w,
                stretch_rate=rate,
                slip_rate=float(np.linalg.norm(along - rate)),
                reserve=beyond * touch.press,
            )
        k, c = self.anchor(law, probe)
        pull = k * along_surface(w, n) + c * along
        size, most, kept = float(np.linalg.norm(pull)), 0.0, 1.0
        mu, across = law.coefficients
        if mu != across:
            first = along_surface(A @ law.axis, n)
            first = first / np.linalg.norm(first)
            size, mu = float(np.hypot(pull @ first / mu, pull @ cross(n, first) / across)), 1.0
        most = mu * (law.static_ratio if is_held else 1.0) * touch.press
        if size > 0.0:
            if is_held or law.stribeck_speed == 0.0:
                waits = law.has_memory and is_held and self.rest is None  # the event of the slip ends the step
                kept = min(1.0, (HELD_BEYOND if waits else 1.0) * most / size)
            else:
                kept = 1.0 - c * law.slip_speed(size, touch.press, c) / size
        drag = kept * pull
        rate = (drag - k * w) / c
        potential = touch.potential + 0.5 * k * float(w @ w)
        reserve = size - most
        if not is_held and law.stribeck_speed > 0.0:
            reserve = size * (1.0 - kept)
        return touch._replace(
            potential=potential,
            along=along,
            carried=carried,
            pull=pull,
            drag=drag,
            stretch=w,
            stretch_rate=rate,
            slip_rate=float(np.linalg.norm(pull - drag)) / c,
            reserve=reserve,
        )

    def anchor(self, law: Coulomb | LuGre, probe: Probe) -> tuple[float, float]:
        """Stiffness and damping of the spring of an anchor; bristles keep no energy that is told."""
        if isinstance(law, LuGre):
            return 0.0, 0.0
        return probe.share * float(law.stiffness or 0.0), probe.share * float(law.damping or 0.0)

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return the forces on the surface and on what touches it (Eq. 11)."""
        wrenches, rates = np.zeros((len(ends), 6)), np.zeros(len(states))
        potential = taken = given = 0.0
        for i, touch in enumerate(self.touches(ends, states)):
            force = touch.press * touch.normal - touch.drag
            potential += touch.potential
            taken += (touch.press - touch.elastic) * touch.rate
            for number, sign in ((touch.end, 1.0), (0, -1.0)):
                wrenches[number, :3] += sign * force
                wrenches[number, 3:] += sign * cross(touch.point - ends[number].p, force)
            if self.friction is None:
                continue
            probe = self.probes[i][1]
            k, _ = self.anchor(self.friction, probe)
            taken += touch.drag @ touch.along - k * (touch.stretch @ touch.stretch_rate)
            given -= touch.drag @ touch.carried
            if touch.couple is not None:
                wrenches[touch.end, 3:] += touch.couple.moment
                wrenches[0, 3:] -= touch.couple.moment
                potential += touch.couple.potential
                taken += touch.couple.taken
            if self.rest is not None:
                continue
            at = self.begins + self.each * i
            rates[at : at + 3] = ends[0].A.T @ touch.stretch_rate
            if touch.depth > 0.0:
                slip = touch.along - touch.stretch_rate
                rates[0] += probe.share * touch.slip_rate
                rates[1] += touch.drag @ slip
            if touch.couple is not None:
                rates[self.turning(i)] = touch.couple.rates
                rates[1] += touch.couple.work
        return Action(wrenches, potential, taken, given, rates)

    def started(self, t: float, ends: Sequence[End]) -> Contact:
        """Return it with what slips at the start; what begins badly is told."""
        touches = self.touches(ends, replace(self, slides=()).initial_states)
        warn_of_start(self.name, self.probes, ends, touches)
        slides = [i for i, touch in enumerate(touches) if touch.depth <= 0.0 or touch.reserve > 0.0]
        return replace(self, slides=tuple(slides))

    def anchors(self, ends: Sequence[End], states: Vector) -> list[Anchor]:
        """Return those of its friction where it touches."""
        return anchors_of(self, ends, states)

    def anchored(self, ends: Sequence[End], states: Vector, drags: Sequence[Vector], slips: Sequence[bool]) -> Vector:
        """Return the internal states with which these give some friction."""
        return anchored(self, ends, states, drags, slips)

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Contact:
        """Return the contact about a state of rest: what sticks hangs on springs to where it is now."""
        touches = self.touches(ends, self.initial_states)
        material = np.array([ends[touch.end].A.T @ (touch.point - ends[touch.end].p) for touch in touches])
        marks = np.array([ends[0].A.T @ (touch.point - ends[0].p) for touch in touches])
        turns = np.array([ends[0].A.T @ ends[touch.end].A for touch in touches])
        return replace(self, rest=Rest(material, marks, turns, softness))

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states at rest: anchors are stretched by what friction holds."""
        after = states.copy()
        for i, touch in enumerate(self.touches(ends, states)):
            if self.friction is not None:
                probe = self.probes[i][1]
                k, _ = self.anchor(self.friction, probe)
                if isinstance(self.friction, LuGre):
                    k = self.friction.sigma0 * max(touch.press, 1e-300)
                at = self.begins + self.each * i
                after[at : at + 3] = ends[0].A.T @ touch.drag / k
                if self.friction.has_memory:
                    after[at + 3] = float(touch.depth > 0.0)
                if touch.couple is not None and isinstance(self.friction, Coulomb):
                    moment = touch.couple.moment
                    after[self.turning(i)] = rested_states(
                        self.friction, k, probe.lever, ends[0].A, touch.normal, moment
                    )
        return after

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return what `columns` say of force, depth, slip, place, work of friction and status."""
        touches = self.touches(ends, states)
        pressed = [touch for touch in touches if touch.depth > 0.0]
        drag = -sum((touch.drag for touch in pressed), np.zeros(3))
        force = sum((touch.press * touch.normal for touch in pressed), np.zeros(3))
        status = OPEN
        if pressed:
            status = SLIPS if self.friction is None or max(touch.reserve for touch in pressed) > 0.0 else STICKS
        slid = (0.0, 0.0) if self.friction is None else (states[0], states[1])
        depth = max(touch.depth for touch in touches)
        normal = sum(touch.press for touch in pressed)
        if normal > 0.0:
            point = sum((touch.press * touch.point for touch in pressed), np.zeros(3)) / normal
        else:
            point = max(touches, key=lambda touch: touch.depth).point
        return np.array((*(force + drag), normal, np.linalg.norm(drag), depth, slid[0], *point, slid[1], status))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping of what presses, and of what sticks: anchors stretch as its ends move."""
        rows, stiffness, damping = [], [], []
        for i, touch in enumerate(self.touches(ends, states)):
            if touch.depth <= 0.0:
                continue
            probe, law = self.probes[i][1], self.normal
            directions = [(touch.normal, law.slope(touch.depth, probe.share), 0.0)]
            if self.friction is not None and touch.reserve <= 0.0:
                k, c = self.anchor(self.friction, probe)
                if isinstance(self.friction, LuGre):
                    c = (self.friction.sigma1 + self.friction.sigma2) * touch.press
                first = cross(touch.normal, np.eye(3)[int(np.argmin(np.abs(touch.normal)))])
                first = first / np.linalg.norm(first)
                directions += [(first, k, c), (cross(touch.normal, first), k, c)]
            for along, k, c in directions:
                row = np.zeros((len(ends), 6))
                for number, sign in ((touch.end, 1.0), (0, -1.0)):
                    row[number, :3] += sign * along
                    row[number, 3:] += sign * cross(touch.point - ends[number].p, along)
                rows.append(row.ravel())
                stiffness.append(k)
                damping.append(c)
        if not rows:
            return None
        return Tangent(np.array(rows), np.array(stiffness), np.array(damping))

    @property
    def reach(self) -> LoadReach | None:
        """Balls about its probes, against the bounds of the surface; a soft contact about a rest acts from afar."""
        if self.rest is not None and self.rest.softness > 0.0:
            return None
        decays = np.zeros((len(self.initial_states), 2))
        if self.friction is not None and self.rest is None:
            for i, (_, probe) in enumerate(self.probes):
                at, law = self.begins + self.each * i, self.friction
                k, c = (law.sigma0, law.sigma1) if isinstance(law, LuGre) else self.anchor(law, probe)
                decays[at : at + 3] = k / c, 0.5 * self.anchor(law, probe)[0]
                for place, arm in enumerate(law.arms(probe.lever), self.turning(i).start):
                    decays[place] = k / c, 0.5 * k * arm**2
        factor = self.normal.stiffness
        of_each = (-1.0, -1.0, -factor, factor)[: 4 if isinstance(self.friction, Coulomb) else 2]
        watched = of_each * (len(self.events) // len(of_each))
        balls = tuple((end, probe.point, probe.extent) for end, probe in self.probes)
        return LoadReach(balls, self.shape.bounds, decays, watched)

    @property
    def kernel(self) -> LoadKernel | None:
        """Numbers: see `kanefe.kernels.contact.contact_forces`."""
        return kernel_of(self)

    def with_ends(self, ends: tuple[Any, ...]) -> Contact:
        """Return the same contact between other frames."""
        return replace(self, ends=ends)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """When it touches and lifts, slips and sticks."""
        return Watched(self).events()

    def in_detail(self) -> Contact | None:
        """Return the contact with the events of each probe; None of one probe, and of boxes on boxes.

        What touches of two boxes changes from corners to edges: it is no point that is known from before.
        """
        is_of_points = len(self.probes) > 1 and self.probes[0][1].ring >= 0.0
        return replace(self, reports_points=True) if is_of_points else None
