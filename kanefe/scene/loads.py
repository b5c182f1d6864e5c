"""Methods of `System` that add loads: forces, torques, motors, springs, bushings, any load between frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers, shaped_numbers
from kanefe.loads.base import Load
from kanefe.loads.functions import Constant, callback, multiplied
from kanefe.scene.readings import with_reads
from kanefe.scene.scene import BodyEntry, Frame, Scene, three

if TYPE_CHECKING:
    from kanefe.loads.point_load import PointLoad

LoadValue = Callable[..., Any] | Sequence[float] | float


class LoadMethods(Scene):
    """The part of `System` that adds loads."""

    def add(self, load: Load) -> None:
        """Add a load between frames, of kanefe or of a class of your own: see `kanefe.Load`.

        Parameters
        ----------
        load : Load
            Its `ends` are frames of this scene. The scene uses a copy; the given object is not changed.

        Raises
        ------
        ModelError
            If it lacks something, its name is taken, or an end is not of this scene. Its forces are checked at freeze,
            when the positions of its ends are known.

        Examples
        --------
        >>> import numpy as np
        >>> import kanefe as kf
        >>> class Wind(kf.Load):
        ...     def __init__(self, name, on, speed, drag):
        ...         self.name, self.ends, self.speed, self.drag = name, (on,), np.array(speed), drag
        ...     def action(self, t, ends, states):
        ...         force = self.drag * (self.speed - ends[0].v)
        ...         return kf.Action(np.append(force, np.zeros(3))[None], given=force @ ends[0].v)
        >>> scene = kf.System()
        >>> ball = scene.add_point("ball", 0.1)
        >>> scene.add(Wind("wind", ball, (3, 0, 0), 0.2))
        >>> result = scene.simulate((0.0, 0.5))
        >>> float(result.velocity("ball")[-1, 0].round(3))  # m/s: 3 (1 - exp(-1))
        1.896
        """
        from kanefe.loads.checks import check_load

        check_load(load)
        label = self._new_load(load.name, load.kind)
        markers = [
            self._marker(end, f"end {i} of {label}", needs_rotation=load.needs_rotation)
            for i, end in enumerate(load.ends)
        ]
        self._loads.append(load.with_ends(tuple(markers)))

    @checked("follows")
    def add_force(
        self, target: Frame, force: LoadValue, *, point: Sequence[float] = (0.0, 0.0, 0.0), follows: bool = False
    ) -> None:
        """Apply a force.

        Parameters
        ----------
        target : Frame
            A rigid body, an interface or node of a flexible body, or a frame of one.
        force : (3,) or callable t -> (3,) or (t, state) -> (3,)
            N. The state has positions and velocities of bodies: see `kanefe.tree.scene_state.SceneState`. Runs
            stay in compiled code for a function of `kanefe.compiled`, (t) or (t, reads), or one compiled by numba, (t)
            or (t, y), with y = (q, u, z) as an array in the order of `Model.state_names`.
        point : array_like, shape (3,)
            Point of action, from the frame's origin in its axes, m.
        follows : bool
            True: the components are those of the frame; False: of N.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> ball = scene.add_point("ball", 0.1)
        >>> scene.add_force(ball, lambda t, state: -0.3 * state.velocity("ball"))
        """
        entry = self._target(target, "a force")
        label = f"the force on {target.label}"
        where = target.at + target.axes @ three(point, f"point of {label}")
        force = with_reads(self._entries, force, label)
        entry.loads.append((_point_load(label, force, False, where, follows, target), target.interface_frame))

    @checked("follows")
    def add_torque(self, target: Frame, torque: LoadValue, *, follows: bool = False) -> None:
        """Apply a torque.

        Parameters
        ----------
        target : Frame
            A rigid body, an interface of a flexible body, or a frame of one.
        torque : (3,), float or callable t -> (3,) or float, or (t, state) -> (3,)
            N m. One number is the torque of a motor: see `add_motor`.
        follows : bool
            True: the three components are those of the frame; False: of N.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.
        """
        entry = self._target(target, "a torque")
        label = f"the torque on {target.label}"
        torque = with_reads(self._entries, torque, label)
        if not (callable(torque) and callback(torque, label)[1]):
            try:
                given = torque(0.0) if callable(torque) else torque
            except Exception as error:
                error.add_note(f"the function of {label} at t = 0 s")
                raise
            sample = numbers(given)
            if sample.shape == () and target.interface_frame is None:
                self._add_motor(target, torque, 0, label, is_single=True)
                return
            if sample.shape != (3,):
                raise ModelError(
                    f"{label} must be three numbers" + ("" if target.interface_frame else " or one for a motor")
                )
        load = _point_load(label, torque, True, np.zeros(3), follows, target)
        entry.loads.append((load, target.interface_frame))

    @checked("coordinate")
    def add_motor(self, body: Frame, force: LoadValue, *, coordinate: int = 0) -> None:
        """Apply the force of a motor along a coordinate of a body's joint: on the body and, reversed, on its parent.

        Parameters
        ----------
        body : RigidBody or FlexibleMember
            The body on the outward side of the joint.
        force : float or callable t -> float or (t, state) -> float
            N m along an angle, N along a distance.
        coordinate : int
            Number of the coordinate of the joint.

        Raises
        ------
        ModelError
            If the joint has no such free coordinate, or the force is not one number.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z"))
        >>> scene.add_motor(arm, lambda t, state: 2.0 * (1.0 - state.joint_coordinates("arm")[0]))
        """
        self._target(body, "a motor")
        self._add_motor(body, force, coordinate, f"the motor of {body.label}", is_single=False)

    def _add_motor(self, body: Frame, force: LoadValue, coordinate: int, label: str, is_single: bool) -> None:
        from kanefe.loads.joint_load import JointLoad

        entry = self._target(body, "a motor")
        joint = entry.joint
        motions = joint.motions if joint.rotation_at is None else ()
        if is_single and (len(motions) != 1 or motions[0] is not None):
            raise ModelError(
                f"{label} is one number, but its {joint.kind} joint has no single free axis. "
                "Remedy: give three components, or a revolute joint that is not driven"
            )
        names = {i: name for i, name in enumerate(joint.coordinate_names[: len(motions)]) if motions[i] is None}
        if coordinate not in names:
            free = ", ".join(f"{i} ({name})" for i, name in names.items()) or "none"
            raise ModelError(
                f"{label}: coordinate {coordinate!r} of its {joint.kind} joint is not one that a motor can drive. "
                f"There are: {free}"
            )
        force = with_reads(self._entries, force, label)
        if callable(force):
            function, asks = callback(force, label)
            entry.joint_loads.append(JointLoad(label, function, coordinate, asks))
            return
        constant = numbers(force)
        if constant.shape != () or not np.isfinite(constant):
            raise ModelError(f"{label} must be a finite number, not {force!r}")
        entry.joint_loads.append(JointLoad(label, Constant(float(constant)), coordinate))

    @checked("name")
    def add_spring(
        self,
        name: str,
        a: Frame,
        b: Frame,
        *,
        stiffness: float = 0.0,
        damping: float = 0.0,
        rest_length: float | None = None,
        force: Callable[[float, float], float] | tuple[Sequence[float], Sequence[float]] | None = None,
    ) -> None:
        """Add a spring and damper along the line between two frames.

        Parameters
        ----------
        name : str
            Unique among springs, bushings and other loads between frames.
        a, b : Frame
            Bodies, interfaces, nodes, frames of them, or the ground.
        stiffness, damping : float
            N/m and N s/m.
        rest_length : float, optional
            m; default: the length at the start.
        force : (lengths, forces) or callable (length, rate) -> N, optional
            Tension instead of the stiffness, positive if it pulls the ends together. A table is linear between its
            points and beyond its ends. The work of either counts as work of loads.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it. A spring of zero length at the start is found at freeze.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> ball = scene.add_point("ball", 0.1, at=(0, 0, -1))
        >>> scene.add_spring("rope", scene.ground, ball, stiffness=1e4, damping=2.0, rest_length=0.9)
        """
        from kanefe.loads.spring import SpringDamper

        label = self._new_load(name, "spring")
        ends = self._marker(a, f"end a of {label}"), self._marker(b, f"end b of {label}")
        k = float(_not_negative(stiffness, (), f"stiffness of {label}"))
        c = float(_not_negative(damping, (), f"damping of {label}"))
        rest = numbers(np.nan if rest_length is None else rest_length)
        if rest_length is not None and not (rest.shape == () and np.isfinite(rest) and rest >= 0):
            raise ModelError(f"rest_length of {label} must be finite and >= 0 m, not {rest_length!r}")
        lengths = forces = np.zeros(0)
        function = force if callable(force) else None
        if force is not None and k > 0.0:
            raise ModelError(f"{label} has a stiffness and a force of its own. Remedy: one of them")
        if force is not None and function is None:
            lengths, forces = _table(force, label)
        if force is None and k == 0.0 and c == 0.0:
            raise ModelError(f"{label} does nothing. Remedy: give stiffness, damping or force")
        self._loads.append(SpringDamper(name, ends, k, c, float(rest), lengths, forces, function))

    @checked("name")
    def add_bushing(
        self,
        name: str,
        a: Frame,
        b: Frame,
        *,
        stiffness: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
        damping: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
        law: Callable[[np.ndarray, np.ndarray], Any] | None = None,
    ) -> None:
        """Add springs and dampers in all directions between two frames; they are at rest if b coincides with a.

        The force acts at b's origin. The rotation is measured by the rotation vector theta, valid up to half a turn;
        the moment is that of the potential ``theta' K theta / 2``, so that a bushing without damping keeps the energy.
        A spring about one axis that turns further: `kanefe.CoordinateForce` of a revolute joint.

        Parameters
        ----------
        name : str
            Unique among springs, bushings and other loads between frames.
        a, b : Frame
            Bodies, interfaces, frames of them, or the ground.
        stiffness, damping : array_like, shape (3,), (6,) or (6, 6)
            Along x, y and z of a (N/m, N s/m), then about them (N m/rad, N m s/rad); three: no moments. Matrices couple
            directions, and need not be symmetric: the skew part of a stiffness, such as that of an oil film, is not
            conservative. For a bearing of a rotating shaft see `kanefe.Bearing`.
        law : callable, optional
            Instead of the stiffness: (displacement (6,), rate (6,)) -> force and moment on b at its origin (6,), all
            in the axes of a: position of b from a and rotation vector, rate of that position and angular velocity. Its
            work counts as work of loads.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> engine = scene.add_rigid_body("engine", 80.0, 2.0, joint=kf.Free())
        >>> scene.add_bushing("mount", scene.ground, engine, stiffness=(2e5, 2e5, 4e5), damping=(200, 200, 400))
        """
        from kanefe.loads.bushing import Bushing, check_damps

        label = self._new_load(name, "bushing")
        wide = numbers(stiffness).size > 3 or numbers(damping).size > 3 or law is not None
        ends = [
            self._marker(x, f"end {n} of {label}", needs_rotation=wide and n == "b") for x, n in ((a, "a"), (b, "b"))
        ]
        constants = [
            _six_by_six(x, f"{what} of {label}") for x, what in ((stiffness, "stiffness"), (damping, "damping"))
        ]
        check_damps(constants[1], label)
        if law is not None and not callable(law):
            raise ModelError(f"law of {label} must be a function of displacement and rate, not {law!r}")
        if law is not None and constants[0].any():
            raise ModelError(f"{label} has a stiffness and a law of its own. Remedy: one of them")
        if law is None and not any(x.any() for x in constants):
            raise ModelError(f"{label} does nothing. Remedy: give stiffness, damping or law")
        self._loads.append(Bushing(name, tuple(ends), constants[0], constants[1], law))

    def _new_load(self, name: str, kind: str) -> str:
        """Return the label of a new load between frames; raise a ModelError if its name is not valid or taken."""
        label = f"{kind} {name!r}"
        self._check_open(label)
        if not isinstance(name, str) or not name:
            raise ModelError(f"the name of a {kind} must be a text, not {name!r}")
        taken = next((other for other in self._loads if other.name == name), None)
        if taken is not None:
            raise ModelError(f"the scene already has a {taken.kind} called {name!r}. Remedy: another name")
        return label

    def _target(self, target: Frame, what: str) -> BodyEntry:
        self._check_open(what)
        self._check_frame(target, "the target of a load")
        if target.number < 0:
            raise ModelError("a load on the ground moves nothing. Remedy: give the body that it acts on")
        return self._entries[target.number]


def _six_by_six(given: object, what: str) -> np.ndarray:
    """Return a matrix over displacements and rotations; three or six numbers, not negative, are its diagonal."""
    shape = numbers(given).shape
    if shape == (6, 6):
        return shaped_numbers(given, (6, 6), what)
    values = _not_negative(given, (6,) if shape == (6,) else (3,), what)
    return np.diag(np.concatenate((values, np.zeros(6 - len(values)))))


def _point_load(
    label: str, load: LoadValue, is_torque: bool, where: np.ndarray, follows: bool, target: Frame
) -> PointLoad:
    """Return a checked force or torque, with components transformed to the frame that the target is fixed in."""
    from kanefe.loads.point_load import PointLoad

    function, asks = callback(load, label) if callable(load) else (Constant(three(load, label)), False)
    if follows and not np.array_equal(target.axes, np.eye(3)):
        function = multiplied(function, target.axes)
    return PointLoad(label, function, is_torque, where, follows, asks)


def _not_negative(value: object, shape: tuple[int, ...], what: str) -> np.ndarray:
    array = numbers(value)
    if array.shape != shape or not np.all(np.isfinite(array)) or np.any(array < 0):
        wanted = "one number" if shape == () else "three or six numbers"
        raise ModelError(f"{what} must be {wanted}, finite and >= 0, not {value!r}")
    return array


def _table(force: object, label: str) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths and forces of a table; a ModelError names the spring."""
    pair = list(force) if isinstance(force, (tuple, list)) else []
    if len(pair) != 2:
        raise ModelError(f"force of {label} must be a function or a table (lengths, forces), not {force!r}")
    lengths, forces = numbers(pair[0]), numbers(pair[1])
    is_finite = bool(np.all(np.isfinite(lengths)) and np.all(np.isfinite(forces)))
    if lengths.ndim != 1 or forces.shape != lengths.shape or len(lengths) < 2 or not is_finite:
        raise ModelError(
            f"the table of {label} needs two lengths or more and as many forces, all finite; shapes {lengths.shape} "
            f"and {forces.shape} were given"
        )
    if np.any(np.diff(lengths) <= 0):
        raise ModelError(f"the lengths in the table of {label} must increase. Remedy: sort them")
    return lengths, forces
