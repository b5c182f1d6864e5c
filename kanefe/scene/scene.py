"""A scene that is being built: its entries, and the frames to which the user attaches things."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.marker import Marker
from kanefe.bodies.rigid import RigidMass
from kanefe.errors import ModelError
from kanefe.frames import Orientation, numbers, orientation_parameters, rotation_matrix
from kanefe.joints import Joint
from kanefe.loads.base import Load

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
    from kanefe.bodies.segmented import SegmentedBody
    from kanefe.contact.shell_balls import ShellBall
    from kanefe.contact.surface import Surface
    from kanefe.fe_model.places import PlaceLike
    from kanefe.loads.controller import Controller
    from kanefe.loads.field_load import FieldLoad
    from kanefe.loads.joint_load import JointLoad
    from kanefe.loads.point_load import PointLoad


@dataclass(eq=False)
class BodyEntry:
    """The user's input for one body; `parent` is a number, -1 for the inertial frame N, and `axes` are A_PF."""

    name: str
    parent: int
    parent_interface: InterfaceFrame | None
    at: np.ndarray
    axes: np.ndarray
    joint: Joint
    rigid: RigidMass | None
    flexible: FlexibleBody | None
    eta: np.ndarray | None
    deta: np.ndarray | None
    has_gravity: bool = True
    loads: list[tuple[PointLoad, InterfaceFrame | None]] = field(default_factory=list)
    joint_loads: list[JointLoad] = field(default_factory=list)
    field_loads: list[FieldLoad] = field(default_factory=list)

    @property
    def interfaces(self) -> tuple[InterfaceFrame, ...]:
        """Its interfaces; a rigid body has none."""
        return () if self.flexible is None else tuple(self.flexible.interfaces)

    def copied(self) -> BodyEntry:
        """Return a copy with its own lists of loads."""
        return replace(
            self, loads=list(self.loads), joint_loads=list(self.joint_loads), field_loads=list(self.field_loads)
        )


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """A frame of a scene, to which bodies, loads, springs and constraints attach.

    Attributes
    ----------
    system : Scene
    number : int
        Number of the body, in the order of adding; -1: the inertial frame N.
    name : str
        Name of the body.
    interface_frame : InterfaceFrame or None
        None: the frame of the body itself.
    at : ndarray, shape (3,)
        Origin, from the origin of the body's frame in its components, or from the interface in components of G rotated
        with it, m.
    axes : ndarray, shape (3, 3)
        Rotation matrix from the axes of this frame to those components.
    """

    system: Scene
    number: int
    name: str
    interface_frame: InterfaceFrame | None = None
    at: np.ndarray = field(default_factory=lambda: np.zeros(3), kw_only=True)
    axes: np.ndarray = field(default_factory=lambda: np.eye(3), kw_only=True)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.label})"

    def frame(self, at: Sequence[float] = (0.0, 0.0, 0.0), orientation: Orientation = (1.0, 0.0, 0.0, 0.0)) -> Frame:
        """Return a frame fixed in this one.

        Parameters
        ----------
        at : array_like, shape (3,)
            Its origin, from this origin in these axes, m.
        orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy
            Orientation of its axes, seen from these: Euler parameters (`rotation_about`, `euler_angles`) or a matrix.

        Raises
        ------
        ModelError
            If the origin or the orientation is not valid.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> rod = scene.add_rigid_body("rod", 1.0, 0.1)
        >>> rod.frame(at=(0.5, 0, 0)).at
        array([0.5, 0. , 0. ])
        """
        origin = self.at + self.axes @ three(at, f"at of a frame of {self.label}")
        turned = self.axes @ orientation_matrix(orientation, f"orientation of a frame of {self.label}")
        return Frame(self.system, self.number, self.name, self.interface_frame, at=origin, axes=turned)

    @property
    def label(self) -> str:
        """The frame in words, for messages."""
        text = repr(self.name) if self.number >= 0 else "the ground"
        if self.interface_frame is not None:
            text = f"{self.interface_frame.name!r} of {text}"
        return f"{text} at ({', '.join(f'{x:.6g}' for x in self.at)})" if self.at.any() else text

    @property
    def is_node(self) -> bool:
        """Whether the frame moves with one node of a mesh and has no rotation of its own."""
        return self.interface_frame is not None and not self.interface_frame.turns


