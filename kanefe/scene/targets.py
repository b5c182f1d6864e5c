"""Names of inputs and outputs: ``"<what> <body>[/<interface>] [<axis>]"``, checked against the scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.bodies.segmented import CUT
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.joints import Joint

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

AXES = {"x": 0, "y": 1, "z": 2}

Named = Sequence[str] | Mapping[str, str] | str
"""Names of channels in a script: one, several, or a mapping from names chosen by the user."""


class NamedBody(Protocol):
    """A body of a scene, frozen or not, as far as names of channels refer to it."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def joint(self) -> Joint:
        """Its joint."""
        ...

    @property
    def interfaces(self) -> Sequence[InterfaceFrame]:
        """Its interfaces; a rigid body has none."""
        ...


class Target(NamedTuple):
    """The quantity of a channel: of a body's frame or interface, along an axis or of a coordinate."""

    name: str
    what: str
    body: int
    interface: InterfaceFrame | None
    axis: str


def asked_for(named: Named) -> list[tuple[str, str]]:
    """Return pairs of a name and a text; the name is empty if the script gives none."""
    if isinstance(named, str):
        return [("", named)]
    if isinstance(named, Mapping):
        return [(str(name), text) for name, text in named.items()]
    # an iterable without a length may be endless: it is returned as it is, for the error of the caller
    return [("", text) for text in (named if isinstance(named, Collection) else [named])]


def target_of(bodies: Sequence[NamedBody], name: str, text: object, kinds: Mapping[str, str], role: str) -> Target:
    """Return the target of a text.

    Parameters
    ----------
    bodies : sequence
        Bodies of the scene.
    name : str
        Name in the script; empty: the text itself.
    text : str
    kinds : mapping
        Possible quantities, with their units.
    role : "input" or "output"

    Raises
    ------
    ModelError
        If there is no such quantity, body or interface; the message lists possible ones.
    """
    if not isinstance(text, str):
        raise ModelError(f"an {role} must be a text such as {next(iter(kinds))!r} and a body, not {text!r}")
    what, _, rest = text.strip().partition(" ")
    if what not in kinds:
        raise ModelError(f"{role} {text!r}: there is no {what!r}. Remedy: one of {', '.join(kinds)}")
    rest = rest.strip()
    head, _, last = rest.rpartition(" ")
    failure = ""
    for place, axis in ((rest, ""), (head.strip(), last)):
        body, _, interface = place.partition("/")
        found = [i for i, b in enumerate(bodies) if b.name == body] or _segment_with(bodies, body, interface)
        if not found:
            continue
        if not interface:
            return Target(name or text.strip(), what, found[0], None, axis)
        frames = {frame.name: frame for frame in bodies[found[0]].interfaces}
        if interface in frames:
            return Target(name or text.strip(), what, found[0], frames[interface], axis)
        failure = f"body {body!r} has no interface {interface!r}. It has: {', '.join(frames) or 'none'}"
    listed = ", ".join(body.name for body in bodies)
    raise ModelError(
        f"{role} {text!r}: {failure or f'the scene has no body called {rest!r}. It has: {listed}'}. "
        f"Remedy: '{what} body', '{what} body/interface', or with an axis, '{what} body x'"
    )


def _segment_with(bodies: Sequence[NamedBody], whole: str, interface: str) -> list[int]:
    """Return the number of the segment that has an interface of a segmented body, if there is such a body."""
    if interface.startswith(CUT):
        return []
    return [
        number
        for number, body in enumerate(bodies)
        if body.name.rpartition(" ")[0] == whole
        and {"", interface} < {frame.name for frame in body.interfaces} | {""}
        and any(frame.name.startswith(CUT) for frame in body.interfaces)
    ]


def axes_of(target: Target, role: str) -> list[tuple[str, int, bool]]:
    """Return name, number and whether it is the frame's own, for the axes of a target: one, or all three.

    ``x`` is along N, ``x'`` along the frame's own axes.
    """
    if not target.axis:
        return [(f"{target.name} {axis}", i, False) for axis, i in AXES.items()]
    plain = target.axis.removesuffix("'")
    if plain not in AXES:
        raise ModelError(
            f"{role} {target.name!r}: {target.axis!r} is not an axis. Remedy: x, y or z of N, x', y' or z' of the frame"
        )
    return [(target.name, AXES[plain], target.axis.endswith("'"))]


def axis_vector(target: Target, axes: np.ndarray, role: str) -> list[tuple[str, Vector]]:
    """Return names and directions in N of the axes of a target, with the current axes of the frame."""
    return [(name, axes[:, i] if is_own else np.eye(3)[i]) for name, i, is_own in axes_of(target, role)]


def joint_entry(
    bodies: Sequence[NamedBody], target: Target, role: str, driven: bool | None = False
) -> list[tuple[str, int, str]]:
    """Return name, number and unit of the scalar coordinates of a joint that a target selects.

    `driven` True: among the driven ones; False: among the others; None: among all.
    """
    body = bodies[target.body]
    joint = body.joint
    kind = "" if driven is None else "driven " if driven else "free "
    if joint.rotation_at is not None:
        raise ModelError(
            f"{role} {target.name!r}: the coordinates of a {joint.kind} joint are Euler parameters. Remedy: "
            "rotation or position of the body"
        )
    if joint.units == ("s",):
        raise ModelError(
            f"{role} {target.name!r}: the {joint.kind} joint follows a given pose as a whole. Remedy: position, "
            "rotation or force of the body; revolute and prismatic joints where single coordinates count"
        )
    there = [i for i, motion in enumerate(joint.motions) if driven is None or (motion is not None) == driven]
    labels = [joint.coordinate_names[i].partition(" [")[0] for i in there]
    chosen = [i for i, label in zip(there, labels, strict=True) if target.axis in ("", label, str(i))]
    if not chosen:
        listed = ", ".join(f"{i} ({label})" for i, label in zip(there, labels, strict=True)) or "none"
        raise ModelError(
            f"{role} {target.name!r}: the {joint.kind} joint of {body.name!r} has no such {kind}coordinate. "
            f"There are: {listed}"
        )
    one = len(chosen) == 1
    return [(target.name if one else f"{target.name} {labels[there.index(i)]}", i, joint.units[i]) for i in chosen]
