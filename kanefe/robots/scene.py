"""Conversion of the description of a robot to a scene: bodies in tree order, couplings, closures, warnings."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.bodies.rigid import RigidMass, rigid_mass
from kanefe.errors import ModelError, outside
from kanefe.joints import Fixed, Joint
from kanefe.robots.description import LinkJoint, NotTaken, Robot, RobotLink
from kanefe.robots.flexible_link import FlexibleLink
from kanefe.robots.pose import Pose
from kanefe.scene.scene import FlexibleMember, Frame
from kanefe.system import System

MOST_NAMES = 4
"""Largest number of names of each kind in a warning; `RobotScene.not_taken` has them all."""

POINT = 1e-12
"""Square of a radius of gyration below which an inertia is round-off of a converter and the link is a point, m2."""


class NotTakenWarning(UserWarning):
    """Elements of a robot's file that would change its motion and are not in the scene."""


class OddInertiaWarning(UserWarning):
    """An inertia in a robot's file that is impossible for a distribution of mass."""


class RobotScene(System):
    """A scene from a robot's file: a `System` that also has the names of the file.

    Bodies have the names of links, with "." for "/"; ``print(scene)`` shows the tree.

    Attributes
    ----------
    joints : dict of str to str
        Name of a joint -> the body that it carries, for results:
        ``result.joint_coordinates(scene.joints["elbow"])``.
    not_taken : dict of str to tuple of str
        Kind -> names of elements of the file that are not in the scene, including visuals and collision shapes.
    """

    def __init__(self, gravity: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        super().__init__(gravity)
        self.joints: dict[str, str] = {}
        self.not_taken: dict[str, tuple[str, ...]] = {}

    def _add_taken(
        self, name: str, taken: RigidMass, parent: Frame | None, joint: Joint, at: Pose, gravity: bool
    ) -> None:
        """Add a rigid body with the inertia of the file."""
        self._add(name, parent, joint, tuple(at.at), at.axes, rigid=taken, gravity=gravity)


def scene_of(
    robot: Robot, gravity: Sequence[float], flexible: Mapping[str, FlexibleBody | FlexibleLink] | None
) -> RobotScene:
    """Return the scene of a robot, and warn of elements that would change its motion and are not read.

    Parameters
    ----------
    robot : Robot
    gravity : array_like, shape (3,)
        m/s2.
    flexible : dict of str to FlexibleBody or FlexibleLink, optional
        Link -> the body that replaces it.

    Raises
    ------
    ModelError
        If a body of the file is not valid, or the replacement of a link does not fit.
    """
    scene = RobotScene(gravity)
    replaced = _replaced(robot, {} if flexible is None else flexible)
    _check_moving_masses(robot, replaced)
    taken = {link.name for link in robot.links}
    for link in robot.links:
        _add_link(scene, link, replaced, taken)
        if link.compensation not in (0.0, 1.0):
            _compensate(scene, link, link.name in replaced, robot.not_taken)
    for handed in robot.handed:
        child = scene.joints[handed.joint]
        if replaced.keys() & {child, *(body for body, _, _ in handed.lifted)}:
            robot.not_taken.add_acting("range of compensation by actuators at flexible links", handed.joint)
        else:
            handed.put_on(scene, child)
    for coupling in robot.couplings:
        bodies: dict[Frame | tuple[Frame, int], float] = {
            scene.body(scene.joints[joint]): c for joint, c in coupling.coefficients.items()
        }
        scene.add_gear(coupling.name, bodies, coupling.constant)
    for closure in robot.closures:
        ends = [_end(scene, link, pose, closure.name, replaced) for link, pose in closure.ends]
        scene.add_loop_joint(closure.name, closure.joint, *ends)
    for number, look in enumerate(robot.looks):
        if look.link not in replaced:
            carrier = scene.ground if look.link is None else scene.body(look.link)
            name = f"{look.link or 'ground'} look {number}"
            scene.add_surface(name, carrier, look.shape, at=tuple(look.pose.at), orientation=look.pose.axes)
    scene.not_taken = {
        kind: tuple(names) for kind, names in {**robot.not_taken.acting, **robot.not_taken.silent}.items()
    }
    _warn_of_what_acts(robot)
    return scene


def _compensate(scene: RobotScene, link: RobotLink, is_replaced: bool, not_taken: NotTaken) -> None:
    """Lift the centre of mass of a link by a part of its weight."""
    if is_replaced:
        not_taken.add_acting("partial compensation of gravity of flexible links", link.name)
        return
    lift = -link.compensation * link.mass * scene.gravity
    if lift.any():
        scene.add_force(scene.body(link.name), tuple(lift), point=tuple(link.center))


def _replaced(robot: Robot, flexible: Mapping[str, FlexibleBody | FlexibleLink]) -> dict[str, FlexibleLink]:
    """Return the replacements of links, checked against the links."""
    if not isinstance(flexible, Mapping):
        raise ModelError(f"flexible must be a dict of links and bodies, such as {{'forearm': body}}, not {flexible!r}")
    links = {link.name: link for link in robot.links}
    replaced = {}
    for name, given in flexible.items():
        if name not in links:
            raise ModelError(f"flexible: robot {robot.name!r} has no link {name!r}. It has: {', '.join(links)}")
        if not isinstance(given, (FlexibleBody, FlexibleLink)):
            raise ModelError(
                f"flexible: link {name!r} is to become {given!r}. Remedy: a FlexibleBody, such as one of "
                "kanefe_fem.solid_body, or FlexibleLink(body, ...)"
            )
        made = FlexibleLink(given) if isinstance(given, FlexibleBody) else given
        made.check(links[name], [link.name for link in robot.links if link.parent == name])
        replaced[name] = made
    return replaced


def _check_moving_masses(robot: Robot, replaced: Mapping[str, FlexibleLink]) -> None:
    """Raise a ModelError if there is no mass outward of a joint."""
    outward = {link.name: replaced[link.name].body.mass if link.name in replaced else link.mass for link in robot.links}
    for link in reversed(robot.links):
        if link.parent is not None:
            outward[link.parent] += outward[link.name]
    for link in robot.links:
        if link.moves and outward[link.name] <= 0.0:
            joint = next(made.name for made in link.joints if not made.joint.is_fixed)
            raise ModelError(
                f"joint {joint!r} moves link {link.name!r}, and nothing from there on has mass. Remedy: an inertial of "
                "the link in the file, or a fixed joint"
            )


def _add_link(scene: RobotScene, link: RobotLink, replaced: Mapping[str, FlexibleLink], taken: set[str]) -> None:
    """Add a link, with a frame for each joint but the last, and for the last if the link is not at its frame M.

    A frame has the name of its joint; where a link or a frame has that already, "joint" follows it.
    """
    gravity, made = link.compensation != 1.0, replaced.get(link.name)
    in_link = Pose() if made is None else made.pose
    parent, fixed = _carrier(scene, link, replaced)
    for number, step in enumerate(link.joints):
        is_last = number == len(link.joints) - 1
        fixed, after = (fixed @ step.fixed if number else fixed), step.moving
        is_body = is_last and (after @ in_link).is_none and (made is None or step.forces is None)
        if is_body:
            scene.joints[step.name] = link.name
            _add_body(scene, link, made, parent, step.joint, fixed, gravity)
            _put_forces(scene, step, parent, fixed)
            return
        name = step.name
        while name in taken:
            name += " joint"
        taken.add(name)
        frame = scene.add_frame(name, parent=parent, joint=step.joint, at=tuple(fixed.at), orientation=fixed.axes)
        scene.joints[step.name] = name
        _put_forces(scene, step, parent, fixed)
        parent, fixed = frame, after
    _add_body(scene, link, made, parent, Fixed(), fixed @ in_link, gravity)


def _put_forces(scene: RobotScene, step: LinkJoint, parent: Frame | None, fixed: Pose) -> None:
    """Apply the forces that a joint cannot have along its coordinates."""
    if step.forces is not None:
        carrier = (scene.ground if parent is None else parent).frame(tuple(fixed.at), fixed.axes)
        step.forces.put_on(scene, f"forces of {step.name}", carrier, scene.joints[step.name])


def _carrier(scene: RobotScene, link: RobotLink, replaced: Mapping[str, FlexibleLink]) -> tuple[Frame | None, Pose]:
    """Return the carrier of the first joint of a link, and the pose of its fixed frame relative to the carrier."""
    fixed = link.joints[0].fixed
    if link.parent is None:
        return None, fixed
    body = scene.body(link.parent)
    if link.parent not in replaced or not isinstance(body, FlexibleMember):
        return body, fixed
    frame, pose = replaced[link.parent].carrier(link.parent, link.name, fixed)
    return body.interface(frame.name), pose


def _add_body(
    scene: RobotScene,
    link: RobotLink,
    made: FlexibleLink | None,
    parent: Frame | None,
    joint: Joint,
    at: Pose,
    gravity: bool,
) -> None:
    if made is not None:
        scene.add_flexible_body(
            link.name, made.body, parent=parent, joint=joint, at=tuple(at.at), orientation=at.axes, gravity=gravity
        )
    else:
        scene._add_taken(link.name, _mass_of(link), parent, joint, at, gravity)


def _mass_of(link: RobotLink) -> RigidMass:
    """Return the mass of a link as given in the file, with a warning if it violates the triangle inequality.

    The equations only need moments that are not negative; many files round, or include the inertia of motors.
    """
    inertia = link.inertia
    if abs(inertia).max() < POINT * link.mass:
        inertia = np.zeros((3, 3))
    checked = rigid_mass(link.name, link.mass, 0.0, tuple(link.center))
    moments = np.linalg.eigvalsh(inertia) if np.isfinite(inertia).all() else inertia.diagonal()
    text = ", ".join(f"{x:.4g}" for x in moments)
    if not np.isfinite(moments).all() or moments[0] < -1e-12 * moments[2]:
        raise ModelError(
            f"link {link.name!r} has principal moments {text} kg m2, and none may be negative. Remedy: correct the "
            "inertia in the file; it is about the centre of mass, along the axes of the inertial frame"
        )
    if moments[2] > (moments[0] + moments[1]) * (1 + 1e-3):
        warnings.warn(
            f"link {link.name!r} has principal moments {text} kg m2, and no "
            "distribution of mass has one larger than the sum of the others. They are used as given. Remedy: "
            "check that the inertia is about the centre of mass",
            OddInertiaWarning,
            stacklevel=outside(),
        )
    return RigidMass(checked.mass, checked.com, inertia, is_as_given=True)


def _end(scene: RobotScene, link: str | None, pose: Pose, name: str, replaced: Mapping[str, FlexibleLink]) -> Frame:
    """Return the frame of an end of a closure."""
    if link is None:
        return scene.ground.frame(tuple(pose.at), pose.axes)
    body = scene.body(link)
    if isinstance(body, FlexibleMember):
        frame, pose = replaced[link].carrier(link, name, pose)
        return body.interface(frame.name).frame(tuple(pose.at), pose.axes)
    return body.frame(tuple(pose.at), pose.axes)


def _warn_of_what_acts(robot: Robot) -> None:
    if not robot.not_taken.acting:
        return
    parts = []
    for kind, names in robot.not_taken.acting.items():
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        parts.append(f"{kind}: {', '.join(names[:MOST_NAMES])}{more}")
    warnings.warn(
        f"robot {robot.name!r}: parts that would change its motion are not in the scene: {'; '.join(parts)}. "
        "scene.not_taken lists all of them",
        NotTakenWarning,
        stacklevel=outside(),
    )
