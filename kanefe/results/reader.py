"""Reader: the quantities of a run, by body and interface name, in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import rotation_matrix
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus
from kanefe.results.body_shape import BodyShape
from kanefe.results.channels import Channels, RunChannels
from kanefe.results.contact_history import ContactHistory, contact_history, is_contact
from kanefe.results.contact_points import ContactPoints, contact_points, point_columns
from kanefe.results.contact_report import contact_report
from kanefe.results.load_forces import load_forces, turned_into
from kanefe.results.load_lines import LoadLine
from kanefe.results.quantities import (
    CENTRES,
    DRIVES,
    ENERGIES,
    INTERFACES,
    LOADS,
    LOOPS,
    MODES,
    MOMENTA,
    MOTIONS,
    OF_SCENE,
    POINTS,
    QUANTITIES,
    Energy,
    Momentum,
    resolved_parts,
)
from kanefe.results.selection import Frames, frame_index, node_numbers
from kanefe.results.surface_outline import SurfaceOutline
from kanefe.tree.neighbours import Neighbours

LARGEST_TABLE = 2**31
"""Bytes of nodal values above which a call asks for a choice of output times."""


class EventTimes(dict[str, np.ndarray]):
    """Times at which events happened, by name."""

    def __missing__(self, name: str) -> np.ndarray:
        """Raise a ModelError that names the events there are."""
        raise ModelError(
            f"the run has no event called {name!r}. It has: {', '.join(self) or 'none'}. Remedy: one of these; that "
            f"ropes become slack and taut, and what single points of contacts do, is told on request, "
            f"simulate(events=[{name!r}])"
        )


class Reader:
    """What a run tells; `kanefe.Result` is the reader that users have, with pictures and files.

    Parameters
    ----------
    channels : Channels
        Of a run in memory, or of a file.
    """

    def __init__(self, channels: Channels) -> None:
        self._channels = channels

    @cached_property
    def _shapes(self) -> dict[str, BodyShape]:
        return {shape.name: shape for shape in self._channels.bodies}

    @property
    def run(self) -> RunChannels | None:
        """Model and trajectory of a run in memory; None of a result from a file."""
        return self._channels if isinstance(self._channels, RunChannels) else None

    @property
    def times(self) -> np.ndarray:
        """Output times, shape (T,), in s."""
        return self._channels.times

    @property
    def statistics(self) -> dict[str, Any]:
        """What did the run and what it cost; ``print(result)`` tells it in a few lines.

        "method" and the "reason" why it was chosen, its "rtol" or "step"; "route" of the equations and "route_reason"
        likewise; how many "steps", "rejected" steps, "evaluations" of the equations, "factorisations" and "jacobians"
        there were; "seconds" in all, and "seconds_by_part": set-up, compiling (or reading compiled kernels), steps,
        outputs, events, checkpoints. Forces and what else a result computes when it is asked for them are not among
        them.
        """
        return self._channels.statistics

    @property
    def status(self) -> RunStatus:
        """How the run ended: finished, stopped by an event or a limit, or failed, and then what to try."""
        return self._channels.status

    @property
    def events(self) -> dict[str, np.ndarray]:
        """Times at which each event happened, by name, s; see `kanefe.Event`."""
        return EventTimes(self._channels.events)

    @property
    def controllers(self) -> dict[str, ControllerLog]:
        """Samples of each controller, by name: ``times`` (K,), ``reads`` and ``drives`` (K, n), with their names."""
        return dict(self._channels.controllers)

    @property
    def has_forces(self) -> bool:
        """Whether accelerations, reactions and coupling forces can be had: not of a result saved without them."""
        return self._channels.has_forces

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, parents before children."""
        return tuple(self._shapes)

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loop joints, distances and rolling contacts."""
        return self._channels.loops

    @property
    def loads(self) -> dict[str, tuple[str, ...]]:
        """Names of the loads between frames, and of what each tells, with units in brackets: see `load`."""
        return dict(self._channels.loads)

    @property
    def surfaces(self) -> tuple[SurfaceOutline, ...]:
        """What the surfaces look like that things touch, and on what they sit."""
        return self._channels.surfaces

    @checked
    def body(self, name: str) -> BodyShape:
        """Return mass, mesh and modes of a body; raise a ModelError that lists the names if there is none."""
        if name not in self._shapes:
            raise ModelError(f"the run has no body called {name!r}. It has: {', '.join(self.bodies)}")
        return self._shapes[name]

    @checked
    def interfaces(self, name: str) -> tuple[str, ...]:
        """Return the names of the interfaces of a body; none for a rigid one."""
        return self.body(name).interfaces

    @checked
    def position(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the position of a frame in N, shape (T, 3), in m."""
        return self.read("position", name, interface)

    @checked
    def rotation(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the Euler parameters of a frame seen from N (Eq. 5), scalar first, without jumps of sign, (T, 4)."""
        return self.read("rotation", name, interface)

    @checked
    def velocity(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the velocity of a frame's origin in components of N, shape (T, 3), in m/s."""
        return self.read("velocity", name, interface)

    @checked
    def angular_velocity(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the angular velocity of a frame in its own components, shape (T, 3), in rad/s."""
        return self.read("angular_velocity", name, interface)

    @checked
    def acceleration(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the acceleration of a frame's origin in components of N (Eq. 15), shape (T, 3), in m/s2."""
        return self.read("acceleration", name, interface)

    @checked
    def angular_acceleration(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the angular acceleration of a frame in its own components (Eq. 16), shape (T, 3), in rad/s2."""
        return self.read("angular_acceleration", name, interface)

    @checked
    def center_of_mass(self, name: str = "") -> np.ndarray:
        """Return the centre of mass of a body, deformed as it is, or of the whole scene, in N, shape (T, 3), in m."""
        return self.read("center_of_mass", name)

    @checked
    def joint_coordinates(self, name: str) -> np.ndarray:
        """Return the coordinates of a body's joint, (T, coordinates); driven ones too. Units: `units`."""
        return self.read("joint_coordinates", name)

    @checked
    def joint_speeds(self, name: str) -> np.ndarray:
        """Return the speeds of a body's joint, (T, speeds); driven ones too. Units: `units`."""
        return self.read("joint_speeds", name)

    @checked
    def modal_coordinates(self, name: str) -> np.ndarray:
        """Return eta of a flexible body, shape (T, k)."""
        return self.read("modal_coordinates", name)

    @checked
    def modal_speeds(self, name: str) -> np.ndarray:
        """Return deta/dt of a flexible body, shape (T, k)."""
        return self.read("modal_speeds", name)

    @checked
    def deflection(self, name: str, interface: str) -> np.ndarray:
        """Return translation (m) and slopes (rad) of an interface from its undeformed place in G, shape (T, 6)."""
        return self.read("deflection", name, interface)

    def coupling_force(self, name: str, interface: str, of: str | None = None) -> np.ndarray:
        """Return force (N) and moment (N m) on a flexible body at an interface, in axes of G, shape (T, 6).

        All that its neighbours do to it there: the body that carries it, where the interface is fixed in G, and bodies
        that hang on it, by their joints with what acts in them; loops, contacts, loads between frames and given forces
        on the interface, frames of it and nodes of the mesh that move with it as one. The moment is about the
        interface where it is, deformed. Loads elsewhere on the body, gravity among them, are not in it. So on each body
        the coupling forces of all interfaces, the loads elsewhere and inertia are in balance.

        Parameters
        ----------
        name, interface : str
        of : str, optional
            Only a part (Eq. 30): "F_u", what is unknown before the equations are solved, by joints, loops and rigid
            contacts, in components that the mesh does not have zero of what carries it (Eq. 39); "F_k", what is known,
            by all other loads; or what does it: a body, at the other end of the joint ("ground": the inertial frame), a
            loop, a load between frames, or a given force or torque by its label as in `SceneState.load`. Where two
            have one name, with "body", "loop", "load", "force" or "carrier" in front. See `neighbours`.

        Raises
        ------
        ModelError
            If there is no such body, interface or part; the message says what there is.

        Examples
        --------
        >>> import kanefe as kf
        >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
        >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
        >>> beam = straight_beam(1.0, Rectangle(0.02, 0.02), steel, elements=4)
        >>> body = beam_body(beam, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=2))
        >>> scene = kf.System()
        >>> arm = scene.add_flexible_body("arm", body)
        >>> above = scene.ground.frame(at=(1, 0, 1))
        >>> scene.add_spring("rope", arm.interface("tip"), above, stiffness=100.0, rest_length=0.8)
        >>> rest = kf.equilibrium(scene)
        >>> rest.coupling_force("arm", "tip", of="rope")[2].round(1)
        19.8
        >>> rest.neighbours("arm", "root")
        Neighbours(unknown=('ground',), known=())
        """
        return self.read("coupling_force", name, interface, of)

    @checked
    def neighbours(self, name: str, interface: str) -> Neighbours:
        """Return the names of what acts at an interface, `unknown` and `known`: parts that `coupling_force` takes."""
        return self.body(name).neighbours[self._interface(self._flexible(name), "coupling_force", interface)]

    @checked
    def joint_reaction(self, name: str) -> np.ndarray:
        """Return force (N) and moment (N m) of a body's joint on it, shape (T, 6).

        About the origin of the body's frame, in its axes; the part of motors and drives is included.
        """
        return self.read("joint_reaction", name)

    @checked
    def driving_force(self, name: str) -> np.ndarray:
        """Return the force (N) or torque (N m) that keeps a driven joint on its motion.

        Of a joint that follows a given pose as a whole it is the power of the drive, W; the wrench is that of
        `joint_reaction`. Shape (T,); (T, n) for a joint with n driven coordinates.
        """
        return self.read("driving_force", name)

    @checked
    def loop_force(self, name: str) -> np.ndarray:
        """Return force (N) and moment (N m) of a loop joint or rolling contact on its end b, shape (T, 6).

        About the origin of that end, in its axes.
        """
        return self.read("loop_force", name)

    @checked
    def load(self, name: str, column: str | None = None) -> np.ndarray:
        """Return what a load between frames tells, such as the tension of a rope, (T, columns), or (T,) of one column.

        Parameters
        ----------
        name : str
            See `loads`, which names the columns too.
        column : str, optional
            The name of one column, with or without its unit: ``"tension"``, ``"force y [N]"``.

        Raises
        ------
        ModelError
            If there is no such load or column; lists what there is.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> ball = scene.add_point("ball", 2.0, joint=kf.Prismatic("z", position=-1.0))
        >>> scene.add(kf.Rope("hoist", (scene.ground, ball), axial_stiffness=1e6, damping=1e3))
        >>> result = scene.simulate((0.0, 1.0))
        >>> float(result.load("hoist", "tension")[-1].round(1))  # N
        19.6
        """
        found = self.read("load", name)
        if column is None:
            return found
        columns = self.loads[name]
        places = [i for i, one in enumerate(columns) if column in (one, one.partition(" [")[0])]
        if not places:
            raise ModelError(f"load {name!r} has no column {column!r}. It has: {', '.join(columns)}")
        return np.asarray(found[..., places[0]])

    @checked
    def load_lines(self, frames: Frames | None = None) -> tuple[LoadLine, ...]:
        """Return where springs, ropes and other loads along a line go, and when they are slack.

        The line of a rope or winch goes over all its points, as its law has it; those of other loads join two ends.
        Contacts have none.

        Parameters
        ----------
        frames : int, slice or ints, optional
            Which output times, by number; default: all, S = T.

        Returns
        -------
        tuple of LoadLine
            Each with its ``name``, its ``points`` (S, ends, 3) in N in m, and its ``states`` (S,): 0 where it is taut,
            1 where it is slack, 2 where it has broken.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> ball = scene.add_point("ball", 2.0, at=(1, 0, -1), joint=kf.Prismatic("z"))
        >>> over = scene.ground.frame(at=(1, 0, 0))
        >>> scene.add(kf.Rope("hoist", (scene.ground, over, ball), axial_stiffness=1e6, damping=1e3, preload=19.62))
        >>> (hoist,) = scene.simulate((0.0, 0.1)).load_lines()
        >>> hoist.points[0].tolist()
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0]]
        """
        rows = np.arange(len(self.times))[frame_index(frames, len(self.times))]
        return self._channels.load_lines(np.atleast_1d(rows))

    @checked
    def load_force(self, name: str, end: int = -1) -> np.ndarray:
        """Return force (N) and moment (N m) of a load between frames on one of its ends, in N, shape (T, 6).

        The moment is about the origin of that end. In axes of the aircraft, the deck or any body: `in_axes_of`.

        Parameters
        ----------
        name : str
            See `loads`.
        end : int
            From 0; default: the last.

        Raises
        ------
        ModelError
            If there is no such load or end, the result is from a file, or the load is a rigid contact, whose force
            `contact` tells.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> ball = scene.add_point("ball", 2.0, joint=kf.Prismatic("z", position=-1.0))
        >>> scene.add(kf.Rope("rope", (scene.ground, ball), axial_stiffness=1e6, damping=2e3, preload=2 * 9.81))
        >>> result = scene.simulate((0.0, 0.1))
        >>> float(result.load_force("rope")[-1, 2].round(2))
        19.62
        """
        self.read("load", name)  # names the loads there are
        return load_forces(self.run, name, end)

    @checked
    def in_axes_of(self, name: str, vectors: np.ndarray, interface: str | None = None) -> np.ndarray:
        """Return vectors that are in components of N in those of a body or interface at the same times.

        Parameters
        ----------
        name : str
            The body.
        vectors : ndarray, shape (T, 3) or (T, 6)
            Such as ``result.contact(...).force`` or ``result.load_force(...)``, a force and a moment.
        interface : str, optional
            One of the body.

        Raises
        ------
        ModelError
            If there is no such body or interface, or the vectors are of other times.

        Examples
        --------
        ``result.in_axes_of("airframe", result.load_force("port lashing"))``
        """
        what = repr(name) if interface is None else f"{interface!r} of {name!r}"
        return turned_into(vectors, self.rotation(name, interface), what)

    @checked
    def contact(self, name: str) -> ContactHistory:
        """Return what a contact did: its forces, depth, slip, the work of its friction, and whether it stuck.

        Examples
        --------
        ``result.contact("skid").slip[-1]``, ``result.contact("skid").normal.max()``
        """
        return contact_history(self.read("load", name), self.loads[name], name)

    @checked
    def contact_points(self, name: str) -> ContactPoints:
        """Return what each point of a contact did: normal force, friction, depth, slip with its sign, and anchor.

        Vectors are along the axes of the surface that is touched. The points are in the order of the frames, or of the
        points of the patch; of a box, its corners; of a capsule, its ends.

        Raises
        ------
        ModelError
            If there is no such contact.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        >>> sled = scene.add_rigid_body("sled", 2.0, 0.1, joint=kf.Free(velocity=(-3.0, 0, 0)))
        >>> feet = [sled.frame(at=(x, y, 0)) for x in (-0.5, 0.5) for y in (-0.2, 0.2)]
        >>> scene.add_contact("feet", feet, floor, normal=kf.HuntCrossley(1e6, damping=1.0), friction=kf.Coulomb(0.3))
        >>> points = scene.simulate((0.0, 0.5)).contact_points("feet")
        >>> points.slip_velocity[-1, :, 0].round(2)  # -3 m/s + 0.3 g t
        array([-1.53, -1.53, -1.53, -1.53])
        """
        return contact_points(self.read("contact_points", name))

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts."""
        return tuple(name for name, columns in self.loads.items() if is_contact(columns))

    @property
    def point_counts(self) -> dict[str, int]:
        """How many points each contact has."""
        return dict(self._channels.points)

    def contact_report(self) -> str:
        """Return a table of the contacts: first touch, largest forces, how long it held, slip and work.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        >>> ball = scene.add_point("ball", 1.0, at=(0, 0, 0.1))
        >>> scene.add_contact("drop", ball, floor, normal=kf.KelvinVoigt(1e4, damping=40.0))
        >>> result = scene.simulate((0.0, 0.5), output_step=1e-3)
        >>> result.contact_report().splitlines()[1].split()[:3]
        ['drop', '0.142784', '4']
        """
        return contact_report(self.times, {name: self.contact(name) for name in self.contacts}, self.events)

    @checked
    def nodal_displacements(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the displacements of the mesh's nodes in G, shape (T, n, 3), in m.

        Parameters
        ----------
        name : str
            A flexible body.
        frames : int, slice or sequence of int, optional
            Which output times; one number leaves the first axis out. Default: all.
        nodes : sequence of int, optional
            Which nodes. Default: all.

        Raises
        ------
        ModelError
            If the body is rigid, a number is out of range, or the table would take more than 2 GiB.

        Examples
        --------
        Every tenth output time: ``result.nodal_displacements("arm", frames=slice(None, None, 10))``.
        """
        shape, chosen = self._flexible(name), frame_index(frames, len(self.times))
        eta = self.modal_coordinates(name)[chosen]
        rows = node_numbers(shape, nodes)
        size = 24 * len(np.atleast_2d(eta)) * len(rows)
        if size > LARGEST_TABLE:
            raise ModelError(
                f"the displacements of {len(rows)} nodes of {name!r} at {len(eta)} times take {size / 2**30:.1f} GiB. "
                "Remedy: choose output times with frames=, or nodes with nodes="
            )
        return shape.displacements(eta, rows)

    @checked
    def nodal_positions(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the positions of the mesh's nodes in N, shape (T, n, 3), in m. Arguments: `nodal_displacements`."""
        chosen, shape = frame_index(frames, len(self.times)), self._flexible(name)
        local = self.nodal_displacements(name, frames, nodes) + shape.nodes[node_numbers(shape, nodes)]
        origin, e = self.position(name)[chosen], self.rotation(name)[chosen]
        if e.ndim == 1:
            return np.asarray(local @ rotation_matrix(e).T + origin)
        A_NG = np.array([rotation_matrix(row) for row in e]).reshape(-1, 3, 3)
        return np.asarray(local @ A_NG.transpose(0, 2, 1) + origin[:, None])

    @property
    def energy(self) -> Energy:
        """Energies of the scene."""
        return Energy(*(self.read(name) for name in ENERGIES))

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum of the scene."""
        return Momentum(*(self.read(name) for name in MOMENTA))

    @checked
    def units(self, quantity: str, name: str | None = None) -> str:
        """Return the unit of a quantity; of a body's joint, if the unit depends on it.

        ``result.units("coupling_force")`` is "N, N m"; ``result.units("joint_coordinates", "hub")`` is "rad". A
        ModelError lists the quantities if there is no such one.
        """
        if quantity in ("times", "nodal_displacements", "nodal_positions", "energy"):
            return {"times": "s", "energy": "J"}.get(quantity, "m")
        if quantity == "momentum":
            return "kg m/s, kg m2/s"
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if name is None:
            return QUANTITIES[quantity].units
        return ", ".join(unit for _, unit, _ in self.parts(quantity, name)) or "1"

    @checked
    def parts(self, quantity: str, name: str = "") -> tuple[tuple[str, str, tuple[str, ...]], ...]:
        """Return label, unit and column names of a quantity of a body, columns of one unit together."""
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if not name or quantity in LOOPS:
            return resolved_parts(quantity)
        if quantity in LOADS:
            return resolved_parts(quantity, self.loads[name])
        if quantity in POINTS:
            return resolved_parts(quantity, point_columns(self._channels.points[self._contact(name)]))
        shape = self.body(name)
        names = {"joint_coordinates": shape.coordinate_names, "driving_force": shape.driven_names}
        return resolved_parts(
            quantity, names.get(quantity, shape.speed_names), shape.basis.shape[1], shape.is_orthonormal
        )

    @checked("quantity", "name", "interface")
    def read(self, quantity: str, name: str = "", interface: str | None = None, of: str | None = None) -> np.ndarray:
        """Return any quantity of `kanefe.results.quantities` by its name; the methods above are the readable way.

        `of` is a part of a coupling force: see `coupling_force`.

        Raises
        ------
        ModelError
            If there is no such quantity, body or interface, or the body has no such thing; the message says what there
            is.
        """
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if of is not None and quantity != "coupling_force":
            raise ModelError(f"of={of!r}: {quantity} has no parts. Remedy: leave it out")
        if quantity in OF_SCENE or (quantity in CENTRES and not name):
            return self._channels.read(quantity)
        if quantity in LOOPS:
            if name not in self.loops or interface is not None:
                there = ", ".join(self.loops) or "none"
                raise ModelError(f"the run has no loop joint called {name!r}. It has: {there}")
            return self._channels.read(quantity, name)
        if quantity in LOADS:
            if name not in self.loads or interface is not None:
                there = ", ".join(self.loads) or "none"
                raise ModelError(f"the run has no load between frames called {name!r}. It has: {there}")
            return self._channels.read(quantity, name)
        if quantity in POINTS:
            if interface is not None:
                raise ModelError(f"{quantity} takes a contact and no interface, {interface!r} was given")
            return self._channels.read(quantity, self._contact(name))
        shape = self.body(name)
        if quantity in MODES or quantity in INTERFACES:
            self._flexible(name)
        if quantity in DRIVES and not shape.is_driven:
            driven = ", ".join(s.name for s in self._shapes.values() if s.is_driven) or "none"
            raise ModelError(f"the joint of body {name!r} is not driven by a motion. Driven are: {driven}")
        if interface is not None and quantity not in MOTIONS and quantity not in INTERFACES:
            raise ModelError(f"{quantity} takes a body and no interface, {interface!r} was given")
        if interface is not None or quantity in INTERFACES:
            self._interface(shape, quantity, interface)
        if of is not None and interface is not None:
            shape.neighbours[interface].parts(of, f"{interface!r} of {name!r}")
            return self._channels.read(quantity, name, interface, of)
        return self._channels.read(quantity, name, interface or "")

    def _contact(self, name: str) -> str:
        if name not in self.contacts:
            raise ModelError(f"the run has no contact called {name!r}. It has: {', '.join(self.contacts) or 'none'}")
        return name

    def _interface(self, shape: BodyShape, quantity: str, interface: str | None) -> str:
        if interface is None:
            raise ModelError(f"{quantity} of {shape.name!r} needs an interface, one of: {_listed(shape)}")
        if interface not in shape.interfaces:
            raise ModelError(f"body {shape.name!r} has no interface called {interface!r}. It has: {_listed(shape)}")
        return interface

    def _flexible(self, name: str) -> BodyShape:
        shape = self.body(name)
        if not shape.is_flexible:
            flexible = ", ".join(s.name for s in self._shapes.values() if s.is_flexible) or "none"
            raise ModelError(f"body {name!r} is rigid: it has no modes, mesh or interfaces. Flexible are: {flexible}")
        return shape


def _listed(shape: BodyShape) -> str:
    return ", ".join(shape.interfaces) or "none"
