"""The state of a scene for functions of the user: positions and motions of frames, computed on request."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, Self

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, Marker
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross
from kanefe.loads.action import End
from kanefe.loads.valued_load import CircularLoad
from kanefe.tree.body_terms import FlexibleTerms
from kanefe.tree.load_names import named_loads
from kanefe.tree.model_data import ModelData
from kanefe.tree.placed import INERTIAL, Placed, fixed_in, interface_placed

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.constraints.rows import Constraint

ORIGIN = (0.0, 0.0, 0.0)
"""Place of a point that nobody gives: the origin of its frame, m."""


class Forces(Protocol):
    """Forces that depend on the accelerations of a state."""

    def joint_reaction(self, name: str) -> Vector: ...  # noqa: D102
    def driving_force(self, name: str) -> Vector: ...  # noqa: D102
    def loop_force(self, name: str) -> Vector: ...  # noqa: D102
    def gear_force(self, name: str) -> Vector: ...  # noqa: D102
    def rigid_contact(self, number: int) -> Vector: ...  # noqa: D102


class SceneState:
    """The state of the scene passed to a function ``f(t, state)``. It is valid only during the call.

    Parameters
    ----------
    model : ModelData
    time : float
        s.
    q : ndarray, shape (coordinates,)
    u : ndarray, shape (free speeds,)
    z : ndarray, shape (states,)
        Internal states of loads and switches of constraints.
    frames : sequence of Placed
        Motion of every body's frame.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", position=0.1))
    >>> scene.add_motor(cart, lambda t, state: -50.0 * state.joint_coordinates("cart")[0])
    >>> result = scene.simulate((0.0, 1.0))
    """

    def __init__(
        self,
        model: ModelData,
        time: float,
        q: Vector,
        u: Vector,
        z: Vector | None = None,
        frames: Sequence[Placed] | None = None,
    ) -> None:
        self.model, self.time = model, time
        # of the run: what a function wrote there would be taken for the motion
        self.q, self.u, self.z = map(_read_only, (q, u, model.initial_states if z is None else z))
        self._given = frames
        self._forces: Forces | None = None
        self._asked: list[str] = []
        self._ends: dict[int, list[End]] = {}
        self._seen: dict[tuple[str, str], End] = {}

    def with_forces(self, forces: Forces) -> Self:
        """Return this state with access to forces that depend on its accelerations."""
        self._forces = forces
        return self

    @property
    def frames(self) -> Sequence[Placed]:
        """Motion of every body's frame, R or G."""
        if self._given is None:
            raise TypeError("a state without frames finds them itself")
        return self._given

    @cached_property
    def full(self) -> Vector:
        """All speeds: free, driven and fixed."""
        return self.model.all_speeds(self.time, self.u)

    @property
    def vector(self) -> Vector:
        """The state ``y = (q, u, z)`` of the equations, named by `Model.state_names`."""
        for body in self.model.bodies:
            if body.flexible is not None:
                self._modes_of(body.name)
        return np.concatenate((self.q, self.u, self.z))

    def position(self, name: str, interface: str = "", point: Sequence[float] = ORIGIN) -> Vector:
        """Return the position of a point of a body or of one of its interfaces, in N, shape (3,), m.

        Parameters
        ----------
        name : str
            The body.
        interface : str
            Interface of a flexible body; "": the frame of the body itself.
        point : array_like, shape (3,)
            Position from the frame's origin in its axes, m.
        """
        frame = self._moving(name, interface)
        return frame.p.copy() if point is ORIGIN else np.asarray(frame.p + frame.A @ np.asarray(point, dtype=float))

    def velocity(self, name: str, interface: str = "", point: Sequence[float] = ORIGIN) -> Vector:
        """Return the velocity of a point given as for `position`, in components of N, shape (3,), m/s."""
        frame = self._moving(name, interface)
        return frame.v.copy() if point is ORIGIN else frame.v + cross(frame.w, frame.A @ np.asarray(point, dtype=float))

    def rotation(self, name: str, interface: str = "") -> Matrix:
        """Return A_NF, which maps components in the frame's axes to those in N, shape (3, 3)."""
        return self._moving(name, interface).A.copy()

    def angular_velocity(self, name: str, interface: str = "") -> Vector:
        """Return the angular velocity of a frame seen from N, in its own axes, shape (3,), rad/s."""
        frame = self._moving(name, interface)
        return frame.w @ frame.A

    def joint_coordinates(self, name: str) -> Vector:
        """Return the coordinates of a body's joint, driven ones included, m and rad."""
        return self.model.bodies[self.model.index(name)].joint_coordinates(self.time, self.q)

    def joint_speeds(self, name: str) -> Vector:
        """Return the speeds of a body's joint, driven ones included, m/s and rad/s."""
        return np.asarray(self.full[self.model.bodies[self.model.index(name)].speeds])

    def modal_coordinates(self, name: str) -> Vector:
        """Return eta of a flexible body, shape (k,)."""
        return np.array(self.q[self._modes_of(name).eta])

    def modal_speeds(self, name: str) -> Vector:
        """Return deta of a flexible body, shape (k,)."""
        return np.array(self.full[self._modes_of(name).speeds])

    def _modes_of(self, name: str) -> FlexibleTerms:
        terms = self.model.flexible_terms(name)
        if not terms.body.components:  # a condensed body, with other coordinates: see kanefe.unreduced.condensed
            raise ModelError(
                f"the coordinates of the unreduced body {name!r} are not available to functions of the state. Remedy: "
                "state.position(body, interface) and the like, or reduction=CraigBampton()"
            )
        return terms

    def joint_reaction(self, name: str) -> Vector:
        """Return the force and moment of a body's joint on it, with those of motors and drives, (6,): N and N m.

        About the origin of the body's frame, in its axes. Available to functions and actions of events.

        Raises
        ------
        ModelError
            If there is no such body, or the caller is a load, on which accelerations and the reaction depend.

        Examples
        --------
        A run that stops when the reaction of a pendulum reaches 20 N:

        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> weight = scene.add_rigid_body("weight", 1.0, com=(0, 0, -1), joint=kf.Revolute("y", position=2.5))
        >>> def tension(t, state):
        ...     return 20.0 - (state.joint_reaction("weight")[:3] ** 2).sum() ** 0.5
        >>> result = scene.simulate((0.0, 2.0), events=kf.Event("torn", tension, terminal=True))
        >>> result.status.kind
        'stopped'
        """
        return self._held(f"the joint reaction of {name!r}").joint_reaction(name)

    def driving_force(self, name: str) -> Vector:
        """Return the forces on the driven coordinates of a body's joint, (driven,), N and N m; as `joint_reaction`."""
        return self._held(f"the driving force of {name!r}").driving_force(name)

    def loop_force(self, name: str) -> Vector:
        """Return force and moment of a loop joint on its end b, in its axes, (6,), N and N m; as `joint_reaction`."""
        return self._held(f"the force of loop joint {name!r}").loop_force(name)

    def gear_force(self, name: str) -> Vector:
        """Return forces of a gear on the coordinates that it couples, (n,), N and N m; as `joint_reaction`."""
        return self._held(f"the force of gear {name!r}").gear_force(name)

    def _held(self, what: str) -> Forces:
        if self._forces is None:
            raise CircularLoad(
                f"{what}, which depends on the accelerations, and these on all loads: that is circular. Remedy: what "
                "depends on places and speeds, such as state.load(name); a controller that reads an acceleration; or "
                "an event that looks at the reaction"
            )
        return self._forces

    def load(self, name: str) -> Vector:
        """Return the outputs of a load between frames, or the value of another load.

        Parameters
        ----------
        name : str
            Name of a spring, bushing, rope or load of your own: outputs as those of `Result.load`. Or the label of a
            force, torque, motor, traction or pressure, such as ``"the motor of 'arm'"``: its value, (1,) or (3,).

        Raises
        ------
        ModelError
            If there is no such load, or the caller is a load on which it depends.

        Examples
        --------
        A motor with half of the force of a spring:

        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", position=1.0))
        >>> scene.add_spring("spring", scene.ground, cart, stiffness=10.0, rest_length=0.8)
        >>> scene.add_motor(cart, lambda t, state: 0.5 * state.load("spring")[2])
        >>> result = scene.simulate((0.0, 1.0))
        """
        for number, load in enumerate(self.model.loads):
            if load.name == name:
                if number in self.model.rigid_contacts:
                    held = self._held(f"the force of the {load.kind} {name!r}")
                    return held.rigid_contact(self.model.rigid_contacts.index(number))
                return load.tell(self.time, self.load_ends(number), self.load_states(number))
        known = named_loads(self.model)
        if name not in known:
            there_are = ", ".join((*(load.name for load in self.model.loads), *known)) or "none"
            raise ModelError(f"the scene has no load {name!r}. It has: {there_are}")
        if name in self._asked:
            way = " for ".join(self._asked[self._asked.index(name) :])
            raise CircularLoad(f"itself: {way} for {name}. Remedy: one of them as a function of places and speeds")
        self._asked.append(name)
        try:
            return np.atleast_1d(known[name].value(self.time, self))
        finally:
            self._asked.pop()

    def is_on(self, name: str) -> bool:
        """Return whether a constraint holds, by its name."""
        return self._constraint(name).holds(self.z)

    def switched(self, *, on: str | Sequence[str] = (), off: str | Sequence[str] = ()) -> Vector:
        """Return the state ``(q, u, z)`` with constraints switched on and off, for the action of an event.

        Parameters
        ----------
        on, off : str or sequence of str
            Names of constraints that were added with `starts_on`.

        Raises
        ------
        ModelError
            If there is no such constraint, or it always holds.

        Examples
        --------
        A weight that is released after half a second:

        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> weight = scene.add_rigid_body("weight", 1.0, joint=kf.Prismatic("z"))
        >>> scene.add_loop_joint("hook", kf.Fixed, scene.ground, weight, starts_on=True)
        >>> let_go = kf.Event("let go", lambda t, state: t - 0.5, action=lambda t, state: state.switched(off="hook"))
        >>> result = scene.simulate((0.0, 1.0), events=[let_go])
        >>> round(float(result.position("weight")[-1, 2]), 6)
        -1.22625
        """
        y = self.vector
        first = len(self.q) + len(self.u)
        for names, value in ((on, 1.0), (off, 0.0)):
            for name in (names,) if isinstance(names, str) else names:
                constraint = self._constraint(name)
                if constraint.switch < 0:
                    raise ModelError(
                        f"{constraint.title} always holds. Remedy: starts_on=True or False where it is added"
                    )
                y[first + constraint.switch] = value
        return y

    def _constraint(self, name: str) -> Constraint:
        for constraint in self.model.constraints:
            if constraint.name == name:
                return constraint
        known = ", ".join(constraint.name for constraint in self.model.constraints)
        raise ModelError(f"the scene has no constraint called {name!r}. It has: {known or 'none'}")

    def load_states(self, number: int) -> Vector:
        """Return the internal states of a load between frames, by its number in the model."""
        return self.z[self.model.load_states[number]]

    def load_ends(self, number: int) -> list[End]:
        """Return the motion of the ends of a load between frames, by its number in the model."""
        if number not in self._ends:
            self._ends[number] = [self._end(marker) for marker in self.model.loads[number].ends]
        return self._ends[number]

    def _end(self, marker: Marker) -> End:
        if not isinstance(marker, CoordinateMarker):
            return self.placed_marker(marker).end
        at, speed = self.model.place_of(marker)
        p, v = np.zeros(3), np.zeros(3)
        body = self.model.bodies[marker.body]
        p[0] = self.q[at] if at >= 0 else body.joint_coordinates(self.time, self.q)[marker.coordinate]
        v[0] = self.full[speed]
        return End(p, np.eye(3), v, np.zeros(3))

    def placed_marker(self, marker: Marker) -> Placed:
        """Return the motion of a marker, also on a node of a mesh or on the ground."""
        carrier = INERTIAL if marker.body < 0 else self.placed(marker.body, marker.interface)
        return fixed_in(carrier, marker.point, marker.axes)

    def placed(self, number: int, frame: InterfaceFrame | None) -> Placed:
        """Return the motion of a body's frame, or of one of its interfaces or nodes (axes of G rotated with it)."""
        G, terms = self._body_frame(number), self.model.bodies[number].flexible
        if frame is None or terms is None:
            return G
        return interface_placed(G, frame, self.q[terms.eta], self.full[terms.speeds], self.model.slopes)

    def _body_frame(self, number: int) -> Placed:
        return self.frames[number]

    def _moving(self, name: str, interface: str) -> End:
        """Return the motion of a body's frame, or of one of its interfaces, in components of N; found once."""
        try:
            found = self._seen.get((name, interface))
        except (TypeError, ValueError):  # what has no hash
            raise ModelError(f"bodies and interfaces are named by texts, not {name!r} and {interface!r}") from None
        if found is None:
            found = self._seen[name, interface] = self._found(self.model.index(name), name, interface)
        return found

    def _found(self, number: int, name: str, interface: str) -> End:
        if not interface:
            return self.placed(number, None).end
        frame = self.model.flexible_terms(name).body.interface(interface)
        return fixed_in(self.placed(number, frame), np.zeros(3), frame.axes).end


def _read_only(x: Vector) -> Vector:
    """Return a view of an array that cannot be written to."""
    view = x[:]
    view.flags.writeable = False
    return view
