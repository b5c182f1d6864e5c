"""Which rows close a loop with a joint of each kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.constraints.rows import DirectionRow, PointRow, Row, ScrewRow
from kanefe.errors import ModelError
from kanefe.frames import Vector, cross
from kanefe.joints import (
    Cylindrical,
    Fixed,
    Joint,
    Planar,
    Prismatic,
    Revolute,
    Screw,
    Spherical,
    Translation,
    Universal,
)

AXES = np.eye(3)


def loop_joint_rows(joint: Joint, a: Marker, b: Marker) -> tuple[Row, ...]:
    """Return the rows that hold marker b on marker a as the joint does: one for each motion that it takes.

    The axes of the joint have the same components in a's and in b's axes.

    Raises
    ------
    ModelError
        If the kind of joint takes no motion away.
    """
    for kind, rows in _ROWS.items():
        if isinstance(joint, kind):
            return tuple(rows(joint, a, b))
    raise ModelError(
        f"a {joint.kind} joint cannot close a loop. Remedy: one of {', '.join(kind.__name__ for kind in _ROWS)}"
    )


def facing_directions(joint: Joint) -> tuple[Vector, ...]:
    """Return the directions that a loop joint wants the same in a and b; none where the opposite ones do as well."""
    if isinstance(joint, (Fixed, Translation)):
        return (AXES[0], AXES[2])
    if isinstance(joint, Prismatic):
        return (joint.direction, across(joint.direction)[0])
    return (joint.direction,) if isinstance(joint, Screw) else ()


def across(axis: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors perpendicular to a unit axis and to each other, right-handed with it."""
    first = cross(axis, AXES[int(np.argmin(abs(axis)))])
    first = first / np.linalg.norm(first)
    return first, cross(axis, first)


def _points(a: Marker, b: Marker, directions: Iterable[Vector]) -> list[Row]:
    return [PointRow(f"position along {_named(e)}", a, b, e) for e in directions]


def _parallel(a: Marker, b: Marker, axis: Vector) -> list[Row]:
    """Return the two rows that keep the axis of b parallel to that of a."""
    return [DirectionRow(f"tilt of axis {_named(axis)} towards {_named(e)}", a, b, e, axis) for e in across(axis)]


def _aligned(a: Marker, b: Marker, axis: Vector) -> list[Row]:
    """Return the three rows that keep all axes of b parallel to those of a."""
    first, second = across(axis)
    return [*_parallel(a, b, axis), DirectionRow(f"turn about {_named(axis)}", a, b, first, second)]


def _fixed(joint: Fixed, a: Marker, b: Marker) -> list[Row]:
    return [*_points(a, b, AXES), *_aligned(a, b, AXES[2])]


def _revolute(joint: Revolute, a: Marker, b: Marker) -> list[Row]:
    return [*_points(a, b, AXES), *_parallel(a, b, joint.direction)]


def _prismatic(joint: Prismatic, a: Marker, b: Marker) -> list[Row]:
    return [*_points(a, b, across(joint.direction)), *_aligned(a, b, joint.direction)]


def _cylindrical(joint: Cylindrical, a: Marker, b: Marker) -> list[Row]:
    return [*_points(a, b, across(joint.direction)), *_parallel(a, b, joint.direction)]


def _universal(joint: Universal, a: Marker, b: Marker) -> list[Row]:
    first, second = joint.directions
    keep = DirectionRow("angle between the axes", a, b, first, second, float(first @ second))
    return [*_points(a, b, AXES), keep]


def _spherical(joint: Spherical, a: Marker, b: Marker) -> list[Row]:
    return _points(a, b, AXES)


def _planar(joint: Planar, a: Marker, b: Marker) -> list[Row]:
    return [*_points(a, b, AXES[2:]), *_parallel(a, b, AXES[2])]


def _translation(joint: Translation, a: Marker, b: Marker) -> list[Row]:
    return _aligned(a, b, AXES[2])


def _screw(joint: Screw, a: Marker, b: Marker) -> list[Row]:
    axis = joint.direction
    if joint.lead == 0.0:
        return _revolute(joint, a, b)  # type: ignore[arg-type]
    turn = ScrewRow(f"advance on the thread {_named(axis)}", a, b, axis, across(axis)[0], float(joint.lead))
    return [*_cylindrical(joint, a, b), turn]  # type: ignore[arg-type]


def _named(direction: Vector) -> str:
    for name, axis in zip("xyz", AXES, strict=True):
        if abs(direction @ axis) > 1.0 - 1e-12:
            return name
    return "(" + ", ".join(f"{c:.3g}" for c in direction) + ")"


_ROWS: dict[type[Joint], Callable[..., list[Row]]] = {
    Fixed: _fixed,
    Revolute: _revolute,
    Prismatic: _prismatic,
    Cylindrical: _cylindrical,
    Universal: _universal,
    Spherical: _spherical,
    Planar: _planar,
    Translation: _translation,
    Screw: _screw,
}
