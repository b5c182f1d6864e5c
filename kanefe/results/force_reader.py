"""Forces of a run: at interfaces, in joints and loops, of loads between frames and contacts."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.results.contact_history import ContactHistory, contact_history
from kanefe.results.contact_points import ContactPoints, contact_points
from kanefe.results.contact_report import contact_report
from kanefe.results.load_forces import load_forces
from kanefe.results.load_lines import LoadLine
from kanefe.results.quantities import FORCES
from kanefe.results.quantity_reader import QuantityReader
from kanefe.results.selection import Frames, frame_index
from kanefe.tree.neighbours import Neighbours

if TYPE_CHECKING:
    from kanefe.results.force_errors import ForceError


class ForceReader(QuantityReader):
    """The forces of `Reader`."""

    @checked("quantity", "name", "interface")
    def read(self, quantity: str, name: str = "", interface: str | None = None, of: str | None = None) -> np.ndarray:
        """Return any quantity by its name: see `QuantityReader.read`; warn of a force with a large error, once."""
        found = super().read(quantity, name, interface, of)
        if quantity in (*FORCES, "load") and self.run is not None and (key := (quantity, name)) not in self._told:
            self._told.add(key)
            if self._force_errors:
                from kanefe.results.force_errors import warn_of_error

                warn_of_error(self.run, self._force_errors, *key)
        return found

    @cached_property
    def _told(self) -> set[tuple[str, str]]:
        """Quantities and names of forces that were read."""
        return set()

    @cached_property
    def _force_errors(self) -> tuple[ForceError, ...]:
        """Errors of forces, where they are estimated without being asked for; else the statistics say why not."""
        if self.run is None:
            return ()
        from kanefe.results.force_errors import estimated_unasked

        return estimated_unasked(self.run)

    def coupling_force(self, name: str, interface: str, of: str | None = None) -> np.ndarray:
        """Return force (N) and moment (N m) on a flexible body at an interface, in axes of G, shape (T, 6).

        The sum of all actions of its neighbours there: of the carrying body, if the interface is fixed in G; of bodies
        attached by joints, including motors and springs in the joints; of loops, contacts, loads between frames and
        given forces on the interface, on frames of it and on nodes of the mesh that move rigidly with it. The moment is
        about the deformed position of the interface. Other loads on the body, such as gravity, are not included: on
        each body the coupling forces of all interfaces, the other loads and inertia are in balance.

        Parameters
        ----------
        name, interface : str
        of : str, optional
            Only a part (Eq. 30). "F_u": the forces that are unknown before the equations are solved, of joints, loops
            and rigid contacts; of the carrying body it is zero in components that the mesh does not have (Eq. 39).
            "F_k": the known forces, of all other loads. Or the force of one source: a body at the other end of the
            joint ("ground": the inertial frame), a loop, a load between frames, or a given force or torque by its label
            as in `SceneState.load`. If two sources have the same name, with "body", "loop", "load", "force" or
            "carrier" in front. See `neighbours`.

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
        """Return the names of the sources of the force at an interface, as `coupling_force` takes them."""
        return self.body(name).neighbours[self._interface(self._flexible(name), "coupling_force", interface)]

    @checked
    def joint_reaction(self, name: str) -> np.ndarray:
        """Return force (N) and moment (N m) of a body's joint on it, shape (T, 6).

        About the origin of the body's frame, in its axes, including motors and drives.
        """
        return self.read("joint_reaction", name)

    @checked
    def driving_force(self, name: str) -> np.ndarray:
        """Return the force (N) or torque (N m) that keeps a driven joint on its motion.

        Shape (T,); (T, n) for a joint with n driven coordinates. For a joint that follows a prescribed pose it is the
        power of the drive, W; its wrench is in `joint_reaction`.
        """
        return self.read("driving_force", name)

    @checked
    def loop_force(self, name: str) -> np.ndarray:
        """Return force (N) and moment (N m) of a loop joint or rolling contact on its end b, shape (T, 6).

        About the origin of that end, in its axes.
        """
        return self.read("loop_force", name)

    @checked
    def gear_force(self, name: str) -> np.ndarray:
        """Return the force (N) or torque (N m) of a gear or rack on each coordinate that it couples, shape (T, n).

        In the order of its coefficients, see `gears`: coefficient times multiplier. The force at the teeth of a wheel
        is its torque over the radius of its pitch circle.

        Raises
        ------
        ModelError
            If there is no such gear; the message lists them.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> motor, wheel = (scene.add_rigid_body(n, 1.0, 0.1, joint=kf.Revolute("z")) for n in ("motor", "wheel"))
        >>> scene.add_gear("pair", {motor: 10, wheel: 30})
        >>> scene.add_torque(motor, (0, 0, 1.0))
        >>> scene.simulate((0.0, 1.0)).gear_force("pair")[-1].round(3)  # N m
        array([-0.1, -0.3])
        """
        return self.read("gear_force", name)

    @checked
    def load(self, name: str, column: str | None = None) -> np.ndarray:
        """Return outputs of a load between frames, such as the tension of a rope, (T, columns), or (T,) of one column.

        Parameters
        ----------
        name : str
            One of `loads`, which also lists the columns.
        column : str, optional
            The name of one column, with or without its unit: ``"tension"``, ``"force y [N]"``.

        Raises
        ------
        ModelError
            If there is no such load or column; the message lists them.

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
        """Return the lines of springs, ropes and other loads that act along one, and when they are slack.

        The line of a rope or winch goes over all its points, as in its law; that of another load connects two ends.
        Contacts have none.

        Parameters
        ----------
        frames : int, slice or ints, optional
            Output times, by number; default: all, S = T.

        Returns
        -------
        tuple of LoadLine
            Each with its ``name``, its ``points`` (S, ends, 3) in N in m, and its ``states`` (S,): 0 where it is taut,
            1 where it is slack, 2 after it has broken.

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

        The moment is about the origin of that end. `in_axes_of` converts it to the axes of a body.

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
            `contact` returns.

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
        self.read("load", name)  # raises if there is no such load
        return load_forces(self.run, name, end)

    @checked
    def contact(self, name: str) -> ContactHistory:
        """Return the outputs of a contact: forces, depth, slip, work of friction, and status.

        Examples
        --------
        ``result.contact("skid").slip[-1]``, ``result.contact("skid").normal.max()``
        """
        return contact_history(self.read("load", name), self.loads[name], name)

    @checked
    def contact_points(self, name: str) -> ContactPoints:
        """Return the outputs of each point of a contact: normal force, friction, depth, slip velocity and status.

        Vectors are along the axes of the touched surface. The order of the points is that of the frames, or of the
        points of the patch; of a box, that of its corners; of a capsule, that of its ends.

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

    def contact_report(self) -> str:
        """Return a table of the contacts: first touch, largest forces, share of sticking, slip and work.

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
