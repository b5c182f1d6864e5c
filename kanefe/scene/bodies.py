"""Methods of `System` that add rigid and flexible bodies, points, frames, rotors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.rigid import RigidMass, rigid_mass
from kanefe.errors import ModelError
from kanefe.frames import Orientation, numbers
from kanefe.joints import Fixed, Joint, Translation
from kanefe.joints.base import axis_direction
from kanefe.joints.checks import check_joint
from kanefe.joints.given_pose import driven
from kanefe.scene.scene import BodyEntry, FlexibleMember, Frame, RigidBody, Scene, orientation_matrix, three

if TYPE_CHECKING:
    from pathlib import Path

    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.bodies.projection import Field
    from kanefe.contact.geometry.look import Look


class Deformed(TypedDict, total=False):
    """Deformation of a flexible body at the start: keywords of `System.add_flexible_body`."""

    modal_coordinates: Sequence[float] | None
    modal_speeds: Sequence[float] | None
    displacement: Field | None
    velocity: Field | None


def _look(given: object, name: str) -> Look:
    """Return a look, from a file if a path is given."""
    from pathlib import Path

    from kanefe.contact.geometry.look import Look

    if isinstance(given, str | Path):
        return Look.from_file(given)
    if not isinstance(given, Look):
        raise ModelError(f"look of {name!r} must be a kanefe.shapes.Look or a path of STL or OBJ, not {given!r}")
    return given


class BodyMethods(Scene):
    """The part of `System` that adds bodies."""

    def add_rigid_body(
        self,
        name: str,
        mass: float,
        inertia: object = 0.0,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
        com: Sequence[float] = (0.0, 0.0, 0.0),
        gravity: bool = True,
        look: Look | str | Path | None = None,
    ) -> RigidBody:
        """Add a rigid body and return it.

        Parameters
        ----------
        name : str
            Unique in the scene.
        mass : float
            kg.
        inertia : float, (3,) or (3, 3)
            About the centre of mass in the body's axes, kg m2. ``(0, 0, I)`` is enough if it rotates only about z.
        parent : Frame, optional
            A rigid body, an interface of a flexible body, or a frame of one; None: the inertial frame.
        joint : Joint, optional
            Default: Fixed().
        at : array_like, shape (3,)
            Position of the joint from the parent's origin in its axes, m.
        orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy
            Orientation of the joint's fixed frame, seen from the parent: Euler parameters (`rotation_about`,
            `euler_angles`) or a matrix.
        com : array_like, shape (3,)
            Centre of mass from the body's origin (at the joint), m.
        gravity : bool
            Whether gravity acts on it.
        look : kanefe.shapes.Look, str or Path, optional
            What it looks like in pages and pictures, in its own axes: a surface with its name that nothing touches; a
            path is that of an STL or OBJ file in m. Default: the surfaces on it, or a box of its mass and inertia.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.
        FileError
            If the file of its look cannot be read.
        """
        properties = rigid_mass(name, mass, inertia, com)
        drawn = None if look is None else _look(look, name)
        self._add(name, parent, Fixed() if joint is None else joint, at, orientation, rigid=properties, gravity=gravity)
        body = RigidBody(self, len(self._entries) - 1, name)
        if drawn is not None:
            self._draw(name, body, drawn)
        return body

    def _draw(self, name: str, body: Frame, look: Look) -> None:
        """Add a look to a body as a surface, with its name or, where that is taken, with "look" after it."""
        from kanefe.contact.surface import Surface

        while name in self._surfaces:
            name += " look"
        self._surfaces[name] = Surface(name, body.frame(), look)

    def add_point(
        self,
        name: str,
        mass: float,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
        gravity: bool = True,
    ) -> RigidBody:
        """Add a mass point and return it: a rigid body without inertia, fixed to its parent or, without one, free.

        Parameters
        ----------
        name, mass, parent, at, orientation, gravity
            As for a rigid body.
        joint : Joint, optional
            Default: Fixed(); without a parent, or on the ground, Translation(): free along x, y and z.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> ball = scene.add_point("ball", 0.1, joint=kf.Translation(velocity=(3.0, 0.0, 4.0)))
        >>> arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("y"))
        >>> tip = scene.add_point("tip", 0.2, parent=arm, at=(1.0, 0.0, 0.0))
        """
        is_on_ground = parent is None or (isinstance(parent, Frame) and parent.number < 0)
        if joint is None:
            joint = Translation() if is_on_ground else Fixed()
        return self.add_rigid_body(
            name,
            mass,
            parent=parent,
            joint=joint,
            at=at,
            orientation=orientation,
            gravity=gravity,
        )

    def add_frame(
        self,
        name: str,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
    ) -> RigidBody:
        """Add a frame without mass and return it, such as a link between two joints of a chain.

        If it can move, it must carry mass outward of it. For a frame fixed in a body, ``body.frame(...)`` is cheaper.

        Parameters
        ----------
        name, parent, joint, at, orientation
            As for a rigid body.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.
        """
        return self.add_rigid_body(name, 0.0, parent=parent, joint=joint, at=at, orientation=orientation)

    def add_rotor(self, body: Frame, axis: str | Sequence[float], inertia: float, rate: float) -> None:
        """Add the spin of a balanced flywheel that rotates in a rigid body at a constant rate.

        Its mass and its inertia must be included in those of the body. The spin adds the moment ``-w x h`` with
        ``h = inertia rate axis``, and h to the angular momentum; the energy of the spin and the work of its motor are
        neglected. For a rotor with a variable rate use a child body on a revolute joint.

        Parameters
        ----------
        body : RigidBody
        axis : "x", "y", "z" or three numbers
            In the body's axes.
        inertia : float
            Moment of inertia about the axis, kg m2.
        rate : float
            Spin relative to the body, rad/s.

        Raises
        ------
        ModelError
            If the body is not a rigid one of this scene, the axis has no length, or a number is not valid.
        """
        self._check_open("a rotor")
        carrier = self._check_frame(body, "the carrier of a rotor")
        entry = self._entries[carrier.number] if carrier.number >= 0 else None
        if entry is None or entry.rigid is None or carrier.interface_frame is not None:
            raise ModelError(
                f"{carrier.label} is not a rigid body and carries no rotor. "
                "Remedy: a rigid body there, fixed to it, that carries the rotor"
            )
        what = f"of the rotor in {carrier.name!r}"
        if not (numbers(inertia).shape == () and np.isfinite(numbers(inertia)) and inertia >= 0):
            raise ModelError(f"the inertia {what} must be finite and >= 0 kg m2, not {inertia!r}")
        if not (numbers(rate).shape == () and np.isfinite(numbers(rate))):
            raise ModelError(f"the rate {what} must be one finite number in rad/s, not {rate!r}")
        direction = carrier.axes @ axis_direction(axis, "rotor's")
        entry.rigid = replace(entry.rigid, rotor=entry.rigid.rotor + inertia * rate * direction)

    @checked()
    def add_flexible_body(
        self,
        name: str,
        body: FlexibleBody,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
        gravity: bool = True,
        **deformed: Unpack[Deformed],
    ) -> FlexibleMember:
        """Add a flexible body and return it.

        Parameters
        ----------
        name : str
            Unique in the scene.
        body : FlexibleBody
            From `kanefe_fem`, from given matrices, or from its file.
        parent, joint, at, orientation
            As for a rigid body; the moving frame of the joint is the mesh frame G. A body without a fixed interface
            floats and needs a free or planar joint.
        gravity : bool
            Whether gravity acts on it.
        **deformed
            Deformation at the start: the other parameters below.

        Other Parameters
        ----------------
        modal_coordinates, modal_speeds : array_like, shape (k,), optional
            eta and deta at the start, which are kept; default zero, or what loops need that joints alone do not close.
        displacement, velocity : callable or array_like, optional
            Displacement and velocity at the start as fields in G: a function of positions (P, 3) in m that returns
            vectors (P, 3) in m and m/s, or a vector of each node (n, 3). They are projected on the modes, weighted by
            mass; a warning names the remainder. Rigid motion belongs to the start of the joint.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.
        """
        from kanefe.bodies.flexible import FlexibleBody
        from kanefe.bodies.projection import projected

        if not isinstance(body, FlexibleBody):
            raise ModelError(
                f"flexible body {name!r} must be a FlexibleBody, not {type(body).__name__}. "
                "Remedy: make one with kanefe_fem.solid_body, beam_body, or kanefe.flexible_body; "
                "add_segmented_body takes one that is cut"
            )
        joint = Fixed() if joint is None else joint
        if body.is_floating and not joint.holds_floating:
            raise ModelError(
                f"flexible body {name!r} has no interface fixed in G, so a {joint.kind} joint has nothing to hold. "
                "Remedy: make an interface 'clamped', or give the body a free joint"
            )
        starts = []
        for modal, field, what in (
            (deformed.get("modal_coordinates"), deformed.get("displacement"), "displacement"),
            (deformed.get("modal_speeds"), deformed.get("velocity"), "velocity"),
        ):
            if modal is not None and field is not None:
                raise ModelError(f"body {name!r} has modal coordinates and a field of {what}. Remedy: one of them")
            starts.append(modal if field is None else projected(body, field, f"{what} of body {name!r}"))
        self._add(name, parent, joint, at, orientation, flexible=body, starts=starts, gravity=gravity)
        return FlexibleMember(self, len(self._entries) - 1, name, body=body)

    def _add(
        self,
        name: str,
        parent: Frame | None,
        joint: Joint,
        at: Sequence[float],
        orientation: Orientation,
        *,
        gravity: bool,
        rigid: RigidMass | None = None,
        flexible: FlexibleBody | None = None,
        starts: Sequence[Sequence[float] | np.ndarray | None] = (None, None),
    ) -> None:
        self._check_open(f"body {name!r}")
        if not isinstance(name, str) or not name or "/" in name or "\0" in name:
            raise ModelError(f"the name of a body must be a text without '/' and null characters, not {name!r}")
        if name in self._segmented or any(entry.name == name for entry in self._entries):
            raise ModelError(f"the scene already has a body called {name!r}. Remedy: another name")
        joint = driven(check_joint(joint, f"joint of body {name!r}"))
        if parent is not None:
            self._check_parent(name, parent)
        if joint.is_free and joint.armature and parent is not None and parent.number >= 0:
            raise ModelError(
                f"the armature of the free joint of body {name!r} acts on motions seen from the ground, and its parent "
                f"is {parent.name!r}. Remedy: a joint on the ground, or no armature"
            )
        if not isinstance(gravity, (bool, np.bool_)):
            raise ModelError(
                f"gravity of body {name!r} must be True or False, not {gravity!r}; System has its direction"
            )
        turn = orientation_matrix(orientation, f"orientation of body {name!r}")
        count = flexible.free_count if flexible else 0
        modal: list[np.ndarray | None] = []
        for what, value in zip(("modal_coordinates", "modal_speeds"), starts, strict=True):
            array = None if value is None else numbers(value)
            if array is not None and (array.shape != (count,) or not np.all(np.isfinite(array))):
                raise ModelError(
                    f"{what} of body {name!r} must be {count} finite numbers, shape {array.shape} was given"
                )
            modal.append(array)
        where = three(at, f"at of body {name!r}")
        P = self.ground if parent is None else parent
        place = P.at + P.axes @ where, P.axes @ turn
        self._entries.append(
            BodyEntry(name, P.number, P.interface_frame, *place, joint, rigid, flexible, modal[0], modal[1], gravity)
        )

    def _check_parent(self, name: str, parent: Frame) -> None:
        if not isinstance(parent, Frame):
            raise ModelError(f"parent of body {name!r} must be a body or interface of this scene, not {parent!r}")
        if parent.system is not self:
            raise ModelError(
                f"parent {parent.name!r} of body {name!r} belongs to another system. Remedy: body(...) of this one"
            )
        frame = parent.interface_frame
        flexible = self._entries[parent.number].flexible if parent.number >= 0 else None
        if flexible is not None and frame is None:
            raise ModelError(
                f"parent of body {name!r}: flexible body {parent.name!r} carries other bodies at its interfaces only. "
                f"Remedy: parent={parent.name}.interface(...), one of {[f.name for f in flexible.interfaces]}"
            )
        if frame is not None and frame.name.startswith("node "):
            raise ModelError(
                f"parent of body {name!r}: {frame.name} of {parent.name!r} has no rotation of its own. "
                "Remedy: an interface"
            )
        if frame is not None and not frame.turns:
            raise ModelError(
                f"parent of body {name!r}: interface {frame.name!r} of {parent.name!r} is a node without a rotation of "
                "its own, which what it carries could follow. Remedy: an interface of three nodes or more"
            )
        if frame is not None and flexible is not None and (loose := frame.loose_rotations(flexible.components)):
            raise ModelError(
                f"parent of body {name!r}: interface {frame.name!r} of {parent.name!r} has no rotation "
                f"{' or '.join(loose)} of its own (its nodes lie on a line or release it), which what it carries could "
                "follow. Remedy: an interface of facets, or a free body joined to it by add_loop_joint"
            )
