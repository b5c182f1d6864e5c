"""A scene as text: its bodies as a tree with their joints, and the loads on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from kanefe.bodies.rigid import RigidMass
from kanefe.joints import Joint
from kanefe.loads.base import Load
from kanefe.scene.scene import BodyEntry

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint
    from kanefe.loads.controller import Controller

DEEPEST_MARGIN = 120
"""Largest indentation of a line, in characters."""


def tree_text(
    entries: Sequence[BodyEntry],
    constraints: Sequence[Constraint],
    loads: Sequence[Load],
    controllers: Sequence[Controller],
    gravity: Sequence[float],
) -> str:
    """Return the text of a scene, with a line for each body, load, constraint and controller."""
    pull = ", ".join(f"{g:g}" for g in gravity)
    flexible = sum(entry.flexible is not None for entry in entries)
    lines = [f"scene of {_count(len(entries), 'body', 'bodies')}, {flexible} flexible, gravity ({pull}) m/s2", "ground"]
    _add_children(lines, entries)
    between = [f"{load.kind} {load.name!r} between {' and '.join(end.label for end in load.ends)}" for load in loads]
    for title, parts in (
        ("loads between frames", between),
        ("constraints", [c.title for c in constraints]),
        ("controllers", [str(controller) for controller in controllers]),
    ):
        if parts:
            lines += [f"{title}:", *(f"  {part}" for part in parts)]
    return "\n".join(lines)


def _add_children(lines: list[str], entries: Sequence[BodyEntry]) -> None:
    """Add the lines of all bodies, without recursion, since chains may be longer than Python's limit."""
    children = _children(entries)
    left = [(number, "", number == children[-1][-1]) for number in reversed(children[-1])]
    while left:
        number, margin, is_last = left.pop()
        entry, below = entries[number], children[number]
        lines.append(f"{margin}{'└─ ' if is_last else '├─ '}{_body(entry)}")
        inner = margin + ("   " if is_last else "│  ") if len(margin) < DEEPEST_MARGIN else margin
        acting = [load.label for load in (*(load for load, _ in entry.loads), *entry.joint_loads)]
        acting += dict.fromkeys(f"{load.label}{load.resultant}" for load in entry.field_loads)
        lines += [f"{inner}{'│  ' if below else '   '}acted on by {label}" for label in acting]
        left += [(child, inner, child == below[-1]) for child in reversed(below)]


def _children(entries: Sequence[BodyEntry]) -> dict[int, list[int]]:
    """Return the numbers of the children of each body, and of the ground, -1."""
    children: dict[int, list[int]] = {number: [] for number in range(-1, len(entries))}
    for number, entry in enumerate(entries):
        children[entry.parent].append(number)
    return children


def body_rows(entries: Sequence[BodyEntry]) -> list[tuple[int, str, str, str]]:
    """Return depth in the tree, name, kind, and joint of each body, parents before their children."""
    children, rows = _children(entries), []
    left = [(number, 0) for number in reversed(children[-1])]
    while left:
        number, depth = left.pop()
        entry = entries[number]
        rows.append((depth, entry.name, _kind(entry), _joint(entry.joint)))
        left += [(child, depth + 1) for child in reversed(children[number])]
    return rows


def _body(entry: BodyEntry) -> str:
    at = f"at {entry.parent_interface.name!r}: " if entry.parent_interface is not None else ""
    return f"{at}{entry.name} ({_kind(entry)}), {_joint(entry.joint)}"


def _kind(entry: BodyEntry) -> str:
    if entry.flexible is not None:
        what = f"flexible, {entry.flexible.mass:.6g} kg, {_count(entry.flexible.free_count, 'mode', 'modes')}"
    elif entry.rigid is not None and entry.rigid.mass > 0.0:
        what = f"rigid, {entry.rigid.mass:.6g} kg{_inertia(entry.rigid)}"
    else:
        what = "massless"
    return what if entry.has_gravity else f"{what}, without gravity"


def _inertia(body: RigidMass) -> str:
    """Return about which point an inertia is, where it is not the origin: other programs take it about that."""
    if not body.com.any() or not body.inertia.any():
        return ""
    return f", inertia about its centre of mass ({', '.join(f'{x:.6g}' for x in body.com)}) m"


def _joint(joint: Joint) -> str:
    axis = getattr(joint, "axis", None)
    along = ""
    if axis is not None:
        along = f" {axis}" if isinstance(axis, str) else f" ({', '.join(f'{x:g}' for x in axis)})"
    # motions and laws belong to speeds; a rotation by Euler parameters has fewer of them than coordinates
    named = joint.coordinate_names if joint.rotation_at is None else joint.speed_names
    names = [name.partition(" [")[0] for name in named]
    driven = [name for name, motion in zip(names, joint.motions, strict=True) if motion is not None]
    laws = [name for name, law in zip(names, joint.coordinate_forces, strict=True) if law is not None]
    more = [f"{', '.join(part)} {word}" for part, word in ((driven, "driven"), (laws, "with a force law")) if part]
    more += ["friction from its load"] if joint.friction is not None else []
    return f"{joint.kind}{along}{'; ' if more else ''}{'; '.join(more)}"


def _count(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"
