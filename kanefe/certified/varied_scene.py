"""A copy of a scene with other bodies in the places of its own: the same interfaces, nodes, loads and constraints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.marker import Marker, ModalMarker
from kanefe.errors import ModelError
from kanefe.scene.scene import BodyEntry, Scene

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint
    from kanefe.loads.base import Load

AnyScene = TypeVar("AnyScene", bound=Scene)

SAME_PLACE = 1e-9
"""Distance of two nodes at the same place, relative to the size of the body."""


def varied_scene(
    scene: AnyScene, bodies: Mapping[str, FlexibleBody], anchors: Mapping[str, float] | None = None
) -> AnyScene:
    """Return a copy of a scene that is open, with other bodies and stiffer friction anchors.

    Parameters
    ----------
    scene : System
    bodies : mapping of str to FlexibleBody
        By the names of those that they replace.
    anchors : mapping of str to float
        Factors on the stiffness of friction anchors, by name of contact.

    Raises
    ------
    ModelError
        If a body has not the interfaces, nodes or surfaces that the scene uses.
    """
    other = scene.copy()
    moved = _Moved(scene, bodies)
    for number, entry in enumerate(other._entries):
        _change_entry(entry, number, moved)
    other._loads = [_anchored(moved.load(load), (anchors or {}).get(load.name, 1.0)) for load in other._loads]
    cast("Any", other)._constraints = [moved.constraint(one) for one in cast("Any", other)._constraints]
    other._surfaces = {
        name: surface._replace(frame=_with(surface.frame, moved, other)) for name, surface in other._surfaces.items()
    }
    return other


def _with(frame: Any, moved: _Moved, scene: Scene) -> Any:
    return replace(frame, system=scene, interface_frame=moved.frame(frame.interface_frame, frame.number))


def _anchored(load: Load, factor: float) -> Load:
    """Return a contact with so many times stiffer friction anchors; their damping follows as the root."""
    if factor == 1.0:
        return load
    contact: Any = load
    law = contact.friction
    damping = None if law.damping is None else law.damping * factor**0.5
    return cast("Load", replace(contact, friction=law.with_numbers(stiffness=factor * law.stiffness, damping=damping)))


def _change_entry(entry: BodyEntry, number: int, moved: _Moved) -> None:
    entry.parent_interface = moved.frame(entry.parent_interface, entry.parent)
    entry.loads = [(load, moved.frame(frame, number)) for load, frame in entry.loads]
    new = moved.bodies.get(number)
    if new is None or entry.flexible is None:
        return
    old, entry.flexible = entry.flexible, new
    entry.field_loads = [replace(load, pattern=new.load_pattern(load.pattern.name)) for load in entry.field_loads]
    entry.eta, entry.deta = (_projected(old, new, given, entry.name) for given in (entry.eta, entry.deta))


def _projected(old: FlexibleBody, new: FlexibleBody, given: np.ndarray | None, name: str) -> np.ndarray | None:
    """Return coordinates with which the nodes are nearest to where the old ones have them."""
    if given is None:
        return None
    if not np.any(given):
        return np.zeros(new.free_count)
    if old.basis.shape[0] != new.basis.shape[0]:
        raise ModelError(f"body {name!r} starts deformed, which another mesh does not take over")
    wanted = old.basis[:, : old.free_count] @ given
    return np.asarray(np.linalg.lstsq(new.basis[:, : new.free_count], wanted, rcond=None)[0])


class _Moved:
    """Frames of the old bodies in the new ones.

    Attributes
    ----------
    bodies : dict of int to FlexibleBody
        New ones, by number.
    """

    def __init__(self, scene: Scene, bodies: Mapping[str, FlexibleBody]) -> None:
        numbers = {entry.name: number for number, entry in enumerate(scene._entries)}
        self.bodies = {numbers[name]: body for name, body in bodies.items()}
        self._old = {number: scene._entries[number].flexible for number in self.bodies}
        self._frames: dict[int, InterfaceFrame] = {}
        self._markers: dict[int, Marker] = {}

    def frame(self, frame: InterfaceFrame | None, number: int) -> InterfaceFrame | None:
        """Return the frame of a body that was one of the old body of this number."""
        new = self.bodies.get(number)
        if frame is None or new is None:
            return frame
        if id(frame) not in self._frames:
            names = {own.name for own in new.interfaces}
            self._frames[id(frame)] = new.interface(frame.name) if frame.name in names else self._node(frame, number)
        return self._frames[id(frame)]

    def _node(self, frame: InterfaceFrame, number: int) -> InterfaceFrame:
        new = self.bodies[number]
        apart = np.linalg.norm(new.nodes - frame.position, axis=1)
        nearest = int(apart.argmin())
        if apart[nearest] > SAME_PLACE * float(np.ptp(new.nodes, axis=0).max()):
            raise ModelError(f"the scene uses {frame.name} of a body, which has no node there after it was made again")
        return new.node_frame(nearest)

    def marker(self, marker: Marker) -> Marker:
        """Return a marker, in the new body if it was in an old one."""
        if marker.body not in self.bodies:
            return marker
        if isinstance(marker, ModalMarker):
            raise ModelError(f"{marker.label} is a coordinate of modes, which others do not have")
        if id(marker) not in self._markers:
            found = self.frame(marker.interface, marker.body)
            self._markers[id(marker)] = marker if found is marker.interface else replace(marker, interface=found)
        return self._markers[id(marker)]

    def load(self, load: Load) -> Load:
        """Return a load between frames of the new bodies."""
        if not any(end.body in self.bodies for end in load.ends):
            return load
        return load.with_ends(tuple(map(self.marker, load.ends)))

    def constraint(self, one: Constraint) -> Constraint:
        """Return a constraint between frames of the new bodies."""
        if not any(end.body in self.bodies for end in one.ends):
            return one
        rows: list[Any] = [
            replace(cast("Any", row), a=self.marker(row.a), b=self.marker(row.b)) if row.markers else row  # type: ignore[union-attr]
            for row in one.rows
        ]
        a, b = (None if end is None else self.marker(end) for end in (one.a, one.b))
        return replace(one, rows=tuple(rows), a=a, b=b)
