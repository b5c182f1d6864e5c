"""URDF, the robot description of ROS: links, joints, mimics; other elements are reported."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import FileError, ModelError
from kanefe.frames import turn_to
from kanefe.joints import Fixed, Joint, Prismatic, Revolute
from kanefe.joints.base import AxisJoint
from kanefe.robots import _yourdfpy
from kanefe.robots.description import Choices, Coupling, LinkJoint, NotTaken, Robot, RobotLink
from kanefe.robots.flexible_link import FlexibleLink
from kanefe.robots.joint_forces import PoseForces
from kanefe.robots.pose import Pose
from kanefe.robots.scene import RobotScene, scene_of
from kanefe.robots.tree import parents_first
from kanefe.storage.files import regular_file

AXIS_JOINTS: dict[str, type[AxisJoint]] = {"revolute": Revolute, "continuous": Revolute, "prismatic": Prismatic}
KINDS = (*AXIS_JOINTS, "fixed", "floating", "planar")
TAKEN = {"link", "joint", "material"}
MOMENTS = ("ixx", "iyy", "izz")


@checked("path", "limit_damping", "joint_forces", "looks")
def read_urdf(
    path: str | Path,
    *,
    base: Joint | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    flexible: Mapping[str, FlexibleBody | FlexibleLink] | None = None,
    positions: Mapping[str, float | Sequence[float]] | None = None,
    limit_stiffness: float | None = None,
    limit_damping: float = 0.0,
    joint_forces: bool = True,
    looks: bool = True,
) -> RobotScene:
    """Return the scene of a URDF file, by yourdfpy: ``pip install 'kanefe[robots]'``.

    Each link becomes a rigid body with its name, in its own frame, on its joint; joints that mimic another become
    gears. Visuals (boxes, cylinders, balls, meshes of STL and OBJ) are drawn. Collision shapes, transmissions, limits
    of efforts and other elements are not used: ``scene.not_taken`` lists them, and a warning those that would change
    the motion.

    Parameters
    ----------
    path : str or Path
        The file, after xacro.
    base : Joint, optional
        Joint of the root link on the ground; default: fixed. With ``Free(position=(0, 0, 0.6))`` it floats.
    gravity : array_like, shape (3,)
        m/s2.
    flexible : dict of str to FlexibleBody or FlexibleLink, optional
        Link -> the body from a mesh that replaces it: see `FlexibleLink`.
    positions : dict of str to float or sequence of float, optional
        Joint -> angle or distance at the start, rad or m, which is kept; default: 0. What mimics another follows it.
        Joints with several coordinates take MuJoCo's: x, y, z and Euler parameters, scalar first, of a floating joint;
        Euler parameters of a ball; two distances and an angle of a planar one, from where the joint is at zero.
    limit_stiffness, limit_damping : float
        Of stops at the limits of joints, N m/rad and N m s/rad, or N/m and N s/m. Without a stiffness, which URDF
        does not define, limits are ignored; so are equal ones, such as zeros where a file has none, with a warning.
    joint_forces : bool
        Whether damping and friction of joints act. Friction includes sticking: see `CoordinateForce`.
    looks : bool
        Whether visuals are read and drawn.

    Returns
    -------
    RobotScene
        A `System` to which anything can be added.

    Raises
    ------
    FileError
        If the file is missing, not URDF, or damaged.
    ModelError
        If links are not a tree with one root, the kind of a joint is unknown, an inertia is not valid, or a moving part
        has no mass; the message names link or joint.
    MissingDependency
        Without yourdfpy.

    Warns
    -----
    NotTakenWarning
        For elements that would change the motion and are not read.
    OddInertiaWarning
        For moments that are impossible for a distribution of mass; they are used as given.

    Examples
    --------
    ::

        scene = kf.read_urdf("ur5.urdf", flexible={"forearm_link": body}, positions={"elbow_joint": 1.2})
        result = scene.simulate((0.0, 1.0))
        result.joint_coordinates(scene.joints["elbow_joint"])
    """
    if base is not None and not isinstance(base, Joint):
        raise ModelError(f"base must be a joint, such as Free(position=(0, 0, 0.6)), not {base!r}")
    source = Path(path)
    elements = _well_formed(source)
    found = _yourdfpy.parsed(elements, source)
    _rename(found)
    choices = Choices({} if positions is None else positions, joint_forces, limit_stiffness, limit_damping)
    robot = Robot(found.name)
    _record_not_taken(elements, robot.not_taken)
    if looks:
        from kanefe.robots.looks import looks_of_urdf

        robot.looks, missed = looks_of_urdf(elements, source)
        for name in missed:
            robot.not_taken.add_silent("visuals", name)
    _add_links(robot, found, base or Fixed(), choices, source)
    choices.check_limits(source)
    return scene_of(robot, gravity, flexible)


def _well_formed(path: Path) -> ElementTree.Element:
    """Return the root element of the file, after checks of what yourdfpy would silently correct or replace."""
    regular_file(path)
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise FileError(f"{path} is truncated or not XML ({error}). Remedy: write it again") from error
    if any("xacro" in element.tag for element in root.iter() if isinstance(element.tag, str)):
        raise FileError(f"{path} has macros of xacro. Remedy: xacro {path.name} > robot.urdf, and read that")
    if root.tag != "robot":
        raise FileError(
            f"{path} is not a URDF file: its root is <{root.tag}>, not <robot>. Remedy: read_mjcf reads MJCF files"
        )
    for link in root.findall("link"):
        inertia = link.find("inertial/inertia")
        if inertia is not None and (missing := [name for name in MOMENTS if inertia.get(name) is None]):
            raise FileError(f"{path}: the inertia of link {link.get('name')!r} has no {', '.join(missing)}")
    return root


def _rename(found: Any) -> None:
    """Replace "/", which names of bodies cannot contain, by "."."""
    for link in found.links:
        link.name = link.name.replace("/", ".")
    for joint in found.joints:
        joint.name, joint.parent, joint.child = (
            x and x.replace("/", ".") for x in (joint.name, joint.parent, joint.child)
        )
        if joint.mimic is not None:
            joint.mimic.joint = joint.mimic.joint.replace("/", ".")


def _record_not_taken(root: ElementTree.Element, not_taken: NotTaken) -> None:
    """Record the elements of the file besides links and joints."""
    for element in root:
        name = element.get("name") or element.get("reference") or "unnamed"
        if element.tag not in TAKEN:
            not_taken.add_silent(str(element.tag), name)
        if element.find("safety_controller") is not None:
            not_taken.add_silent("safety controllers", name)
        if element.find("collision") is not None:
            not_taken.add_silent("collision shapes, which touch nothing", name)
        limit = element.find("limit")
        if element.tag == "joint" and limit is not None and (limit.get("effort") or limit.get("velocity")):
            not_taken.add_silent("limits of effort and velocity", name)


def _add_links(robot: Robot, found: Any, base: Joint, choices: Choices, path: Path) -> None:
    links = _once([link.name for link in found.links], "links", path)
    joints = _once([joint.name for joint in found.joints], "joints", path)
    to_parent: dict[str, Any] = {}
    for joint in found.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                raise ModelError(f"{path}: {role} of joint {joint.name!r} is {name!r}, and there is no such link")
        if joint.child in to_parent:
            raise ModelError(
                f"{path}: link {joint.child!r} is the child of joints {to_parent[joint.child].name!r} and "
                f"{joint.name!r}. Remedy: one of them in the file, the other as scene.add_loop_joint"
            )
        to_parent[joint.child] = joint
    parents = {name: to_parent[name].parent if name in to_parent else None for name in links}
    if unknown := sorted(set(choices.positions) - set(joints)):
        raise ModelError(f"positions: {path} has no joint {unknown[0]!r}. It has: {', '.join(joints) or 'none'}")
    for joint in found.joints:
        if joint.mimic is not None and joint.type in AXIS_JOINTS:
            robot.couplings.append(_coupling(joint, found.joints, path))
        elif joint.mimic is not None and joint.type != "fixed":
            robot.not_taken.add_acting("mimics by joints with several coordinates", joint.name)
    choices.take_couplings(robot.couplings, {joint.name: 0.0 for joint in found.joints if joint.type in AXIS_JOINTS})
    inertials = {link.name: link.inertial for link in found.links}
    for name in parents_first(parents, str(path)):
        joint = to_parent.get(name)
        made = LinkJoint(f"base of {name}", base) if joint is None else _joint(joint, choices, robot.not_taken, path)
        robot.links.append(RobotLink(name, parents[name], (made,), *_mass(inertials[name])))


def _once(names: list[str], what: str, path: Path) -> list[str]:
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ModelError(f"{path} has two {what} called {twice[0]!r}. Remedy: another name for one of them")
    if not all(names):
        raise ModelError(f"{path} has {what} without a name")
    return names


def _joint(joint: Any, choices: Choices, not_taken: NotTaken, path: Path) -> LinkJoint:
    """Return the joint of a scene for one of the file."""
    fixed = _pose(joint.origin)
    if joint.type == "fixed":
        return LinkJoint(joint.name, choices.fixed(joint.name), fixed)
    if joint.type == "floating":
        return LinkJoint(
            joint.name, choices.free(joint.name), fixed, forces=_pose_damper(joint, choices, not_taken, path)
        )
    if joint.type not in KINDS:
        raise ModelError(f"{path}: joint {joint.name!r} is {joint.type!r}. Joints of URDF are {', '.join(KINDS)}")
    axis = np.asarray(joint.axis, dtype=float)
    length = np.linalg.norm(axis) if axis.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise ModelError(f"{path}: the axis of joint {joint.name!r} is {joint.axis}. Remedy: a direction")
    axis = axis / length
    if joint.type == "planar":
        damping = _damping(joint, not_taken, path)
        forces = choices.coordinate_force(joint.name, not_taken, damping=damping)
        turn = np.eye(3) if np.array_equal(axis, (0.0, 0.0, 1.0)) else turn_to(axis)
        return LinkJoint(
            joint.name, choices.planar(joint.name, (forces,) * 3), fixed @ Pose(axes=turn), Pose(axes=turn.T)
        )
    dynamics, limit = joint.dynamics, joint.limit
    has_limits = limit is not None and joint.type != "continuous"
    limits = (limit.lower or 0.0, limit.upper or 0.0) if has_limits else (None, None)
    forces = choices.coordinate_force(
        joint.name,
        not_taken,
        limits=limits,
        damping=_number(dynamics and dynamics.damping, f"damping of joint {joint.name!r}", path),
        friction=_number(dynamics and dynamics.friction, f"friction of joint {joint.name!r}", path),
    )
    made = AXIS_JOINTS[joint.type](tuple(axis), position=choices.start(joint.name, 0.0), forces=forces)
    return LinkJoint(joint.name, made, fixed)


def _pose_damper(joint: Any, choices: Choices, not_taken: NotTaken, path: Path) -> PoseForces | None:
    """Return the damper of a floating joint."""
    none = 0.0, 0.0, 0.0
    return choices.pose_forces(joint.name, not_taken, none, (_damping(joint, not_taken, path), 0.0, 0.0), Pose(), True)


def _damping(joint: Any, not_taken: NotTaken, path: Path) -> float:
    """Return the damping of a joint with several speeds, the same for each; record its friction, which is not read."""
    if _number(joint.dynamics and joint.dynamics.friction, f"friction of joint {joint.name!r}", path):
        not_taken.add_acting("friction of floating and planar joints", joint.name)
    damping = _number(joint.dynamics and joint.dynamics.damping, f"damping of joint {joint.name!r}", path)
    if not (np.isfinite(damping) and damping >= 0.0):
        raise ModelError(f"{path}: damping of joint {joint.name!r} is {damping}, and it must be finite and >= 0")
    return damping


def _coupling(joint: Any, joints: Sequence[Any], path: Path) -> Coupling:
    """Return ``q - multiplier q_of_other = offset``."""
    mimic = joint.mimic
    if mimic.joint == joint.name:
        raise FileError(f"{path}: joint {joint.name!r} mimics itself. Remedy: the name of the joint that it follows")
    if not any(other.name == mimic.joint and other.type in AXIS_JOINTS for other in joints):
        raise ModelError(
            f"{path}: joint {joint.name!r} mimics {mimic.joint!r}, and there is no such joint with an axis"
        )
    coefficients = {joint.name: 1.0, mimic.joint: -mimic.multiplier}
    return Coupling(f"{joint.name} mimics {mimic.joint}", {n: c for n, c in coefficients.items() if c}, mimic.offset)


def _mass(inertial: Any) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre and inertia about it, in the axes of the link."""
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    pose = _pose(inertial.origin)
    inertia = np.zeros((3, 3)) if inertial.inertia is None else pose.axes @ inertial.inertia @ pose.axes.T
    mass = 0.0 if inertial.mass is None else float(inertial.mass)
    return mass, pose.at, 0.5 * (inertia + inertia.T)


def _pose(origin: np.ndarray | None) -> Pose:
    return Pose() if origin is None else Pose(origin[:3, 3].copy(), origin[:3, :3].copy())


def _number(text: Any, what: str, path: Path) -> float:
    try:
        return float(text or 0.0)
    except ValueError:
        raise FileError(f"{path}: {what} is {text!r}, no number") from None
