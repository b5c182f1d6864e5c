"""System: what the user builds. `freeze` turns it into the immutable model that the equations read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.frames import numbers
from kanefe.freeze import BodyEntry, build_model
from kanefe.joints import Fixed, Free, Joint, Planar
from kanefe.loads import JointLoad, PointLoad
from kanefe.model import Model
from kanefe.rigid import RigidMass, rigid_mass
from kanefe.slopes import slope_measure

if TYPE_CHECKING:
    from kanefe.results import Result

Load = Callable[[float], Any] | Sequence[float] | float


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of a body of a system: where other bodies and loads attach.

    Attributes
    ----------
    system : System
    number : int
        The body, in the order of adding.
    name : str
        Of the body.
    interface : InterfaceFrame or None
        None: the frame of the body itself.
    """

    system: System
    number: int
    name: str
    interface_frame: InterfaceFrame | None = None


@dataclass(frozen=True, eq=False)
class RigidBody(Frame):
    """A rigid body of a system."""


@dataclass(frozen=True, eq=False)
class FlexibleMember(Frame):
    """A flexible body of a system."""

    body: FlexibleBody = field(kw_only=True)

    def interface(self, name: str) -> Frame:
        """Return the frame of an interface, to carry a body or a load."""
        return Frame(self.system, self.number, self.name, self.body.interface(name))

    def node(self, number: int) -> Frame:
        """Return a frame that moves with a node of the mesh, to carry a load."""
        return Frame(self.system, self.number, self.name, self.body.node_frame(number))


