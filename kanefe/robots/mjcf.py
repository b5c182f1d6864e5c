"""MJCF, MuJoCo's model file: bodies with any number of joints, and equalities; other elements are reported."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.frames import axis_rotation, rotation_matrix
from kanefe.joints import Fixed, Joint, Prismatic, Revolute, Spherical
from kanefe.robots import _mujoco
from kanefe.robots.compensation import Handed
from kanefe.robots.description import Choices, Closure, Coupling, Ends, LinkJoint, NotTaken, Robot, RobotLink
from kanefe.robots.flexible_link import FlexibleLink
from kanefe.robots.joint_forces import AxisForces, Coefficients, PoseForces, is_linear_law
from kanefe.robots.mjcf_flags import ACTUATION, CONTACT, EQUALITY, SLEEP, apply_flags, switched_off
from kanefe.robots.mjcf_keys import number_of, record_what_is_left, start_at
from kanefe.robots.pose import Pose
from kanefe.robots.scene import RobotScene, scene_of
from kanefe.storage.files import regular_file

FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint
CONNECT, WELD, JOINT = range(3)  # mjtEq
BODY, SITE = 1, 6  # mjtObj
TORQUESCALE = 10
"""Place in the numbers of a weld of the factor of its moments: without it only places are held."""

OFF_BY = {"actuators": ACTUATION, "equalities": EQUALITY}
"""Kind of elements that are not read -> the flag that switches them off."""


@checked("path", "key", "limit_stiffness", "limit_damping", "joint_forces", "looks")
def read_mjcf(
    path: str | Path,
    *,
    gravity: Sequence[float] | None = None,
    flexible: Mapping[str, FlexibleBody | FlexibleLink] | None = None,
    positions: Mapping[str, float | Sequence[float]] | None = None,
    key: str | int | None = None,
    limit_stiffness: float | None = None,
    limit_damping: float = 0.0,
    joint_forces: bool = True,
    looks: bool = True,
) -> RobotScene:
    """Return the scene of an MJCF file, by MuJoCo's own parser: ``pip install 'kanefe[robots]'``.

    Each body becomes a rigid one with its name, in its own frame; with several joints, all but the last carry a
    massless frame. Coordinates are those of MuJoCo, including `ref`. Springs and dampers of all joints act, with their
    polynomials, armatures, and dry friction of hinges and slides; so does compensation of gravity. Equalities of kind
    connect and weld (of bodies or sites) and joint (linear) hold exactly, while MuJoCo's are compliant. Flags of the
    file switch parts off as in MuJoCo. Shapes are used for the inertia of bodies without their own, and drawn.
    Actuators, tendons, contacts and other elements are not read: ``scene.not_taken`` lists them, and a warning those
    that would change the motion.

    Parameters
    ----------
    path : str or Path
    gravity : array_like, shape (3,), optional
        m/s2; default: that of the file.
    key : str or int, optional
        Keyframe at which the scene starts, by name or MuJoCo's number: coordinates and speeds of joints, places of
        mocap bodies. `positions` change single joints of it, and what equalities hold moves near it as they need. Its
        `ctrl` and `act` are named in `not_taken`, because actuators are not read.
    flexible, positions, limit_stiffness, limit_damping, joint_forces, looks
        As for `read_urdf`; drawn are the shapes that touch nothing, or all shapes of a body that has none of these.
        Bodies and joints without a name are called "body 3" and "joint 2", by MuJoCo's numbers.

    Returns
    -------
    RobotScene
        A `System` to which anything can be added.

    Raises
    ------
    FileError
        If the file is missing, MuJoCo's parser refuses it, or the keyframe has too few numbers.
    ModelError
        If a named body, joint or keyframe does not exist, or a flexible body does not fit.
    MissingDependency
        Without mujoco.

    Warns
    -----
    NotTakenWarning
        For elements that would change the motion and are not read.

    Examples
    --------
    ``scene = kf.read_mjcf("ant.xml", positions={"hip_1": 0.3})``
    """
    source = regular_file(path)
    file = _mujoco.compiled(source, None if key is None else lambda names: number_of(key, names, source))
    model = file.model
    apply_flags(model)
    robot = Robot(source.stem)
    _record_not_taken(file, robot.not_taken)
    names = _Names(model)
    start = () if file.key is None else start_at(model, file.key, names.joints)
    choices = Choices({} if positions is None else positions, joint_forces, limit_stiffness, limit_damping, *start)
    if unknown := sorted(set(choices.positions) - set(names.joints)):
        raise ModelError(
            f"positions: {source} has no joint {unknown[0]!r}. It has: {', '.join(names.joints) or 'none'}"
        )
    if model.nbody < 2:
        raise ModelError(f"{source} has no bodies")
    for number in range(model.neq):
        _add_equality(model, names, number, robot)
    usual = {name: _usual(model, i, choices, name) for i, name in enumerate(names.joints) if _has_axis(model, i)}
    choices.take_couplings(robot.couplings, usual)
    for body in range(1, model.nbody):
        robot.links.append(_link(file, names, body, choices, robot.not_taken))
    _add_handed(file, names, robot)
    if looks:
        _add_looks(robot, source, model, names)
    choices.check_limits(source)
    return scene_of(robot, tuple(model.opt.gravity.tolist()) if gravity is None else gravity, flexible)


def _add_looks(robot: Robot, source: Path, model: Any, names: _Names) -> None:
    """Add the shapes of the whole file, which needs its meshes; where these are missing nothing is drawn."""
    from kanefe.robots.looks import looks_of_mjcf

    whole = _mujoco.with_shapes(source)
    if whole is None or whole.nbody != model.nbody:
        robot.not_taken.add_silent("shapes, which are not drawn because meshes are missing", source.name)
    else:
        robot.looks.extend(looks_of_mjcf(whole, names.bodies))


class _Names:
    """Names of bodies and joints, with "." for "/", and numbers for those without one."""

    def __init__(self, model: Any) -> None:
        self.bodies = [model.body(i).name.replace("/", ".") or f"body {i}" for i in range(model.nbody)]
        self.joints = [model.joint(i).name.replace("/", ".") or f"joint {i}" for i in range(model.njnt)]

    def link(self, body: int) -> str | None:
        """Return the link of a body; None: the ground."""
        return self.bodies[body] if body else None


def _record_not_taken(file: _mujoco.CompiledRobot, not_taken: NotTaken) -> None:
    """Record the elements that are not read; those that the flags of the file switch off do not act."""
    off = switched_off(file.model)
    if file.key is not None:
        record_what_is_left(file.model, file.key, [] if off & ACTUATION else file.controls, not_taken)
    for kind, name in _mujoco.SILENT.items():
        for element in file.named[kind]:
            not_taken.add_silent(name, element)
    for kind, name in _mujoco.ACTING.items():
        for element in file.named[kind]:
            if kind in OFF_BY and off & OFF_BY[kind]:
                not_taken.add_silent(f"{kind} that are off", element)
            else:
                not_taken.add_acting(name, element)
    for body in file.shapes:
        (not_taken.add_silent if off & CONTACT else not_taken.add_acting)("shapes, which touch nothing", body)
    for what in ("density", "viscosity"):
        if getattr(file.model.opt, what):
            not_taken.add_acting("fluid", what)
    if int(file.model.opt.enableflags) & SLEEP:
        not_taken.add_acting("flags", "sleep")


def _link(file: _mujoco.CompiledRobot, names: _Names, body: int, choices: Choices, not_taken: NotTaken) -> RobotLink:
    model, name = file.model, names.bodies[body]
    turn = rotation_matrix(model.body_iquat[body])
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    return RobotLink(
        name,
        names.link(int(model.body_parentid[body])),
        _joints(model, names, body, choices, not_taken),
        float(model.body_mass[body]),
        model.body_ipos[body].copy(),
        0.5 * (inertia + inertia.T),
        compensation=_compensation(file, body, name, not_taken),
    )


def _compensation(file: _mujoco.CompiledRobot, body: int, name: str, not_taken: NotTaken) -> float:
    """Return the part of the weight of a body that is compensated, before hinges and slides clamp what they hand on.

    Without a positive one in the whole model, MuJoCo leaves out negative ones too. What joints hand to their actuators
    is lost without actuators.
    """
    model, compensation = file.model, float(file.model.body_gravcomp[body])
    if not compensation or model.body_gravcomp.max() <= 0.0:
        return 0.0
    joints = _joints_below(model, body)
    handed = [joint for joint in joints if model.jnt_actgravcomp[joint]]
    if not handed or _actuators_act(file):
        return compensation
    if len(handed) < len(joints) and all(_has_axis(model, joint) for joint in handed):
        return compensation
    if len(handed) < len(joints):
        not_taken.add_acting("compensation of gravity by actuators of free and ball joints", name)
    return 0.0


def _actuators_act(file: _mujoco.CompiledRobot) -> bool:
    """Return whether compensation that is handed to actuators reaches the joints."""
    return bool(file.named["actuators"]) and not switched_off(file.model) & ACTUATION


def _add_handed(file: _mujoco.CompiledRobot, names: _Names, robot: Robot) -> None:
    """Add the hinges and slides that hand compensation to actuators that clamp it or are not there."""
    model, acts = file.model, _actuators_act(file)
    for joint, name in enumerate(names.joints):
        if not model.jnt_actgravcomp[joint] or not _has_axis(model, joint):
            continue
        if acts and not model.jnt_actfrclimited[joint]:
            continue
        lifted = tuple(
            (link.name, tuple(link.center.tolist()), link.compensation * link.mass)
            for body, link in enumerate(robot.links, start=1)
            if link.compensation and joint in _joints_below(model, body)
        )
        low, high = model.jnt_actfrcrange[joint].tolist() if acts else (0.0, 0.0)
        turns = int(model.jnt_type[joint]) == HINGE
        if lifted:
            robot.handed.append(Handed(name, model.jnt_axis[joint].copy(), turns, low, high, lifted))


def _joints_below(model: Any, body: int) -> list[int]:
    """Return the joints between the ground and a body."""
    joints: list[int] = []
    while body:
        first = int(model.body_jntadr[body])
        joints.extend(range(first, first + int(model.body_jntnum[body])))
        body = int(model.body_parentid[body])
    return joints


def _joints(model: Any, names: _Names, body: int, choices: Choices, not_taken: NotTaken) -> tuple[LinkJoint, ...]:
    """Return the joints of a body in order, with anchors and axes fixed in the body, each after the previous ones."""
    place = Pose(model.body_pos[body].copy(), rotation_matrix(model.body_quat[body]))
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    if not count:
        return (LinkJoint(f"mount of {names.bodies[body]}", Fixed(), place),)
    made = []
    for number in range(first, first + count):
        name, kind = names.joints[number], int(model.jnt_type[number])
        anchor = Pose(model.jnt_pos[number].copy())
        if kind == FREE:
            start = model.qpos0[model.jnt_qposadr[number] :][:7].tolist()
            forces = _pose_forces(model, number, name, choices, not_taken)
            free = replace(choices.free(name, start), armature=_armature(model, number))
            return (LinkJoint(name, free, forces=forces),)
        before = place if number == first else Pose()
        if kind == BALL:
            if model.jnt_limited[number]:
                not_taken.add_acting("limits of ball joints", name)
            forces = _pose_forces(model, number, name, choices, not_taken)
            ball = replace(choices.ball(name), armature=_armature(model, number))
            made.append(LinkJoint(name, ball, before @ anchor, anchor.inverse, forces))
            continue
        axis, ref = model.jnt_axis[number].copy(), float(model.qpos0[model.jnt_qposadr[number]])
        back = Pose(axes=axis_rotation(axis, -ref)) if kind == HINGE else Pose(-ref * axis)
        joint, more = _along_axis(model, number, name, choices, not_taken)
        made.append(LinkJoint(name, joint, before @ anchor @ back, anchor.inverse, more))
    return tuple(made)


def _has_axis(model: Any, number: int) -> bool:
    """Return whether a joint is a hinge or a slide."""
    return int(model.jnt_type[number]) in (SLIDE, HINGE)


def _usual(model: Any, number: int, choices: Choices, name: str) -> float:
    """Return where the keyframe or the file puts a hinge or a slide."""
    return float(choices.guesses[name][0] if name in choices.guesses else model.qpos0[model.jnt_qposadr[number]])


def _along_axis(
    model: Any, number: int, name: str, choices: Choices, not_taken: NotTaken
) -> tuple[Joint, AxisForces | None]:
    """Return a hinge or a slide, and the forces that it cannot have along its coordinate."""
    speed, place = int(model.jnt_dofadr[number]), int(model.jnt_qposadr[number])
    limits: tuple[float | None, float | None] = (None, None)
    if model.jnt_limited[number]:
        limits = float(model.jnt_range[number, 0]), float(model.jnt_range[number, 1])
    stiffness, damping = _springs(model, number, name, not_taken)
    rest = float(model.qpos_spring[place])
    more = choices.axis_forces(name, not_taken, stiffness, damping, rest)
    is_linear = is_linear_law(stiffness, damping)
    forces = choices.coordinate_force(
        name,
        not_taken,
        limits=limits,
        stiffness=stiffness[0] if is_linear else 0.0,
        rest=rest,
        damping=damping[0] if is_linear else 0.0,
        friction=float(model.dof_frictionloss[speed]),
        armature=_armature(model, number),
    )
    kind = Revolute if model.jnt_type[number] == HINGE else Prismatic
    axis = tuple(model.jnt_axis[number].tolist())
    start = choices.start(name, _usual(model, number, choices, name))
    return kind(axis, position=start, speed=choices.speed(name), forces=forces), more


def _pose_forces(model: Any, number: int, name: str, choices: Choices, not_taken: NotTaken) -> PoseForces | None:
    """Return springs and dampers of a free or ball joint; record its friction, which is not read."""
    is_free = int(model.jnt_type[number]) == FREE
    speed, place = int(model.jnt_dofadr[number]), int(model.jnt_qposadr[number])
    speeds = slice(speed, speed + (6 if is_free else 3))
    if model.dof_frictionloss[speeds].any():
        not_taken.add_acting("friction of free and ball joints", name)
    spring = model.qpos_spring[place:]
    rest = Pose(spring[:3].copy(), rotation_matrix(spring[3:7])) if is_free else Pose(axes=rotation_matrix(spring[:4]))
    return choices.pose_forces(name, not_taken, *_springs(model, number, name, not_taken), rest, is_free)


def _armature(model: Any, number: int) -> float:
    """Return the inertia of the rotor of a joint, the same along all its speeds."""
    return float(model.dof_armature[model.jnt_dofadr[number]])


def _springs(model: Any, number: int, name: str, not_taken: NotTaken) -> tuple[Coefficients, Coefficients]:
    """Return the coefficients of the spring and the damper of a joint; record yield, which is not read."""
    if model.jnt_springyield[number].any():
        not_taken.add_acting("springs of joints that yield", name)
    speed = int(model.jnt_dofadr[number])
    stiffness = float(model.jnt_stiffness[number]), *model.jnt_stiffnesspoly[number].tolist()
    return stiffness, (float(model.dof_damping[speed]), *model.dof_dampingpoly[speed].tolist())


def _add_equality(model: Any, names: _Names, number: int, robot: Robot) -> None:
    """Add an equality between two bodies or joints, or record that it is not read."""
    name = model.equality(number).name or f"equality {number}"
    kind, one, two = int(model.eq_type[number]), int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
    data, things = model.eq_data[number], int(model.eq_objtype[number])
    if not model.eq_active0[number]:
        robot.not_taken.add_silent("equalities that are off", name)
    elif kind == JOINT and not data[2:5].any():
        robot.couplings.append(_coupling(model, names, name, one, two, data))
    elif kind in (CONNECT, WELD) and things in (BODY, SITE):
        of = _site_ends if things == SITE else _connected if kind == CONNECT else _welded
        turns = kind == CONNECT or data[TORQUESCALE] == 0.0
        joint = Spherical() if turns else Fixed()
        robot.closures.append(Closure(name, joint, of(model, names, one, two, data)))
    else:
        robot.not_taken.add_acting("equalities of other kinds", name)


def _connected(model: Any, names: _Names, one: int, two: int, data: np.ndarray) -> Ends:
    """Return the anchor of two connected bodies in each."""
    return (names.link(one), Pose(data[0:3].copy())), (names.link(two), Pose(data[3:6].copy()))


def _welded(model: Any, names: _Names, one: int, two: int, data: np.ndarray) -> Ends:
    """Return the anchor of two welded bodies in each, with the axes of the second; `relpose` is that of the anchor."""
    relative = Pose(data[3:6].copy(), rotation_matrix(data[6:10]))
    return (names.link(one), relative), (names.link(two), Pose(data[0:3].copy()))


def _site_ends(model: Any, names: _Names, one: int, two: int, data: np.ndarray) -> Ends:
    """Return two sites, each in its body."""
    first, second = (
        (
            names.link(int(model.site_bodyid[site])),
            Pose(model.site_pos[site].copy(), rotation_matrix(model.site_quat[site])),
        )
        for site in (one, two)
    )
    return first, second


def _coupling(model: Any, names: _Names, name: str, one: int, two: int, data: np.ndarray) -> Coupling:
    """Return ``(q1 - q1_0) = c0 + c1 (q2 - q2_0)``, with the coordinates of the initial pose of the file."""
    first = float(model.qpos0[model.jnt_qposadr[one]])
    if two < 0:
        return Coupling(name, {names.joints[one]: 1.0}, first + float(data[0]))
    second = float(model.qpos0[model.jnt_qposadr[two]])
    coefficients = {names.joints[one]: 1.0, names.joints[two]: -float(data[1])}
    constant = first + float(data[0]) - float(data[1]) * second
    return Coupling(name, {joint: c for joint, c in coefficients.items() if c}, constant)
