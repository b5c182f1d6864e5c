"""The rows of a loop joint: from the constraints of a joint to equations between two markers."""

from __future__ import annotations

import numpy as np

from kanefe import joints
from kanefe.bodies.marker import Marker
from kanefe.constraints.rows import DirectionRow, PointRow, Row, ScrewRow
from kanefe.errors import ModelError
from kanefe.frames import Vector, across
from kanefe.joints import Held, Joint

AXES = np.eye(3)


def held_by(joint: Joint) -> Held:
    """Return the constraints of a joint that closes a loop.

    Raises
    ------
    ModelError
        If the kind of joint cannot close a loop.
    """
    held = joint.held()
    if held is None:
        raise ModelError(f"a {joint.kind} joint cannot close a loop. Remedy: one of {', '.join(_closing_kinds())}")
    return held


def loop_joint_rows(joint: Joint, a: Marker, b: Marker) -> tuple[Row, ...]:
    """Return the rows that hold marker b on marker a like the joint: one for each motion that it prevents.

    The axes of the joint have the same components in a's and in b's axes.

    Raises
    ------
    ModelError
        If the kind of joint cannot close a loop.
    """
    held = held_by(joint)
    rows: list[Row] = [PointRow(f"position along {_named(e)}", a, b, e) for e in held.along]
    if held.parallel is not None:
        axis, sides = held.parallel, across(held.parallel)
        rows += [DirectionRow(f"tilt of axis {_named(axis)} towards {_named(e)}", a, b, e, axis) for e in sides]
        if held.is_aligned:
            rows.append(DirectionRow(f"turn about {_named(axis)}", a, b, *sides))
    if held.angle is not None:
        first, second = held.angle
        rows.append(DirectionRow("angle between the axes", a, b, first, second, float(first @ second)))
    if held.thread is not None:
        axis, lead = held.thread
        rows.append(ScrewRow(f"advance on the thread {_named(axis)}", a, b, axis, across(axis)[0], lead))
    return tuple(rows)


def _named(direction: Vector) -> str:
    for name, axis in zip("xyz", AXES, strict=True):
        if abs(direction @ axis) > 1.0 - 1e-12:
            return name
    return "(" + ", ".join(f"{c:.3g}" for c in direction) + ")"


def _closing_kinds() -> list[str]:
    """Return the names of the joints that close loops."""
    kinds = {name: getattr(joints, name) for name in joints.__all__}
    return [name for name, kind in kinds.items() if issubclass(kind, Joint) and kind.held is not Joint.held]