@dataclass(frozen=True, eq=False, repr=False)
class RigidBody(Frame):
    """A rigid body of a system."""


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleMember(Frame):
    """A flexible body of a system."""

    body: FlexibleBody = field(kw_only=True)

    def interface(self, name: str) -> Frame:
        """Return the frame of an interface, to carry a body, a load or the end of a spring or constraint.

        Its axes are those given to the interface, and rotate with it.
        """
        frame = self.body.interface(name)
        return Frame(self.system, self.number, self.name, frame, axes=frame.axes)

    def node(self, number: int) -> Frame:
        """Return a frame that moves with a node of the mesh, to carry a load or the end of a spring."""
        return Frame(self.system, self.number, self.name, self.body.node_frame(number))

    def patch(self, place: str | PlaceLike, most: int = 16) -> ContactPatch:
        """Return points on the surface of the body for contacts: see `System.add_contact`.

        Of a shell balls of half the thickness in its middle: they touch at either face, and friction has its moment.

        Parameters
        ----------
        place : str, Place or function of nodes (n, 3) -> bool (n,)
            Name of a group of the mesh; `OnPlane`, `Near`, `InBox` or `InCylinder`, in the axes of the mesh.
        most : int
            Largest number of points. If there are more nodes, those furthest from each other are taken, each with the
            area nearest to it.

        Raises
        ------
        ModelError
            If there is no such group, or no node on the surface of the body in the place.

        Examples
        --------
        ``scene.add_contact("foot", arm.patch(kf.OnPlane((0, 0, -1), (0, 0, 1))), floor, normal=kf.HuntCrossley(1e7))``
        """
        from kanefe.contact.shell_balls import balls_in_thickness
        from kanefe.fe_model.contact_points import contact_points

        body = self.body
        stack = None if body.elasticity is None else body.elasticity.shell
        numbers_of, shares = contact_points(
            body.nodes, body.cells, body.groups, place, most, repr(self.name), is_shell=stack is not None
        )
        frames = tuple(self.node(int(number)) for number in numbers_of)
        balls = () if stack is None else balls_in_thickness(stack, numbers_of)
        return ContactPatch(frames, tuple(shares.tolist()), self._left_out_at(place), balls)

    def _left_out_at(self, place: str | PlaceLike) -> float:
        """Return the local compliance at a point of a surface that the modes neglect, m/N; 0 if it is not known."""
        known = self.body.provenance.get("reduction", {}).get("contact_compliance", ())
        found = [entry for entry in known if entry["surface"] == place]
        return found[0]["compliance"] * (1.0 - found[0]["held"]) if found else 0.0


class ContactPatch(NamedTuple):
    """Points of one side of a contact.

    Attributes
    ----------
    frames : tuple of Frame
    shares : tuple of float
        Shares of the points in the stiffness of the contact, of sum 1.
    left_out : float
        Local compliance at a point that the body's modes neglect, m/N; 0 if it is not known.
    balls : tuple of ShellBall
        Of a shell: balls of half its thickness, which touch at both faces.
    """

    frames: tuple[Frame, ...]
    shares: tuple[float, ...]
    left_out: float = 0.0
    balls: tuple[ShellBall, ...] = ()


