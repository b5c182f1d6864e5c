"""Names of inputs and outputs: ``"<what> <body>[/<interface>] [<axis>]"``, checked against the scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.joints import Joint

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

AXES = {"x": 0, "y": 1, "z": 2}

Named = Sequence[str] | Mapping[str, str] | str
"""Names of channels in a script: one, several, or a mapping from names of its own."""


class NamedBody(Protocol):
    """What a name says of a body, in a scene that is built as in one that is frozen."""

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
        """Its interfaces; none of a rigid body."""
        ...


class Target(NamedTuple):
    """What a channel is about: a quantity of a body's frame or interface, along an axis or of a coordinate."""

    name: str
    what: str
    body: int
    interface: InterfaceFrame | None
    axis: str


def asked_for(named: Named) -> list[tuple[str, str]]:
    """Return pairs of a name and a text; the name is empty where the script gives none."""
    if isinstance(named, str):
        return [("", named)]
    if isinstance(named, Mapping):
        return [(str(name), text) for name, text in named.items()]
    # what has no length may have no end: whoever asks says that it is no text
    return [("", text) for text in (named if isinstance(named, Collection) else [named])]


def target_of(bodies: Sequence[NamedBody], name: str, text: object, kinds: Mapping[str, str], role: str) -> Target:
    """Return the target of a text.

    Parameters
    ----------
    bodies : sequence
        Of the scene.
    name : str
        As the script calls it; empty: the text itself.
    text : str
    kinds : mapping
        What there is, each with its unit.
    role : "input" or "output"

    Raises
    ------
    ModelError
        If there is no such quantity, body or interface; the message lists those there are.
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
        found = [i for i, b in enumerate(bodies) if b.name == body]
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


def axes_of(target: Target, role: str) -> list[tuple[str, int, bool]]:
    """Return name, axis and whether it is the frame's own, of what a target asks for: one axis, or three.

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
    """Return names and directions in N of what a target asks for, with the frame's axes as they are in the state."""
    return [(name, axes[:, i] if is_own else np.eye(3)[i]) for name, i, is_own in axes_of(target, role)]


def joint_entry(
    bodies: Sequence[NamedBody], target: Target, role: str, driven: bool | None = False
) -> list[tuple[str, int, str]]:
    """Return name, coordinate and unit of the scalar coordinates of a joint that a target asks for.

    `driven`: of those that are driven, else of those that are not; None: of all.
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