class System:
    """A scene of rigid and flexible bodies in a tree.

    Parameters
    ----------
    gravity : array_like, shape (3,)
        In the inertial frame N, m/s2.
    slopes : "rotation-vector" or "tait-bryan"
        How the slopes of interfaces that carry bodies are read as rotations (Eq. 23).

    Raises
    ------
    ModelError
        If an argument makes no sense.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> result = scene.simulate((0.0, 1.0), rtol=1e-8)
    >>> result.position("rod").shape
    (501, 3)
    """

    def __init__(self, gravity: Sequence[float] = (0.0, 0.0, 0.0), slopes: str = "rotation-vector") -> None:
        self.gravity = _three(gravity, "gravity")
        self.slopes = slope_measure(slopes)
        self._entries: list[BodyEntry] = []

    def add_rigid_body(
        self,
        name: str,
        mass: float,
        inertia: object = 0.0,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        com: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> RigidBody:
        """Add a rigid body and return it.

        Parameters
        ----------
        name : str
            Unique in the scene.
        mass : float
            kg.
        inertia : float, (3,) or (3, 3)
            About the centre of mass in the body's axes, kg m2.
        parent : Frame, optional
            A rigid body, an interface of a flexible body, or None: the inertial frame.
        joint : Joint, optional
            Default: Fixed().
        at : array_like, shape (3,)
            Where the joint sits, from the parent's origin in its axes, m.
        orientation : array_like, shape (4,)
            Euler parameters of the joint's fixed frame, seen from the parent.
        com : array_like, shape (3,)
            Centre of mass from the body's origin (at the joint), m.

        Raises
        ------
        ModelError
            Naming what is wrong with the body.
        """
        properties = rigid_mass(name, mass, inertia, com)
        self._add(name, parent, joint or Fixed(), at, orientation, properties, None, None, None)
        return RigidBody(self, len(self._entries) - 1, name)

    def add_flexible_body(
        self,
        name: str,
        body: FlexibleBody,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        modal_coordinates: Sequence[float] | None = None,
        modal_speeds: Sequence[float] | None = None,
    ) -> FlexibleMember:
        """Add a flexible body and return it.

        Parameters
        ----------
        name : str
            Unique in the scene.
        body : FlexibleBody
            From `kanefe_fem`, from given matrices, or from its file.
        parent, joint, at, orientation
            As for a rigid body; the frame placed is the mesh frame G. A body without a fixed interface floats and
            takes a free or planar joint.
        modal_coordinates, modal_speeds : array_like, shape (k,), optional
            eta and deta at the start; default zero.

        Raises
        ------
        ModelError
            Naming what is wrong with the body.
        """
        if not isinstance(body, FlexibleBody):
            raise ModelError(
                f"flexible body {name!r} must be a FlexibleBody, not {type(body).__name__}. "
                "Remedy: make one with kanefe_fem.solid_body, beam_body, or kanefe.flexible_body"
            )
        joint = joint or Fixed()
        if body.is_floating and not isinstance(joint, (Free, Planar)):
            raise ModelError(
                f"flexible body {name!r} has no interface fixed in G, so a {joint.kind} joint has nothing to hold. "
                "Remedy: make an interface 'clamped', or give the body a free joint"
            )
        self._add(name, parent, joint, at, orientation, None, body, modal_coordinates, modal_speeds)
        return FlexibleMember(self, len(self._entries) - 1, name, body=body)

    def add_force(
        self, target: Frame, force: Load, *, point: Sequence[float] = (0.0, 0.0, 0.0), follows: bool = False
    ) -> None:
        """Apply a force.

        Parameters
        ----------
        target : Frame
            A rigid body, or an interface or node of a flexible body.
        force : (3,) or callable t -> (3,)
            N.
        point : array_like, shape (3,)
            Where it acts, from the frame's origin in its axes, m.
        follows : bool
            True: the components are those of the frame; False: of N.
        """
        entry = self._target(target)
        label = f"the force on {_frame_name(target)}"
        function = _vector_function(force, label)
        where = _three(point, f"point of {label}")
        entry.loads.append((PointLoad(label, function, False, where, follows), target.interface_frame))

    def add_torque(self, target: Frame, torque: Load, *, follows: bool = False) -> None:
        """Apply a torque.

        Parameters
        ----------
        target : Frame
            A rigid body, an interface of a flexible body, or a flexible body (for a torque about its joint).
        torque : float, (3,) or callable of t
            One number: a motor about the axis of the target's joint, which pushes back on the parent (N m; N for a
            prismatic joint). Three: a torque from outside, N m.
        follows : bool
            True: the three components are those of the frame; False: of N.
        """
        entry = self._target(target)
        label = f"the torque on {_frame_name(target)}"
        sample = numbers(torque(0.0) if callable(torque) else torque)
        if sample.shape == (3,):
            function = _vector_function(torque, label)
            entry.loads.append((PointLoad(label, function, True, np.zeros(3), follows), target.interface_frame))
            return
        if sample.shape != () or target.interface_frame is not None:
            raise ModelError(
                f"{label} must be three numbers" + ("" if target.interface_frame else " or one for a motor")
            )
        if len(entry.joint.speed_names) != 1 or entry.joint.motion is not None:
            raise ModelError(
                f"{label} is one number, but its {entry.joint.kind} joint has no single free axis. "
                "Remedy: give three components, or a revolute joint that is not driven"
            )
        if not np.isfinite(sample):
            raise ModelError(f"{label} must be a finite number or three, not {sample} (at t = 0)")
        constant = float(sample)
        value: Callable[[float], Any] = torque if callable(torque) else lambda t: constant
        entry.joint_loads.append(JointLoad(label, value))

    def freeze(self) -> Model:
        """Return the immutable model of the scene.

        Raises
        ------
        ModelError
            If the scene is empty.
        """
        return build_model(self._entries, self.gravity, self.slopes)

    def simulate(self, t_span: tuple[float, float], **options: Any) -> Result:
        """Run the scene and return a `Result`; the options are those of `kanefe.integrate.run.integrate`."""
        from kanefe.integrate.run import integrate
        from kanefe.results import Result

        model = self.freeze()
        return Result(model, integrate(model, t_span, **options))

    def _add(
        self,
        name: str,
        parent: Frame | None,
        joint: Joint,
        at: Sequence[float],
        orientation: Sequence[float],
        rigid: RigidMass | None,
        flexible: FlexibleBody | None,
        eta: Sequence[float] | None,
        deta: Sequence[float] | None,
    ) -> None:
        if not name or not isinstance(name, str) or "/" in name:
            raise ModelError(f"the name of a body must be a text without '/', not {name!r}")
        if any(entry.name == name for entry in self._entries):
            raise ModelError(f"the scene already has a body called {name!r}. Remedy: another name")
        if not isinstance(joint, Joint):
            raise ModelError(f"joint of body {name!r} must be a Joint, such as Revolute('z'), not {joint!r}")
        if parent is not None:
            self._check_parent(name, parent)
        e = numbers(orientation)
        if e.shape != (4,) or not np.all(np.isfinite(e)) or np.linalg.norm(e) < 1e-12:
            raise ModelError(f"orientation of body {name!r} must be four Euler parameters, not {orientation!r}")
        count = flexible.free_count if flexible else 0
        starts = []
        for what, value in (("modal_coordinates", eta), ("modal_speeds", deta)):
            array = np.zeros(count) if value is None else numbers(value)
            if array.shape != (count,) or not np.all(np.isfinite(array)):
                raise ModelError(
                    f"{what} of body {name!r} must be {count} finite numbers, shape {array.shape} was given"
                )
            starts.append(array)
        where = _three(at, f"at of body {name!r}")
        number, interface = (-1, None) if parent is None else (parent.number, parent.interface_frame)
        self._entries.append(
            BodyEntry(name, number, interface, where, e, joint, rigid, flexible, starts[0], starts[1], [], [])
        )

    def _check_parent(self, name: str, parent: Frame) -> None:
        if not isinstance(parent, Frame):
            raise ModelError(f"parent of body {name!r} must be a body or interface of this scene, not {parent!r}")
        if parent.system is not self:
            raise ModelError(
                f"parent {parent.name!r} of body {name!r} belongs to another system. Remedy: add it to this one"
            )
        if isinstance(parent, FlexibleMember):
            raise ModelError(
                f"parent of body {name!r}: flexible body {parent.name!r} carries other bodies at its interfaces only. "
                f"Remedy: parent={parent.name}.interface(...), one of {[f.name for f in parent.body.interfaces]}"
            )
        frame = parent.interface_frame
        if frame is not None and frame.name.startswith("node "):
            raise ModelError(
                f"parent of body {name!r}: {frame.name} of {parent.name!r} has no rotation of its own. "
                "Remedy: an interface"
            )
        if frame is not None and not frame.motion[3:].any():
            raise ModelError(
                f"parent of body {name!r}: interface {frame.name!r} of {parent.name!r} is a node without a rotation of "
                "its own, which what it carries could follow. Remedy: an interface of three nodes or more"
            )

    def _target(self, target: Frame) -> BodyEntry:
        if not isinstance(target, Frame):
            raise ModelError(f"a load acts on a body or an interface of this scene, not on {target!r}")
        if target.system is not self:
            raise ModelError(f"{_frame_name(target)} belongs to another system. Remedy: add the body to this one")
        return self._entries[target.number]


def _three(value: Sequence[float], what: str) -> np.ndarray:
    array = numbers(value)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise ModelError(f"{what} must be three finite numbers, not {value!r}")
    return array


def _vector_function(load: Load, label: str) -> Callable[[float], np.ndarray]:
    if callable(load):
        return load
    constant = _three(load, label)  # type: ignore[arg-type]
    return lambda t: constant


def _frame_name(frame: Frame) -> str:
    return repr(frame.name) if frame.interface_frame is None else f"{frame.interface_frame.name!r} of {frame.name!r}"
