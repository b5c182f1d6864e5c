"""Methods of `System` that add constraints: loop joints, distances, gears, racks and rolling contacts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.marker import Marker
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.joints import Joint
from kanefe.joints.checks import check_joint
from kanefe.joints.given_pose import driven
from kanefe.scene.scene import Frame, Scene

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint


class ConstraintMethods(Scene):
    """The part of `System` that adds constraints."""

    def __init__(self) -> None:
        super().__init__()
        self._constraints: list[Constraint] = []

    def add_loop_joint(
        self, name: str, joint: Joint | type[Joint], a: Frame, b: Frame, *, starts_on: bool | None = None
    ) -> None:
        """Close a loop by a joint between frames a and b, in addition to the joints of the tree.

        Parameters
        ----------
        name : str
            Unique among the scene's constraints.
        joint : Joint, or a class of joints
            Any but Free. Its axes have the same components in a's and in b's axes: rotate the frames with
            ``frame(orientation=...)`` if the bodies' own axes do not match. It has no start, spring or drive.
        a, b : Frame
            Frames of different bodies; ``scene.ground`` is the inertial frame.
        starts_on : bool, optional
            Whether the joint holds at the start, if events switch it on and off in a run by an action that returns
            ``state.switched(on=name)`` or ``off=name``. Default: it always holds. It must be closed when it is switched
            on; inconsistent speeds are lost as in a plastic impact.

        Raises
        ------
        ModelError
            If the joint cannot close a loop, or an end is not a frame of this scene. Loops are assembled by `freeze`.

        Examples
        --------
        A four-bar linkage; `freeze` finds the start of coupler and rocker.

        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> crank = scene.add_rigid_body("crank", 1, 0.1, joint=kf.Revolute("z", position=1.0, speed=2.0))
        >>> coupler = scene.add_rigid_body("coupler", 1, 0.1, parent=crank, at=(1, 0, 0), joint=kf.Revolute("z"))
        >>> rocker = scene.add_rigid_body("rocker", 1, 0.1, at=(2, 0, 0), joint=kf.Revolute("z"))
        >>> ends = coupler.frame(at=(2, 0, 0)), rocker.frame(at=(0, 1.5, 0))
        >>> scene.add_loop_joint("pin", kf.Revolute("z"), *ends)
        >>> scene.freeze().constraint_report().degrees_of_freedom
        1
        """
        from kanefe.constraints.loop_joints import held_by, loop_joint_rows
        from kanefe.constraints.rows import Constraint

        label = f"loop joint {name!r}"
        self._check_new(name, label, starts_on)
        made = joint() if isinstance(joint, type) and issubclass(joint, Joint) else joint
        if not isinstance(made, Joint):
            raise ModelError(f"{label} takes a joint, such as Revolute('z'), not {joint!r}")
        check_joint(made, f"the joint of {label}")
        _check_plain(made, label)
        held = held_by(made)
        ends = self._ends(a, b, label, needs_rotation=not held.takes_points)
        rows = loop_joint_rows(made, *ends)
        self._constraints.append(Constraint(name, f"{made.kind} loop joint", rows, *ends, held.facing, starts_on))

    def add_distance(self, name: str, a: Frame, b: Frame, length: float, *, starts_on: bool | None = None) -> None:
        """Keep the origins of two frames at a distance: a massless rod with a ball joint at each end.

        Parameters
        ----------
        name : str
            Unique among the scene's constraints.
        a, b : Frame
            Frames of different bodies.
        length : float
            m, above zero.
        starts_on : bool, optional
            See `add_loop_joint`.

        Raises
        ------
        ModelError
            If the length is not above zero (remedy: a spherical loop joint), or an end is not a frame of this scene.
        """
        from kanefe.constraints.rows import Constraint, DistanceRow

        label = f"distance {name!r}"
        self._check_new(name, label, starts_on)
        size = _positive(length, f"length of {label}", "a spherical loop joint keeps two points together")
        ends = self._ends(a, b, label, needs_rotation=False)
        self._constraints.append(
            Constraint(name, "distance", (DistanceRow("distance", *ends, size),), *ends, (), starts_on)
        )

    @checked("constant")
    def add_gear(
        self,
        name: str,
        coefficients: Mapping[Frame | tuple[Frame, int], float],
        constant: float | None = None,
        *,
        starts_on: bool | None = None,
    ) -> None:
        """Couple joint coordinates: ``sum c_i q_i = constant``, such as gears, belts and differentials.

        Parameters
        ----------
        name : str
            Unique among the scene's constraints.
        coefficients : dict
            Body -> coefficient c of its joint's coordinate; (body, number) -> that of a joint with several.
        constant : float, optional
            Default: the value at the start.
        starts_on : bool, optional
            See `add_loop_joint`.

        Raises
        ------
        ModelError
            If a joint has no coordinate that can be coupled, or a coefficient is not finite.

        Examples
        --------
        Two wheels of 10 and 30 teeth with opposite rotations: ``scene.add_gear("pair", {small: 10, large: 30})``.
        """
        label = f"gear {name!r}"
        self._check_new(name, label, starts_on)
        if not isinstance(coefficients, Mapping) or not coefficients:
            raise ModelError(f"{label} takes a dict of bodies and coefficients, such as {{small: 10, large: 30}}")
        self._add_coupler(name, "gear", label, coefficients, constant, starts_on)

    def add_rack(self, name: str, pinion: Frame, rack: Frame, radius: float, *, starts_on: bool | None = None) -> None:
        """Couple a pinion and a rack: the rack's distance increases by radius times the pinion's angle.

        Parameters
        ----------
        name : str
            Unique among the scene's constraints.
        pinion, rack : Frame
            Bodies on a revolute and on a prismatic joint.
        radius : float
            Radius of the pinion's pitch circle, m; negative if the rack moves in the opposite direction.
        starts_on : bool, optional
            See `add_loop_joint`.

        Raises
        ------
        ModelError
            If the joints are of other kinds, or the radius is zero.
        """
        label = f"rack {name!r}"
        self._check_new(name, label, starts_on)
        if not np.isfinite(numbers(radius)).all() or numbers(radius).shape != () or radius == 0:
            raise ModelError(f"radius of {label} must be a length in m other than zero, not {radius!r}")
        for what, frame, unit in (("pinion", pinion, "[rad]"), ("rack", rack, "[m]")):
            joint = self._joint_of(frame, f"{what} of {label}")
            if len(joint.coordinate_names) != 1 or unit not in joint.coordinate_names[0]:
                kind = "revolute" if what == "pinion" else "prismatic"
                raise ModelError(f"the {what} of {label} is on a {joint.kind} joint. Remedy: a {kind} one")
        self._add_coupler(name, "rack", label, {rack: 1.0, pinion: -float(radius)}, None, starts_on)

    def add_rolling_wheel(
        self, name: str, wheel: Frame, radius: float, plane: Frame | None = None, *, starts_on: bool | None = None
    ) -> None:
        """Let a thin wheel roll on a plane, without slip and always in contact.

        Parameters
        ----------
        name : str
            Unique among the scene's constraints.
        wheel : Frame
            Its origin is the hub, its z axis the axle.
        radius : float
            m.
        plane : Frame, optional
            Frame whose plane z = 0 the wheel rolls on, above it; default: the ground.
        starts_on : bool, optional
            See `add_loop_joint`.

        Raises
        ------
        ModelError
            If the radius is not above zero, or a frame is not of this scene.

        Examples
        --------
        A disc that rolls upright along x, its axle along -y: see ``tests/kane/test_rolling.py``.
        """
        self._add_rolling(name, "rolling wheel", wheel, radius, plane, starts_on, is_ball=False)

    def add_rolling_ball(
        self, name: str, ball: Frame, radius: float, plane: Frame | None = None, *, starts_on: bool | None = None
    ) -> None:
        """Let a ball roll on a plane, without slip and always in contact; arguments: `add_rolling_wheel`."""
        self._add_rolling(name, "rolling ball", ball, radius, plane, starts_on, is_ball=True)

    def _add_rolling(
        self,
        name: str,
        kind: str,
        body: Frame,
        radius: float,
        plane: Frame | None,
        starts_on: bool | None,
        *,
        is_ball: bool,
    ) -> None:
        from kanefe.constraints.rows import FIRST, NORMAL, SECOND, Constraint, RollingRow

        label = f"{kind} {name!r}"
        self._check_new(name, label, starts_on)
        size = _positive(radius, f"radius of {label}", "give it in m")
        a, b = self._ends(
            self.ground if plane is None else plane, body, label, needs_rotation=True, called=("plane", "body")
        )
        rows = tuple(
            RollingRow(text, a, b, size, direction, is_ball)
            for text, direction in (("contact", NORMAL), ("slip along x", FIRST), ("slip along y", SECOND))
        )
        self._constraints.append(Constraint(name, kind, rows, a, b, (), starts_on))

    def _add_coupler(
        self,
        name: str,
        kind: str,
        label: str,
        coefficients: Mapping[Frame | tuple[Frame, int], float],
        constant: float | None,
        starts_on: bool | None,
    ) -> None:
        from kanefe.constraints.rows import METRE, RADIAN, Constraint, CouplerRow

        terms, start, unit = [], 0.0, RADIAN
        for key, coefficient in coefficients.items():
            frame, coordinate = key if isinstance(key, tuple) else (key, 0)
            joint = self._joint_of(frame, label)
            count = len(joint.coordinate_names)
            if count == 0 or count != len(joint.speed_names):
                raise ModelError(
                    f"{label}: the {joint.kind} joint of {frame.name!r} has no coordinate that can be coupled. "
                    "Remedy: a joint with axes, such as a revolute one"
                )
            if not isinstance(key, tuple) and count > 1:
                raise ModelError(
                    f"{label}: the {joint.kind} joint of {frame.name!r} has {count} coordinates. "
                    f"Remedy: (body, number) for one of {', '.join(joint.coordinate_names)}"
                )
            if not isinstance(coordinate, int) or not 0 <= coordinate < count:
                raise ModelError(f"{label}: {coordinate!r} is not one of the {count} coordinates of {frame.name!r}")
            value = numbers(coefficient)
            if value.shape != () or not np.isfinite(value) or value == 0:
                raise ModelError(f"{label}: the coefficient of {frame.name!r} must be a number other than zero")
            terms.append((frame.number, coordinate, float(value)))
            start += float(value) * joint_start(joint, coordinate)
            unit = METRE if "[m]" in joint.coordinate_names[coordinate] else unit
        if constant is not None and not np.isfinite(numbers(constant)):
            raise ModelError(f"{label}: constant must be finite, not {constant!r}")
        row = CouplerRow("coordinates", tuple(terms), start if constant is None else float(constant), unit)
        self._constraints.append(Constraint(name, kind, (row,), starts_on=starts_on))

    def _check_new(self, name: object, label: str, starts_on: object) -> None:
        self._check_open(label)
        if starts_on is not None and not isinstance(starts_on, (bool, np.bool_)):
            raise ModelError(f"starts_on of {label} must be True, False or None, not {starts_on!r}")
        if not isinstance(name, str) or not name or "/" in name:
            raise ModelError(f"the name of a constraint must be a text without '/', not {name!r}")
        if any(constraint.name == name for constraint in self._constraints):
            raise ModelError(f"the scene already has a constraint called {name!r}. Remedy: another name")

    def _ends(
        self,
        a: Frame,
        b: Frame,
        label: str,
        *,
        needs_rotation: bool,
        called: tuple[str, str] = ("end a", "end b"),
    ) -> tuple[Marker, Marker]:
        first, second = (
            self._marker(frame, f"{what} of {label}", needs_rotation=needs_rotation)
            for what, frame in zip(called, (a, b), strict=True)
        )
        is_one_rigid = first.interface is None and second.interface is None
        if first.body == second.body and (is_one_rigid or a.interface_frame is b.interface_frame):
            raise ModelError(f"both ends of {label} are on {a.name!r}: nothing moves between them. Remedy: two bodies")
        return first, second

    def _joint_of(self, frame: object, label: str) -> Joint:
        given = self._check_frame(frame, label)
        if given.number < 0:
            raise ModelError(f"{label}: the ground has no joint. Remedy: a body")
        return self._entries[given.number].joint


def joint_start(joint: Joint, coordinate: int) -> float:
    """Return a coordinate of a joint at t = 0, from its start or from the motion that drives it."""
    motion = joint.motions[coordinate]
    return float(joint.initial_coordinates()[coordinate] if motion is None else motion.position(0.0))


def _check_plain(joint: Joint, label: str) -> None:
    """Raise a ModelError if a joint that closes a loop has a motion, a start or forces."""
    if any(motion is not None for motion in driven(joint).motions):
        raise ModelError(f"{label} cannot be driven by a motion. Remedy: drive a joint of the tree, close another one")
    # Euler parameters of opposite signs are the same rotation
    has_start = bool(np.any(abs(joint.initial_coordinates()) != joint.home()) or joint.initial_speeds().any())
    if type(joint).given_start is not Joint.given_start:  # otherwise nobody said that a zero is one
        has_start = has_start or any(map(any, joint.given_start()))
    has_forces = (
        joint.friction is not None
        or joint.armature > 0.0
        or any(force is not None for force in joint.coordinate_forces)
    )
    if has_start or has_forces:
        raise ModelError(
            f"{label} has a start or forces of its own. Remedy: leave them out: its start follows from the loop, and "
            "springs act between any two frames with add_spring and add_bushing; friction is of joints of the tree"
        )


def _positive(value: object, what: str, remedy: str) -> float:
    array = numbers(value)
    if array.shape != () or not np.isfinite(array) or array <= 0:
        raise ModelError(f"{what} must be above zero m, not {value!r}. Remedy: {remedy}")
    return float(array)
