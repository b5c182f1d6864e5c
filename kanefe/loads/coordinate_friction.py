"""Dry friction along joint coordinates: an anchor that holds, and slips at the friction limit (cap)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Matrix, Vector
from kanefe.joints.joint_friction import RubbingSurfaces
from kanefe.kernels.contact.falling import still_to_fall
from kanefe.kernels.force_elements.coordinate_friction import (
    MOST_DIRECTIONS,
    FrictionNumbers,
    Rubbing,
    coordinate_friction,
    coordinate_friction_change,
    coordinate_friction_watch,
    is_held,
    load_on,
    put_load_rates,
    slipping,
    stretch,
)
from kanefe.kernels.force_elements.falling_friction import falling_friction, falling_friction_watch
from kanefe.kernels.values import tensors
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel, Tangent
from kanefe.loads.anchors import Anchor
from kanefe.loads.base import HeldCoordinates, Load, LoadEvent
from kanefe.loads.by_kernel import ActionByKernel, EventByKernel, numbers_of
from kanefe.loads.screened import ScreenedLoad

FORCE = 0

LARGE_STRETCH = 10.0
"""Scale of the error of stretches, in multiples of the stretch at the friction limit."""

SLIPS, STICKS = 0.0, 1.0


@dataclass(frozen=True, eq=False)
class CoordinateFriction(Load):
    """Friction along coordinates of a joint, like `kanefe.Coulomb`.

    The surface slips at ``v_i = arm_i rate_i``. With w the stretch of a spring to the anchor and ``p = k w + c v``, the
    drag against the motion is p, with its norm limited by the cap; ``dw/dt = (drag - k w) / c``, which is v while it
    sticks. The cap is ``sliding`` or ``static`` times ``base``, or times ``base + load`` if the load of the joint is
    followed. At a slip speed s it may fall, ``sliding + (static - sliding) exp(-(s/stribeck_speed)^2)``.

    States: w, one number for each coordinate; if the caps differ, 1 while it sticks and 0 while it slips; if a load n
    from the reaction is followed, the filtered load and T times its rate, N: ``dx/dt = (y + 2 (n - x))/T``,
    ``dy/dt = (n - x)/T``.

    Attributes
    ----------
    name : str
    ends : tuple of CoordinateMarker
        One for each coordinate, three at most.
    coordinate : str
        Name in its events: the body, and the coordinate if its joint has several.
    units : tuple of str
        Units of the coordinates: m or rad.
    sliding, static : float
        Kinetic and static friction limit, N or N m; coefficients if a load is followed.
    stribeck_speed : float
        m/s; 0: friction falls at once.
    stiffness, damping : float
        k and c, N/m and N s/m, or N m/rad and N m s/rad.
    arms : tuple of float
        Slip of the surface per coordinate: 1, or m/rad.
    base : float
        Factor of the cap: 1, or the constant load of the joint, N.
    bearing : RubbingSurfaces or None
        Relation of the load to the joint's reaction; None: the caps are given.
    load_time : float
        T, s.
    load_scale : float
        A large load, N.
    first_load : float
        Load at the start, N.
    rest : tuple of float or None
        Coordinates at a rest, for the linearised form: the stretches then follow from the coordinates.
    """

    name: str
    ends: tuple[CoordinateMarker, ...]
    coordinate: str = field(kw_only=True)
    units: tuple[str, ...] = field(kw_only=True)
    sliding: float = field(kw_only=True)
    static: float = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    damping: float = field(kw_only=True)
    arms: tuple[float, ...] = field(default=(1.0,), kw_only=True)
    base: float = field(default=1.0, kw_only=True)
    bearing: RubbingSurfaces | None = field(default=None, kw_only=True)
    load_time: float = field(default=0.0, kw_only=True)
    load_scale: float = field(default=1.0, kw_only=True)
    first_load: float = field(default=0.0, kw_only=True)
    rest: tuple[float, ...] | None = field(default=None, kw_only=True)
    stribeck_speed: float = field(default=0.0, kw_only=True)

    kind = "friction"
    acts_at_once = True

    @property
    def columns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Forces on the body along the coordinates, stretch of the anchor's spring, 1 while it sticks, slip, and load.

        Stretch and slip are along a single coordinate, with its sign; for several coordinates at the sliding surface.
        """
        forces = ["torque [N m]" if unit == "rad" else "force [N]" for unit in self.units]
        along, unit = [""], self.units[0]
        if self.count == MOST_DIRECTIONS:
            along, unit = [f" {axis}" for axis in "xyz"], "m"
            forces = [f"torque{axis} [N m]" for axis in along]
        elif self.count > 1:
            along, unit = [" turning" if unit == "rad" else " sliding" for unit in self.units], "m"
        stretches, slips = ([f"{what}{one} [{unit}" for one in along] for what in ("stretch", "slip speed"))
        load = () if self.bearing is None else ("load [N]",)
        return *forces, *(f"{one}]" for one in stretches), "sticks [1]", *(f"{one}/s]" for one in slips), *load

    @property
    def subject(self) -> str:
        """The coordinate, or the body."""
        return self.coordinate

    @property
    def has_memory(self) -> bool:
        """Whether kinetic and static limits differ, so that a state has to distinguish sliding and sticking."""
        return self.static > self.sliding

    @property
    def count(self) -> int:
        """Number of coordinates."""
        return len(self.ends)

    @property
    def load_state(self) -> int:
        """Index of the load of friction among the states."""
        return self.count + self.has_memory

    @property
    def initial_states(self) -> Vector:
        """Unstretched and sticking, under the load at the start."""
        states = np.zeros(self.load_state + (0 if self.bearing is None else 2))
        states[self.count : self.load_state] = STICKS
        states[self.load_state : self.load_state + 1] = self.first_load
        return states

    def anchors(self, ends: Sequence[End], states: Vector) -> list[Anchor]:
        """Return its anchor, of all coordinates together."""
        slip, coefficient = self._anchor(ends, states)[1], self.sliding
        if self.stribeck_speed > 0.0:
            share = still_to_fall(float(np.linalg.norm(slip)), self.stribeck_speed, 2.0)[1]
            coefficient += share * (self.static - self.sliding)
        load = float(load_on(self._numbers, states))
        one = np.ones(self.count)
        return [Anchor(self._rows, slip, one, self.static * load, coefficient * load, self.stiffness, self.damping)]

    def anchored(
        self, ends: Sequence[End], states: Vector, friction_forces: Sequence[Vector], slips: Sequence[bool]
    ) -> Vector:
        """Return the states with the stretch of its anchor, and whether it sticks."""
        (anchor,), after = self.anchors(ends, states), states.copy()
        after[: self.count] = anchor.stretch(friction_forces[0])
        after[self.count : self.count + self.has_memory] = SLIPS if slips[0] else STICKS
        return after

    def state_scales(self, acceleration: float) -> Vector:
        """Return scales of the anchor, which are small relative to the scene, for an accurate friction force."""
        sizes = np.ones(len(self.initial_states))
        sizes[: self.count] = LARGE_STRETCH * self.static * self.load_scale / self.stiffness
        sizes[self.load_state :] = self.load_scale
        return sizes

    @property
    def has_rates(self) -> bool:
        """Whether the stretch is integrated; in the form about a rest it follows from the coordinate."""
        return self.rest is None

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> CoordinateFriction | None:
        """Return the friction about a state of rest, with its spring attached at the present coordinates.

        None for a rotation in space, which has no coordinates for such a spring.
        """
        if self.count == MOST_DIRECTIONS:
            return None
        return replace(self, rest=tuple(float(end.p[0]) for end in ends))

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states at rest, with the stretch of the anchor for the friction force."""
        after = states.copy()
        after[: self.count] = self._friction_force(ends, states) / self.stiffness
        return after

    @property
    def reaction_load(self) -> Self | None:
        """The friction itself, if it follows the load of its joint."""
        return None if self.bearing is None else self

    @property
    def surfaces(self) -> RubbingSurfaces:
        """Relation of the load to the joint's reaction; a neutral one if the caps are given."""
        return self.bearing or RubbingSurfaces(self.arms, 0.0, np.zeros(3))

    def with_first_load(self, load: float) -> Self:
        """Return the same friction with the initial load, N."""
        return replace(self, first_load=load)

    @property
    def held_coordinates(self) -> HeldCoordinates:
        """Stiffness and damping of its anchor, and the faster of the rates of its stretch and of its load."""
        squares = np.square(self.arms)
        follows = 0.0 if self.bearing is None else 1.0 / self.load_time
        along = tuple(self.stiffness * squares), tuple(self.damping * squares)
        return HeldCoordinates(*along, max(self.stiffness / self.damping, follows))

    def slipping(self, ends: Sequence[End], states: Vector) -> tuple[float, str] | None:
        """Return the friction force on its only coordinate, if that slips."""
        if self.count > 1 or self._sticks(ends, states):
            return None
        held = float(self.action(0.0, ends, states).wrenches[0, FORCE])
        return abs(held), "N m" if self.units[0] == "rad" else "N"

    @property
    def screened(self) -> ScreenedLoad:  # type: ignore[override]
        """That states of sticking anchors follow the coordinates, if it follows no load."""
        return ScreenedLoad("" if self.bearing is None else None)

    def load_rates(self, wrench: Vector, ends: Sequence[End], states: Vector) -> Vector:
        """Return the rates of the load of friction and of its own rate, from the joint's reaction (6,)."""
        rates = np.zeros(len(states))
        if self.bearing is not None:
            axis, *reaction = (tensors.Vector(*part) for part in (self.bearing.axis, wrench[:3], wrench[3:]))
            put_load_rates(self._numbers, axis, (reaction[0], reaction[1]), numbers_of(ends), states, rates)
        return rates[self.load_state :]

    def load(self, wrench: Vector, ends: Sequence[End], states: Vector) -> float:
        """Return the load of a joint with a reaction (6,) in the axes of its body's frame, N."""
        return 0.0 if self.bearing is None else self.bearing.load(wrench, float(self._friction_force(ends, states)[0]))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the forces on the body, the stretch, whether it sticks, the slip speed of the anchor, and the load."""
        forces, w, slip = self.action(t, ends, states).wrenches[:, FORCE], *self._anchor(ends, states)
        sticks = self._sticks(ends, states)
        slip = np.zeros(self.count) if sticks else slip + (forces / self.arms + self.stiffness * w) / self.damping
        scale = self.arms[0] if self.count == 1 else 1.0
        load = () if self.bearing is None else (max(0.0, float(states[self.load_state])),)
        return np.array((*forces, *(w / scale), sticks, *(slip / scale), *load))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping of an anchor that sticks."""
        if not self._sticks(ends, states):
            return None
        return Tangent(self._rows, np.full(self.count, self.stiffness), np.full(self.count, self.damping))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        bearing = self.surfaces
        unused = (0.0,) * (MOST_DIRECTIONS - self.count)
        given = filled_from(
            self,
            FrictionNumbers,
            directions=self.count,
            follows=self.bearing is not None,
            rubbing=filled_from(bearing, Rubbing),
            arms=(*self.arms, *unused),
            is_at_rest=self.rest is not None,
            rest=(*(self.rest or self.count * (0.0,)), *unused),
        )
        change = coordinate_friction_change if self.has_memory else None
        real = falling_friction if self.stribeck_speed > 0.0 else coordinate_friction
        return LoadKernel(real, given, real, self._watch, change)

    @property
    def _numbers(self) -> FrictionNumbers:
        return FrictionNumbers(self.kernel.numbers)

    @property
    def _watch(self) -> Callable[..., None]:
        return falling_friction_watch if self.stribeck_speed > 0.0 else coordinate_friction_watch

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """Its events of slip and stick."""
        by = (ActionByKernel(self, coordinate_friction_change, i) if self.has_memory else None for i in (0, 1))
        (slip, stick), (above, below) = by, (EventByKernel(self, self._watch, i) for i in (0, 1))
        return LoadEvent("slip", above, 1, slip), LoadEvent("stick", below, -1, stick)

    @property
    def _rows(self) -> Matrix:
        """Partial derivatives of the rates of slip with respect to the motion of the ends."""
        rows = np.zeros((self.count, 6 * self.count))
        rows[range(self.count), range(FORCE, 6 * self.count, 6)] = self.arms
        return rows

    def _anchor(self, ends: Sequence[End], states: Vector) -> tuple[Vector, Vector]:
        """Return the stretch of its spring, and the slip speed of the surface."""
        given, at, directions = self._numbers, numbers_of(ends), range(self.count)
        stretches = np.array([stretch(given, at, states, i) for i in directions])
        return stretches, np.array([slipping(given, at, i) for i in directions])

    def _friction_force(self, ends: Sequence[End], states: Vector) -> Vector:
        return np.asarray(-self.action(0.0, ends, states).wrenches[:, FORCE] / self.arms)

    def _sticks(self, ends: Sequence[End], states: Vector) -> bool:
        """Return whether the force of spring and damper is within the friction limit."""
        look = EventByKernel(self, self._watch, 0 if is_held(self._numbers, states) else 1)
        return look(0.0, ends, states) <= 0.0
