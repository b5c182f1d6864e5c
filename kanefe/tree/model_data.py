"""The frozen scene: immutable tables that the equations read, and the layout of the state.

All speeds of the scene are numbered: first the free ones (body by body: joint speeds, then elastic speeds), then
the driven joint speeds, then the interface components fixed in G. The equations are assembled over as many of them as
are needed; the rows of driven and fixed speeds give driving and coupling forces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, Marker, ModalMarker
from kanefe.bodies.slopes import SlopeMeasure
from kanefe.errors import ModelError
from kanefe.frames import Matrix
from kanefe.joints import Motion
from kanefe.joints.motion import of_body
from kanefe.loads.base import Load, has_contacts
from kanefe.loads.reaction_load import ReactionLoad, reaction_load
from kanefe.storage.pickled import PickledByFields
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms, is_unreduced

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint
    from kanefe.contact.rigid.granular_contacts import GranularContacts
    from kanefe.contact.rigid.rigid_contact import RigidContact
    from kanefe.contact.surface import Surface
    from kanefe.loads.controller import Controller

QUADRATURES = 2
"""Number of energy quadratures at the end of the state of a run: energy dissipated, and work of loads and drives, J."""

LISTED = 8
"""Largest number of bodies in the repr of a model."""


@dataclass(frozen=True, eq=False, repr=False)
class ModelData(PickledByFields):
    """A frozen scene.

    Attributes
    ----------
    bodies : tuple of BodyTerms
        Parents before children.
    gravity : ndarray, shape (3,)
        In N, m/s2.
    slopes : SlopeMeasure
    coordinate_count, free_count, driven_count, fixed_count : int
        Sizes of q and of the three kinds of speeds.
    initial_coordinates, initial_speeds : ndarray
        q (coordinates,) and free speeds u (free,) at the start.
    constraints : tuple of Constraint
        Loop joints and couplers.
    loads : tuple of Load
        Loads between frames: springs, bushings, ropes and the like.
    load_states : tuple of slice
        Indices of the internal states of each load in z.
    initial_states : ndarray
        z (states,) at the start: internal states of loads, switches of constraints, and held outputs of controllers.
    controllers : tuple of Controller
    slack_time : float
        Time of the start at which springs without a rest length are slack, s.
    surfaces : tuple of Surface
        Surfaces on markers, for views; the equations use the contacts in `loads`.
    """

    bodies: tuple[BodyTerms, ...]
    gravity: np.ndarray
    slopes: SlopeMeasure
    coordinate_count: int
    free_count: int
    driven_count: int
    fixed_count: int
    initial_coordinates: np.ndarray
    initial_speeds: np.ndarray
    constraints: tuple[Constraint, ...] = ()
    loads: tuple[Load, ...] = ()
    load_states: tuple[slice, ...] = ()
    initial_states: np.ndarray = field(default_factory=lambda: np.zeros(0))
    controllers: tuple[Controller, ...] = ()
    slack_time: float = 0.0
    surfaces: tuple[Surface, ...] = ()

    def __post_init__(self) -> None:
        for array in (self.gravity, self.initial_coordinates, self.initial_speeds, self.initial_states):
            array.flags.writeable = False

    def __repr__(self) -> str:
        names = ", ".join(repr(body.name) for body in self.bodies[:LISTED]) + (
            ", ..." if len(self.bodies) > LISTED else ""
        )
        return f"{type(self).__name__}({names}; {self.free_count} speeds)"

    @cached_property
    def rigid_contacts(self) -> tuple[int, ...]:
        """Numbers of the loads that are rigid contacts."""
        if not has_contacts(self.loads):
            return ()
        from kanefe.contact.rigid.rigid_contact import rigid_contacts

        return tuple(i for i, _ in rigid_contacts(self.loads))

    def rigid_contact(self, number: int) -> RigidContact:
        """Return a rigid contact by its number in `rigid_contacts`."""
        from kanefe.contact.rigid.rigid_contact import rigid_contacts

        return [contact for _, contact in rigid_contacts(self.loads)][number]

    @cached_property
    def granular(self) -> GranularContacts | None:
        """Rigid contacts among many bodies, which need time stepping."""
        if not has_contacts(self.loads):
            return None
        from kanefe.contact.rigid.granular_contacts import granular_contacts

        return granular_contacts(self.loads)

    @property
    def is_constrained(self) -> bool:
        """Whether there are constraints or rigid contacts."""
        return bool(self.constraints) or bool(self.rigid_contacts)

    @cached_property
    def of_scene(self) -> dict[object, Any]:
        """What was found of the scene whatever its start is: shared by models that differ in their start alone."""
        return {}

    @cached_property
    def looks(self) -> dict[tuple[int, float, float], Matrix]:
        """Cache of the values of motions at the samples of a run."""
        return {}

    @property
    def has_power(self) -> bool:
        """Whether loads, drives or damping exchange energy, so that their work must be integrated."""
        return self.driven_count > 0 or any(
            part.exchanges_energy for parts in (self.bodies, self.loads) for part in parts
        )

    @property
    def has_unreduced(self) -> bool:
        """Whether a flexible body has all degrees of freedom of its mesh, in sparse matrices."""
        return any(body.flexible is not None and is_unreduced(body.flexible.body) for body in self.bodies)

    @cached_property
    def has_varying_tangents(self) -> bool:
        """Whether stiffness or damping changes with the state other than by geometry."""
        return bool(self.loads) or self.has_stops

    @cached_property
    def has_stops(self) -> bool:
        """Whether stops act along coordinates of joints."""
        return any(
            force is not None and force.is_varying for body in self.bodies for force in body.joint.coordinate_forces
        )

    @cached_property
    def armatures(self) -> np.ndarray:
        """Inertia along single speeds, of rotors behind gears, kg m2 or kg: (free + driven,)."""
        found = np.zeros(self.free_count + self.driven_count)
        for body in self.bodies:
            found[body.speeds] = body.joint.armature
            for speed, force in zip(body.speeds, body.joint.coordinate_forces, strict=True):
                if force is not None:
                    found[speed] = force.armature
        return found

    @property
    def state_count(self) -> int:
        """Number of internal states z."""
        return len(self.initial_states)

    @property
    def states_move(self) -> bool:
        """Whether internal states change between events."""
        return any(load.has_rates for load in self.loads)

    @cached_property
    def bearings(self) -> dict[int, int]:
        """Number of the joint's body for the number of each load that depends on the reaction of a joint."""
        found = ((i, reaction_load(load)) for i, load in enumerate(self.loads))
        return {i: load.ends[0].body for i, load in found if load is not None}

    def following(self, number: int) -> ReactionLoad:
        """Return a load that depends on the reaction of a joint, by its number."""
        load = reaction_load(self.loads[number])
        if load is None:
            raise TypeError(f"{self.loads[number].name!r} follows no reaction")
        return load

    def markers(self) -> Iterator[Marker]:
        """Yield the ends of loads between frames, and the markers of constraints and of their rows."""
        for load in self.loads:
            yield from load.ends
        for constraint in self.constraints:
            yield from (end for end in (constraint.a, constraint.b) if end is not None)
            yield from (marker for row in constraint.rows for marker in row.markers)

    def all_speeds(self, t: float, u: np.ndarray) -> np.ndarray:
        """Return free, driven and fixed speeds at time t (s) from the free ones; the fixed ones are zero."""
        if self.driven_count + self.fixed_count == 0:
            return u
        count = self.free_count + self.driven_count + self.fixed_count
        found = np.zeros(count, dtype=np.result_type(u, float))  # the free ones may be whole or complex numbers
        found[: self.free_count] = u
        if self.drives:
            found[self.free_count :][: self.driven_count] = self.driven_speeds(t)[0]
        return found

    def parts(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return q, u and z of a state that begins with them."""
        n, m = self.coordinate_count, self.coordinate_count + self.free_count
        return y[:n], y[n:m], y[m : m + self.state_count]

    def with_loads(self, loads: Sequence[Load]) -> Self:
        """Return the scene with these loads between frames, and their internal states at the start."""
        sizes = [len(load.initial_states) for load in loads]
        stops = np.cumsum(sizes, dtype=int).tolist()
        where = tuple(slice(stop - size, stop) for stop, size in zip(stops, sizes, strict=True))
        start = [float(x) for load in loads for x in load.initial_states]
        constraints = []
        for constraint in self.constraints:
            if constraint.starts_on is not None:
                constraint = replace(constraint, switch=len(start))
                start.append(1.0 if constraint.starts_on else 0.0)
            constraints.append(constraint)
        start += [0.0] * sum(controller.drive_count for controller in self.controllers)
        return replace(
            self,
            loads=tuple(loads),
            load_states=where,
            initial_states=np.array(start),
            constraints=tuple(constraints),
        )

    @cached_property
    def held(self) -> dict[str, slice]:
        """Indices in z of the values held by each controller, by its name."""
        stop, found = len(self.initial_states), {}
        for controller in reversed(self.controllers):
            found[controller.name] = slice(stop - controller.drive_count, stop)
            stop -= controller.drive_count
        return found

    def coordinate_places(self, number: int) -> list[tuple[int, int]]:
        """Return the index in q (-1 - drive if it is driven) and of the speed of each coordinate of a body's joint."""
        body = self.bodies[number]
        return [
            (int(at) if at >= 0 else int(self.free_count - 1 - speed), int(speed))
            for at, speed in zip(body.coordinates, body.speeds, strict=False)
        ]

    def index(self, name: str) -> int:
        """Return the number of the body called `name`; raise a ModelError that lists the names."""
        number = self._numbers.get(name) if isinstance(name, str) else None
        if number is None:
            raise ModelError(f"the scene has no body called {name!r}. It has: {', '.join(b.name for b in self.bodies)}")
        return number

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {body.name: number for number, body in enumerate(self.bodies)}

    def place_of(self, marker: CoordinateMarker) -> tuple[int, int]:
        """Return the index in q (-1 - drive if it is driven) and of the speed of the coordinate of a marker."""
        terms = self.bodies[marker.body].flexible
        if isinstance(marker, ModalMarker) and terms is not None:
            return terms.eta.start + marker.coordinate, terms.speeds.start + marker.coordinate
        return self.coordinate_places(marker.body)[marker.coordinate]

    def flexible_terms(self, name: str) -> FlexibleTerms:
        """Return the terms of a flexible body by name; raise a ModelError if it is rigid."""
        terms = self.bodies[self.index(name)].flexible
        if terms is None:
            raise ModelError(f"body {name!r} is rigid: it has no modal coordinates, mesh or interfaces")
        return terms

    def coordinate_names(self) -> tuple[str, ...]:
        """Return a name for every coordinate of q."""
        names = []
        for body in self.bodies:
            names += [
                f"{body.name}: {name}"
                for name, where in zip(body.joint.coordinate_names, body.coordinates, strict=True)
                if where >= 0
            ]
            if body.flexible:
                names += [f"{body.name}: eta {i}" for i in range(body.flexible.body.free_count)]
        return tuple(names)

    def speed_names(self) -> tuple[str, ...]:
        """Return a name for every free speed."""
        names = [""] * self.free_count
        for body in self.bodies:
            for where, name in zip(body.speeds, body.joint.speed_names, strict=True):
                if where < self.free_count:
                    names[where] = f"{body.name}: {name}"
            if body.flexible:
                for i in range(body.flexible.body.free_count):
                    names[body.flexible.speeds.start + i] = f"{body.name}: deta {i}"
        return tuple(names)

    def internal_names(self) -> tuple[str, ...]:
        """Return a name for every internal state."""
        names = [f"{load.name}: state {i}" for load in self.loads for i in range(len(load.initial_states))]
        names += [f"{c.name}: is on" for c in self.constraints if c.switch >= 0]
        return (
            *names,
            *(f"{controller.name}: {drive}" for controller in self.controllers for drive in controller.drives),
        )

    def advance(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return q moved by `step`, a vector in the directions of the free speeds times a time."""
        moved = np.empty_like(q)
        for body in self.bodies:
            at, speeds = body.free_coordinates()
            if len(at):
                moved[at] = body.joint.advance(q[at], step[speeds])
            if body.flexible:
                moved[body.flexible.eta] = q[body.flexible.eta] + step[body.flexible.speeds]
        return moved

    def coordinate_rates(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return dq/dt from the free speeds."""
        rates = np.empty_like(q)
        for body in self.bodies:
            at, speeds = body.free_coordinates()
            if len(at):
                rates[at] = body.joint.coordinate_rates(q[at], u[speeds])
            if body.flexible:
                rates[body.flexible.eta] = u[body.flexible.speeds]
        return rates

    def coordinate_map(self, q: np.ndarray) -> Matrix:
        """Return the map from the free speeds to dq/dt, (coordinates, free), at q."""
        found = np.zeros((self.coordinate_count, self.free_count))
        for body in self.bodies:
            at, speeds = body.free_coordinates()
            for i, unit in zip(speeds, np.eye(len(speeds)), strict=True):
                found[at, i] = body.joint.coordinate_rates(q[at], unit)
            if body.flexible:
                found[body.flexible.eta, body.flexible.speeds] = np.eye(body.flexible.body.free_count)
        return found

    @cached_property
    def drives(self) -> tuple[tuple[Motion, str], ...]:
        """The motions of the driven coordinates with their names, in the order of the driven speeds."""
        return tuple((motion, of_body(b.name)) for b in self.bodies for motion in b.joint.motions if motion is not None)

    @property
    def motions(self) -> tuple[tuple[Motion, str], ...]:
        """All that is given as a function of time, of joints and of loads between frames, each with its name."""
        return (*self.drives, *(given for load in self.loads for given in load.motions))

    def driven_speeds(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the driven joint speeds and their rates at time t, each (driven,)."""
        speeds = np.array([motion.at("velocity", t, what) for motion, what in self.drives])
        return speeds, np.array([motion.at("acceleration", t, what) for motion, what in self.drives])
