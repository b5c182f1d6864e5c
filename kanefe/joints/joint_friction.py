"""Dry friction in a joint from the joint's own load: its parameters, and the part of a reaction that loads it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kernels.force_elements.coordinate_friction import PADS, THREAD, load_of


@dataclass(frozen=True)
class JointFriction:
    """Coulomb's friction in a joint, as large as the joint is loaded: ``mu n``, with n from the joint's reaction.

    With F and M the force and moment of the reaction about the origin of the body's frame, a the joint's axis, and
    what is across it marked _|_, the load n and the friction are

    - revolute: two bearings at ``+-length/2`` along the axis, ``n = |F_|_/2 + M x a/length| + |F_|_/2 - M x a/length|``
      (without `length` ``n = |F_|_|``), and ``collar/radius |F . a|`` more where a collar takes thrust; a torque
      ``mu radius n``.
    - prismatic: two pads at ``+-length/2``, the same n, and ``|M . a|/radius`` more where a `radius` is given, half the
      width of the rail; a force ``mu n``.
    - cylindrical: the same two bearings; a force ``mu n`` against the sliding of the surface, whose velocity is v along
      the axis and ``radius w`` round it.
    - screw: the normal force of a thread of that radius under the thrust ``F . a``; it holds a load by itself where mu
      is above the tangent of its lead angle, ``lead / (2 pi radius)``. Side loads are taken to be borne elsewhere.
    - spherical: ``n = |F|``; a torque ``mu radius n`` against the angular velocity.

    It sticks as `CoordinateForce` and `Coulomb` do: the surface hangs on the spring and damper of an anchor, which
    moves only when it slips, and nothing creeps. ``result.load("friction of <body>")`` tells force, stretch, whether it
    sticks, how fast it slips and n; ``result.events["<body> slip"]`` and ``["<body> stick"]`` when that changed.

    The reaction depends on the accelerations, these on friction, and friction on the reaction. The load that friction
    feels therefore follows n through a filter of second order with the time T of `load_time`: it differs by
    ``-T^2 d^2n/dt^2``, nothing where a load is steady or changes at a steady rate, and it starts as that of the start.

    Parameters
    ----------
    mu : float
        Coefficient while it slips.
    radius : float, optional
        Of the surface that rubs, m; a prismatic joint does without.
    static : float, optional
        Coefficient at which it begins to slip; default: the same.
    stribeck_speed : float, optional
        Speed of the surface in which friction falls from static to mu, m/s: ``mu + (static - mu) exp(-(s/speed)^2)``
        at a slip speed s; default: at once. Not of a screw, whose load follows from its friction.
    length : float, optional
        Between two bearings or pads, m; default: moments across the axis load nothing.
    collar : float, optional
        Mean radius of the collar of a revolute joint that takes thrust, m; default: thrust loads nothing.
    preload : float
        Load that is there always, N: of a press fit, a seal, a tightened nut.
    stiffness : float, optional
        Of the anchor's spring at the surface, N/m; default: the static friction under the load of the start, or under
        the weight that the joint carries where that is more, over 1e-7 of the scene's length (over a turn of 1e-7 rad
        where that is less): a tenth of what a run at the default tolerance resolves.
    damping : float, optional
        N s/m; default: what is critical for the inertia that the surface moves at the start.
    load_time : float, optional
        T, s; default: ``sqrt(m/k)`` of that inertia and stiffness, in which the anchor itself gives way.

    Raises
    ------
    ModelError
        If a number is negative or not finite, `static` is below `mu`, or there is none that it could fall from.

    Examples
    --------
    A wheel of 2 kg that coasts on a journal bearing of 1 cm:

    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> axle = kf.Revolute("y", speed=10.0, friction=kf.JointFriction(mu=0.1, radius=0.01))
    >>> wheel = scene.add_rigid_body("wheel", 2.0, 0.02, joint=axle)
    >>> result = scene.simulate((0.0, 1.0))
    >>> round(float(result.joint_speeds("wheel")[-1, 0] - 10.0), 2)  # -mu m g radius / inertia
    -0.98
    """

    mu: float
    radius: float | None = None
    static: float | None = None
    length: float | None = None
    collar: float | None = None
    preload: float = 0.0
    stiffness: float | None = None
    damping: float | None = None
    load_time: float | None = None
    stribeck_speed: float | None = None

    def __post_init__(self) -> None:
        for name in ("mu", "preload"):
            value = numbers(getattr(self, name))
            if value.shape != () or not np.isfinite(value) or value < 0.0:
                raise ModelError(f"{name} of JointFriction must be one number, finite and >= 0, not {value!r}")
        for name in ("radius", "static", "length", "collar", "stiffness", "damping", "load_time", "stribeck_speed"):
            given = getattr(self, name)
            value = numbers(1.0 if given is None else given)
            if value.shape != () or not np.isfinite(value) or value <= 0.0:
                raise ModelError(f"{name} of JointFriction must be one number, finite and > 0, not {given!r}")
        if self.static is not None and self.static < self.mu:
            raise ModelError(f"static of JointFriction, {self.static:g}, is below mu, {self.mu:g}. Remedy: the larger")
        if self.stribeck_speed is not None and (self.static or 0.0) <= self.mu:
            raise ModelError("stribeck_speed of JointFriction needs a `static` above mu to fall from")


@dataclass(frozen=True, eq=False)
class RubbingSurfaces:
    """How friction in a joint takes its load from the reaction, and where it acts.

    Attributes
    ----------
    arms : tuple of float
        Slip of the surface over each speed of the joint: 1, or m/rad.
    kind : float
        PADS, BALL or THREAD.
    axis : ndarray, shape (3,)
        In the axes of the body's frame.
    per_length : float
        Of two pads, 1/m; 0: moments do not count.
    thrust, twist : float
        Load over the force along the axis and over the moment about it (1/m); of a thread over the drag.
    """

    arms: tuple[float, ...]
    kind: float
    axis: Vector
    per_length: float = 0.0
    thrust: float = 0.0
    twist: float = 0.0

    @property
    def has_moment(self) -> bool:
        """Whether moments of the reaction count."""
        return self.kind == PADS and (self.per_length > 0.0 or self.twist > 0.0)

    def load(self, wrench: Vector, drag: float) -> float:
        """Return n (N) of a reaction (6,), in axes of the body's frame about its origin, and the drag of a thread."""
        law = self.kind, self.per_length, self.thrust, self.twist
        axis, force, moment = (tuple(part) for part in (self.axis, wrench[:3], wrench[3:]))
        return float(load_of(law, axis, force, moment, drag))