class Scene:
    """The entries of a scene, and checks shared by all parts of `System`.

    Attributes
    ----------
    is_frozen : bool
        Whether a model has been made of it, so that nothing can be added.
    """

    def __init__(self) -> None:
        self._entries: list[BodyEntry] = []
        self._loads: list[Load] = []
        self._controllers: list[Controller] = []
        self._surfaces: dict[str, Surface] = {}
        self._segmented: dict[str, SegmentedBody] = {}
        self._kept: tuple[float, Any] | None = None
        self._unstarted: Any = None
        self.is_frozen = False

    @property
    def ground(self) -> Frame:
        """The inertial frame N, for the ends of springs and constraints and as a parent.

        Examples
        --------
        >>> import kanefe as kf
        >>> kf.System().ground.frame(at=(0, 0, 1)).label
        'the ground at (0, 0, 1)'
        """
        return Frame(self, -1, "ground")

    def copy(self) -> Self:
        """Return a copy with the same bodies, joints and loads that is not frozen.

        Additions to one do not affect the other. Frames belong to their scene: ``copy.body("arm")`` is the arm of the
        copy.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
        >>> modes = kf.linearise(scene).modes()
        >>> pulled = scene.copy()
        >>> pulled.add_force(pulled.body("cart"), (1.0, 0.0, 0.0))
        """
        other = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, (list, dict)):
                setattr(other, name, value.copy())
        other._entries = [entry.copied() for entry in self._entries]
        other.is_frozen, other._kept, other._unstarted = False, None, None
        return other

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"_kept": None, "_unstarted": None}

    @checked("name")
    def body(self, name: str) -> RigidBody | FlexibleMember:
        """Return a body of the scene by its name, as returned when it was added.

        Raises
        ------
        ModelError
            If there is none of that name; the message lists the bodies.
        """
        for number, entry in enumerate(self._entries):
            if entry.name == name:
                if entry.flexible is not None:
                    return FlexibleMember(self, number, name, body=entry.flexible)
                return RigidBody(self, number, name)
        known = ", ".join(entry.name for entry in self._entries) or "none"
        raise ModelError(f"the scene has no body called {name!r}. It has: {known}")

    def _check_open(self, what: str) -> None:
        """Raise a ModelError that names `what` if the scene has been frozen."""
        if self.is_frozen:
            raise ModelError(
                f"{what} cannot be added or changed: the scene was frozen. "
                "Remedy: do it before freeze, simulate or linearise, or in a copy, scene.copy(), which is open"
            )

    def _check_frame(self, frame: object, what: str) -> Frame:
        """Return `frame` if it is one of this scene; otherwise raise a ModelError that names it as `what`."""
        if not isinstance(frame, Frame):
            raise ModelError(f"{what} must be a body or an interface of this scene, or scene.ground, not {frame!r}")
        if frame.system is not self:
            raise ModelError(f"{what}: {frame.label} belongs to another system. Remedy: scene.body(name) of this one")
        return frame

    def _marker(self, frame: object, what: str, *, needs_rotation: bool = False) -> Marker:
        """Return the marker of a frame of this scene.

        Parameters
        ----------
        frame : Frame
        what : str
            Its purpose, such as "end a of spring 's'", for messages.
        needs_rotation : bool
            Whether its axes are used: nodes of a mesh without rotations are refused then.

        Raises
        ------
        ModelError
            If it is not a frame of this scene, or cannot be used so.
        """
        given = self._check_frame(frame, what)
        if given.number >= 0 and given.interface_frame is None:
            body = self._entries[given.number].flexible
            if body is not None:
                raise ModelError(
                    f"{what}: flexible body {given.name!r} is held at its interfaces and nodes only. "
                    f"Remedy: {given.name}.interface(...), one of {[f.name for f in body.interfaces]}"
                )
        if needs_rotation and given.is_node:
            raise ModelError(f"{what}: {given.label} has no rotation of its own. Remedy: an interface of three nodes")
        return Marker(given.number, given.interface_frame, given.at.copy(), given.axes.copy(), given.label)


def three(value: object, what: str) -> np.ndarray:
    """Return three finite numbers; a ModelError names them as `what`."""
    array = numbers(value)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ModelError(f"{what} must be three finite numbers, not {value!r}")
    return array


def orientation_matrix(value: object, what: str) -> np.ndarray:
    """Return the rotation matrix of an orientation; a ModelError names it as `what`."""
    return rotation_matrix(orientation_parameters(value, what))
