"""Checks of joints of users: their parts, and the consistency of pose, velocities, remainders and links."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, axial, axis_rotation, cross, numbers, rotation_matrix, shaped_numbers
from kanefe.joints.base import Joint
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import Held
from kanefe.joints.link import Link, LinkKernel, LinkMotion, motion_in
from kanefe.joints.motion import Motion
from kanefe.kernels.compiler.addresses import addresses, call_in_python
from kanefe.kernels.compiler.foreign import check_functions
from kanefe.kernels.links.places import SIGNATURE, WrittenMotion

Motions = tuple[Vector, Matrix, Vector, Vector]
"""Position, rotation, velocity and angular velocity of M seen from F, in components of F."""

OWN = f"{__package__}."

AWAY = 0.1
"""Distance from the start at which a joint is checked again, m or rad, since an error may vanish at the start."""

STEP = 1e-6
"""Step of central differences, m or rad."""

SHARE, LEAST = 0.01, 1e-6
"""Largest deviation from differences, relative to a rate and to the scale of what changes: far below a wrong sign or
factor 2, and above the error of differences of motions with features of a millimetre."""

SAME = 1e-6
"""Largest deviation of a link from the joint, relative to 1 m or rad or to the larger number: tables of both may differ
by this."""


def check_joint(joint: object, label: str) -> Joint:
    """Return the joint, or raise a ModelError that names a missing part or a contradiction.

    Joints of this package are not checked here, but by their tests.
    """
    if not isinstance(joint, Joint):
        raise ModelError(f"{label} must be a Joint, such as Revolute('z'), not {joint!r}{_lacks(joint)}")
    if type(joint).__module__.startswith(OWN):
        return joint
    label = f"{label} ({type(joint).__name__})"
    _check_names(joint, label)
    q0 = shaped_numbers(joint.initial_coordinates(), (len(joint.coordinate_names),), f"initial_coordinates of {label}")
    count = len(joint.speed_names)
    shaped_numbers(joint.initial_speeds(), (count,), f"initial_speeds of {label}")
    given: object = joint.given_start()
    if not (isinstance(given, tuple) and len(given) == 2 and all(_are_bools(one, count) for one in given)):
        raise ModelError(
            f"given_start() of {label} must give a tuple of two lists, each of {count} times True or False: which "
            f"coordinates and which speeds are given; not {given!r}"
        )
    for what, given, kind in (
        ("motions", joint.motions, Motion),
        ("coordinate_forces", joint.coordinate_forces, CoordinateForce),
    ):
        if len(given) != count or not all(x is None or isinstance(x, kind) for x in given):
            raise ModelError(f"{what} of {label} must be {count} of {kind.__name__} or None, not {given!r}")
    held: object = joint.held()
    if held is not None and not isinstance(held, Held):
        raise ModelError(f"held() of {label} must give a kanefe.Held or None, not {held!r}")
    u = 0.5 + np.arange(count) / max(count, 1)  # no component is zero, and no two are the same
    low, high = _checked_ranges(joint, label, q0)
    links = _checked_links(joint, label)
    for q in (q0, joint.advance(q0, AWAY * u)):
        q = np.clip(q, low, high)  # keeps differences within the range
        motion = _check_motion(joint, label, q, u)
        if links is not None:
            _check_links(links, f"{label} at q = {q.tolist()}", q, u, motion)
    return joint


def _are_bools(flags: object, count: int) -> bool:
    return isinstance(flags, (list, tuple)) and len(flags) == count and all(isinstance(one, bool) for one in flags)


def _lacks(joint: object) -> str:
    """Return the remedy, as the rest of a message, if a class was given instead of an object of it."""
    if not isinstance(joint, type) or not issubclass(joint, Joint):
        return ""
    missing = ", ".join(sorted(joint.__abstractmethods__))
    return f", the class itself. Remedy: an object of it{f', after it has {missing}' if missing else ''}"


def _check_names(joint: Joint, label: str) -> None:
    coordinates, speeds, at = joint.coordinate_names, joint.speed_names, joint.rotation_at
    for what, names, units in (
        ("coordinate_names", coordinates, ("[m]", "[rad]")),
        ("speed_names", speeds, ("[m/s]", "[rad/s]")),
    ):
        of_rotation = range(at, at + 4) if at is not None and what == "coordinate_names" else ()
        if not isinstance(names, tuple) or not all(
            isinstance(name, str) and (i in of_rotation or name.endswith(units)) for i, name in enumerate(names)
        ):
            raise ModelError(f"{what} of {label} must be a tuple of texts that end in {' or '.join(units)}: {names!r}")
    if len(coordinates) != len(speeds) + (at is not None):
        rule = "one for each speed" if at is None else "one for each speed, and a fourth Euler parameter"
        raise ModelError(
            f"{label} has {len(coordinates)} coordinates and {len(speeds)} speeds; it must have {rule}. "
            "Remedy: coordinate_names, speed_names, rotation_at"
        )


def _check_motion(joint: Joint, label: str, q: Vector, u: Vector) -> Motions:
    """Return the motion at q with speeds u, or raise a ModelError if the functions of the joint are not consistent."""
    count, where = len(u), f"{label} at q = {q.tolist()}"
    p, axes = _pose(joint, q, where)
    V_, W_ = (
        shaped_numbers(x, (3, count), f"{n} of {where}") for n, x in zip("VW", joint.partial_velocities(q), strict=True)
    )
    Z, Y = (shaped_numbers(x, (3,), f"{n} of {where}") for n, x in zip("ZY", joint.remainders(q, u), strict=True))
    for i in range(count):
        step = STEP * np.eye(count)[i]
        back, ahead = (_pose(joint, joint.advance(q, way * step), where) for way in (-1.0, 1.0))
        turned = -0.5 * axial((ahead[1] - back[1]) @ axes.T)
        _check_rate(f"column {i} of V of {where}", V_[:, i], ahead[0] - back[0], p, "the position of pose() changes")
        _check_rate(f"column {i} of W of {where}", W_[:, i], turned, np.zeros(3), "the rotation of pose() changes")
    back_q, ahead_q = joint.advance(q, -STEP * u), joint.advance(q, STEP * u)
    rates = shaped_numbers(joint.coordinate_rates(q, u), q.shape, f"coordinate_rates of {where}")
    _check_rate(f"coordinate_rates of {where}, u = {u.tolist()}", rates, ahead_q - back_q, q, "advance() moves q")
    back, ahead = joint.partial_velocities(back_q), joint.partial_velocities(ahead_q)
    at = f"of remainders() of {where}, u = {u.tolist()},"
    _check_rate(f"Z {at}", Z, (ahead[0] - back[0]) @ u, V_ @ u, "V u changes")
    _check_rate(f"Y {at}", Y, (ahead[1] - back[1]) @ u, W_ @ u, "W u changes")
    return p, axes, V_ @ u, W_ @ u


def _pose(joint: Joint, q: Vector, where: str) -> tuple[Vector, Matrix]:
    p, axes = joint.pose(q)
    p, axes = (
        shaped_numbers(p, (3,), f"the position of {where}"),
        shaped_numbers(axes, (3, 3), f"the rotation of {where}"),
    )
    if abs(axes.T @ axes - np.eye(3)).max() > SAME or np.linalg.det(axes) < 0.0:
        raise ModelError(f"the rotation of {where} is not a rotation matrix: {axes.tolist()}")
    return p, axes


def _check_rate(what: str, given: Vector, change: Vector, value: Vector, but: str) -> None:
    """Raise a ModelError if a rate is not the change of a value from -STEP to STEP."""
    found = change / (2 * STEP)
    allowed = SHARE * np.maximum(np.abs(found), np.abs(given)) + LEAST * (1.0 + np.abs(value))
    if not np.all(np.abs(found - given) <= allowed):
        raise ModelError(f"{what} is {given.tolist()}, but {but} by {found.tolist()}. Remedy: make the two agree")


def _checked_ranges(joint: Joint, label: str, q: Vector) -> tuple[Vector, Vector]:
    """Return the ranges in which the coordinates are checked."""
    low, high = np.full(len(q), -np.inf), np.full(len(q), np.inf)
    ranges: Any = joint.ranges
    if not isinstance(ranges, tuple) or len(ranges) != len(joint.speed_names):
        raise ModelError(f"ranges of {label} must be {len(joint.speed_names)} of (low, high) or None, not {ranges!r}")
    for i, ends in enumerate(ranges):
        if ends is None:
            continue
        given = numbers(ends)
        if given.shape != (2,) or not given[0] < given[1] or joint.rotation_at is not None:
            raise ModelError(
                f"ranges of {label} must be of a smaller and a larger number, of a joint without Euler parameters: "
                f"{ranges!r}"
            )
        low[i], high[i] = given + np.array((2 * STEP, -2 * STEP))
        if not given[0] <= q[i] <= given[1]:
            raise ModelError(f"{label} starts at q = {q.tolist()}, out of its ranges {ranges!r}. Remedy: within them")
    return low, high


def _checked_links(joint: Joint, label: str) -> tuple[Link, ...] | None:
    links: Any = joint.links()
    if links is None:
        return None
    if not isinstance(links, tuple) or not all(isinstance(link, Link) for link in links):
        raise ModelError(f"links() of {label} must give a tuple of kanefe.Link or None, not {links!r}")
    counts = sum(link.coordinate_count for link in links), sum(link.speed_count for link in links)
    wanted = len(joint.coordinate_names), len(joint.speed_names)
    if counts != wanted:
        raise ModelError(
            f"the links of {label} have {counts[0]} coordinates and {counts[1]} speeds, the joint has {wanted[0]} and "
            f"{wanted[1]}. Remedy: links() of as many"
        )
    for kernel in (link.kernel for link in links if link.is_given):
        if not isinstance(kernel, LinkKernel):
            raise ModelError(f"a given link of {label} takes a kanefe.LinkKernel, not {kernel!r}")
        check_functions((kernel.real, kernel.complex_), f"a link of {label}")
        shaped_numbers(kernel.numbers, np.shape(kernel.numbers)[:1], f"numbers of a link of {label}")
    return links


def _check_links(links: tuple[Link, ...], where: str, q: Vector, u: Vector, motion: Motions) -> None:
    """Raise a ModelError if the motion of the chain of links is not that of the joint."""
    p, axes, v, w = np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)
    for link in links:
        own_q, q = np.split(q, (link.coordinate_count,))
        own_u, u = np.split(u, (link.speed_count,))
        position, turned, velocity, spin = _motion_of(link, own_q, own_u, where)
        lever = axes @ position
        p, v = p + lever, v + cross(w, lever) + axes @ velocity
        w, axes = w + axes @ spin, axes @ turned
    for what, found, wanted in zip(("position", "rotation", "V u", "W u"), (p, axes, v, w), motion, strict=True):
        if not np.allclose(found, wanted, rtol=SAME, atol=SAME):
            raise ModelError(
                f"the links of {where} give the {what} {found.tolist()}, the joint {wanted.tolist()}. "
                "Remedy: make the two agree"
            )


def _motion_of(link: Link, q: Vector, u: Vector, where: str) -> Motions:
    """Return the motion of a link's frame seen from the frame before it."""
    p, axes, v, w = np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)
    if link.is_given:
        out, back, ahead = (_outputs(link, q[0] + step, where) for step in (0.0, -STEP, STEP))
        for what in "VW":
            first, here, last = (getattr(motion, what) for motion in (back, out, ahead))
            label = f"d{what}/dq of a link of {where}"
            _check_rate(label, getattr(out, f"d{what}"), last - first, here, f"{what} changes")
        p, axes, v, w = out.p, out.A, u * out.V, u * out.W
    elif link.speed_count == 1:
        p, v, w = link.along * q * link.axis, link.along * u * link.axis, link.about * u * link.axis
        axes = axis_rotation(link.axis, link.about * q[0])
    elif not link.is_fixed:
        axes = rotation_matrix(q[-4:])
        w = axes @ u[-3:]
        if link.is_free:
            p, v = q[:3], u[:3]
    return p, axes, v, w


def _outputs(link: Link, q: float, where: str) -> LinkMotion:
    """Return the output of the function of a given link."""
    kernel = cast(LinkKernel, link.kernel)
    out = np.zeros(WrittenMotion.number_count)
    real, _ = addresses(kernel.real, None, SIGNATURE)
    call_in_python(real, (np.array(kernel.numbers, dtype=float), np.array((q,)), out))
    return motion_in(shaped_numbers(out, out.shape, f"what the function of a link of {where} writes"))