class Wanted(NamedTuple):
    """Which lengths of a `JointFriction` a kind of joint needs, and which it has no use for."""

    needs: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()


def check_friction(friction: object, kind: str, wanted: Wanted) -> None:
    """Raise a ModelError if what a joint of some kind is given is no friction that it can have."""
    if friction is None:
        return
    if not isinstance(friction, JointFriction):
        raise ModelError(f"friction of a {kind} joint must be a JointFriction, not {friction!r}")
    for name in wanted.needs:
        if getattr(friction, name) is None:
            raise ModelError(
                f"friction of a {kind} joint needs the {name} of the sliding surface, m. Remedy: {name}=..."
            )
    for name in wanted.lacks:
        if getattr(friction, name) is not None:
            raise ModelError(f"friction of a {kind} joint has no use for {name}={getattr(friction, name)!r}")


def pads(
    friction: JointFriction, axis: Vector, arms: tuple[float, ...], thrust: float, twist: float
) -> RubbingSurfaces:
    """Return two bearings or pads along an axis."""
    return RubbingSurfaces(arms, PADS, axis, 1.0 / friction.length if friction.length else 0.0, thrust, twist)


def thread(radius: float, lead: float, axis: Vector) -> RubbingSurfaces:
    """Return a thread, of its radius and lead a turn, m.

    Its flank is inclined by ``tan b = lead / (2 pi radius)``: the surface slips by ``radius / cos b`` a radian, and the
    normal force is ``|F . a / cos b + D tan b|``: what rises against a drag D is pressed down by it.
    """
    rise = lead / (2.0 * math.pi)
    slip = math.hypot(radius, rise)
    return RubbingSurfaces((slip,), THREAD, axis, thrust=slip / radius, twist=rise / radius)
