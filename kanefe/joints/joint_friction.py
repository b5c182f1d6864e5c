"""Dry friction in a joint that is proportional to its load: parameters, and the load from the joint's reaction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from kanefe.arguments import plain_numbers
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kernels.force_elements.coordinate_friction import PADS, THREAD, load_of
from kanefe.kernels.values import tensors


@dataclass(frozen=True)
class JointFriction:
    """Coulomb friction in a joint, proportional to its load: ``mu n``, with n from the joint's reaction.

    With F and M the force and moment of the reaction about the origin of the body's frame, a the joint's axis, and _|_
    for components perpendicular to it, the load n and the friction are

    - revolute: two bearings at ``+-length/2`` along the axis, ``n = |F_|_/2 + M x a/length| + |F_|_/2 - M x a/length|``
      (without `length` ``n = |F_|_|``), plus ``collar/radius |F . a|`` if a collar takes thrust; a torque
      ``mu radius n``.
    - prismatic: two pads at ``+-length/2``, the same n, plus ``|M . a|/radius`` with a `radius`, half the width of the
      rail; a force ``mu n``.
    - cylindrical: the same two bearings; a force ``mu n`` against the sliding of the surface, whose velocity is v along
      the axis and ``radius w`` around it.
    - screw: the normal force of a thread of that radius under the thrust ``F . a``; it is self-locking if mu is above
      the tangent of its lead angle, ``lead / (2 pi radius)``. Side loads are assumed to act elsewhere.
    - spherical: ``n = |F|``; a torque ``mu radius n`` against the angular velocity.

    It sticks like `CoordinateForce` and `Coulomb`: a spring and damper connect the surface to an anchor, which moves
    only when it slips, without creep. ``result.load("friction of <body>")`` has force, stretch, whether it sticks, the
    slip speed and n; ``result.events["<body> slip"]`` and ``["<body> stick"]`` have the times of changes.

    The reaction depends on the accelerations, these on friction, and friction on the reaction. Friction therefore uses
    n through a filter of second order with the time T of `load_time`: the error is ``-T^2 d^2n/dt^2``, zero for a load
    that is constant or changes at a constant rate. It starts at the load of the start.

    Parameters
    ----------
    mu : float
        Coefficient of kinetic friction.
    radius : float, optional
        Radius of the sliding surface, m; optional for a prismatic joint.
    static : float, optional
        Coefficient of static friction; default: `mu`.
    stribeck_speed : float, optional
        Speed over which friction falls from static to mu, m/s: ``mu + (static - mu) exp(-(s/speed)^2)`` at a slip speed
        s; default: at once. Not for a screw, whose load depends on its friction.
    length : float, optional
        Distance of two bearings or pads, m; default: moments across the axis are neglected.
    collar : float, optional
        Mean radius of the collar of a revolute joint that takes thrust, m; default: thrust is neglected.
    preload : float
        Constant load, N: of a press fit, a seal, a tightened nut.
    stiffness : float, optional
        Stiffness of the anchor's spring at the surface, N/m; default: the static friction under the load at the start,
        or under the weight that the joint carries if that is more, over 1e-7 of the scene's length (or a rotation by
        1e-7 rad if that is less): a tenth of what a run at the default tolerance resolves.
    damping : float, optional
        N s/m; default: critical damping for the inertia that the surface moves at the start.
    load_time : float, optional
        T, s; default: ``sqrt(m/k)`` of that inertia and stiffness, the time constant of the anchor itself.

    Raises
    ------
    ModelError
        If a number is negative or not finite, `static` is below `mu`, or `stribeck_speed` is given without `static`
        above `mu`.

    Examples
    --------
    A wheel of 2 kg that coasts on a journal bearing with a radius of 1 cm:

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
            given = getattr(self, name)
            value = numbers(given)
            if value.shape != () or not np.isfinite(value) or value < 0.0:
                raise ModelError(f"{name} of JointFriction must be one number, finite and >= 0, not {given!r}")
        for name in ("radius", "static", "length", "collar", "stiffness", "damping", "load_time", "stribeck_speed"):
            given = getattr(self, name)
            value = numbers(1.0 if given is None else given)
            if value.shape != () or not np.isfinite(value) or value <= 0.0:
                raise ModelError(f"{name} of JointFriction must be one number, finite and > 0, not {given!r}")
        if self.static is not None and self.static < self.mu:
            raise ModelError(
                f"static of JointFriction, {float(self.static):g}, is below mu, {float(self.mu):g}. Remedy: the larger"
            )
        if self.stribeck_speed is not None and (self.static or 0.0) <= self.mu:
            raise ModelError("stribeck_speed of JointFriction needs a `static` above mu to fall from")
        plain_numbers(self)


@dataclass(frozen=True, eq=False)
class RubbingSurfaces:
    """The relation of friction in a joint to its reaction, and the surface on which it acts.

    Attributes
    ----------
    arms : tuple of float
        Slip speed of the surface per speed of the joint: 1, or m/rad.
    kind : float
        PADS, BALL or THREAD.
    axis : ndarray, shape (3,)
        In the axes of the body's frame.
    per_length : float
        One over the distance of two pads, 1/m; 0: moments are neglected.
    thrust, twist : float
        Load per force along the axis and per moment about it (1/m); for a thread per friction force.
    """

    arms: tuple[float, ...]
    kind: float
    axis: Vector
    per_length: float = 0.0
    thrust: float = 0.0
    twist: float = 0.0

    @property
    def has_moment(self) -> bool:
        """Whether the load depends on moments of the reaction."""
        return self.kind == PADS and (self.per_length > 0.0 or self.twist > 0.0)

    def load(self, wrench: Vector, drag: float) -> float:
        """Return n (N) from a reaction (6,), in axes of the body's frame about its origin, and the drag of a thread."""
        axis, force, moment = (tensors.Vector(*part) for part in (self.axis, wrench[:3], wrench[3:]))
        return float(load_of(cast(Any, self), axis, force, moment, drag))


class Wanted(NamedTuple):
    """Names of the numbers of a `JointFriction` that a kind of joint needs, and of those that it does not use."""

    needs: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()


def check_friction(friction: object, kind: str, wanted: Wanted) -> None:
    """Raise a ModelError if a kind of joint cannot have this friction."""
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

    Its flank is inclined by ``tan b = lead / (2 pi radius)``: the surface slips by ``radius / cos b`` per radian, and
    the normal force is ``|F . a / cos b + D tan b|`` with the friction force D.
    """
    rise = lead / (2.0 * math.pi)
    slip = math.hypot(radius, rise)
    return RubbingSurfaces((slip,), THREAD, axis, thrust=slip / radius, twist=rise / radius)
